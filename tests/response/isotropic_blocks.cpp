// Contacts of isotropic bodies in blocks, of eight doubles or sixteen floats: the same bits as the
// same contacts one by one.
#include <doctest/doctest.h>

#include <cstdint>
#include <random>
#include <type_traits>
#include <vector>

#include "talus/constraint/isotropic_contact.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/contact/law.hpp"

namespace {

using namespace talus;
using namespace talus::detail;
using law = hard_contact<coulomb_friction, newton_restitution>;

template <class Real>
struct random_heap {
  using moving = isotropic_contact<law, partner::moving, Real>;
  using vector_type = vector3<Real>;
  /// The round-off allowed for numbers about 1, if that of doubles is `of_double`.
  static real allowed(real of_double) {
    return std::is_same_v<Real, double> ? of_double : 1e9 * of_double;
  }

  explicit random_heap(unsigned seed) : engine(seed) {}
  Real number(real low, real high) {
    return static_cast<Real>(std::uniform_real_distribution<real>(low, high)(engine));
  }
  vector_type vector() { return {number(-1, 1), number(-1, 1), number(-1, 1)}; }
  std::int32_t body(std::size_t count) {
    return std::uniform_int_distribution<std::int32_t>(
        0, static_cast<std::int32_t>(count) - 1)(engine);
  }
  solver_state_of<Real> bodies(std::size_t count, std::size_t fixed) {
    solver_state_of<Real> s;
    for (std::size_t i = 0; i < count; ++i) {
      const Real inverse_mass = i < fixed ? 0 : number(0.5, 2);
      s.bodies.push_back({i < fixed ? vector_type(0, 0, 0) : vector(), inverse_mass,
                          i < fixed ? vector_type(0, 0, 0) : vector(), Real(2.5) * inverse_mass});
      s.shift.push_back({{0, 0, 0}, inverse_mass});
    }
    return s;
  }
  moving contact(std::int32_t a, std::int32_t b) {
    moving c;
    c.a = a, c.b = b;
    c.normal = vector().normalized();
    c.arm_a = number(0.4, 0.6), c.arm_b = number(0.4, 0.6);
    c.friction = number(0, 1);
    c.target_velocity = number(-0.1, 0.1);
    c.correction_rate = number(-0.1, 0.1);
    c.load_impulse(in_scalar<real>(vector_type(vector() + c.normal)));
    return c;
  }

  std::mt19937 engine;
};

template <class Real>
vec3 momentum(const solver_state_of<Real>& s) {
  vec3 sum{0, 0, 0};
  for (const auto& b : s.bodies)
    if (b.inverse_mass > 0) sum += v_of(b) / b.inverse_mass;
  return sum;
}
template <class Real>
bool moves(const solver_state_of<Real>& s, std::int32_t i) {
  return s.bodies[static_cast<std::size_t>(i)].inverse_mass > 0;
}

}  // namespace

TEST_CASE_TEMPLATE(
    "contacts of crowded, large and fixed bodies find places where no block moves a body twice",
    Real, double, float) {
  using moving = typename random_heap<Real>::moving;
  const auto allowed = random_heap<Real>::allowed;
  for (const unsigned seed : {1u, 2u, 3u}) {
    CAPTURE(seed);
    random_heap<Real> random(seed);
    const std::size_t count = seed == 1 ? 12 : 400;
    auto s = random.bodies(count, 3);
    isotropic_blocks<moving> blocks;
    std::vector<moving> all;
    for (int step = 0; step < 2; ++step) {  // the second as after another step
      blocks.clear(), all.clear();
      for (int k = 0; k < 3000; ++k) {
        const auto a = random.body(count);
        const auto b = k % 4 == 0 ? static_cast<std::int32_t>(count) - 1 : random.body(count);
        if (a == b || (!moves(s, a) && !moves(s, b))) continue;
        all.push_back(random.contact(a, b));
        blocks.add(all.back(), moves(s, a), moves(s, b));
      }
    }
    REQUIRE(blocks.size() == all.size());
    bool same = true;
    for (std::size_t i = 0; i < all.size(); ++i)
      same = same && blocks[i].a == all[i].a && blocks[i].b == all[i].b &&
             blocks[i].normal == all[i].normal && blocks[i].impulse() == all[i].impulse() &&
             blocks[i].target_velocity == all[i].target_velocity &&
             blocks[i].correction_rate == all[i].correction_rate;
    CHECK(same);

    // If a block moved a body twice, one of the two changes would be lost.
    const vec3 before = momentum(s);
    blocks.prepare(s);
    blocks.apply(s);
    vec3 to_fixed{0, 0, 0};
    const auto on_fixed = [&](const moving& c) {
      vec3 sum{0, 0, 0};
      if (!moves(s, c.b)) sum += c.impulse();
      if (!moves(s, c.a)) sum -= c.impulse();
      return sum;
    };
    for (std::size_t i = 0; i < all.size(); ++i) to_fixed += on_fixed(blocks[i]);
    CHECK((momentum(s) - before - to_fixed).norm() <
          allowed(1e-11) * static_cast<real>(all.size()));
    for (int k = 0; k < 4; ++k) k % 2 == 0 ? blocks.forward(s) : blocks.backward(s);
    vec3 now{0, 0, 0};
    bool in_cones = true;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const moving c = blocks[i];
      now += on_fixed(c);
      in_cones = in_cones && c.rn >= 0 && c.rt.norm() <= c.friction * c.rn * (1 + allowed(1e-15));
    }
    CHECK((momentum(s) - before - now).norm() < allowed(1e-11) * static_cast<real>(all.size()));
    CHECK(in_cones);
    blocks.correct(s);
    vec3 shifted{0, 0, 0};
    for (const auto& x : s.shift)
      if (x.inverse_mass > 0) shifted += in_scalar<real>(x.v) / x.inverse_mass;
    vec3 correction_impulse{0, 0, 0};
    for (std::size_t i = 0; i < all.size(); ++i) {
      const moving c = blocks[i];
      if (!moves(s, c.b)) correction_impulse += c.correction_impulse * c.axis();
      if (!moves(s, c.a)) correction_impulse -= c.correction_impulse * c.axis();
    }
    CHECK((shifted - correction_impulse).norm() < allowed(1e-11) * static_cast<real>(all.size()));
  }
}

TEST_CASE_TEMPLATE("blocks that are filled in part, and not in their order, conserve momentum",
                   Real, double, float) {
  using moving = typename random_heap<Real>::moving;
  for (unsigned seed = 1; seed <= 400; ++seed) {  // of 400, some fill blocks in irregular ways
    CAPTURE(seed);
    random_heap<Real> random(seed);
    const std::size_t count = 3 + seed % 20;
    auto s = random.bodies(count, 0);
    isotropic_blocks<moving> blocks;
    for (unsigned k = 0; k < 2 + seed % 37; ++k) {
      const auto a = random.body(count), b = random.body(count);
      if (a != b) blocks.add(random.contact(a, b), true, true);
    }
    const vec3 before = momentum(s);
    blocks.prepare(s);
    blocks.apply(s);
    blocks.forward(s);
    blocks.backward(s);
    CHECK((momentum(s) - before).norm() < random.allowed(1e-11));
  }
}

TEST_CASE_TEMPLATE("contacts that share no body are solved in blocks as one by one, to the bit",
                   Real, double, float) {
  using moving = typename random_heap<Real>::moving;
  const auto allowed = random_heap<Real>::allowed;
  random_heap<Real> random(7);
  auto s = random.bodies(62, 0), t = s;
  isotropic_blocks<moving> blocks;
  std::vector<moving> all;
  for (std::int32_t i = 0; i < 62; i += 2) {
    all.push_back(random.contact(i, i + 1));
    blocks.add(all.back(), true, true);
  }
  blocks.prepare(s);
  blocks.apply(s);
  for (moving& c : all) c.prepare(t, 1, 1), c.apply(t, c.impulse_in_frame());
  for (int k = 0; k < 3; ++k) {
    std::vector<std::pair<std::size_t, real>> changed;
    if (k < 2)
      blocks.forward(s);
    else
      blocks.backward_watched(s, 1e-3, [&](std::size_t i, real by) { changed.push_back({i, by}); });
    std::size_t above = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto d = all[i].relax(t);
      all[i].apply(t, d);
      above += all[i].speed_of(d) > 1e-3;
      CHECK(blocks[i].impulse() == all[i].impulse());
      for (const auto& [which, by] : changed)
        if (which == i) CHECK(by == doctest::Approx(all[i].speed_of(d)).epsilon(allowed(1e-14)));
    }
    if (k == 2) CHECK(changed.size() == above);
  }
  blocks.correct(s);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto d = all[i].relax_correction(t);
    all[i].correct_a(t, d), all[i].correct_b(t, d);
  }
  for (std::size_t i = 0; i < s.bodies.size(); ++i) {
    CHECK(s.bodies[i].v == t.bodies[i].v);
    CHECK(s.bodies[i].w == t.bodies[i].w);
    CHECK(s.shift[i].v == t.shift[i].v);
  }
}

TEST_CASE_TEMPLATE("rows of four numbers end within the object that they are read from", Real,
                   double, float) {
  const auto inside = [](const auto& whole, const auto& part) {
    const auto row = row_of(whole, part);
    const char* const begin = reinterpret_cast<const char*>(&whole);
    return row.begin >= begin && row.begin + 4 * sizeof(Real) <= begin + sizeof whole;
  };
  const solver_body_of<Real> b;
  CHECK(inside(b, b.v));
  CHECK(inside(b, b.w));
  const body_shift_of<Real> shift;
  CHECK(inside(shift, shift.v));
}
