# long
# The same motion on one rank and on five: the agglomerate is known to all five, owned by the third,
# and turns with the same spin.
set(turns "momentum_lost LESS 1e-13" "angular_momentum_lost LESS 1e-12" "spin GREATER 0.56324"
          "spin LESS 0.56326")
add_example_test(alone ARGS --quiet CHECK ${turns} "ranks_that_know_it EQUAL 1")
add_example_test(threads ARGS --quiet --ranks 5 CHECK ${turns} "ranks_that_know_it EQUAL 5")
add_example_test(mpi RANKS 5 ARGS --quiet CHECK ${turns} "ranks_that_know_it EQUAL 5")

# The same bits on any ranks, while it is known to all of them.
add_same_bits_test(same_bits RESTART STEPS 1000 ARGS --reproducible
                   RUNS "--ranks 1" "--ranks 2" "--ranks 5" "mpi 4")

# What the default solver promises: from run to run on as many ranks, threads or processes.
add_same_bits_test(twice LONG STEPS 5000 RUNS "--ranks 5" "--ranks 5" "mpi 5")
