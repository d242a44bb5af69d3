# Counts of emitted, present and removed bodies add up on any ranks. Rank 0 has three neighbours, the
# others two or three, with 15 messages a step for each.
set(flows "unaccounted EQUAL 0" "penetration_mean LESS 1e-3" "collectives_per_step EQUAL 0"
          "messages_per_step_max LESS 46")
add_example_test(alone ARGS --quiet --steps 2000 CHECK ${flows} "emitted GREATER 1000")
add_example_test(eight ARGS --quiet --steps 2000 --ranks 8 CHECK ${flows} "emitted GREATER 1000")
add_example_test(nine RANKS 9 ARGS --quiet --steps 600 --sectors 8 --slabs 1
                 CHECK ${flows} "ranks EQUAL 9")
# Until spheres leave at the foot.
add_example_test(whole LONG ARGS --quiet --ranks 8 CHECK ${flows} "removed GREATER 1000")

# Bodies emitted by one rank and removed by others: the same bits on any ranks.
set(one_and_others "--ranks 1" "--ranks 8" "--sectors 4 --slabs 3 --ranks 7"
                   "mpi 9 --sectors 8 --slabs 1")
add_same_bits_test(same_bits RESTART STEPS 700 ARGS --reproducible RUNS ${one_and_others})
add_same_bits_test(same_bits_whole LONG RESTART STEPS 12000 ARGS --reproducible RUNS ${one_and_others})

# What the default solver promises: from run to run on as many ranks, threads or processes.
add_same_bits_test(twice LONG STEPS 6000 RUNS "--ranks 9 --sectors 8 --slabs 1"
                   "--ranks 9 --sectors 8 --slabs 1" "mpi 9 --sectors 8 --slabs 1")
