# long
# The depth is that of the law within a factor of 1.5 (of grains that are a fifth of the sphere, whose
# slope of repose is known to a tenth or two), from heights that differ by a factor of 16.
set(sinks "depth_to_law GREATER 0.667" "depth_to_law LESS 1.5" "collectives_per_step LESS 0.1")
add_example_test(alone ARGS --quiet CHECK ${sinks} "bodies EQUAL 6001")
add_example_test(low ARGS --quiet --ranks 4 --fall 5 CHECK ${sinks})
add_example_test(high LONG ARGS --quiet --fall 80 CHECK ${sinks})

# The same bits on any ranks.
add_same_bits_test(same_bits RESTART STEPS 160 ARGS --reproducible --spheres 1000 --settle 0.35
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
