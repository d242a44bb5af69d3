#include "runner.hpp"
#include "talus_toss.hpp"

int main(int argc, char** argv) {
  return bench::tosses::run<bench::tosses::talus_toss>(argc, argv);
}
