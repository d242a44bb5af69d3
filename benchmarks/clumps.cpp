// Grains of ten overlapping spheres, the usual clumps of DEM, and spheres of the same volumes:
//   clumps settle sphere|clump hard|soft SIDE STEPS RANKS    SIDE^3 grains settle in a box: what a
//                                                            step costs for each contact
//   clumps heap sphere|clump hard SIDE STEPS RANKS           a column collapses: the slope of the
//   heap
#include <time.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/each_contact.hpp>
#include <talus/world/world.hpp>
#include <vector>

namespace {

using namespace talus;
using clump = union_of<sphere>;

/// A sphere with nine smaller ones around it, some longer than wide.
clump grain(double size) {
  std::vector<clump::part> parts{{.shape = sphere{0.5 * size}}};
  for (int k = 0; k < 9; ++k) {
    const double z = (2 * k + 1) / 9. - 1, turn = 2.399963 * k, r = std::sqrt(1 - z * z);
    parts.push_back({.shape = sphere{0.32 * size},
                     .at = {0.4 * size * vec3(r * std::cos(turn), r * std::sin(turn), 1.3 * z)}});
  }
  return clump(parts);
}
template <class Shape>
std::array<Shape, 4> forms() {
  std::array<Shape, 4> all;
  for (std::size_t k = 0; k < 4; ++k) {
    const clump c = grain(0.85 + 0.05 * static_cast<double>(k));
    if constexpr (std::is_same_v<Shape, clump>)
      all[k] = c;
    else
      all[k] = sphere{std::cbrt(c.volume() * 3 / (4 * pi))};
  }
  return all;
}

double processor_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct settings {
  bool heap;
  int side, steps, ranks;
};

template <class Shape, class Contact, class Integrator>
void run(const settings& how) {
  using scene = scenario<bodies<Shape, plane>, Contact, Integrator,
                         decomposition<grid<dynamic, dynamic>>, transport<threads>>;
  constexpr bool soft = scene::contact_law::soft;
  const double spacing = 1.5, half = how.side * spacing / 2, wall = how.heap ? 10 * half : half;
  const double dt = soft ? 1e-4 : 1. / 240;
  threads::launch({.ranks = how.ranks}, [&](auto& link) {
    world<scene> w(link);
    const int across = how.ranks % 2 == 0 ? 2 : 1;
    w.decompose(
        {.cells = {how.ranks / across, across}, .lower = {-half, -half}, .upper = {half, half}});
    w.gravity({0, 0, -9.81});
    material stone{.density = 2.6, .restitution = soft ? 0.3 : 0., .friction = 0.5};
    if constexpr (soft) stone.youngs_modulus = 1e6, stone.poisson_ratio = 0.25;
    const auto m = w.material(stone);
    w.global([&](auto& s) {
      s.add(plane{}, m);
      for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
        s.add(plane{.normal = n, .offset = -wall}, m);
    });
    const auto shapes = forms<Shape>();
    w.fill(simple_cubic{.spacing = spacing,
                        .origin = {0.5 * spacing - half, 0.5 * spacing - half, 0.9}} &
               box_region{{-half, -half, 0}, {half, half, how.side * spacing + 0.5}},
           [&](const site& s, random_stream& random) {
             return body<Shape>{.shape = shapes[random.integer(4)],
                                .position = s.position,
                                .material = m,
                                .velocity = 0.3 * random.unit_vector(),
                                .orientation = random.rotation()};
           });
    const int last = how.steps / 10;
    for (int k = last; k < how.steps; ++k) w.step(dt);
    const double before = processor_seconds();
    for (int k = 0; k < last; ++k) w.step(dt);
    std::array<double, 2> sums{processor_seconds() - before, 0};
    for_each_contact(w, [&](const loaded_contact&) { sums[1] += 1; });
    // Heights of the highest points over rings about the axis.
    constexpr std::size_t rings = 40;
    const double wide = half / 8;
    std::array<double, rings> tops{};
    w.for_each_local([&](const auto& b) {
      const vec3& x = b.position();
      const auto ring = static_cast<std::size_t>(std::hypot(x[0], x[1]) / wide);
      if (ring < rings) tops[ring] = std::max(tops[ring], x[2]);
    });
    link.reduce(reduction::sum, std::span(sums));
    link.reduce(reduction::max, std::span(tops));
    const auto motion = measure_motion(w);
    const auto overlap = measure_penetration(w);
    if (link.rank() > 0) return;
    const double n = static_cast<double>(motion.bodies), each = sums[0] / last / sums[1];
    std::printf(
        "%s %s, %d ranks: %.0f bodies, mass %.9g, %.2f contacts a body, %.3f us a contact "
        "and step, largest overlap %.1e, speed %.1e, centre at %.4f\n",
        Shape::name, soft ? "soft" : "hard", how.ranks, n, motion.mass, sums[1] / n, 1e6 * each,
        overlap.max, motion.max_speed, motion.potential_energy / (motion.mass * 9.81));
    if (!how.heap) return;
    // A line through the tops between the axis and the foot, without the round top.
    double sr = 0, sz = 0, srr = 0, srz = 0, count = 0;
    for (std::size_t k = 4; k < rings && tops[k] > 1.5; ++k) {
      const double r = (static_cast<double>(k) + 0.5) * wide;
      sr += r, sz += tops[k], srr += r * r, srz += r * tops[k], ++count;
    }
    const double slope = (count * srz - sr * sz) / (count * srr - sr * sr);
    std::printf("  slope %.1f degrees over %.0f rings\n", std::atan(-slope) * 180 / pi, count);
  });
}

template <class Shape>
void run(const std::string& law, const settings& how) {
  if (law == "soft")
    run<Shape, soft_contact<hertz_mindlin, coulomb_friction>, integrator<velocity_verlet>>(how);
  else
    run<Shape, hard_contact<coulomb_friction, newton_restitution>, integrator<semi_implicit_euler>>(
        how);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 7) {
    std::fprintf(stderr, "clumps settle|heap sphere|clump hard|soft SIDE STEPS RANKS\n");
    return 1;
  }
  const auto number = [&](int k) { return std::atoi(arguments[k]); };
  const settings how{std::string(arguments[1]) == "heap", number(4), number(5), number(6)};
  if (std::string(arguments[2]) == "sphere")
    run<sphere>(arguments[3], how);
  else
    run<clump>(arguments[3], how);
}
