# long
# 91 hexagonal ranks: nothing is lost, and the busiest rank has six neighbours with 15 messages each.
set(falls "bodies EQUAL 4200" "penetration_mean LESS 1e-3" "collectives_per_step EQUAL 0")
set(size --bodies 1200 --steps 60 --quiet)
add_example_test(alone ARGS ${size} CHECK ${falls})
add_example_test(threads ARGS ${size} --ranks 91 CHECK ${falls} "messages_per_step_max EQUAL 90")
add_example_test(mpi RANKS 91 TIMEOUT 600 ARGS --bodies 1200 --steps 5 --quiet
                 CHECK ${falls} "messages_per_step_max EQUAL 90" "ranks EQUAL 91")
add_example_test(mpi_whole LONG RANKS 91 ARGS --quiet CHECK "bodies EQUAL 6000")

# The same bits on any ranks.
add_same_bits_test(same_bits RESTART STEPS 150 ARGS --reproducible --bodies 1200
                   RUNS "--ranks 1" "--ranks 7" "--ranks 19" "mpi 7")
add_same_bits_test(same_bits_whole LONG RESTART STEPS 3000 ARGS --reproducible
                   RUNS "--ranks 1" "--ranks 19" "--ranks 91" "mpi 37")

# What the default solver promises: from run to run on as many ranks, threads or processes.
add_same_bits_test(twice LONG STEPS 3000 RUNS "--ranks 19" "--ranks 19" "mpi 19")
