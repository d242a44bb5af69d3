# The initial state is the same to the bit on every transport and number of ranks.
add_same_bits_test(same_start STEPS 0 RUNS "--ranks 1" "--ranks 3" "--ranks 9" "mpi 4")

# So is the final one, with the reproducible solver.
set(one_and_others "--ranks 1" "--ranks 4" "--ranks 9 --decomposition slabs"
                   "--ranks 7 --decomposition hexagonal" "--ranks 19 --decomposition hexagonal"
                   "mpi 2")
add_same_bits_test(same_bits RESTART STEPS 1200 ARGS --reproducible --spheres 300
                   RUNS ${one_and_others})
add_same_bits_test(same_bits_whole LONG RESTART STEPS 6000 ARGS --reproducible RUNS ${one_and_others})

# A shorter fall of fewer spheres, on each transport.
set(falls --spheres 400 --steps 2500 --quiet)
set(rests "bodies EQUAL 600" "penetration_mean LESS 1e-4" "penetration_max LESS 1e-2"
          "kinetic_energy LESS 100" "collectives_per_step EQUAL 0")
add_example_test(alone ARGS ${falls} CHECK ${rests} "transport STREQUAL serial")
add_example_test(threads ARGS ${falls} --ranks 4
                 CHECK ${rests} "transport STREQUAL threads" "messages_per_step_max LESS 60")
add_example_test(mpi RANKS 4 ARGS ${falls}
                 CHECK ${rests} "transport STREQUAL mpi" "messages_per_step_max LESS 60")

# The whole job: the resting pile is still and hardly overlaps.
add_example_test(whole LONG ARGS --quiet
                 CHECK "bodies EQUAL 3200" "penetration_mean LESS 1e-4" "kinetic_energy LESS 160")
add_example_test(whole_threads LONG ARGS --quiet --ranks 4
                 CHECK "bodies EQUAL 3200" "penetration_mean LESS 1e-4" "kinetic_energy LESS 160")
# Any decomposition will do.
set(few --spheres 400 --steps 600 --quiet)
set(kept "bodies EQUAL 600" "penetration_mean LESS 1e-3" "collectives_per_step EQUAL 0")
add_example_test(slabs ARGS ${few} --ranks 5 --decomposition slabs
                 CHECK ${kept} "messages_per_step_max LESS 31")
add_example_test(hexagonal ARGS ${few} --ranks 19 --decomposition hexagonal
                 CHECK ${kept} "messages_per_step_max LESS 91")

# What the default solver promises: the same bits from run to run on as many ranks, whether these are
# threads or processes.
add_same_bits_test(twice LONG STEPS 6000 RUNS "--ranks 4" "--ranks 4" "mpi 4")
add_same_bits_test(twice_alone LONG STEPS 6000 RUNS "--ranks 1" "--ranks 1")
add_example_test(bisection LONG ARGS ${few} --ranks 7 --decomposition bisection CHECK ${kept})
