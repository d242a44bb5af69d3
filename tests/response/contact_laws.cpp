// The law of a single contact, piece by piece: the parameters of two materials, the conditions of a
// new contact, the residual, and the memory of a soft contact.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <talus/body/material.hpp>
#include <talus/constraint/coulomb_block.hpp>
#include <talus/constraint/isotropic_contact.hpp>
#include <talus/constraint/natural_map.hpp>
#include <talus/constraint/rebound.hpp>
#include <talus/constraint/stored_impulses.hpp>
#include <talus/contact/law.hpp>
#include <talus/core/random.hpp>
#include <talus/interaction/soft_contact.hpp>
#include <talus/solver/contact_list.hpp>
#include <talus/step/contact_conditions.hpp>

using namespace talus;
using namespace talus::detail;

namespace {

constexpr real dt = 0.01, g = 10;
const vec3 up{0, 0, 1};

using law = hard_contact<coulomb_friction, newton_restitution, split_correction>;

contact_conditions ask(const pair_material& pair, const vec3& u, real gap = 0) {
  return conditions_of<law, false>(
      pair, up, u, gap, dt, g, [] { return real(g); }, 1e-6, 0.2);
}

using hertz = soft_contact<hertz_mindlin, coulomb_friction>;
using linear = soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>;

contact_kinematics touch_at(real overlap, const vec3& u = {0, 0, 0}) {
  return {.normal = up, .gap = -overlap, .velocity = u};
}
/// Parameters of all parts of a law.
template <class Law>
typename Law::law::parameters made_of(const auto&... of_parts) {
  typename Law::law::parameters all;
  Law::law::each_part([&]<class Part>() {
    const auto take = [&](const auto& p) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(p)>, typename Part::parameters>)
        Law::law::template of<Part>(all) = p;
    };
    (take(of_parts), ...);
  });
  return all;
}
template <class Law>
pair_force force(const contact_kinematics& c, const typename Law::law::parameters& p,
                 typename Law::memory& memory) {
  not_booked none;
  return Law::law::force(c, p, dt, memory, none);
}
using linear_friction = tangential_spring<bearing>::parameters;
using hertz_friction = tangential_spring<growing_bearing>::parameters;
using rolling = rolling_resistance::parameters;

/// Data for warm starting a contact of a pair with several.
struct point {
  static constexpr bool manifolds = true;
  vec3 start{0, 0, 0};
  void load_impulse(const vec3& impulse) { start = impulse; }
};

}  // namespace

TEST_CASE("a pair of materials takes the mean of both, whichever comes first") {
  const material a{.restitution = 0.9,
                   .friction = 0.8,
                   .dynamic_friction = 0.6,
                   .stiffness = 1e4,
                   .rolling_friction = 0.1};
  const material b{.restitution = 0.3,
                   .friction = 0.2,
                   .dynamic_friction = 0.1,
                   .stiffness = 3e4,
                   .rolling_friction = 0.3};
  for (const bool swapped : {false, true}) {
    material_table table;
    const auto first = table.add(swapped ? b : a), second = table.add(swapped ? a : b);
    for (const auto& p : {table.pair(first, second), table.pair(second, first)}) {
      CHECK(p.restitution == doctest::Approx(0.6));
      CHECK(p.friction == doctest::Approx(0.5));
      CHECK(p.dynamic_friction == doctest::Approx(0.35));
      CHECK(rolling_resistance::combine(table[first], table[second], p).rolling_friction ==
            doctest::Approx(0.2));
      const auto soft = linear_spring_dashpot::combine(table[first], table[second], p);
      CHECK(soft.stiffness == doctest::Approx(1.5e4));  // two springs of 2e4 and 6e4 in a row
      CHECK(soft.damping == doctest::Approx(damping_of_restitution(0.6)));
    }
    CHECK(table.pair(first, first).restitution == doctest::Approx(swapped ? 0.3 : 0.9));
  }
}

TEST_CASE("an impact rebounds from more than twice what gravity adds in a step") {
  const pair_material bouncy{.restitution = 0.5, .friction = 0, .dynamic_friction = 0};
  CHECK(ask(bouncy, {0, 0, -1.9 * g * dt}).target_velocity == 0);
  CHECK(ask(bouncy, {0, 0, -3 * g * dt}).target_velocity > 0);
  CHECK(ask({.restitution = 0, .friction = 0, .dynamic_friction = 0}, {0, 0, -3 * g * dt})
            .target_velocity == 0);
}

// What an impact needs that strikes a contact within the step; solvers with substeps need none.
TEST_CASE("with restitution, contacts know it and the limit by their gap") {
  const pair_material bouncy{.restitution = 0.5, .friction = 0, .dynamic_friction = 0};
  const real gap = 3 * g * dt * dt;
  for (const real un : {0.0, 3 * g * dt, -30 * g * dt}) {
    CHECK(ask(bouncy, {0, 0, un}, gap).restitution == 0.5);
    CHECK(ask(bouncy, {0, 0, un}, gap).limit == doctest::Approx(-gap / dt));
    CHECK(ask(bouncy, {0, 0, un}).limit == 0);
  }
  const auto divided = conditions_of<law, true>(
      bouncy, up, {0, 0, 0}, gap, dt, g, [] { return real(g); }, 1e-6, 0.2);
  CHECK(divided.restitution == 0);
}

TEST_CASE("a rebound has e^2 of the energy of the impact, less that of half a step of fall") {
  // Stored velocities are those of half a step before: 3 in the store is 3.05 at the surface.
  const real e = 0.7, stored = 3, at_surface = stored + g * dt / 2;
  const real after = rebound(e, -stored, 0, dt, g), after_at_surface = after + g * dt / 2;
  CHECK(after_at_surface * after_at_surface ==
        doctest::Approx(e * e * at_surface * at_surface).epsilon(1e-12));
  // Above the surface the fall continues, and the rise begins lower.
  CHECK(rebound(e, -stored, 0.01, dt, g) < after);
  CHECK(rebound(e, -stored, 0, dt, 0) == e * stored);
}

TEST_CASE("what slides meets the dynamic coefficient, what sticks the static one") {
  const pair_material rough{.restitution = 0, .friction = 0.5, .dynamic_friction = 0.3};
  CHECK(ask(rough, {0.5 * g * dt, 0, 0}).friction == 0.5);
  CHECK(ask(rough, {1.1 * g * dt, 0, 0}).friction == 0.3);
  CHECK(ask(rough, {0, 0, -5}).friction == 0.5);  // sliding excludes the normal velocity
}

TEST_CASE("points that are new start from equal parts of what points bore that are gone") {
  contact_history history;
  const auto key = [](std::uint64_t feature) {
    return contact_key{system_id{3}, system_id{8}, feature};
  };
  for (const std::uint64_t k : {1, 2, 3, 4}) history.add(key(k), vec3(0, 0, real(k)));
  history.add({system_id{3}, system_id{9}, 7}, vec3(5, 5, 5));  // of another pair
  plain_vector<contact_key> keys;
  for (const std::uint64_t k : {3, 7, 4, 8}) keys.push_back(key(k));
  plain_vector<history_place*> places(4, nullptr);
  plain_vector<point> points(4);
  load_impulses(history, keys, places, points);
  CHECK(points[0].start == vec3(0, 0, 3));
  CHECK(points[1].start == vec3(0, 0, 1.5));
  CHECK(points[2].start == vec3(0, 0, 4));
  CHECK(points[3].start == vec3(0, 0, 1.5));
}

TEST_CASE("contacts with bodies of other ranks share the mass of the body that they meet in") {
  // A light body at rest that heavy ones of another rank strike from one side, all solved from one
  // state: with undivided masses each would give it the full speed.
  using contact = isotropic_contact<law, partner::moving>;
  for (const int strikers : {1, 2, 5}) {
    solver_state s;
    s.bodies.push_back({{0, 0, 0}, 1000, {0, 0, 0}, 0});
    contact_list<contact> list;
    for (int k = 1; k <= strikers; ++k) {
      s.bodies.push_back({{-1, 0, 0}, 1, {0, 0, 0}, 0});
      contact c;
      c.a = 0, c.b = k;
      c.normal = {-1, 0, 0};
      list.add_boundary(c, {system_id{0}, static_cast<system_id>(k), 0}, true, nullptr);
    }
    s.boundary_contacts.assign(s.bodies.size(), 0);
    list.count_boundary(s);
    CHECK(s.boundary_contacts[0] == static_cast<std::uint32_t>(strikers));
    list.prepare_boundary(s);
    list.relax_boundary(s);
    list.apply_boundary(s);
    CAPTURE(strikers);
    CHECK(s.bodies[0].v[0] > -1.0);
    CHECK(s.bodies[0].v[0] < -0.99);
    CHECK(s.bodies[1].v[0] == -1);  // its own rank applies that
  }
}

TEST_CASE("a load on its cone stays where the contact could open or slide, too") {
  random_stream random(1, 2);
  const auto number = [&] { return random.uniform(-1, 1); };
  for (int k = 0; k < 2000; ++k) {
    mat3 part;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) part(i, j) = number();
    coulomb_block block;
    const mat3 w = part * part.transpose() + diagonal_matrix(real(0.1));
    block.set(w);
    const real mu = 3, turn = pi * number();
    const vec3 load = vec3(1, mu * std::cos(turn), mu * std::sin(turn));
    CHECK((block.solve(load, 1e-11 * vec3(number(), number(), number()), mu) - load).norm() < 1e-8);
    CHECK((block.solve(real(1 + 1e-12) * load, {0, 0, 0}, mu) - load).norm() < 1e-9);
    CHECK(block.solve(load, {0.01, 0, 0}, mu) != load);
    CHECK(block.solve({0, 0, 0}, {0.01, 0, 0}, mu) == vec3(0, 0, 0));
  }
}

TEST_CASE("eight contacts at once have the impulses of one by one to the bit, whatever they do") {
  using eight = pack<real, 8>;
  random_stream random(3, 2);
  const auto number = [&] { return random.uniform(-1, 1); };
  int slide = 0, different = 0;
  for (int k = 0; k < 5000; ++k) {
    coulomb_blocks<eight> all;
    coulomb_block one[8];
    pack_vector<eight> r, u;
    eight mu{};
    for (std::size_t l = 0; l < 8; ++l) {
      mat3 part;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) part(i, j) = number();
      one[l].set(part * part.transpose() + diagonal_matrix(real(1e-3)));
      mu[l] = k % 7 == 0 ? 0 : std::pow(10, number());
      vec3 load(random.uniform(0, 1), number(), number());
      load *= k % 3;  // from no load too
      put_lane(r, l, load), put_lane(u, l, vec3(number(), number(), number()));
    }
    const auto of = [&](auto member) {
      eight x{};
      for (std::size_t l = 0; l < 8; ++l) x[l] = one[l].*member;
      return x;
    };
    using block = coulomb_blocks<real>;
    all.set(of(&block::nn), of(&block::n1), of(&block::n2), of(&block::t11), of(&block::t12),
            of(&block::t22));
    mask_of<eight> present{};
    for (std::size_t l = 0; l < 8; ++l)
      if (k % 5 > 0 || l < 6) include_lane(present, l);
    const auto found = all.solve(r, u, mu, present);
    for (std::size_t l = 0; l < 8; ++l) {
      const vec3 alone = present[l] ? one[l].solve(lane(r, l), lane(u, l), mu[l]) : vec3(0, 0, 0);
      slide +=
          alone[0] > 0 && std::abs(std::hypot(alone[1], alone[2]) / (mu[l] * alone[0]) - 1) < 1e-9;
      const vec3 here = lane(found, l);
      for (int i = 0; i < 3; ++i)
        different +=
            std::bit_cast<std::uint64_t>(alone[i]) != std::bit_cast<std::uint64_t>(here[i]);
    }
  }
  CHECK(slide > 5000);
  CHECK(different == 0);
}

TEST_CASE("the natural map is zero exactly where Coulomb's law holds") {
  const real mu = 0.4;
  for (const real rho : {0.1, 1.0, 7.0}) {
    // Sliding: the impulse on the edge of the cone against the slip, and zero normal velocity.
    const vec3 slides{-mu * 2, 0, 2}, slip{0.7, 0, 0};
    CHECK(natural_map(slides, slip, up, mu, rho).norm() < 1e-14);
    // Sticking, and separated.
    CHECK(natural_map({0.1, 0.2, 2}, {0, 0, 0}, up, mu, rho).norm() < 1e-14);
    CHECK(natural_map({0, 0, 0}, {0.3, -0.2, 0.1}, up, mu, rho).norm() < 1e-14);
    // Slip with an impulse inside of the cone, an impulse outside of it, an impulse during
    // separation.
    CHECK(natural_map({-0.3, 0, 2}, slip, up, mu, rho).norm() > 1e-3);
    CHECK(natural_map({-1.2, 0, 2}, {0, 0, 0}, up, mu, rho).norm() > 1e-3);
    CHECK(natural_map({0, 0, 1}, {0, 0, 0.5}, up, mu, rho).norm() > 1e-3);
  }
}

TEST_CASE("the nearest point of the cone is in it, and what is left is perpendicular to it") {
  random_stream random(1, 1);
  for (int k = 0; k < 1000; ++k) {
    const real mu = random.uniform(0, 2);
    const vec3 r = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
    const vec3 p = nearest_in_cone(r, up, mu), rest = r - p;
    const real height = p[2], width = std::hypot(p[0], p[1]);
    CHECK(width <= mu * height + 1e-14);
    CHECK(std::abs(rest.dot(p)) < 1e-14);
    // In the polar cone: no point of the cone is nearer.
    CHECK(mu * std::hypot(rest[0], rest[1]) <= -rest[2] + 1e-14);
  }
}

TEST_CASE("Mindlin's force is kept while the overlap grows, and shrinks with it") {
  const auto pair = made_of<hertz>(hertz_mindlin::parameters{.modulus = 1e4, .tangential = 1e4},
                                   hertz_friction{.friction = 100, .dynamic_friction = 100});
  hertz::memory memory;
  const auto across = [&](const contact_kinematics& t) {
    return force<hertz>(t, pair, memory).force[0];
  };
  const real first = across(touch_at(0.01, {0.1, 0, 0}));
  REQUIRE(first < 0);
  CHECK(across(touch_at(0.01)) == doctest::Approx(first));
  CHECK(across(touch_at(0.04)) == doctest::Approx(first));      // a circle of twice the radius
  CHECK(across(touch_at(0.01)) == doctest::Approx(first / 2));  // and back
  CHECK(across(touch_at(0.04)) == doctest::Approx(first / 2));
}

TEST_CASE("a soft contact that slides goes on sliding until the dynamic coefficient holds it") {
  const auto pair =
      made_of<linear>(linear_spring_dashpot::parameters{.stiffness = 1e3, .tangential = 1e3},
                      linear_friction{.friction = 0.5, .dynamic_friction = 0.3});
  linear::memory memory;
  const real normal = 1e3 * 0.01;
  const auto across = [&](real u) {
    return force<linear>(touch_at(0.01, {u, 0, 0}), pair, memory).force[0];
  };
  CHECK(across(0.04) == doctest::Approx(-0.4));           // below both: sticks
  CHECK(across(0.40) == doctest::Approx(-4.4));           // between both: sticks
  CHECK(across(0.10) == doctest::Approx(-0.3 * normal));  // above both: slides
  CHECK(memory.sliding);
  CHECK(across(0.10) == doctest::Approx(-0.3 * normal));   // between both: continues to slide
  CHECK(across(-0.10) == doctest::Approx(-0.2 * normal));  // held again
  CHECK_FALSE(memory.sliding);
}

TEST_CASE("springs of soft contacts turn with the bodies about the normal and keep their length") {
  const vec3 old{0.3, 0, 0};
  const vec3 now = carried_along(old, up, 0.01);
  CHECK(now[1] == doctest::Approx(0.003).epsilon(1e-3));
  CHECK(now.norm() == doctest::Approx(0.3).epsilon(1e-14));
  const vec3 tilted = carried_along({0.3, 0, 0.4}, up, 0);
  CHECK(tilted[2] == 0);
  CHECK(tilted.norm() == doctest::Approx(0.5).epsilon(1e-14));
}

TEST_CASE("rolling resistance has a spring and a dashpot of 0.3 of critical damping") {
  const auto pair =
      made_of<linear>(linear_spring_dashpot::parameters{.stiffness = 1e3, .tangential = 1e3},
                      rolling{.rolling_friction = 0.2});
  const real stiffness = 2.25 * 1e3 * 0.2 * 0.2;
  linear::memory memory;
  contact_kinematics t = touch_at(0.5);
  t.spin = {0.01, 0, 0};
  const real moment = force<linear>(t, pair, memory).moment[0];
  CHECK(moment == doctest::Approx(-stiffness * 0.01 * dt - 0.6 * std::sqrt(stiffness) * 0.01));
  t.spin = {100, 0, 0};  // yields
  CHECK(force<linear>(t, pair, memory).moment[0] == doctest::Approx(-0.2 * 1e3 * 0.5));
}
