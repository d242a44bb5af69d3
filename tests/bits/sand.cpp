// A pile of soft contacts.
#include <variant>

#include "digest_of.hpp"

namespace {

using granular = scenario<bodies<sphere, box, plane>,
                          soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance>,
                          integrator<velocity_verlet>, decomposition<squares>, transport<threads>>;

// Soft spheres and boxes that slide, roll and pile up.
void set_up_sand(world<granular>& w) {
  const auto grain = w.material({.density = 1,
                                 .restitution = 0.2,
                                 .friction = 0.5,
                                 .dynamic_friction = 0.4,
                                 .youngs_modulus = 1e5,
                                 .rolling_friction = 0.05});
  w.gravity({0, 0, -g});
  w.global([&](auto& scope) { add_tub(scope, 3.5, grain); });
  w.fill(simple_cubic{.spacing = 1, .origin = {-2.8, -2.8, 0.6}} &
             box_region{{-3.2, -3.2, 0.3}, {3.2, 3.2, 2}},
         [&](const site& at, random_stream& random) -> std::variant<body<sphere>, body<box>> {
           const vec3 push = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 0));
           if (random.integer(3) == 0)
             return body{.shape = box{random.uniform(vec3(0.4, 0.4, 0.4), vec3(0.6, 0.6, 0.6))},
                         .position = at.position,
                         .material = grain,
                         .velocity = push,
                         .orientation = random.rotation()};
           return body{.shape = sphere{random.uniform(0.3, 0.45)},
                       .position = at.position,
                       .material = grain,
                       .velocity = push};
         });
}

}  // namespace

std::string sand(const course& how) {
  return digest_of(
      how, [](threads::link& link) { return square_world<granular>(link, 3.5); }, set_up_sand);
}
