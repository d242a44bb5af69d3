// Command lines that libFuzzer makes up: ./dev fuzz options [SECONDS].
#include "options.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::check_options({reinterpret_cast<const char*>(data), size});
  return 0;
}
