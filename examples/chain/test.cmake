# The chain rests in the discrete catenary, its supports bear its weight and its pull: on one
# rank and on four.
set(rests "deviation LESS 1e-10" "gap LESS 1e-12" "pull_error LESS 1e-10" "weight_error LESS 1e-10")
add_example_test(alone ARGS --quiet --ranks 1 CHECK ${rests})
add_example_test(threads ARGS --quiet --ranks 4 CHECK ${rests})
add_same_bits_test(same_bits RESTART STEPS 600 ARGS --reproducible
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
