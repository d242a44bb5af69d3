# Lenses settle beside spheres, boxes and unions of lenses; most lie flat, none falls through the floor.
add_example_test(settles RANKS 4 ARGS --quiet CHECK "lenses GREATER 200" "flat GREATER 0.5" "mean_speed LESS 0.05" "below EQUAL 0")

# The same bits on any ranks, and over restarts.
add_same_bits_test(same_bits RESTART STEPS 400 ARGS --reproducible RESULTS lenses flat mean_speed RUNS "--ranks 1" "--ranks 4" "mpi 2")
