# A plain column: dry it runs out into a layer, with little liquid it slumps, wet it stands. No liquid is lost.
set(column ARGS --quiet --column --size 0.5 --steps 8000)
set(kept "bodies EQUAL 243" "liquid_lost LESS 1e-14" "dt_above_critical EQUAL 0")
add_example_test(dry ${column} --liquid 0 CHECK ${kept} "height LESS 0.2" "spread GREATER 3")
add_example_test(moist ${column} --liquid 0.5 CHECK ${kept} "height GREATER 0.35" "height LESS 0.65")
add_example_test(wet ${column} --liquid 4 CHECK ${kept} "height GREATER 0.8" "spread LESS 1.1"
                                                "bridges_per_grain GREATER 2")

# The same bits on any ranks, and over restarts: films go with the grains, bridges with their contacts.
add_same_bits_test(same_bits RESTART STEPS 1000 ARGS --size 0.45 RESULTS height bridges_per_grain
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
