#include <talus/talus.hpp>

using scene = talus::scenario<talus::bodies<talus::sphere>>;

int main() {
  [[maybe_unused]] const scene checked;
  const talus::sphere ball{.radius = 2};
  fmt::print("a ball of radius {} has the volume {}\n", ball.radius, ball.volume());
  return ball.volume() > 33.5 && ball.volume() < 33.6 ? 0 : 1;
}
