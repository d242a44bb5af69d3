// The files of benchmark programs follow the rules of outputs.
#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "../../benchmarks/scenes/report.hpp"

namespace {

std::string text_of(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// The file of --json FILE, as a program asks for it at its beginning.
std::string asked(const std::string& file) {
  std::vector<std::string> words{"bench", "--json", file};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  return bench::arguments(static_cast<int>(arguments.size()), arguments.data()).json_file();
}

}  // namespace

TEST_CASE("a benchmark replaces results, and neither other files nor links") {
  char folder[] = "/tmp/talus_bench_XXXXXX";
  REQUIRE(mkdtemp(folder) != nullptr);
  const std::string base = folder, rows = base + "/rows.json", diary = base + "/diary",
                    link = base + "/link";
  bench::record::write_text("[1]\n", asked(rows));
  bench::record::write_text("[2]\n", asked(rows));
  CHECK(text_of(rows) == "[2]\n");
  std::ofstream(diary) << "a day\n";
  REQUIRE(::symlink(diary.c_str(), link.c_str()) == 0);
  for (const std::string& file : {diary, link, base, base + "/none/rows.json", std::string()}) {
    CAPTURE(file);
    CHECK_THROWS(asked(file));
    CHECK_THROWS(bench::write_file("[3]\n", file, bench::json_output));
  }
  CHECK_THROWS_AS(asked("/dev/full"), std::runtime_error);
  CHECK_THROWS(bench::write_file("3", link, bench::state_output));
  bench::write_file("3", diary, bench::state_output);
  CHECK(text_of(diary) == "3");
  for (const std::string& file : {rows, diary, link}) CHECK(::unlink(file.c_str()) == 0);
  CHECK(::rmdir(folder) == 0);  // nothing is left beside them
}
