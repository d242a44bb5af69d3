// Inputs that the fuzzer of the command line found or started from are read correctly.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "../fuzz/options.hpp"

TEST_CASE("every command line of the corpus is accepted or refused with a message, and kept") {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(__FILE__).parent_path() / "../fuzz/options")) {
    CAPTURE(entry.path().string());
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(in), {});
    fuzz::check_options(bytes);  // aborts
    for (std::size_t cut = 0; cut < bytes.size(); ++cut)
      fuzz::check_options(std::string_view(bytes).substr(0, cut));
    ++files;
  }
  CHECK(files >= 10);
}
