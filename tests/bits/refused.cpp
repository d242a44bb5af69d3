// A reproducible world: refused if the compiler does not round as written.
#include <cstdio>
#include <talus/parallel/serial.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

using namespace talus;

int main() try {
  serial::link link;
  const world<scenario<bodies<sphere, plane>, solver<reproducible>, transport<serial>>> w(link);
  std::puts("this program may be reproducible");
} catch (const std::exception& e) {
  std::puts(e.what());
  return 3;
}
