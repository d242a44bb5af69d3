// Prints the reference values of the probes of a scene: reference SCENE.
#include "reference.hpp"

#include <cstdio>

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "reference SCENE\n");
    return 2;
  }
  std::printf("[");
  const char* between = "";
  for (const auto& row : bench::joints::reference(bench::joints::scene_of(argv[1]))) {
    std::printf("%s[", between);
    for (std::size_t i = 0; i < row.size(); ++i) std::printf("%s%.16g", i ? ", " : "", row[i]);
    std::printf("]");
    between = ", ";
  }
  std::printf("]\n");
} catch (const std::exception& problem) {
  std::fprintf(stderr, "%s\n", problem.what());
  return 1;
}
