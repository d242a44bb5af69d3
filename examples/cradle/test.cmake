# long
# The last sphere, or as many as were drawn aside, swing out as far, again and again.
set(swings "swing_of_last GREATER 0.995" "swing_of_last LESS 1.001" "swing_of_others LESS 0.03"
           "momentum_handed_on GREATER 0.995" "momentum_handed_on LESS 1.001"
           "energy_kept GREATER 0.999" "energy_kept LESS 1.001" "collectives_per_step EQUAL 0")
add_example_test(alone ARGS --quiet CHECK ${swings})
add_example_test(two ARGS --quiet --displaced 2 --ranks 3 --steps 3010 CHECK ${swings})
# In a row that touches, the impact goes on from pair to pair: the last sphere alone swings out.
add_example_test(touching ARGS --quiet --steps 1003 --gap 1e-9 CHECK
                 "energy_kept GREATER 0.999" "swing_of_last GREATER 0.999" "swing_of_last LESS 1.001")

# The same bits on any ranks.
add_same_bits_test(same_bits RESTART STEPS 700 ARGS --reproducible RUNS "--ranks 1" "--ranks 3" "mpi 2")
