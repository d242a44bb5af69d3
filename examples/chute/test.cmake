# long
# At 25 degrees it flows for ever at one speed, and at 18 it stops.
add_example_test(flows LONG ARGS --quiet --ranks 4
                 CHECK "mean_velocity GREATER 0.6" "mean_velocity LESS 1.0" "surface_over_mean GREATER 1.5"
                       "surface_over_mean LESS 2.2" "penetration_mean LESS 1e-3")
add_example_test(stops LONG ARGS --quiet --angle 18 --steps 15000 CHECK "mean_velocity LESS 0.01")

# Over the sides of the box, on any ranks, and over restarts: the same bits.
add_same_bits_test(same_bits LONG RESTART STEPS 600 ARGS --reproducible --layers 5
                   RUNS "--ranks 1" "--ranks 4" "--ranks 6" "mpi 2")
