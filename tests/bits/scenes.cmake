# The scenes by COMPILER with FLAGS end with the digests that are pinned in scenes.cpp, on processors
# without fused multiply-adds too, and call no function of the C library that platforms round
# differently. NM lists symbols. The other variables are those of configure.cmake.
include(${CMAKE_CURRENT_LIST_DIR}/configure.cmake)
run(${CMAKE_COMMAND} --build ${WORK} --target scenes)
run(${WORK}/scenes)
message("${out}")

# glibc has variants of its functions for such processors, and is told that this is none.
set(features -FMA,-FMA4,-AVX2,-AVX512F,-FMA_Usable,-FMA4_Usable,-AVX2_Usable,-AVX512F_Usable)
run(${CMAKE_COMMAND} -E env GLIBC_TUNABLES=glibc.cpu.hwcaps=${features} ${WORK}/scenes shapes)

run(${NM} -D -u ${WORK}/scenes)
set(rounded "a?(sin|cos|tan)h?|sincos|atan2|exp|exp2|expm1|exp10|log|log2|log10|log1p|pow|cbrt|hypot")
if(out MATCHES "[ \n]((${rounded})[fl]?)(@[^\n]*)?\n")
  message(FATAL_ERROR "the program calls '${CMAKE_MATCH_1}' of the C library, which platforms round "
                      "differently: use the function of talus::portable")
endif()
