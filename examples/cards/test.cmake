# long
# The house stands for 8 s; with half the friction that it needs at least it falls, and so does one
# pair by itself.
add_example_test(stands ARGS --quiet CHECK "bodies EQUAL 14" "height_kept GREATER 0.99"
                 "height_kept LESS 1.01" "friction_needed GREATER 0.36" "friction_needed LESS 0.37"
                 "collectives_per_step EQUAL 0")
add_example_test(falls ARGS --quiet --friction 0.18 --steps 2000 CHECK "height_kept LESS 0.5")
add_example_test(pair_stands ARGS --quiet --storeys 1 --ranks 2 --steps 500 CHECK "height_kept GREATER 0.999")
add_example_test(pair_falls ARGS --quiet --storeys 1 --friction 0.21 --steps 1500 CHECK "height_kept LESS 0.5")

# The same bits on any ranks.
add_same_bits_test(same_bits RESTART STEPS 100 ARGS --reproducible RUNS "--ranks 1" "--ranks 3" "mpi 2")
