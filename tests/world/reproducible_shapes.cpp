// The same bits on any number of ranks, for any decomposition: rotating shapes.
// timeout: 300
// long
#include "reproducible.hpp"

#include <talus/scene/lattice.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/superellipsoid.hpp>
#include <talus/shape/union_of.hpp>

namespace {

using dumbbell = union_of<sphere, capsule>;
template <class... Shapes>
using heap = scenario<bodies<Shapes..., plane>, solver<reproducible>, transport<threads>,
                      decomposition<any_decomposition>>;

quat any_turn(random_stream& random) {
  return rotation(random.uniform(vec3(-1, -1, 0.1), vec3(1, 1, 1)).normalized(),
                  random.uniform(0.0, 3.0));
}

template <class MakeBody>
void fill(auto& w, std::size_t count, MakeBody&& make) {
  const auto sites =
      simple_cubic{.spacing = 1.1, .origin = {-3.3, -3.3, 0.7}} & vertical_cylinder{.radius = 3.6};
  w.fill(sites.first(count), [&](const site& place, random_stream& random) {
    auto b = make(random);
    b.position = place.position;
    b.orientation = any_turn(random);
    b.velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0));
    return b;
  });
}

const auto nothing = [](auto&, int) {};

}  // namespace

TEST_CASE("a heap of boxes with friction has the same bits on any ranks") {
  check_same<heap<box>>(
      400,
      [](auto& w) {
        fill(w, 150, [](random_stream& random) {
          return body{.shape = box{random.uniform(vec3(0.4, 0.4, 0.3), vec3(0.7, 0.6, 0.6))}};
        });
      },
      nothing);
}

TEST_CASE("a heap of superellipsoids beside spheres and boxes has the same bits on any ranks") {
  check_same<heap<superellipsoid, sphere, box>>(
      300,
      [](auto& w) {
        fill(w, 80, [](random_stream& random) {
          const real n1 = random.uniform(2.0, 8.0), n2 = random.uniform(2.0, 8.0);
          return body{.shape = superellipsoid{
                          random.uniform(vec3(0.2, 0.2, 0.2), vec3(0.4, 0.4, 0.4)), n1, n2}};
        });
        const auto above = [&](double z) {
          return simple_cubic{.spacing = 1.1, .origin = {-3.3, -3.3, z}} &
                 vertical_cylinder{.radius = 3.6};
        };
        w.fill(above(4.5).first(30), [](const site& place, random_stream& random) {
          return body{.shape = sphere{random.uniform(0.2, 0.4)}, .position = place.position};
        });
        w.fill(above(6).first(30), [&](const site& place, random_stream& random) {
          return body{.shape = box{{0.5, 0.4, 0.6}},
                      .position = place.position,
                      .orientation = any_turn(random)};
        });
      },
      nothing);
}

TEST_CASE("a heap of capsules, spheres and unions has the same bits on any ranks") {
  check_same<heap<sphere, capsule, dumbbell>>(
      300,
      [](auto& w) {
        using any = std::variant<body<sphere>, body<capsule>, body<dumbbell>>;
        (void)sizeof(any);
        fill(w, 60, [](random_stream& random) {
          return body{.shape = capsule{random.uniform(0.15, 0.25), random.uniform(0.2, 0.5)}};
        });
        const auto above = [&](double z) {
          return simple_cubic{.spacing = 1.1, .origin = {-3.3, -3.3, z}} &
                 vertical_cylinder{.radius = 3.6};
        };
        w.fill(above(4).first(40), [](const site& place, random_stream& random) {
          return body{.shape = sphere{random.uniform(0.2, 0.4)}, .position = place.position};
        });
        const dumbbell shape({{sphere{0.3}, {{-0.4, 0, 0}}},
                              {sphere{0.2}, {{0.4, 0, 0}}},
                              {capsule{0.1, 0.8}, {{0, 0, 0}}}});
        w.fill(above(6).first(30), [&](const site& place, random_stream& random) {
          return body{.shape = shape, .position = place.position, .orientation = any_turn(random)};
        });
      },
      nothing);
}
