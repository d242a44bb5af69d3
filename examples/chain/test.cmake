# The chain rests in the discrete catenary, its supports bear its weight and its pull: on one rank, where
# joints are solved directly, and on four.
add_example_test(alone ARGS --quiet --ranks 1
                 CHECK "deviation LESS 1e-6" "gap LESS 1e-12" "pull_error LESS 1e-6" "weight_error LESS 1e-6")
add_example_test(threads ARGS --quiet --ranks 4
                 CHECK "deviation LESS 1e-3" "gap LESS 1e-4" "pull_error LESS 1e-3" "weight_error LESS 1e-3")
add_same_bits_test(same_bits RESTART STEPS 600 ARGS --reproducible
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
