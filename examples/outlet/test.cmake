# long
# Half full, the flow rate is that of Beverloo's law within the spread of its constants, on one rank
# and on 64.
set(flows "collectives_per_step EQUAL 0" "penetration_mean LESS 2e-3" "spheres_left GREATER 500"
          "mass_flow_rate GREATER 150" "mass_flow_rate LESS 260")
add_example_test(alone ARGS --quiet CHECK ${flows})
add_example_test(threads ARGS --quiet --ranks 64 --steps 40 CHECK "bodies EQUAL 4000" "ranks EQUAL 64")
add_example_test(threads_whole LONG ARGS --quiet --ranks 64 CHECK ${flows})

# The same bits on any ranks.
add_same_bits_test(same_bits RESTART STEPS 120 ARGS --reproducible --spheres 1500
                   RUNS "--ranks 1" "--ranks 64")
add_same_bits_test(same_bits_whole LONG RESTART STEPS 2000 ARGS --reproducible RUNS "--ranks 1" "--ranks 64")
