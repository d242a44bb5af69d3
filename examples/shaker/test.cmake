# long
# The large grain comes from the bottom to the top, on one rank and on four. (It takes 12,000 to 25,000
# steps, by the seed and by the order of contacts.)
set(rises "bodies EQUAL 501" "height_gained GREATER 4" "penetration_mean LESS 5e-3")
add_example_test(alone LONG ARGS --quiet --steps 28000 CHECK ${rises})
add_example_test(threads LONG ARGS --quiet --ranks 4 --steps 28000 CHECK ${rises})

add_same_bits_test(same_bits LONG RESTART STEPS 900 ARGS --reproducible
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
