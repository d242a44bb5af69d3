// The interaction laws of the library, a user-defined law, and the composed laws of
// soft_contact<...>, by the law suite.
#include "interaction_laws.hpp"

#include <doctest/doctest.h>

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
const liquid_bridge::parameters water{.tension = 0.7, .angle = 0.3, .volume = 1e-3};
constexpr real overlap = 1e-2;

/// Gives a composed law a name, which the parts of a scenario have.
template <class... Parts>
struct composed : soft_contact<Parts...>::law {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "composed";
  using base = typename soft_contact<Parts...>::law;
  static typename base::parameters made() {
    typename base::parameters all;
    const pair_material both = detail::mean_of(glass, glass);
    base::each_part([&]<class Part>() {
      auto& own = base::template of<Part>(all);
      if constexpr (detail::combines<Part>)
        own = Part::combine(glass, glass, both);
      else
        own = water;
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
  const pair_material both = detail::mean_of(glass, glass);
  check_law<linear_spring_dashpot>(linear_spring_dashpot::combine(glass, glass, both), overlap);
  check_law<hertz_mindlin>(hertz_mindlin::combine(glass, glass, both), overlap);
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
