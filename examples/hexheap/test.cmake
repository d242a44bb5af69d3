# long: the last program of docs/first_hour.md.
set(rests "bodies EQUAL 3969" "penetration_mean LESS 1e-3" "collectives_per_step EQUAL 0")
add_example_test(threads LONG ARGS --steps 400 --quiet --ranks 91
                 CHECK ${rests} "ranks EQUAL 91" "messages_per_step_max LESS 91")
add_test(NAME example_hexheap_job COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/hexheap/job_test.sh
                                          $<TARGET_FILE:example_hexheap> ${MPIEXEC_EXECUTABLE}
                                          ${MPIEXEC_NUMPROC_FLAG})
set_tests_properties(example_hexheap_job PROPERTIES TIMEOUT 600 LABELS "example;long" PROCESSORS 2
                                                    ENVIRONMENT "${TALUS_MPI_ENVIRONMENT}")
