# Beads hang from the ceiling up to the weight that a bridge bears, the moist column stands where the dry
# one spreads, and the books of energy close.
set(books "bodies EQUAL 210" "energy_closure LESS 1e-11" "dt_above_critical EQUAL 0")
add_example_test(moist ARGS --quiet CHECK ${books} "hanging EQUAL 5" "mean_height GREATER 2.8")
add_example_test(dry ARGS --quiet --volume 0 CHECK ${books} "hanging EQUAL 0" "mean_height LESS 2.2")

# The same bits on any ranks, and over restarts: the memory of bridges goes with the bodies.
add_same_bits_test(same_bits RESTART STEPS 1500 ARGS RESULTS mean_height
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
