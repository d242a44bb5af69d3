// What sleeping islands cost and save: a settled pile of spheres in a program without the feature,
// in one with it that stays awake, asleep, and asleep below a ball that falls on it.
#include <algorithm>
#include <talus/core/clock.hpp>
#include <talus/observe/memory.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>

#include "scenes/pile_scene.hpp"
#include "scenes/protocol.hpp"

namespace {

using namespace talus;

template <class... Features>
class pile {
 public:
  using scenario = talus::scenario<talus::bodies<sphere, plane>, features<damping, Features...>,
                                   transport<serial>>;
  static constexpr bool sleeps = scenario::template has_feature<sleeping>;

  pile(std::uint64_t bodies, std::uint64_t settle) {
    const auto stuff = w_.material({.density = 1, .restitution = 0, .friction = 0.5});
    w_.gravity({0, 0, -9.81});
    w_.damping(0.5);  // spheres that spin on the spot are braked by nothing else
    if constexpr (sleeps) w_.sleeping({.speed = 0.05, .time = 1e9});
    const std::size_t sites = bench::pile_sites(bodies);
    const double side = bench::pile_side(bodies);
    w_.global([&](auto& scope) {
      scope.add(plane{.normal = {0, 0, 1}, .offset = 0}, stuff);
      scope.add(plane{.normal = {1, 0, 0}, .offset = 0}, stuff);
      scope.add(plane{.normal = {-1, 0, 0}, .offset = -side}, stuff);
      scope.add(plane{.normal = {0, 1, 0}, .offset = 0}, stuff);
      scope.add(plane{.normal = {0, -1, 0}, .offset = -side}, stuff);
    });
    for (std::uint64_t n = 0; n < bodies; ++n) {
      bench::dice random(1, n);
      const auto at = [&](std::size_t i) {
        return 1.05 * (static_cast<double>(i) + 0.5) + random.between(-0.02, 0.02);
      };
      w_.add(body{.shape = sphere{random.between(0.4, 0.5)},
                  .position = {at(n % sites), at(n / sites % sites), at(n / sites / sites)},
                  .material = stuff});
    }
    run(settle);
  }
  void run(std::uint64_t steps) {
    for (std::uint64_t k = 0; k < steps; ++k) w_.step(1.0 / 240);
  }
  /// Median processor time of a step, in ms.
  [[nodiscard]] double median(std::uint64_t steps) {
    bench::stopwatch watch;
    for (std::uint64_t k = 0; k < steps; ++k) watch.time([&] { run(1); });
    return watch.median();
  }
  [[nodiscard]] double bytes_per_body() {
    return static_cast<double>(bytes_in_use(w_)) / static_cast<double>(measure_motion(w_).bodies);
  }
  [[nodiscard]] world<scenario>& get() { return w_; }

 private:
  serial::link link_;
  world<scenario> w_{link_};
};

void run(std::uint64_t bodies, std::uint64_t settle, std::uint64_t measure,
         const std::string& file) {
  bench::record out;
  out.add("engine", "talus");
  out.add("scene", "sleeping pile");
  out.add("bodies", bodies);
  {
    pile<> plain(bodies, settle);
    out.add("without_ms_per_step", plain.median(measure));
    out.add("without_bytes_per_body", plain.bytes_per_body());
  }
  pile<sleeping> p(bodies, settle);
  out.add("awake_ms_per_step", p.median(measure));
  out.add("awake_bytes_per_body", p.bytes_per_body());
  p.get().sleeping({.speed = 0.05, .time = 0.01});
  p.run(16);
  out.add("asleep", measure_motion(p.get()).asleep);
  out.add("asleep_ms_per_step", p.median(measure));
  out.add("asleep_bytes_per_body", p.bytes_per_body());
  const double side = bench::pile_side(bodies);
  p.get().add(body{.shape = sphere{0.5}, .position = {side / 2, side / 2, 3 * side}});
  out.add("below_a_falling_ball_ms_per_step", p.median(measure));
  out.add("asleep_below_it", measure_motion(p.get()).asleep);
  out.add("settle", settle);
  out.add("measure", measure);
  out.write(file);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto bodies = args.count("bodies", 8000);
    const auto settle = args.count("settle", 2600);
    const auto measure = args.count("measure", 120);
    const auto file = args.json_file();
    if (!args.done()) return;
    run(bodies, settle, measure, file);
  });
}
