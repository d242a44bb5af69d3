# The disc splits, by bonds that break in tension, at a strength below that of the bonds; both plates carry the load.
add_example_test(splits ARGS --quiet --strength 5 --steps 8000
                 CHECK "strength_over_bonds GREATER 0.3" "strength_over_bonds LESS 0.7" "broken GREATER 100"
                       "uneven LESS 0.1" "dt_above_critical EQUAL 0")

# The same bits on any ranks, and over restarts: bonds go with their bodies, broken or not.
add_same_bits_test(same_bits RESTART STEPS 3000 ARGS --radius 15 --length 7 --strength 3 RESULTS load broken
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")

# A cylinder under compression along its axis bears about three times as much.
add_example_test(uniaxial ARGS --quiet --uniaxial --radius 10 --length 20 --strength 2 --steps 5000
                 CHECK "strength_over_bonds GREATER 0.8" "strength_over_bonds LESS 1.6" "broken GREATER 20"
                       "uneven LESS 0.1" "dt_above_critical EQUAL 0")
add_same_bits_test(uniaxial_same_bits RESTART STEPS 3000
                   ARGS --uniaxial --radius 9 --length 16 --strength 1 RESULTS load broken
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
