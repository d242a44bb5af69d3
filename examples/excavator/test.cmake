# The bucket digs from -1.2 to 1.2 radians; the work of its motor is that in the ledger, which closes: on
# one rank and on two.
set(digs "angle GREATER 1.19" "angle LESS 1.21" "digging_torque GREATER 0.05" "work_error LESS 1e-3"
         "ledger LESS 1e-9")
add_example_test(alone ARGS --quiet --ranks 1 CHECK ${digs})
add_example_test(threads ARGS --quiet --ranks 2 CHECK ${digs})
# Without grains the motor bears the weight of the bucket alone.
add_example_test(empty ARGS --quiet --ranks 1 --grains 0 --steps 2400
                 CHECK "angle GREATER 1.19" "angle LESS 1.21" "largest_torque LESS 1e-6" "ledger LESS 1e-12")
