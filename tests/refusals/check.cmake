# Passes if SOURCE is refused by the compiler with the sentence it expects within the first lines,
# and compiles once its mistake is corrected.
#   // expects: <fragment>        first lines of SOURCE; may be repeated, all must appear
#   #ifdef TALUS_CONTROL ... #else ... #endif     the correct variant and the mistake
set(most_lines 24)
file(STRINGS ${SOURCE} expectations LIMIT_COUNT 8 REGEX "^// expects: *[^ ]")
file(STRINGS ${SOURCE} control REGEX "TALUS_CONTROL")
if(NOT expectations OR NOT control)
  message(FATAL_ERROR "${SOURCE} needs a first line '// expects: <fragment>' and a variant that "
                      "compiles under '#ifdef TALUS_CONTROL'")
endif()
set(compile ${COMPILER} @${FLAGS} -fsyntax-only -fmessage-length=0 -fdiagnostics-color=never -w)

execute_process(COMMAND ${compile} ${SOURCE} RESULT_VARIABLE result OUTPUT_VARIABLE out
                ERROR_VARIABLE out)
string(REPLACE ";" "," out "${out}")
string(REPLACE "[" "(" lines "${out}")
string(REPLACE "]" ")" lines "${lines}")
string(REPLACE "\\" "/" lines "${lines}")
string(REPLACE "\n" ";" lines "${lines}")
list(LENGTH lines count)
if(result EQUAL 0)
  message(FATAL_ERROR "${SOURCE} compiles, but must be refused")
endif()
list(SUBLIST lines 0 ${most_lines} head)
foreach(expectation IN LISTS expectations)
  string(REGEX REPLACE "^// expects: *" "" fragment "${expectation}")
  string(REPLACE "[" "(" fragment "${fragment}")
  string(REPLACE "]" ")" fragment "${fragment}")
  string(FIND "${head}" "${fragment}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "${SOURCE} is refused, but the first ${most_lines} lines of the message "
                        "lack '${fragment}':\n${out}")
  endif()
endforeach()

execute_process(COMMAND ${compile} -DTALUS_CONTROL ${SOURCE} RESULT_VARIABLE result
                OUTPUT_VARIABLE out ERROR_VARIABLE out)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${SOURCE} does not compile with TALUS_CONTROL either, so its refusal proves "
                      "nothing:\n${out}")
endif()
