// Contacts of spheres that stay in the solver's list from step to step: each has the numbers of a
// contact made anew, whichever pairs began to touch, parted, or touched again.
#include <doctest/doctest.h>

#include <map>
#include <random>
#include <talus/parallel/serial.hpp>
#include <talus/step/detect.hpp>
#include <talus/world/world.hpp>
#include <utility>
#include <vector>

using namespace talus;

namespace {

template <class... Policies>
using heap = scenario<bodies<sphere, plane>, transport<serial>, Policies...>;

/// The numbers of a contact that do not depend on its impulse.
struct numbers_of_contact {
  vec3 normal;
  real arm_a, arm_b, target_velocity, correction_rate, friction;
  friend bool operator==(const numbers_of_contact&, const numbers_of_contact&) = default;
};
template <class Scenario>
auto contacts_of(const world<Scenario>& w) {
  std::map<std::pair<system_id, system_id>, numbers_of_contact> found;
  std::size_t doubled = 0;
  detail::state_of(w).each_contact_list([&](const auto& list) {
    using detail::contact_part;
    for (std::size_t i = 0; i < list.size(contact_part::interior); ++i) {
      const auto c = list.contact(contact_part::interior, i);
      const auto& key = list.key(contact_part::interior, i);
      const bool added =
          found
              .emplace(std::pair(key.a, key.b),
                       numbers_of_contact{detail::in_scalar<real>(c.normal), c.arm_a, c.arm_b,
                                          c.target_velocity, c.correction_rate, c.friction})
              .second;
      doubled += added ? 0 : 1;
    }
  });
  CHECK(doubled == 0);
  return found;
}

template <class Scenario>
struct scene {
  serial::link link;
  world<Scenario> w{link};
  std::vector<handle<sphere>> spheres;

  scene(unsigned seed, real restitution, real dynamic_friction) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<real> some(-0.1, 0.1);
    const auto m = w.material(
        {.restitution = restitution, .friction = 0.4, .dynamic_friction = dynamic_friction});
    w.gravity({0, 0, -9.81});
    w.global([&](auto& s) {
      s.add(plane{.normal = {0, 0, 1}}, m);
      s.add(plane{.normal = {1, 0, 0}}, m), s.add(plane{.normal = {-1, 0, 0}, .offset = -6}, m);
      s.add(plane{.normal = {0, 1, 0}}, m), s.add(plane{.normal = {0, -1, 0}, .offset = -6}, m);
    });
    for (int k = 0; k < 300; ++k) {
      const vec3 at{0.6 + 0.95 * (k % 6) + some(engine), 0.6 + 0.95 * (k / 6 % 6) + some(engine),
                    1 + 1.1 * (k / 36)};
      spheres.push_back(
          w.add(body{.shape = sphere{0.4 + some(engine) / 2}, .position = at, .material = m}));
    }
  }
  /// The state of another one of the same seed, without what that has kept.
  void take_over(const scene& other) {
    auto& mine = detail::state_of(w);
    const auto& its = detail::state_of(other.w).template of<sphere>().movable;
    auto& store = mine.template of<sphere>().movable;
    REQUIRE(store.size() == its.size());
    store.position = its.position, store.velocity = its.velocity;
    store.angular_velocity = its.angular_velocity, store.id = its.id, store.shape = its.shape;
    mine.found = {};
    mine.history = {};
    mine.dt = 1.0 / 240;
  }
};

template <class Scenario>
void compare(real restitution, real dynamic_friction) {
  for (const unsigned seed : {1u, 2u}) {
    CAPTURE(seed);
    scene<Scenario> kept(seed, restitution, dynamic_friction),
        anew(seed, restitution, dynamic_friction);
    std::mt19937 engine(seed + 10);
    std::size_t differing = 0, compared = 0, rested = 0, kept_steps = 0;
    for (int step = 0; step < 300; ++step) {
      if (step > 150 && step % 20 == 0) {  // pairs part and touch again
        auto which = kept.w[kept.spheres[engine() % kept.spheres.size()]];
        which.set_velocity({0, 0, 1.5});
      }
      anew.take_over(kept);
      detail::find_contacts(detail::state_of(anew.w));
      const auto search = detail::state_of(kept.w).found.searches;
      kept.w.step(1.0 / 240);
      const auto one = contacts_of(kept.w), other = contacts_of(anew.w);
      compared += other.size();
      if (one != other) ++differing;
      kept_steps += detail::state_of(kept.w).found.searches == search ? 1 : 0;
      detail::state_of(kept.w).each_contact_list([&](const auto& list) {
        if constexpr (requires { list.resting(); }) rested += list.resting();
      });
    }
    CHECK(compared > 50000);
    CHECK(differing == 0);
    CHECK(kept_steps > 100);  // otherwise nothing was kept
    CHECK(rested > 100);
  }
}

}  // namespace

TEST_CASE("kept contacts of spheres have the numbers of contacts made anew") {
  compare<heap<>>(0, 0.4);
}
TEST_CASE(
    "kept contacts of spheres have the numbers of contacts made anew, with rebounds and "
    "less friction while they slide") {
  compare<heap<>>(0.5, 0.2);
}
TEST_CASE("kept contacts of spheres have the numbers of contacts made anew in mixed precision") {
  compare<heap<precision<mixed_precision>>>(0.3, 0.4);
}
