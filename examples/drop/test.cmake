# 729 sites: 9 by 9 by 9 of a lattice.
set(rests "penetration_mean LESS 1e-3" "penetration_max LESS 0.05" "collectives_per_step EQUAL 0")
add_example_test(alone ARGS --steps 600 --quiet CHECK ${rests} "transport STREQUAL serial")
add_example_test(mpi RANKS 4 ARGS --steps 600 --quiet CHECK ${rests} "ranks EQUAL 4")

# The same bits on any ranks.
add_same_bits_test(same_bits RESTART STEPS 300 ARGS --reproducible
                   RUNS "--ranks 1" "--ranks 2" "--ranks 9" "mpi 4")
