# Ellipsoids fill more of the volume than spheres do.
add_example_test(spheres ARGS --quiet --candies 300 --aspect 1 --steps 1000
                 CHECK "fraction GREATER 0.56" "fraction LESS 0.67")
add_example_test(ellipsoids ARGS --quiet --candies 300 --aspect 1.5 --steps 1000
                 CHECK "fraction GREATER 0.67" "fraction LESS 0.74")

# The same bits on any ranks, and over restarts.
add_same_bits_test(same_bits RESTART STEPS 400 ARGS --reproducible --candies 300 RESULTS fraction
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
