// Piles of what is neither sphere nor box: capsules, ellipsoids, and unions of three spheres. In
// talus alone, judged by its own measure of overlaps, which is geometry and not what the solver
// believes.
#include <array>
#include <cmath>
#include <talus/core/clock.hpp>
#include <talus/observe/memory.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/observe/residual.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/ellipsoid.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/world.hpp>

#include "scenes/pile_scene.hpp"
#include "scenes/protocol.hpp"

namespace {

using namespace talus;
using clump = union_of<sphere>;

/// Half as long again as thick, to three times.
struct capsules {
  using shape = capsule;
  static constexpr double reach = 0.7;
  shape operator()(bench::dice& random) const {
    return {.radius = 0.3, .length = random.between(0.3, 0.8)};
  }
};
/// Of the form 1 : 1 : 2, as large as the spheres.
struct eggs {
  using shape = ellipsoid;
  static constexpr double reach = 0.8;
  shape operator()(bench::dice& random) const {
    const double r = random.between(0.3, 0.5) / 1.2599210498948732;
    return {.radii = {r, r, 2 * r}};
  }
};
/// For comparison, by the same program.
struct balls {
  using shape = sphere;
  static constexpr double reach = 0.5;
  shape operator()(bench::dice& random) const { return {.radius = random.between(0.3, 0.5)}; }
};
/// Three overlapping spheres in a triangle, of four sizes: bodies of one size share their parts.
struct clumps {
  using shape = clump;
  static constexpr double reach = 0.66;
  std::array<clump, 4> forms = [] {
    const auto of = [](double size) {
      const double r = 0.3 * size, far = 0.3 * size;
      return clump{{{.shape = sphere{r}, .at = {{far, 0, 0}}},
                    {.shape = sphere{r}, .at = {{-0.5 * far, std::sqrt(0.75) * far, 0}}},
                    {.shape = sphere{r}, .at = {{-0.5 * far, -std::sqrt(0.75) * far, 0}}}}};
    };
    return std::array<clump, 4>{of(0.8), of(0.9), of(1.0), of(1.1)};
  }();
  const shape& operator()(bench::dice& random) const {
    return forms[static_cast<std::size_t>(random.between(0, 4))];
  }
};

quat turn(bench::dice& random) {
  double q[4], norm = 0;
  while (norm < 0.01 || norm > 1) {
    norm = 0;
    for (double& x : q) x = random.between(-1, 1), norm += x * x;
  }
  norm = 1 / std::sqrt(norm);
  return {q[0] * norm, q[1] * norm, q[2] * norm, q[3] * norm};
}

template <class Kind>
void run(const std::string& name, std::uint64_t bodies, std::uint64_t settle, std::uint64_t measure,
         std::uint64_t iterations, const std::string& file) {
  using shape = typename Kind::shape;
  using scenario = talus::scenario<talus::bodies<shape, plane>, transport<serial>>;
  serial::link link;
  world<scenario> w(link);
  const auto stuff = w.material({.density = 1, .restitution = 0, .friction = 0.5});
  w.gravity({0, 0, -9.81});
  const double spacing = 2.1 * Kind::reach;
  const std::size_t sites = bench::pile_sites(bodies);
  const double side = spacing * static_cast<double>(sites);
  w.global([&](auto& scope) {
    scope.add(plane{.normal = {0, 0, 1}, .offset = 0}, stuff);
    scope.add(plane{.normal = {1, 0, 0}, .offset = 0}, stuff);
    scope.add(plane{.normal = {-1, 0, 0}, .offset = -side}, stuff);
    scope.add(plane{.normal = {0, 1, 0}, .offset = 0}, stuff);
    scope.add(plane{.normal = {0, -1, 0}, .offset = -side}, stuff);
  });
  const Kind kind;
  for (std::uint64_t n = 0; n < bodies; ++n) {
    bench::dice random(1, n);
    const auto at = [&](std::size_t i) { return spacing * (static_cast<double>(i) + 0.5); };
    w.add(body<shape>{.shape = kind(random),
                      .position = {at(n % sites), at(n / sites % sites), at(n / sites / sites)},
                      .material = stuff,
                      .orientation = turn(random)});
  }
  if (iterations > 0) w.solver().iterations = static_cast<int>(iterations);
  const double dt = 1.0 / 240;
  for (std::uint64_t k = 0; k < settle; ++k) w.step(dt);
  const stage_seconds before = w.stage_times();
  bench::stopwatch watch;
  for (std::uint64_t k = 0; k < measure; ++k) watch.time([&] { w.step(dt); });
  const stage_seconds now = w.stage_times();

  std::size_t contacts = 0;
  talus::detail::state_of(w).each_contact_list([&](const auto& list) { contacts += list.size(); });
  const auto overlap = measure_penetration(w);
  bench::record out;
  out.add("engine", "talus");
  out.add("scene", name);
  out.add("bodies", bodies);
  out.add("cpu_ms_per_step", watch.mean());
  out.add("cpu_ms_per_step_median", watch.median());
  out.add("cpu_ms_per_step_fastest", watch.fastest());
  out.add("contacts", contacts);
  out.add("iterations", w.solver().iterations);
  out.add("penetration_mean", overlap.mean);
  out.add("penetration_max", overlap.max);
  out.add("contact_residual", measure_residual(w).value);
  out.add("kinetic_energy_per_body",
          measure_motion(w).kinetic_energy / static_cast<double>(bodies));
  const double steps = static_cast<double>(std::max<std::uint64_t>(1, measure));
  out.add("detect_ms_per_step", 1e3 * (now.detect - before.detect) / steps);
  out.add("respond_ms_per_step", 1e3 * (now.respond - before.respond) / steps);
  out.add("integrate_ms_per_step", 1e3 * (now.integrate - before.integrate) / steps);
  out.add("bytes_in_use_per_body",
          static_cast<double>(bytes_in_use(w)) / static_cast<double>(bodies));
  out.add("settle", settle);
  out.add("measure", measure);
  out.write(file);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto shape = args.text("shape", "capsule");
    const auto bodies = args.count("bodies", 1000);
    const auto settle = args.count("settle", 720);
    const auto measure = args.count("measure", 120);
    const auto iterations = args.count("iterations", 0);
    const auto file = args.json_file();
    if (!args.done()) return;
    if (shape == "capsule")
      run<capsules>("capsules", bodies, settle, measure, iterations, file);
    else if (shape == "union")
      run<clumps>("unions of three spheres", bodies, settle, measure, iterations, file);
    else if (shape == "ellipsoid")
      run<eggs>("ellipsoids 1 : 1 : 2", bodies, settle, measure, iterations, file);
    else if (shape == "sphere")
      run<balls>("spheres", bodies, settle, measure, iterations, file);
    else
      throw std::invalid_argument("there is no shape '" + shape +
                                  "'; there are capsule, ellipsoid, sphere and union");
  });
}
