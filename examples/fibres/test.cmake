# A fibre swings with the first frequency of a beam.
add_example_test(swing ARGS --quiet --swing --spheres 20 --steps 60000
                 CHECK "frequency_over_beam GREATER 0.99" "frequency_over_beam LESS 1.01")

# Fibres settle in a heap, and no bond breaks.
add_example_test(heap ARGS --quiet --fibres 16 --spheres 8 --steps 40000
                 CHECK "bonds EQUAL 112" "intact EQUAL 112" "height LESS 0.7" "dt_above_critical EQUAL 0")

# The same bits on any ranks, and over restarts.
add_same_bits_test(same_bits RESTART STEPS 4000 ARGS --fibres 12 --spheres 8 RESULTS height intact
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
