# Outputs, fields, flow. These tests are long; an everyday one, view_of_output, reads its outputs.
# All that has left the hopper is below it, fields hold all of the mass, and the flow carries no more than
# a heap of its height can press: on one rank and on four.
set(flows "collectives_per_step EQUAL 0" "penetration_mean LESS 5e-3" "mass_out_error LESS 1e-12"
          "mass_in_cells_error LESS 1e-12" "bodies_out GREATER 100" "coordination GREATER 1"
          "density_above_the_slot GREATER 0.5" "density_above_the_slot LESS 2.5")
add_example_test(alone LONG ARGS --quiet CHECK ${flows})
add_example_test(mpi LONG RANKS 4 ARGS --quiet CHECK ${flows})
