# The bucket digs from -1.2 to 1.2 radians; the work of its motor, summed from torque and angle, is that in
# the ledger, which closes.
set(digs "angle GREATER 1.2" "angle LESS 1.21" "digging_torque GREATER 0.35" "digging_torque LESS 0.55"
         "work_error LESS 1e-12" "ledger LESS 1e-12")
add_example_test(alone ARGS --quiet --ranks 1 --grains 300 CHECK ${digs})
add_example_test(mpi RANKS 2 ARGS --quiet --grains 300 CHECK ${digs})
# Without grains the motor bears the weight of the bucket alone.
add_example_test(empty ARGS --quiet --ranks 1 --grains 0
                 CHECK "angle GREATER 1.2" "angle LESS 1.21" "largest_torque LESS 1e-3" "ledger LESS 1e-12")
add_same_bits_test(same_bits RESTART STEPS 1400 ARGS --grains 200 RUNS "--ranks 1" "--ranks 3" "mpi 2")
