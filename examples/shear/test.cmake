# long
# The plates press with what the servo holds, and what one exerts the other one bears.
set(shears "friction GREATER 0.3" "friction LESS 0.5" "pressure GREATER 0.95" "pressure LESS 1.05"
           "plates_differ LESS 0.02" "penetration_mean LESS 1e-3")
add_example_test(alone LONG ARGS --quiet CHECK ${shears})
add_example_test(threads LONG ARGS --quiet --ranks 4 CHECK ${shears})

# A servo and a belt in a periodic box: the same bits on any ranks, and over restarts.
add_same_bits_test(same_bits LONG RESTART STEPS 500 ARGS --reproducible
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
