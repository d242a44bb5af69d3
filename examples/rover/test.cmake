# On a floor wheels roll without slip while the pull is below friction, and spin on the spot above; on
# loose ground they slip.
add_example_test(floor ARGS --quiet --ranks 1 --layers 0 --pull 0.3
                 CHECK "slip GREATER -1e-3" "slip LESS 1e-3" "joint_gap LESS 1e-10" "ledger LESS 1e-9")
add_example_test(held ARGS --quiet --ranks 1 --layers 0 --pull 0.8 CHECK "slip GREATER 1")
set(drives "slip GREATER 0" "slip LESS 0.9" "ledger LESS 1e-9")
add_example_test(alone ARGS --quiet --ranks 1 CHECK ${drives} "joint_gap LESS 1e-10")
add_example_test(threads ARGS --quiet --ranks 2 CHECK ${drives} "joint_gap LESS 1e-2")
