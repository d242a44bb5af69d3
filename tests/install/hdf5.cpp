#include <cstdio>
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>

using namespace talus;
using scene = scenario<bodies<sphere>, transport<as_launched>, features<checkpoints>>;

int main(int argc, char** argv) {
  std::string before, after;
  launch_settings how{.argc = &argc, .argv = &argv};
  as_launched::launch(how, [&](auto& link) {
    world<scene> written(link), read(link);
    const auto stone = written.material({.density = 2});
    read.material({.density = 2});
    written.add(sphere{0.5}, stone);
    write_checkpoint(written, "installed.h5");
    read_checkpoint(read, "installed.h5");
    before = state_digest(written), after = state_digest(read);
  });
  std::remove("installed.h5");
  return !before.empty() && before == after ? 0 : 1;
}
