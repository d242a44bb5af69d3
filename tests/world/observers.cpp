// The values of observers are correct: fields add up to the bodies and to the weight above, flow to
// the crossings, contacts to the forces, on any number of ranks.
// long
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <talus/observe.hpp>
#include <talus/observe/force.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

template <class Law, class... More>
using scene = scenario<bodies<sphere, plane>, Law, decomposition<grid<dynamic, dynamic, dynamic>>,
                       transport<threads>, More...>;
using hard = scene<hard_contact<coulomb_friction>>;
using soft = scene<soft_contact<linear_spring_dashpot, coulomb_friction>>;

constexpr real g = 10, width = 2;

/// A column of spheres on the ground, held by smooth walls so that the ground bears all.
template <class World>
void set_up_column(World& w, int height = 8) {
  if (w.ranks() > 1) w.decompose({.lower = {-1, -1, 0}, .upper = {1, 1, 1.0 * height}});
  w.gravity({0, 0, -g});
  const auto stone =
      w.material({.density = 2, .restitution = 0.2, .friction = 0.3, .stiffness = 5e3});
  const auto smooth = w.material({.restitution = 0.2, .stiffness = 5e3});
  w.material_pair(stone, smooth, {});
  w.global([&](auto& scope) {
    scope.add(plane{}, stone);
    for (const real side : {-1.0, 1.0}) {
      scope.add(plane{.normal = {side, 0, 0}, .offset = -width / 2}, smooth);
      scope.add(plane{.normal = {0, side, 0}, .offset = -width / 2}, smooth);
    }
  });
  w.fill(simple_cubic{.spacing = 0.5, .origin = {0.25, 0.25, 0.25}} &
             box_region{{-1, -1, 0}, {1, 1, 0.5 * height}},
         [&](const site& place, random_stream& random) {
           return body{.shape = sphere{random.uniform(0.2, 0.24)},
                       .position = place.position,
                       .material = stone,
                       .velocity = random.unit_vector()};
         });
}

/// Over all ranks.
template <class World>
double sum_of(World& w, double mine) {
  w.link().reduce(reduction::sum, std::span(&mine, 1));
  return mine;
}

template <class Scenario>
void check_fields(int ranks, double close) {
  threads::launch({.ranks = ranks}, [&](auto& link) {
    world<Scenario> w(link);
    set_up_column(w);
    const bool hard_ones = !Scenario::contact_law::soft;
    const std::size_t steps = hard_ones ? 240 : 3000;  // at rest by then
    const double dt = hard_ones ? 0.01 : 0.001;
    w.simulate({.steps = steps, .dt = dt});

    const field_grid cells{.lower = {-1, -1, 0}, .upper = {1, 1, 4}, .cells = {2, 1, 8}};
    coarse_fields mean(cells);
    w.observe(every{5}, [&](auto& now) { mean += measure_fields(now, cells); });
    w.simulate({.steps = 50, .dt = dt});
    CHECK(w.steps() == steps + 50);
    CHECK(mean.samples() == 10);

    const coarse_fields now = measure_fields(w, cells);
    CHECK(now.samples() == 1);
    double mass = 0, bodies = 0, in_cells = 0, volume = 0, solid = 0;
    vec3 momentum{0, 0, 0}, in_cells_momentum{0, 0, 0};
    w.for_each_local([&](const auto& b) {
      mass += b.mass(), ++bodies, volume += b.shape().volume();
      momentum += b.mass() * b.velocity();
    });
    for (std::size_t c = 0; c < cells.size(); ++c) {
      in_cells += now.mass(c);
      in_cells_momentum += now.mass(c) * now.velocity(c);
      solid += now.solid_fraction(c) * (1 * 2 * 0.5);
    }
    mass = sum_of(w, mass), bodies = sum_of(w, bodies), volume = sum_of(w, volume);
    CHECK(bodies == 128);
    CHECK(in_cells == doctest::Approx(mass).epsilon(1e-12));
    CHECK(solid == doctest::Approx(volume).epsilon(1e-12));
    for (int k = 0; k < 3; ++k) {
      const double all = sum_of(w, momentum[k]);
      CHECK(in_cells_momentum[k] == doctest::Approx(all).epsilon(1e-9));
    }
    // In a slice the stress is the mean over heights of the load above, which is known exactly.
    const int slices = 8;
    const double h = 0.5, area = width * width;
    std::vector<double> borne(slices);
    w.for_each_local([&](const auto& b) {
      for (int k = 0; k < slices; ++k) {
        const double part = std::clamp((b.position()[2] - k * h) / h, 0.0, 1.0);
        borne[static_cast<std::size_t>(k)] += part * b.mass() * g / area;
      }
    });
    for (int k = 0; k < slices; ++k) {
      const double expected = -sum_of(w, borne[static_cast<std::size_t>(k)]);
      const double zz =
          0.5 * (now.stress(cells.index(0, 0, k))(2, 2) + now.stress(cells.index(1, 0, k))(2, 2));
      const double zz_mean =
          0.5 * (mean.stress(cells.index(0, 0, k))(2, 2) + mean.stress(cells.index(1, 0, k))(2, 2));
      CAPTURE(k);
      CHECK(std::abs(zz - expected) < close * mass * g / area);
      CHECK(std::abs(zz_mean - expected) < close * mass * g / area);
    }

    // Every contact once; together with the ground they bear the weight.
    double contacts = 0, up = 0, sliding = 0;
    for_each_contact(w, [&](const loaded_contact& c) {
      ++contacts;
      CHECK(c.normal_force() >= 0);
      sliding = std::max(sliding, c.tangential_force().norm() - 0.32 * c.normal_force());
      if (c.centre_b == c.point && c.normal[2] > 0.5) up += c.force[2];
    });
    CHECK(sum_of(w, up) == doctest::Approx(mass * g).epsilon(close));
    CHECK(sliding < 1e-3);
    const coordination z = measure_coordination(w);
    CHECK(z.bodies == 128);
    CHECK(z.alone < 10);
    CHECK(z.mean > 3);
    CHECK(z.mean < 7);
    CHECK(z.mean_of_touching == doctest::Approx(z.mean * 128 / (128.0 - z.alone)));
  });
}

}  // namespace

TEST_CASE("density, velocity and stress of a column at rest") {
  check_fields<hard>(1, 0.01);
  check_fields<hard>(2, 0.01);
}
TEST_CASE("the same of soft contacts") {
  check_fields<soft>(1, 0.01);
  check_fields<soft>(2, 0.01);
}

TEST_CASE("the stress of two spheres is that of the line between them") {
  threads::launch({.ranks = 1}, [&](auto& link) {
    world<hard> w(link);
    const field_grid cells{.lower = {0, 0, 0}, .upper = {4, 1, 1}, .cells = {4, 1, 1}};
    coarse_fields f(cells, 1);
    f.add_force({3.25, 0.5, 0.5}, {0.75, 0.5, 0.5}, {10, 2, 0});  // a quarter, one, one, a quarter
    const double part[] = {0.25, 1, 1, 0.25};
    for (std::size_t c = 0; c < 4; ++c) {
      CHECK(f.contact_stress(c)(0, 0) == doctest::Approx(-10 * part[c]));
      CHECK(f.contact_stress(c)(1, 0) == doctest::Approx(-2 * part[c]));
      CHECK(f.contact_stress(c)(0, 1) == 0);
    }
    f.add_force({-1, 0.5, 0.5}, {0.5, 0.5, 0.5}, {-4, 0, 0});  // from within to outside
    CHECK(f.contact_stress(0)(0, 0) == doctest::Approx(-2.5 - 4 * 0.5));
    CHECK(f.contact_stress(1)(0, 0) == doctest::Approx(-10));
    f.add_force({0.5, 5, 0.5}, {0.5, 2, 0.5}, {0, 4, 0});  // outside
    CHECK(f.contact_stress(0)(1, 1) == 0);
    f.add_body({2.5, 0.5, 0.5}, {1, 0, 0}, 3, 0.5), f.add_body({2.5, 0.1, 0.1}, {-1, 0, 2}, 3, 0.5);
    CHECK(f.density(2) == 6);
    CHECK(f.velocity(2) == vec3(0, 0, 1));
    CHECK(f.kinetic_stress(2)(0, 0) == -6);
    CHECK(f.kinetic_stress(2)(2, 2) == -6);
    CHECK(f.kinetic_stress(2)(0, 2) == 6);
    f.add_body({4, 0.5, 0.5}, {0, 0, 0}, 3, 1);  // on the upper face: outside
    CHECK(f.density(3) == 0);

    coarse_fields other({.lower = {0, 0, 0}, .upper = {4, 1, 1}, .cells = {2, 1, 1}});
    CHECK_THROWS_WITH(other += f, doctest::Contains("fields on two grids were added"));
    CHECK_THROWS_WITH((void)measure_fields(w, {.lower = {0, 0, 0}, .upper = {1, 0, 1}}),
                      doctest::Contains("a volume between them"));
    CHECK_THROWS_WITH((void)measure_fields(w, {.cells = {1, 0, 1}}),
                      doctest::Contains("was given 1 times 0 times 1"));
    CHECK_THROWS_WITH(w.observe(every{0}, [](auto&) {}), doctest::Contains("every 0 steps"));
  });
}

TEST_CASE("flow through a plane is what has passed it, body by body, also from rank to rank") {
  std::array<flow, 4> found{};
  int n = 0;
  for (const int ranks : {1, 2, 8})
    threads::launch(
        {.ranks = ranks},
        [&](auto& link) {
          world<hard> w(link);
          if (ranks > 1)
            w.decompose({.cells = {ranks == 8 ? 2 : 1, ranks == 8 ? 2 : 1, 2},
                         .lower = {-4, -4, -4},
                         .upper = {4, 4, 4}});
          w.gravity({0, 0, -g});
          const auto stone = w.material({.density = 2});
          // Some rise through the plane and fall back, some are removed below it, and some that are
          // added there do not count. None meets another.
          w.fill(simple_cubic{.spacing = 0.5, .origin = {0, 0, 0.25}} &
                     box_region{{-3.6, -3.6, -1.6}, {3.6, 3.6, 3.6}},
                 [&](const site& place, random_stream& random) {
                   const auto [x, y, z] = [&] {
                     std::array<long, 3> n{};
                     for (int k = 0; k < 3; ++k)
                       n[static_cast<std::size_t>(k)] =
                           std::lround(2 * place.position[k] - 0.5 * (k == 2));
                     return n;
                   }();
                   std::optional<body<sphere>> made;
                   if ((x + 3 * y - z + 110) % 11 == 0)  // one above each point of the ground
                     made = body{.shape = sphere{random.uniform(0.1, 0.2)},
                                 .position = place.position,
                                 .material = stone,
                                 .velocity = {0, 0, random.uniform(-3., 6.)}};
                   return made;
                 });
          double started_above = 0, gone = 0, up = 0;
          w.for_each_local([&](const auto& b) {
            started_above += b.position()[2] >= 0;
            const double z = b.position()[2], v = b.velocity()[2];
            up += z < 0 && v > 0 && v * v > -2 * g * z;
          });
          const flow_meter down(w, plane{.normal = {0, 0, -1}, .offset = 0});
          w.after_each_step([&] {
            w.destroy_if([&](const auto& b) {
              if (b.position()[2] > -3.9) return false;
              ++gone;
              return true;
            });
          });
          std::uint64_t calls = 0;
          w.observe(every{40}, [&](auto& now) {
            ++calls;
            if (const vec3 place(0.25, 0.25, -2); now.contains(place))
              (void)now.add(body{.shape = sphere{0.04}, .position = place, .material = stone});
          });
          w.simulate({.steps = 200, .dt = 0.005});
          CHECK(calls == 5);
          CHECK(w.steps() == 200);
          double above = 0;
          w.for_each_local([&](const auto& b) { above += b.position()[2] >= 0; });
          const flow f = down.total();
          above = sum_of(w, above), started_above = sum_of(w, started_above), up = sum_of(w, up);
          CHECK(f.bodies() == started_above - above);  // nothing is added above
          CHECK(up > 10);
          CHECK(std::abs(static_cast<double>(f.backward) - up) <= 2);  // rising, in steps
          CHECK(f.forward > 100);
          CHECK(sum_of(w, gone) > 50);
          if (w.rank() == 0) found[static_cast<std::size_t>(n)] = f;
        }),
        ++n;
  for (int k = 1; k < n; ++k) {
    const flow &f = found[static_cast<std::size_t>(k)], &one = found[0];
    CHECK(f.forward == one.forward);
    CHECK(f.backward == one.backward);
    CHECK(f.mass() == doctest::Approx(one.mass()).epsilon(1e-12));
  }
}
