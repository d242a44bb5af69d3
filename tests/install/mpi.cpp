#include <talus/mpi.hpp>

using scene = talus::scenario<talus::bodies<talus::sphere>, talus::transport<talus::mpi>>;

int main(int argc, char** argv) {
  [[maybe_unused]] const scene checked;
  int ranks = 0;
  talus::launch_settings how{.argc = &argc, .argv = &argv};
  talus::mpi::launch(how, [&](auto& link) { ranks = link.size(); });
  return ranks == 1 ? 0 : 1;
}
