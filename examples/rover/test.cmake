# On a floor wheels roll without slip while the pull is below friction, and the rover is pulled back above.
add_example_test(floor ARGS --quiet --ranks 1 --layers 0 --pull 0.3
                 CHECK "slip GREATER -1e-4" "slip LESS 1e-4" "joint_gap LESS 1e-4" "ledger LESS 1e-12"
                       "torque GREATER 0.2999" "torque LESS 0.3001" "torque_differs LESS 1e-3")
# Without a pull its motors bear nothing.
add_example_test(free ARGS --quiet --ranks 2 --layers 0 --pull 0
                 CHECK "slip GREATER -1e-4" "slip LESS 1e-4" "torque_differs LESS 1e-3" "ledger LESS 1e-12")
add_example_test(held ARGS --quiet --ranks 1 --layers 0 --pull 0.8 CHECK "slip GREATER 1")
# On loose ground they slip: on one rank and on two.
set(drives "slip GREATER 0.02" "slip LESS 0.6" "joint_gap LESS 0.03" "ledger LESS 1e-12")
add_example_test(alone ARGS --quiet --ranks 1 --steps 1500 CHECK ${drives})
add_example_test(mpi RANKS 2 ARGS --quiet --steps 1500 CHECK ${drives})
add_same_bits_test(same_bits STEPS 150 ARGS --reproducible
                   RUNS "--ranks 1" "--ranks 3" "mpi 2")
