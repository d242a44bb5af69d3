// One point of a work-precision plot in Bullet: --scene, --dt, --iterations, --size.
#include "scenes/bullet_engine.hpp"
#include "scenes/precision.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto chosen = bench::setting::from(args);
    if (!args.done()) return;
    using engine = bench::bullet_engine;
    bench::run_precision<engine>(chosen, engine::name());
  });
}
