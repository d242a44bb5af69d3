// The triangles near bodies are kept from step to step: the bits of a run are those of a run that
// searches the whole surface for each body in each step.
#include <doctest/doctest.h>

#include <string>
#include <talus/mesh.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <variant>
#include <vector>

#include "../landscape.hpp"

using namespace talus;

namespace {

/// A triangle_mesh that keeps nothing: the name by which worlds find its lists is no type.
struct searched_mesh : triangle_mesh {
  static constexpr int near_lists = 0;
  searched_mesh() = default;
  explicit searched_mesh(const triangle_mesh& m) : triangle_mesh(m) {}
  static searched_mesh unpack(detail::byte_reader& in) {
    return searched_mesh(triangle_mesh::unpack(in));
  }
};
template <class B, class Sink>
requires(std::is_same_v<B, sphere> ||
         std::is_same_v<B, box>) void collide(const searched_mesh& a, const pose& pa, const B& b,
                                              const pose& pb, real margin, Sink&& sink) {
  collide_pair(static_cast<const triangle_mesh&>(a), pa, b, pb, margin, sink);
}

template <class Mesh, class... Rest>
using scene = scenario<bodies<sphere, box, Mesh>, decomposition<grid<dynamic, dynamic>>,
                       transport<threads>, features<driven>, Rest...>;
template <class Mesh>
using pressed =
    scene<Mesh, soft_contact<hertz_mindlin, coulomb_friction>, integrator<velocity_verlet>>;
template <class Mesh>
using reproduced = scene<Mesh, hard_contact<coulomb_friction>, solver<reproducible>>;
template <class Mesh>
using swept = scene<Mesh, hard_contact<coulomb_friction>, solver<nonlinear_gauss_seidel>>;

enum class moves { nothing, floor, both };

/// Spheres and boxes slide and roll over hills in a box, and a wheel turns in the middle of them.
template <class Scenario, class Mesh>
std::string digest_of(int ranks, moves what) {
  std::string digest;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
    constexpr bool soft = Scenario::contact_law::soft;
    w.gravity({0, 0, -10});
    w.seed(5);
    const auto stuff = w.material({.density = 1,
                                   .restitution = soft ? 0.3 : 0.0,
                                   .friction = 0.2,
                                   .youngs_modulus = 2e4,
                                   .poisson_ratio = 0.2});
    w.global([&](auto& scope) {
      const auto put = [&](const triangle_mesh& m) {
        const pose at = placed(m);
        return scope.add(Mesh(m), stuff, at.position, at.orientation);
      };
      // Steep at the sides, and lower towards +x +y: bodies go from rank to rank.
      const auto ground = put(triangle_mesh(landscape(15, 12, [](real x, real y) {
        return 0.04 * (x * x + y * y) - 0.1 * (x + y) + 0.1 * std::cos(2 * x) * std::cos(3 * y);
      })));
      const auto wheel = put(tube_surface({.radius = 0.7, .height = 1.6}, {.sectors = 9}));
      if (what != moves::nothing)
        w.drive(ground, oscillation{.amplitude = {0.1, 0, 0.02}, .frequency = 3});
      if (what == moves::both) w.drive(wheel, turning{.axis = {0.1, 1, 0}, .speed = 5});
    });
    w.fill(simple_cubic{.spacing = 0.62} & box_region{{-2.5, -2.5, 1.3}, {2.5, 2.5, 2.7}},
           [&](const site& at, random_stream& random) -> std::variant<body<sphere>, body<box>> {
             const vec3 v = random.uniform(vec3(0, 0, -1), vec3(3, 3, 0));
             if (random.integer(4) == 0)
               return body{.shape = box{{0.4, 0.3, 0.35}},
                           .position = at.position,
                           .material = stuff,
                           .velocity = v,
                           .orientation = random.rotation()};
             return body{.shape = sphere{random.uniform(0.12, 0.25)},
                         .position = at.position,
                         .material = stuff,
                         .velocity = v};
           });
    const int steps = soft ? 500 : 150;
    for (int k = 0; k < steps; ++k) w.step(soft ? 0.002 : 0.005);
    const auto one = state_digest(w);
    if (link.rank() == 0) digest = one;
  });
  return digest;
}

template <template <class> class Scenario>
void compare(std::vector<int> ranks, std::vector<moves> all) {
  for (const moves what : all) {
    CAPTURE(static_cast<int>(what));
    const std::string expected = digest_of<Scenario<searched_mesh>, searched_mesh>(1, what);
    for (const int n : ranks)
      CHECK(digest_of<Scenario<triangle_mesh>, triangle_mesh>(n, what) == expected);
  }
}

}  // namespace

TEST_CASE("soft contacts with surfaces at rest and driven have the bits of whole searches") {
  compare<pressed>({1, 2, 4}, {moves::nothing, moves::floor, moves::both});
}
TEST_CASE("reproducible hard contacts with surfaces likewise") {
  compare<reproduced>({1, 4}, {moves::nothing, moves::both});
}
TEST_CASE("hard contacts of one rank likewise") {
  compare<swept>({1}, {moves::nothing, moves::floor, moves::both});
}
TEST_CASE("a blade that turns hits a body at rest which was out of reach at the last search") {
  threads::launch({}, [&](threads::link& link) {
    world<pressed<triangle_mesh>> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
    w.material({.density = 1, .friction = 0.2, .youngs_modulus = 2e4, .poisson_ratio = 0.2});
    w.global([&](auto& scope) {
      const triangle_mesh blade(
          std::vector<triangle_mesh::triangle>{{vec3(-2, 0, -1), vec3(2, 0, -1), vec3(2, 0, 1)},
                                               {vec3(-2, 0, -1), vec3(2, 0, 1), vec3(-2, 0, 1)}});
      const pose at = placed(blade);
      const auto turns = scope.add(blade, material_id{}, at.position, at.orientation);
      w.drive(turns, turning{.axis = {0, 0, 1}, .speed = 2});
    });
    const auto b = w.add(body{.shape = sphere{0.2}, .position = {0, 1.5, 0}});
    for (int k = 0; k < 600; ++k) w.step(0.002);
    CHECK(w[b].velocity()[0] < -2);
  });
}
