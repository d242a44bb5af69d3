# Configures the projects beside this in WORK, for COMPILER with FLAGS and the talus of BUILD; how to
# run a command and take what it prints.
file(MAKE_DIRECTORY ${WORK})
macro(try)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE out)
endmacro()
macro(run)
  try(${ARGN})
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed: ${ARGN}\n${out}")
  endif()
endmacro()
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK} -G ${GENERATOR} -Dtalus_DIR=${BUILD}
    -DCMAKE_CXX_COMPILER=${COMPILER} "-DCMAKE_CXX_FLAGS=${FLAGS} -DNDEBUG -w" -DCMAKE_BUILD_TYPE=
    "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
