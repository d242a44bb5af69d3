// expects: this scenario does not have this feature: add it to its features<...>
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere>, transport<serial>, features<checkpoints>>;
#else
using scene = scenario<bodies<sphere>, transport<serial>>;
#endif

int main() {
  serial::link link;
  world<scene> w(link);
  int count = 0;
  w.keep("count", count);
}
