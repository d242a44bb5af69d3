# long
# It runs as fast in the third quarter as in the second one.
set(runs "rate_ratio GREATER 0.85" "rate_ratio LESS 1.15" "penetration_mean LESS 2e-3")
add_example_test(alone ARGS --quiet CHECK ${runs})
add_example_test(threads LONG ARGS --quiet --ranks 4 CHECK ${runs})

# The same bits on any ranks.
add_same_bits_test(same_bits RESTART STEPS 160 ARGS --reproducible --spheres 500
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
