# The steady profile of a column whose ends are kept at two temperatures is linear; two spheres come to
# one temperature exponentially; no heat is lost.
set(conserved "heat_lost LESS 1e-13")
add_example_test(column ARGS --quiet --column 8 --steps 10000
                 CHECK "heat_lost LESS 1e-12" "temperature_error LESS 1e-9" "heat_given GREATER 0.01")
add_example_test(column_ranks ARGS --quiet --column 8 --steps 10000 --ranks 4
                 CHECK "heat_lost LESS 1e-12" "temperature_error LESS 1e-9" "heat_given GREATER 0.01")
add_example_test(pair ARGS --quiet --pair --steps 500
                 CHECK ${conserved} "temperature_error LESS 5e-3" "heat_given EQUAL 0")
add_example_test(adiabatic ARGS --quiet --adiabatic CHECK ${conserved} "heat_given EQUAL 0")
add_example_test(bed RANKS 4 ARGS --quiet CHECK ${conserved} "heat_given GREATER 0.01")

# The digest holds the temperatures: they have the same bits on any ranks, and over restarts.
add_same_bits_test(same_bits RESTART STEPS 1000 ARGS --reproducible RESULTS heat_given
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
