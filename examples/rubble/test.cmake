# What contacts bear is what gravity asks for, the core is packed as grains of many sizes are (random
# close packing of equal ones is 0.64: G. D. Scott, D. M. Kilgour, J. Phys. D 2, 863, 1969), and contacts
# that correct no overlap change no angular momentum: on one rank and on two.
set(holds "virial GREATER 0.998" "virial LESS 1.002" "solid_fraction_of_core GREATER 0.58"
          "solid_fraction_of_core LESS 0.68" "angular_momentum_lost LESS 1e-12"
          "penetration_mean LESS 1e-4" "bodies EQUAL 823")
add_example_test(alone ARGS --quiet CHECK ${holds})
add_example_test(mpi LONG RANKS 2 ARGS --quiet CHECK ${holds})

# A table and a force field: the same bits on any ranks, and over restarts.
add_same_bits_test(same_bits RESTART STEPS 160 ARGS --reproducible --settle 0.2
                   RESULTS virial
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
