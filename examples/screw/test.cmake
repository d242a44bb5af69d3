# long: boxes on a mesh.
# What lies in the screw goes by a pitch in each turn, on one rank and on two; nothing is lost.
set(conveys "pitches_per_turn GREATER 0.99" "pitches_per_turn LESS 1.01" "inserted GREATER 595"
            "fell_off GREATER 150" "leaked EQUAL 0" "penetration_mean LESS 2e-3")
add_example_test(alone ARGS --quiet CHECK ${conveys})
add_example_test(threads ARGS --quiet --ranks 2 CHECK ${conveys})

# A driven mesh, an inflow and an outflow: the same bits on any ranks, and over restarts.
add_same_bits_test(same_bits RESTART STEPS 1600 ARGS --reproducible --rate 30 --speed 12
                   RESULTS pitches_per_turn
                   RUNS "--ranks 1" "--ranks 3" "mpi 2")
