# 91 hexagonal ranks: nothing is lost, and the busiest rank has six neighbours with 15 messages each.
set(falls "bodies EQUAL 4200" "penetration_mean LESS 1e-3" "collectives_per_step EQUAL 0")
set(size --bodies 1200 --steps 60 --quiet)
add_example_test(alone ARGS ${size} CHECK ${falls})
add_example_test(threads ARGS ${size} --ranks 91 CHECK ${falls} "messages_per_step_max EQUAL 90")
add_example_test(mpi RANKS 91 TIMEOUT 600 ARGS --bodies 1200 --steps 5 --quiet
                 CHECK ${falls} "messages_per_step_max EQUAL 90" "ranks EQUAL 91")
add_example_test(mpi_whole LONG RANKS 91 ARGS --quiet CHECK "bodies EQUAL 6000")
