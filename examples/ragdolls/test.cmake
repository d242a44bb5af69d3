# Nothing explodes: no body is faster than by a fall from the top and its own rotation, energy never
# grows, and the joints hold: on one rank and on four.
set(calm "joints EQUAL 144" "speed LESS 1.5" "energy LESS 1.000001" "ledger LESS 1e-9" "penetration_mean LESS 1e-2")
add_example_test(alone ARGS --quiet --ranks 1 --ragdolls 16 CHECK ${calm} "gap LESS 1e-10")
add_example_test(threads ARGS --quiet --ranks 4 --ragdolls 16 CHECK ${calm} "gap LESS 0.02")
add_same_bits_test(same_bits RESTART STEPS 200 ARGS --reproducible --ragdolls 6
                   RUNS "--ranks 1" "--ranks 4" "mpi 2")
