// Six scenes whose digests are pinned: the same bits from every compiler, at every level of
// optimisation, for every set of instructions of x86-64, on 1 and 4 ranks. Compiled without a test
// framework, by the compilers and with the options listed in tests/CMakeLists.txt. A commit that
// changes arithmetic on purpose replaces the digests by those that this program prints.
//   scenes [PART OF A NAME [STEPS]]     only those runs, with a digest each so many steps
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "scenes.hpp"

namespace {

int differences = 0;
std::string_view only;  ///< runs whose names contain this

template <class Run>
void compare(const char* name, std::string_view pinned, Run&& run) {
  if (!only.empty() && std::string_view(name).find(only) == std::string_view::npos) return;
  const std::string found = run();
  std::printf("%-28s %s%s\n", name, found.c_str(), found == pinned ? "" : "  differs");
  differences += found != pinned;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) only = argv[1];
  if (argc > 2) interval = std::atoi(argv[2]);
  const std::string file = "/tmp/talus_bits_" + std::to_string(getpid()) + ".h5";
  const double dt = 1.0 / 240;
  const course saved{4, 700, dt, file}, loaded{1, 700, dt, "", file};
  compare("balls, 1 rank", "cf75993951e35844", [&] { return balls({1, 800, dt}); });
  compare("balls, 4 ranks", "cf75993951e35844", [&] { return balls({4, 800, dt}); });
  compare("crates, 1 rank", "15318d5aa486e50f", [&] { return crates({1, 700, dt}); });
  compare("crates, 4 ranks", "15318d5aa486e50f", [&] { return crates({4, 700, dt}); });
  compare("shapes, 1 rank", "ce9ec6a7c56195f0", [&] { return shapes({1, 700, dt}); });
  compare("shapes, 4 ranks", "ce9ec6a7c56195f0", [&] { return shapes(saved); });
  compare("shapes, restarted on 1 rank", "ce9ec6a7c56195f0", [&] { return shapes(loaded); });
  compare("shear, 1 rank", "514f663fb44e330b", [&] { return shear({1, 600, dt}); });
  compare("shear, 4 ranks", "514f663fb44e330b", [&] { return shear({4, 600, dt}); });
  compare("sand, 1 rank", "ae06e73812189db4", [&] { return sand({1, 2000, dt / 8}); });
  compare("sand, 4 ranks", "ae06e73812189db4", [&] { return sand({4, 2000, dt / 8}); });
  unlink(file.c_str());
  if (differences > 0)
    std::printf("%d digests differ from those pinned in scenes.cpp\n", differences);
  return differences > 0;
}
