# long: the scenario of the README and of ./dev new.
set(rests "bodies EQUAL 729" "penetration_mean LESS 1e-3" "penetration_max LESS 0.05"
          "collectives_per_step EQUAL 0")
add_example_test(alone LONG ARGS --steps 600 --quiet CHECK ${rests} "transport STREQUAL serial")
add_example_test(mpi LONG RANKS 4 ARGS --steps 600 --quiet CHECK ${rests} "ranks EQUAL 4")
