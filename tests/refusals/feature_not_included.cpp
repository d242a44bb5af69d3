// expects: a world with a feature of one's own needs what its hooks see: write #include
// <talus/feature.hpp>
// long
#include "talus/parallel/serial.hpp"
#ifdef TALUS_CONTROL
#include "talus/feature.hpp"
#endif
#include "talus/world/world.hpp"
using namespace talus;

struct watcher {
  using talus_part_of = roles::features;
  static constexpr const char* name = "watcher";
  struct state {
    std::uint64_t steps = 0;
  };
  struct hooks {
    template <class Stage>
    static void at_end(Stage& stage) {
      ++stage.state().steps;
    }
  };
};
using scene = scenario<bodies<sphere>, transport<serial>, features<watcher>>;

void go(world<scene>& w) { w.step(0.01); }

int main() {}
