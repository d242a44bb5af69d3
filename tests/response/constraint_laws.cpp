// The laws of all kinds of constraints: the properties that a solver relies on, for any kind.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <talus/concepts.hpp>
#include <talus/constraint/frame_around.hpp>
#include <talus/constraint/general_contact.hpp>
#include <talus/constraint/isotropic_contact.hpp>
#include <talus/contact/law.hpp>
#include <talus/core/random.hpp>
#include <talus/solver/coloured_list.hpp>
#include <talus/solver/contact_list.hpp>
#include <talus/solver/either_list.hpp>

using namespace talus;
using namespace talus::detail;

namespace {

using rough = rows_of_contact<true, false, true>;
using smooth = rows_of_contact<false, false, true>;
using biased = rows_of_contact<true, true, true>;

constexpr int bodies = 4;

vec3 any_vector(random_stream& random, real size) {
  return random.uniform(vec3(-size, -size, -size), vec3(size, size, size));
}

/// Two isotropic bodies and two with tensors of inertia, in motion.
solver_state any_state(random_stream& random) {
  solver_state s;
  s.first_tensor = 2;
  for (int k = 0; k < bodies; ++k) {
    const real mass = random.uniform(0.2, 5);
    s.bodies.push_back({any_vector(random, 1), 1 / mass, any_vector(random, 1),
                        k < 2 ? 1 / (mass * random.uniform(0.1, 0.5)) : real(0)});
    s.shift.push_back({any_vector(random, 0.1), 1 / mass});
  }
  for (int k = 2; k < bodies; ++k) {
    const mat3 axes = frame_around<real>(any_vector(random, 1).normalized());
    mat3 moments = mat3::Zero();
    for (int i = 0; i < 3; ++i) moments(i, i) = random.uniform(0.5, 8);
    s.tensors.push_back(axes.transpose() * moments * axes);
    s.turn.push_back({any_vector(random, 0.1)});
  }
  return s;
}

template <class Kind>
Kind any_constraint(random_stream& random, std::int32_t a, std::int32_t b) {
  Kind c;
  c.a = a, c.b = b;
  c.normal = any_vector(random, 1).normalized();
  if constexpr (requires { c.r; }) {
    c.arm_a = any_vector(random, 0.5), c.arm_b = any_vector(random, 0.5);
    c.friction = 0.4;
  } else if constexpr (Kind::rows == 3) {
    c.arm_a = random.uniform(0.2, 0.6), c.arm_b = Kind::paired ? random.uniform(0.2, 0.6) : 0;
    c.friction = 0.4;
  }
  c.target_velocity = random.uniform(0, 1) < 0.5 ? 0 : random.uniform(0, 0.3);
  c.correction_rate = random.uniform(-0.02, 0.02);
  if constexpr (Kind::biased) c.bias = 0.1 * any_vector(random, 1);
  return c;
}

vec3 momentum(const solver_state& s) {
  vec3 p{0, 0, 0};
  for (const auto& b : s.bodies) p += b.v / b.inverse_mass;
  return p;
}
real kinetic_energy(const solver_state& s) {
  real e = 0;
  for (std::size_t k = 0; k < s.bodies.size(); ++k) {
    const auto& b = s.bodies[k];
    e += b.v.squaredNorm() / b.inverse_mass;
    if (k >= s.first_tensor)
      e += b.w.dot(s.tensors[k - s.first_tensor].inverse() * b.w);
    else
      e += b.w.squaredNorm() / b.inverse_inertia;
  }
  return e / 2;
}
real largest_difference(const solver_state& x, const solver_state& y) {
  real d = 0;
  for (std::size_t k = 0; k < x.bodies.size(); ++k)
    d = std::max(
        {d, (x.bodies[k].v - y.bodies[k].v).norm(), (x.bodies[k].w - y.bodies[k].w).norm()});
  return d;
}

/// Calls law(constraint, state) for constraints of a kind, prepared, in random states.
template <class Kind, class Law>
void for_random(std::int32_t a, std::int32_t b, Law&& law) {
  const std::uint64_t seed = 20;
  for (std::uint64_t k = 0; k < 200; ++k) {
    random_stream random(seed, k);
    CAPTURE(seed);
    CAPTURE(k);
    solver_state s = any_state(random);
    Kind c = any_constraint<Kind>(random, a, b);
    c.prepare(s, 1, 1);
    law(c, s, random);
  }
}

/// An isotropic body with a contact off its normal: its effective mass includes its rotation, but
/// the correction does not rotate it.
template <class Kind>
inline constexpr bool round_with_arm = false;
template <class Rows, contact_side A, contact_side B>
inline constexpr bool round_with_arm<general_contact<Rows, A, B>> =
    A == contact_side::scalar || B == contact_side::scalar;

template <class Kind>
void obeys_all_laws(std::int32_t a, std::int32_t b) {
  static_assert(concepts::contact_kind<Kind>);
  static_assert(concepts::constraint_list<contact_list<Kind>>);
  static_assert(concepts::constraint_list<coloured_list<Kind>>);
  static_assert(concepts::constraint_list<either_list<Kind>>);

  SUBCASE("a change of impulse conserves the momentum of a pair") {
    for_random<Kind>(a, b, [](Kind& c, solver_state& s, random_stream&) {
      const vec3 before = momentum(s);
      c.apply(s, c.relax(s));
      if constexpr (Kind::paired) CHECK((momentum(s) - before).norm() < 1e-13);
    });
  }
  SUBCASE("a constraint that is solved stays solved, and has no residual") {
    for_random<Kind>(a, b, [](Kind& c, solver_state& s, random_stream&) {
      c.apply(s, c.relax(s));
      solver_state after = s;
      c.apply(after, c.relax(after));
      CHECK(largest_difference(s, after) < 1e-11);
      const real rho = Kind::rows / c.delassus_trace(s);
      CHECK(natural_map(c.impulse(), violation(c, s), c.axis(), c.mu(), rho).norm() < 1e-11);
    });
  }
  SUBCASE("without a target or a bias it takes energy, and adds none") {
    for_random<Kind>(a, b, [](Kind& c, solver_state& s, random_stream&) {
      c.target_velocity = 0;
      if constexpr (Kind::biased) c.bias = vec3(0, 0, 0);
      const real before = kinetic_energy(s);
      c.apply(s, c.relax(s));
      CHECK(kinetic_energy(s) <= before * (1 + 1e-13));
    });
  }
  SUBCASE("divided masses make a change as large as that of lighter bodies") {
    for_random<Kind>(a, b, [](Kind& c, solver_state& s, random_stream&) {
      Kind whole = c, halved = c;
      solver_state light = s;
      for (auto& body : light.bodies) body.inverse_mass *= 2, body.inverse_inertia *= 2;
      for (auto& tensor : light.tensors) tensor = 2 * tensor;
      halved.prepare(s, 2, 2), whole.prepare(light, 1, 1);
      halved.set(halved.impulse_in_frame() + halved.relax(s));
      whole.set(whole.impulse_in_frame() + whole.relax(light));
      CHECK((halved.impulse() - whole.impulse()).norm() <= 1e-12 * (1 + whole.impulse().norm()));
    });
  }
  SUBCASE("a loaded impulse is admissible, and an admissible one is loaded as it is") {
    for_random<Kind>(a, b, [](Kind& c, solver_state&, random_stream& random) {
      c.load_impulse(any_vector(random, 2));
      const vec3 p = c.impulse();
      const real normal = p.dot(c.axis());
      CHECK(normal >= 0);
      CHECK((p - normal * c.axis()).norm() <= c.mu() * normal + 1e-14);
      Kind again = c;
      again.load_impulse(p);
      CHECK((again.impulse() - p).norm() < 1e-14);
    });
  }
  SUBCASE("the impulse on a body and the change of its velocity are one") {
    for_random<Kind>(a, b, [&](Kind& c, solver_state& s, random_stream&) {
      const vec3 before = c.impulse();
      const vec3 v = s.bodies[static_cast<std::size_t>(a)].v;
      c.apply_to_a(s, c.relax(s));
      const auto& body = s.bodies[static_cast<std::size_t>(a)];
      CHECK(((body.v - v) / body.inverse_mass - (c.impulse() - before)).norm() < 1e-12);
    });
  }
  SUBCASE("a correction that is solved again changes less, and not at all where bodies may turn") {
    for_random<Kind>(a, b, [&](Kind& c, solver_state& s, random_stream&) {
      const auto d = c.relax_correction(s);
      c.correct_a(s, d), c.correct_b(s, d);
      const real again = std::abs(c.relax_correction(s));
      CHECK(again <= std::abs(d));
      if (!round_with_arm<Kind>) CHECK(again < 1e-12);
    });
  }
}

}  // namespace

TEST_CASE("a contact of round bodies obeys the laws of constraints") {
  obeys_all_laws<isotropic_contact<rough, partner::moving>>(0, 1);
}
TEST_CASE("a contact of round bodies without friction obeys the laws of constraints") {
  obeys_all_laws<isotropic_contact<smooth, partner::moving>>(1, 0);
}
TEST_CASE("a contact of a round body with an immovable one obeys the laws of constraints") {
  obeys_all_laws<isotropic_contact<rough, partner::immovable>>(1, -1);
}
TEST_CASE("a biased contact of round bodies obeys the laws of constraints") {
  obeys_all_laws<isotropic_contact<biased, partner::moving>>(0, 1);
}
TEST_CASE("a contact of two bodies with tensors obeys the laws of constraints") {
  obeys_all_laws<general_contact<rough, contact_side::tensor, contact_side::tensor>>(2, 3);
}
TEST_CASE("a contact without friction of a tensor and a round body obeys the laws") {
  obeys_all_laws<general_contact<smooth, contact_side::tensor, contact_side::scalar>>(3, 0);
}
TEST_CASE("a contact of a round body with a tensor obeys the laws of constraints") {
  obeys_all_laws<general_contact<rough, contact_side::scalar, contact_side::tensor>>(1, 2);
}
TEST_CASE("a contact of a tensor with something immovable obeys the laws of constraints") {
  obeys_all_laws<general_contact<rough, contact_side::tensor, contact_side::immovable>>(2, -1);
}
TEST_CASE("a biased contact of a tensor obeys the laws of constraints") {
  obeys_all_laws<general_contact<biased, contact_side::tensor, contact_side::tensor>>(3, 2);
}
