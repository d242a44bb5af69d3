# long
# The heap leans by the dynamic angle of repose, on one rank and on four.
set(leans "inserted EQUAL 600" "bodies EQUAL 600" "angle_of_repose GREATER 20" "angle_of_repose LESS 45"
          "penetration_mean LESS 5e-3")
add_example_test(alone LONG ARGS --quiet CHECK ${leans})
add_example_test(threads LONG ARGS --quiet --ranks 4 CHECK ${leans})

# Inflow, driven bodies and what is kept of them: the same bits on any ranks, and over restarts.
add_same_bits_test(same_bits LONG RESTART STEPS 700 ARGS --reproducible --bodies 250
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
