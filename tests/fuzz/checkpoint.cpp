// Parts of checkpoints that libFuzzer makes up: ./dev fuzz checkpoint [SECONDS].
#include "checkpoint.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)fuzz::read_part(std::as_bytes(std::span(data, size)));
  return 0;
}
