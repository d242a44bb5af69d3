# long: heaps on one side of space, and cuts that follow them.
# The heap in the corner is shared out evenly, and nothing is lost; without moving cuts it is not.
set(slides ARGS --quiet --ranks 4)
set(rests "bodies EQUAL 4000" "penetration_mean LESS 1e-3")
add_example_test(never LONG ${slides} --balance never
                 CHECK ${rests} "imbalance_bodies_after GREATER 1.8" "balance_moves EQUAL 0")
add_example_test(count LONG ${slides} --balance count
                 CHECK ${rests} "imbalance_bodies_after LESS 1.15" "balance_moves GREATER 3")
add_example_test(time LONG ${slides} --balance time CHECK ${rests} "imbalance_bodies_after LESS 1.6")

# The same bits, however cuts move, and from a checkpoint of a run whose cuts have moved.
set(often --reproducible --balance-every 20 --spheres 600)
add_same_bits_test(same_bits LONG RESTART STEPS 700 ARGS ${often}
                   RUNS "--ranks 1" "--ranks 4 --balance count" "--ranks 7" "--ranks 4 --balance never"
                        "mpi 5 --balance count")
