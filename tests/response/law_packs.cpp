// Interaction laws evaluated for eight contacts at once: the same bits as one by one, in all
// branches of each law.
#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cstdint>
#include <random>
#include <talus/core/pack_fields.hpp>
#include <talus/detect/pairs/sphere_sphere.hpp>
#include <talus/interaction/pair_kinematics.hpp>
#include <talus/interaction/soft_contact.hpp>
#include <talus/interaction/twisting_resistance.hpp>
#include <utility>

namespace {

using namespace talus;
using namespace talus::detail;
using eight = wide_pack<real>;
constexpr std::size_t lanes = lanes_of<eight>;

std::uint64_t bits(real x) { return std::bit_cast<std::uint64_t>(x); }

struct dice {
  std::mt19937 engine;
  real between(real low, real high) {
    return std::uniform_real_distribution<real>(low, high)(engine);
  }
  vec3 vector(real size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  bool one_of(int n) { return std::uniform_int_distribution<int>(1, n)(engine) == 1; }
};

contact_kinematics random_contact(dice& roll, real step) {
  contact_kinematics c;
  c.normal = roll.vector(1).normalized();
  c.gap = -roll.between(1e-6, 1e-2);
  c.velocity = roll.one_of(5) ? vec3(0, 0, 0) : roll.vector(1);
  c.spin = roll.one_of(5) ? vec3(0, 0, 0) : roll.vector(10);
  c.mean_spin = roll.between(-10, 10);
  c.mass = roll.between(0.1, 1), c.radius = roll.between(0.1, 1);
  c.rolling_inertia = roll.between(0.01, 0.1);
  c.step = step;
  return c;
}
void put(contact_kinematics_of<eight>& all, std::size_t l, const contact_kinematics& c) {
  put_lane(all.normal, l, c.normal), put_lane(all.gap, l, c.gap);
  put_lane(all.velocity, l, c.velocity), put_lane(all.spin, l, c.spin);
  put_lane(all.mean_spin, l, c.mean_spin), put_lane(all.mass, l, c.mass);
  put_lane(all.radius, l, c.radius), put_lane(all.rolling_inertia, l, c.rolling_inertia);
  all.step = c.step;
}

/// Numbers of magnitudes at which each branch of the laws is met.
void choose_parameters(dice& roll, hertz_mindlin::parameters& p) {
  p = {roll.between(1, 1e3), roll.between(1, 1e3), roll.one_of(3) ? roll.between(1, 3) : 0.3};
}
void choose_parameters(dice& roll, linear_spring_dashpot::parameters& p) {
  p = {roll.between(1, 1e3), roll.between(1, 1e3), roll.one_of(3) ? roll.between(1, 3) : 0.3};
}
template <class Bearing>
void choose_friction(dice& roll, typename tangential_spring<Bearing>::parameters& p) {
  p.friction = roll.one_of(5) ? 0 : roll.one_of(3) ? 1e6 : roll.between(0.1, 1);
  p.dynamic_friction = roll.one_of(2) ? p.friction : p.friction / 2;
}
void choose_parameters(dice& roll, rolling_resistance::parameters& p) {
  p = {roll.one_of(4) ? 0 : roll.one_of(3) ? 50 : roll.between(0.001, 0.1)};
}
void choose_parameters(dice& roll, twisting_resistance::parameters& p) {
  p = {roll.one_of(4) ? 0 : roll.one_of(3) ? 50 : roll.between(0.001, 0.1)};
}

/// How often each branch was taken.
struct branches {
  std::size_t sliding = 0, sticking = 0, kept = 0, pulled = 0;
};

template <class Law, class Friction>
branches compare(unsigned seed) {
  dice roll{std::mt19937(seed)};
  branches met;
  std::size_t differ = 0;
  for (int n = 0; n < 400; ++n) {
    const real dt = n % 7 == 0 ? 0 : 1e-3, step = n % 5 == 0 ? 0 : 1e-3;
    std::array<typename Law::parameters, lanes> p{};
    std::array<typename Law::memory, lanes> memory{};
    typename Law::template parameters_of<eight> all_p;
    typename Law::template memory_of<eight> all_memory;
    for (std::size_t l = 0; l < lanes; ++l)
      Law::each_part([&]<class Part>() {
        if constexpr (std::is_same_v<Part, tangential_spring<Friction>>)
          choose_friction<Friction>(roll, Law::template of<Part>(p[l]));
        else
          choose_parameters(roll, Law::template of<Part>(p[l]));
      });
    Law::each_part([&]<class Part>() {
      gather_fields<eight>(
          Law::template of<Part>(all_p), [&](int l) -> const auto& {
            return Law::template of<Part>(p[static_cast<std::size_t>(l)]);
          });
    });
    for (int k = 0; k < 4; ++k) {
      std::array<contact_kinematics, lanes> c;
      contact_kinematics_of<eight> all;
      for (std::size_t l = 0; l < lanes; ++l) {
        if (roll.one_of(4)) memory[l] = {};  // a new contact
        c[l] = random_contact(roll, step);
        put(all, l, c[l]);
      }
      Law::each_part([&]<class Part>() {
        gather_fields<eight>(
            Law::template of<Part>(all_memory), [&](int l) -> const auto& {
              return Law::template of<Part>(memory[static_cast<std::size_t>(l)]);
            });
      });
      not_booked books;
      const pair_force_of<eight> f = Law::template force<eight>(all, all_p, dt, all_memory, books);
      std::array<typename Law::memory, lanes> scattered{};
      Law::each_part([&]<class Part>() {
        scatter_fields<eight>(
            Law::template of<Part>(all_memory), [&](int l) -> auto& {
              return Law::template of<Part>(scattered[static_cast<std::size_t>(l)]);
            });
      });
      for (std::size_t l = 0; l < lanes; ++l) {
        const pair_force one = Law::force(c[l], p[l], dt, memory[l], books);
        const vec3 force = lane(f.force, l), moment = lane(f.moment, l);
        for (int i = 0; i < 3; ++i)
          differ +=
              (bits(force[i]) != bits(one.force[i])) + (bits(moment[i]) != bits(one.moment[i]));
        Law::each_part([&]<class Part>() {
          using part = typename Part::memory;
          if constexpr (!std::is_empty_v<part>) {
            using array = std::array<std::uint64_t, sizeof(part) / sizeof(std::uint64_t)>;
            differ += std::bit_cast<array>(Law::template of<Part>(scattered[l])) !=
                      std::bit_cast<array>(Law::template of<Part>(memory[l]));
          }
        });
        if constexpr (!std::is_void_v<Friction>) {
          const auto& m = Law::template of<tangential_spring<Friction>>(memory[l]);
          ++(m.sliding != 0 ? met.sliding : met.sticking);
          met.kept += m.spring.squaredNorm() > 0;
        }
        met.pulled += one.force.squaredNorm() == 0;
      }
    }
  }
  CHECK(differ == 0);
  return met;
}

template <class... Parts>
using law_of = typename soft_contact<Parts...>::law;

}  // namespace

TEST_CASE_TEMPLATE("a spring alone has the same bits for eight contacts at once", spring,
                   hertz_mindlin, linear_spring_dashpot) {
  CHECK(compare<law_of<spring>, void>(1).pulled > 100);
}

TEST_CASE("springs, friction and resistances have the same bits for eight contacts at once") {
  const auto check = [](const branches& met) {
    CHECK(met.sliding > 500);
    CHECK(met.sticking > 500);
    CHECK(met.kept > 500);
  };
  check(compare<law_of<hertz_mindlin, coulomb_friction>, growing_bearing>(2));
  check(compare<law_of<linear_spring_dashpot, coulomb_friction>, bearing>(3));
  check(compare<law_of<hertz_mindlin, coulomb_friction, rolling_resistance, twisting_resistance>,
                growing_bearing>(4));
  check(compare<law_of<linear_spring_dashpot, coulomb_friction, rolling_resistance>, bearing>(5));
  check(compare<law_of<linear_spring_dashpot, coulomb_friction, twisting_resistance>, bearing>(6));
}

TEST_CASE("laws without templates are evaluated one by one") {
  CHECK(law_of<hertz_mindlin, coulomb_friction>::in_packs);
  CHECK_FALSE(law_of<hertz_mindlin, parallel_bond>::in_packs);
}

TEST_CASE("the contact points of eight pairs of spheres have the same bits as one by one") {
  dice roll{std::mt19937(7)};
  std::size_t differ = 0;
  for (int n = 0; n < 300; ++n) {
    std::array<body_at_contact<real>, lanes> a, b;
    std::array<vec3, lanes> at_a, at_b;
    body_at_contact<eight> all_a, all_b;
    vectors_of<eight> all_at_a, all_at_b;
    const auto body = [&] {
      const real radius = roll.between(0.5, 1);
      return body_at_contact<real>{
          roll.vector(1), roll.vector(1), roll.one_of(4) ? 0 : roll.between(0.1, 1),
          radius,         1 / radius,     {0, 0, 0}};
    };
    const auto put_body = [](body_at_contact<eight>& all, std::size_t l,
                             const body_at_contact<real>& one) {
      put_lane(all.v, l, one.v), put_lane(all.w, l, one.w);
      put_lane(all.inverse_mass, l, one.inverse_mass), put_lane(all.radius, l, one.radius);
      put_lane(all.curvature, l, one.curvature);
    };
    for (std::size_t l = 0; l < lanes; ++l) {
      a[l] = body(), b[l] = body();
      at_a[l] = roll.vector(1), at_b[l] = roll.one_of(10) ? at_a[l] : roll.vector(1);
      put_body(all_a, l, a[l]), put_body(all_b, l, b[l]);
      put_lane(all_at_a, l, at_a[l]), put_lane(all_at_b, l, at_b[l]);
    }
    touch_of_spheres<eight> all(all_at_a, all_a.radius, all_at_b, all_b.radius);
    all.find_point(all_at_b, all_b.radius);
    all_a.arm = all.point - all_at_a, all_b.arm = all.point - all_at_b;
    const auto t = kinematics_of_pair<eight>(all.normal, all.gap, all_a, all_b, 1e-3);
    for (std::size_t l = 0; l < lanes; ++l) {
      touch_of_spheres<real> one(at_a[l], a[l].radius, at_b[l], b[l].radius);
      one.find_point(at_b[l], b[l].radius);
      a[l].arm = one.point - at_a[l], b[l].arm = one.point - at_b[l];
      const auto u = kinematics_of_pair<real>(one.normal, one.gap, a[l], b[l], 1e-3);
      const vec3 normal = lane(t.normal, l), velocity = lane(t.velocity, l), spin = lane(t.spin, l);
      for (int i = 0; i < 3; ++i)
        differ += (bits(normal[i]) != bits(u.normal[i])) +
                  (bits(velocity[i]) != bits(u.velocity[i])) + (bits(spin[i]) != bits(u.spin[i]));
      differ += (bits(lane(t.gap, l)) != bits(u.gap)) +
                (bits(lane(t.mean_spin, l)) != bits(u.mean_spin)) +
                (bits(lane(t.mass, l)) != bits(u.mass)) +
                (bits(lane(t.radius, l)) != bits(u.radius)) +
                (bits(lane(t.rolling_inertia, l)) != bits(u.rolling_inertia));
    }
  }
  CHECK(differ == 0);
}
