// The interaction laws of the library, a user-defined law, and the composed laws of
// soft_contact<...>, by the law suite.
#include "interaction_laws.hpp"

#include <doctest/doctest.h>

#include <talus/adhesion.hpp>
#include <talus/interaction/film_bridge.hpp>
#include <talus/interaction/liquid_bridge.hpp>

#include "../../examples/own_law/liquid_bridge.hpp"

using namespace talus;
using namespace laws;

namespace {

const material glass{.density = 1,
                     .restitution = 0.4,
                     .friction = 0.5,
                     .dynamic_friction = 0.4,
                     .stiffness = 1e4,
                     .youngs_modulus = 1e5,
                     .rolling_friction = 0.05};
/// What a contact of two bodies of glass has.
[[nodiscard]] pair_material two_of_glass() {
  material_table materials;
  const material_id m = materials.add(glass);
  return materials.pair(m, m);
}
const liquid_bridge::parameters water{.tension = 0.7, .angle = 0.3, .volume = 1e-3};
constexpr real overlap = 1e-2;
[[nodiscard]] jkr_adhesion::parameters sticky() {
  return jkr_adhesion::combine(glass, glass, two_of_glass(), {.work_of_adhesion = 5});
}
const cohesive_spring::parameters clay{
    .loading = 1e4, .unloading = 4e4, .cohesive = 2e4, .plasticity_depth = 0.05, .damping = 0.1};

/// The same for a law of the library, with a viscous force.
template <class Parameters>
Parameters water_of() {
  if constexpr (std::is_same_v<Parameters, liquid_bridge::parameters>)
    return water;
  else if constexpr (std::is_same_v<Parameters, jkr_adhesion::parameters>)
    return sticky();
  else if constexpr (std::is_same_v<Parameters, cohesive_spring::parameters>)
    return clay;
  else if constexpr (std::is_same_v<Parameters, twisting_resistance::parameters>)
    return {0.05};
  else if constexpr (std::is_same_v<Parameters, dmt_adhesion::parameters>)
    return {3};
  else
    return {.tension = 0.7, .angle = 0.3, .volume = 1e-3, .viscosity = 0.01};
}

/// Gives a composed law a name, which the parts of a scenario have.
template <class... Parts>
struct composed : soft_contact<Parts...>::law {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "composed";
  using base = typename soft_contact<Parts...>::law;
  static typename base::parameters made() {
    typename base::parameters all;
    const pair_material both = two_of_glass();
    base::each_part([&]<class Part>() {
      auto& own = base::template of<Part>(all);
      if constexpr (detail::combines<Part>)
        own = Part::combine(glass, glass, both);
      else
        own = water_of<typename Part::parameters>();
    });
    return all;
  }
};
template <class... Parts>
void check_composed() {
  using law = composed<Parts...>;
  check_law<law>(law::made(), overlap);
  if constexpr (law::reaches) check_range<law>(law::made(), overlap);
}

}  // namespace

TEST_CASE("the laws of the library fulfil the law suite, each alone") {
  const pair_material both = two_of_glass();
  check_law<linear_spring_dashpot>(linear_spring_dashpot::combine(glass, glass, both), overlap);
  check_law<hertz_mindlin>(hertz_mindlin::combine(glass, glass, both), overlap);
  check_law<willett_bridge>(water_of<willett_bridge::parameters>(), overlap);
  check_law<rabinovich_bridge>(water_of<rabinovich_bridge::parameters>(), overlap);
  check_law<from_films<willett_bridge>>(water_of<willett_bridge::parameters>(), overlap);
  check_law<parallel_bond>(parallel_bond::parameters{.youngs_modulus = 1e5, .range = 0.05},
                           overlap);
}

TEST_CASE("the laws of adhesion fulfil the law suite, each alone") {
  check_law<jkr_adhesion>(sticky(), overlap);
  check_law<jkr_adhesion>(jkr_adhesion::combine(glass, glass, two_of_glass(), {}), overlap);
  check_law<dmt_adhesion>(dmt_adhesion::parameters{3}, overlap);
  check_law<linear_cohesion>(linear_cohesion::parameters{1e3}, overlap);
  check_law<van_der_waals>(
      van_der_waals::parameters{.hamaker = 1e-3, .least_distance = 1e-3, .cutoff = 0.05}, overlap);
  check_law<cohesive_spring>(clay, overlap);
  check_law<cohesive_spring>(cohesive_spring::parameters{.loading = 1e4, .unloading = 1e4},
                             overlap);
}

TEST_CASE("a law of one's own fulfils it") { check_law<liquid_bridge>(water, overlap); }

TEST_CASE("what soft_contact composes of laws and resistances fulfils it") {
  check_composed<linear_spring_dashpot>();
  check_composed<linear_spring_dashpot, coulomb_friction>();
  check_composed<hertz_mindlin, coulomb_friction>();
  check_composed<linear_spring_dashpot, coulomb_friction, rolling_resistance>();
  check_composed<hertz_mindlin, coulomb_friction, rolling_resistance>();
  check_composed<liquid_bridge>();
  check_composed<linear_spring_dashpot, liquid_bridge>();
  check_composed<hertz_mindlin, coulomb_friction, rolling_resistance, liquid_bridge>();
  check_composed<hertz_mindlin, coulomb_friction, rolling_resistance, willett_bridge>();
  check_composed<linear_spring_dashpot, rabinovich_bridge>();
  check_composed<jkr_adhesion, coulomb_friction, rolling_resistance, twisting_resistance>();
  check_composed<cohesive_spring, coulomb_friction, twisting_resistance>();
  check_composed<hertz_mindlin, coulomb_friction, twisting_resistance, dmt_adhesion>();
}

TEST_CASE("the forces of laws add up, each with its own parameters and memory") {
  using law = composed<linear_spring_dashpot, liquid_bridge>;
  const auto p = law::made();
  law::memory both{};
  liquid_bridge::memory wet{};
  no_memory none;
  const auto c = contact_at(-overlap);
  const vec3 sum =
      linear_spring_dashpot::force(c, law::of<linear_spring_dashpot>(p), 1e-4, none).force +
      liquid_bridge::force(c, law::of<liquid_bridge>(p), 1e-4, wet).force;
  CHECK(distance(law::force(c, p, 1e-4, both).force, sum) <= 1e-14 * sum.norm());
  CHECK(law::of<liquid_bridge>(both).wet);
  static_assert(law::central && !law::exerts_moment && law::reaches && law::needs_parameters);
  static_assert(sizeof(law::memory) == 1);
}

TEST_CASE("a bridge holds up to its range, and the work to break it is what it stored") {
  using law = composed<liquid_bridge>;
  const auto p = law::made();
  law::memory memory{};
  contact_kinematics c = contact_at(-1e-6);
  c.velocity = vec3(0, 0, 0);
  (void)law::force(c, p, 1e-4, memory);
  const real before = law::stored(c, p, memory).normal, end = law::range(p, c.radius);
  CHECK(end == doctest::Approx((1 + 0.15) * 0.1));
  real work = 0;
  const int steps = 10000;
  for (int k = 0; k < steps; ++k) {
    c.gap = end * (k + 0.5) / steps;
    work -= law::force(c, p, 1e-4, memory).force.dot(c.normal) * end / steps;
  }
  CHECK(law::of<liquid_bridge>(memory).wet);
  CHECK(work == doctest::Approx(-before).epsilon(1e-4));
  c.gap = 1.001 * end;
  (void)law::force(c, p, 1e-4, memory);
  CHECK_FALSE(law::of<liquid_bridge>(memory).wet);
  c.gap = 0.5 * end;  // nearer again, and dry
  CHECK(law::force(c, p, 1e-4, memory).force.norm() == 0);
}

namespace {

/// Has only the tag.
struct only_tagged {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "only_tagged";
};
/// Its memory owns a resource.
struct owning_memory : liquid_bridge {
  struct memory {
    std::vector<int> past;
  };
  static interaction_force force(const contact_kinematics&, const parameters&, real, memory&) {
    return {};
  }
  static stored_energy stored(const contact_kinematics&, const parameters&, const memory&) {
    return {};
  }
};

}  // namespace

TEST_CASE("what lacks an expression is no interaction law") {
  static_assert(!concepts::interaction_law<only_tagged>);
  static_assert(!concepts::interaction_law<owning_memory>);
  static_assert(!concepts::interaction_law<coulomb_friction>);
  static_assert(!concepts::interaction_law<rolling_resistance>);
  static_assert(concepts::resistance<rolling_resistance>);
  static_assert(concepts::bearing_law<linear_spring_dashpot>);
  static_assert(concepts::bearing_law<hertz_mindlin>);
  static_assert(!concepts::bearing_law<liquid_bridge>);
}

TEST_CASE("Willett's force and its rupture have the values of the literature") {
  // Two spheres of 1 mm, V = 8e-11 m^3, water of 0.07 N/m.
  const real r = 1e-3, effective = r / 2, v = 8e-11, gamma = 0.07;
  for (const real theta : {0.0, 0.4}) {
    const willett_bridge::parameters p{.tension = gamma, .angle = theta, .volume = v};
    const real end = (1 + theta / 2) * std::cbrt(v);
    CHECK(willett_bridge::range(p, effective) == doctest::Approx(end).epsilon(1e-12));
    willett_bridge::memory memory;
    for (const real gap : {-1e-6, 0.0, 1e-6, 1e-4, 2e-4, 4e-4}) {
      CAPTURE(gap);
      const contact_kinematics c{.gap = gap, .radius = effective};
      const real s = std::max(0.0, gap) * std::sqrt(r / v);
      const real f = 2 * pi * r * gamma * std::cos(theta) / (1 + 1.05 * s + 2.5 * s * s);
      CHECK(willett_bridge::force(c, p, 1e-6, memory).force[2] ==
            doctest::Approx(-f).epsilon(1e-12));
    }
  }
}

TEST_CASE("Rabinovich's force, for equal and unequal spheres and a sphere on a wall") {
  const real v = 8e-11, gamma = 0.07, theta = 0.3;
  const rabinovich_bridge::parameters p{.tension = gamma, .angle = theta, .volume = v};
  rabinovich_bridge::memory memory{.volume = v};
  for (const real gap : {1e-6, 1e-4, 4e-4}) {
    CAPTURE(gap);
    // With 2 R_a R_b / (R_a + R_b) of two spheres.
    const real r = 2 * 1e-3 * 3e-3 / (1e-3 + 3e-3);
    const real d = gap / 2 * (std::sqrt(1 + 2 * v / (pi * r * gap * gap)) - 1);
    const real f = 2 * pi * r * gamma * std::cos(theta) / (1 + gap / (2 * d));
    contact_kinematics c{.gap = gap, .radius = 1 / (1 / 1e-3 + 1 / 3e-3)};
    CHECK(rabinovich_bridge::force(c, p, 1e-6, memory).force[2] ==
          doctest::Approx(-f).epsilon(1e-12));
    // On a wall 4 pi R gamma cos(theta) / (1 + S/d), d = sqrt(S^2 + V / (pi R)) - S.
    const real d_wall = std::sqrt(gap * gap + v / (pi * 1e-3)) - gap;
    const real f_wall = 4 * pi * 1e-3 * gamma * std::cos(theta) / (1 + gap / d_wall);
    c.radius = 1e-3;
    CHECK(rabinovich_bridge::force(c, p, 1e-6, memory).force[2] ==
          doctest::Approx(-f_wall).epsilon(1e-12));
  }
}

TEST_CASE("the viscous force of a bridge has its closed forms along and across the normal") {
  const real R = 0.5e-3, eta = 0.01, v = 8e-11, gap = 2e-5;
  const willett_bridge::parameters p{.volume = v, .viscosity = eta, .roughness = 1e-6};
  contact_kinematics c{.gap = gap, .velocity = {0.3, -0.2, -0.1}, .radius = R};
  willett_bridge::memory memory{.volume = v};
  const vec3 f = willett_bridge::force(c, p, 1e-6, memory).force;
  const real finite = 1 - gap / std::sqrt(gap * gap + 2 * v / (pi * 2 * R));
  const real across = 6 * pi * eta * R * (8.0 / 15 * std::log(R / gap) + 0.9588);
  CHECK(f[0] == doctest::Approx(-0.3 * across).epsilon(1e-12));
  CHECK(f[1] == doctest::Approx(0.2 * across).epsilon(1e-12));
  CHECK(f[2] == doctest::Approx(0.1 * 6 * pi * eta * R * R * finite * finite / gap).epsilon(1e-12));
  // Below the height of the asperities it does not grow.
  c.gap = 0.5e-6;
  const vec3 near = willett_bridge::force(c, p, 1e-6, memory).force;
  c.gap = -1e-6;
  CHECK(distance(near, willett_bridge::force(c, p, 1e-6, memory).force) < 1e-15);
}

TEST_CASE(
    "a bridge from films takes what they offer, up to its volume, and keeps it to its rupture") {
  using films = from_films<willett_bridge>;
  using phase = detail::bridge_phase;
  const willett_bridge::parameters p{.tension = 0.7, .angle = 0.3, .volume = 1e-3};
  const auto c = contact_at(-overlap);
  films::memory memory;
  CHECK(films::force(c, p, 1e-4, memory).force.norm() == 0);
  CHECK(memory.phase == phase::wanted);
  memory = {.volume = 5e-3, .phase = phase::offered};
  auto same = memory;
  (void)films::force(c, p, 0, same);
  CHECK(same.phase == phase::offered);  // no time, no change
  const real f = films::force(c, p, 1e-4, memory).force.norm();
  CHECK(memory.phase == phase::formed);
  CHECK(memory.volume == p.volume);
  CHECK(f == doctest::Approx(willett_bridge::pull_off_force(p, c.radius)).epsilon(1e-14));
  memory.phase = phase::wet, memory.volume = 1e-4;
  CHECK(memory.held() == 1e-4);
  auto wide = contact_at(1.15 * std::cbrt(1e-4) * (1 - 1e-12));
  CHECK(films::force(wide, p, 1e-4, memory).force.norm() > 0);
  CHECK(memory.phase == phase::wet);
  wide.gap *= 1 + 1e-11;
  CHECK(films::force(wide, p, 1e-4, memory).force.norm() == 0);
  CHECK(memory.phase == phase::ruptured);
  CHECK(memory.volume == 1e-4);  // for the films
  memory = {.volume = 0, .phase = phase::offered};
  (void)films::force(c, p, 1e-4, memory);
  CHECK(memory.phase == phase::dry);
}

TEST_CASE("a contact of JKR in tension bears friction up to mu (f + 2 f_c), until its neck tears") {
  const auto p = sticky();
  jkr_adhesion::memory memory;
  contact_kinematics c = contact_at(1e-9);
  c.velocity = vec3(0, 0, 0);
  CHECK(jkr_adhesion::force(c, p, 1e-4, memory).force.norm() == 0);
  c.gap = -1e-9;
  const real most = jkr_adhesion::pull_off_force(p, c.radius);
  CHECK(most == doctest::Approx(1.5 * pi * 5 * 0.4));
  const auto touch = jkr_adhesion::force(c, p, 1e-4, memory);
  CHECK(touch.force.dot(c.normal) == doctest::Approx(-8.0 / 9 * most).epsilon(1e-4));
  CHECK(touch.pressing == doctest::Approx((2 - 8.0 / 9) * most).epsilon(1e-4));
  c.gap = jkr_adhesion::range(p, c.radius) * (1 - 1e-12);
  const auto end = jkr_adhesion::force(c, p, 1e-4, memory);
  CHECK(end.force.dot(c.normal) == doctest::Approx(-5.0 / 9 * most).epsilon(1e-4));
  CHECK(end.pressing == doctest::Approx((2 - 5.0 / 9) * most).epsilon(1e-4));
}

TEST_CASE("Luding's spring follows its branches, and reloads from the limit of attraction") {
  auto p = clay;
  p.damping = 0;
  cohesive_spring::memory memory;
  contact_kinematics c = contact_at(-overlap);
  c.velocity = vec3(0, 0, 0);
  const auto force_at = [&](real d) {
    c.gap = -d;
    return cohesive_spring::force(c, p, 1e-4, memory).force.dot(c.normal);
  };
  const real most = 4.0 / 3 * 0.05 * 2 * c.radius;
  const real k = 1e4 + 3e4 * overlap / most, zero = (1 - 1e4 / k) * overlap;
  CHECK(force_at(overlap) == doctest::Approx(1e4 * overlap));
  CHECK(force_at(0.9 * overlap) == doctest::Approx(k * (0.9 * overlap - zero)));
  CHECK(force_at(overlap) == doctest::Approx(1e4 * overlap));  // the same line upwards
  const real low = 0.3 * k * zero / (k + 2e4);
  CHECK(force_at(low) == doctest::Approx(-2e4 * low));
  CHECK(memory.deepest < overlap);
  CHECK(force_at(1.5 * low) > -2e4 * 1.4 * low);  // steeper than back along the limit
  CHECK(cohesive_spring::pull_off_force(p, c.radius, overlap) ==
        doctest::Approx(2e4 * k * zero / (k + 2e4)));
}

TEST_CASE("twisting resistance yields at its lever arm times the normal force") {
  const twisting_resistance::parameters p{.twisting_friction = 0.1};
  const bearing b{.pressing = 3, .stiffness = 1e4, .tangential = 3e3};
  contact_kinematics c = contact_at(-overlap);
  c.spin = 2 * c.normal;
  twisting_resistance::memory memory;
  interaction_force f;
  for (int k = 0; k < 1000; ++k) f = twisting_resistance::force(c, b, p, 1e-2, memory);
  CHECK(f.moment.dot(c.normal) == doctest::Approx(-0.1 * 0.4 * 3));
  CHECK(f.lost == doctest::Approx(0.12 * 2e-2));
  c.spin = 2 * vec3(c.normal[1], -c.normal[0], 0);  // across the normal
  memory = {};
  CHECK(twisting_resistance::force(c, b, p, 1e-2, memory).moment.norm() < 1e-15);
}
