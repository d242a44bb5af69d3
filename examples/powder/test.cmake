# Dry grains find their angle of repose; a sticky block of this size stands.
set(block ARGS --quiet --size 0.5)
set(rests "part_moving LESS 0.02" "dt_above_critical EQUAL 0")
add_example_test(dry ${block} --bond 0 CHECK ${rests} "angle GREATER 25" "angle LESS 50" "part_on_ledge LESS 0.75")
add_example_test(sticky ${block} --bond 4 CHECK ${rests} "angle GREATER 70" "part_on_ledge GREATER 0.9")

# The same bits on any ranks, and over restarts: necks go with their contacts.
add_same_bits_test(same_bits RESTART STEPS 1000 ARGS --size 0.5 --bond 2 RESULTS angle part_on_ledge
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
