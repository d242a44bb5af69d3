# The flow is within a third of Beverloo's law for a flat bottom, for both materials; the rougher one
# flows slower. No sphere is lost through the walls: those that left and those within are all.
set(flows "filled EQUAL 700" "dt_above_critical EQUAL 0" "mass_flow_rate_over_beverloo LESS 1.33")
add_example_test(m1 ARGS --quiet CHECK ${flows} "mass_flow_rate_over_beverloo GREATER 0.9" "left GREATER 350")
add_example_test(m2 ARGS --quiet --m2 CHECK ${flows} "mass_flow_rate_over_beverloo GREATER 0.75"
                                      "left GREATER 300")

# A restart in the second stage has what was measured between the stages.
add_same_bits_test(stages RESTART STEPS 1000 ARGS --spheres 200 --settling 0.04
                   RESULTS filled bulk_density RUNS "--ranks 1" "--ranks 2")

add_test(NAME example_silo_tables COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/silo/tables_test.sh
                                          $<TARGET_FILE:example_silo>)
set_tests_properties(example_silo_tables PROPERTIES TIMEOUT 300 LABELS example
                                                    ENVIRONMENT "${TALUS_MPI_ENVIRONMENT}")
