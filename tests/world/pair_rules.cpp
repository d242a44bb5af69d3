// world.pair_rules: how a pair of materials follows from the two, for hard and for soft contacts,
// on any number of ranks; and the warning about materials that are frictionless in name only.
#include <doctest/doctest.h>

#include <cmath>
#include <mutex>
#include <stdexcept>
#include <string>
#include <talus/observe/half_frictionless.hpp>
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "../scenes/solids.hpp"

using namespace talus;

namespace {

using cells = grid<dynamic>;
using soft_scene =
    scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
             transport<threads>, decomposition<any_decomposition>>;

/// The speed along x that a sphere of the friction 0.6 keeps of 2, on a plane without friction,
/// after a tenth of a second under a gravity of 10; by how much it turns shows the friction.
template <class Scenario, class Rules>
real kept_speed(int ranks, Rules&& set_rules) {
  real speed = 0;
  std::mutex one_by_one;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, cells{.lower = {-4}, .upper = {4}});
    const material rough{.density = 1, .friction = 0.6, .stiffness = 1e5};
    const auto ball = w.material(rough);
    const auto platen = w.material({.density = 1, .stiffness = rigid});
    w.gravity({0, 0, -10});
    set_rules(w, ball, platen);
    w.global([&](auto& scope) { scope.add(plane{}, platen); });
    w.add_if_local(body{
        .shape = sphere{0.5}, .position = {-0.1, 0, 0.5}, .material = ball, .velocity = {2, 0, 0}});
    for (int k = 0; k < 400; ++k) w.step(0.1 / 400);
    w.for_each_local([&](const auto& b) {
      const std::scoped_lock lock(one_by_one);
      speed = b.velocity()[0];
    });
  });
  return speed;
}

template <class Scenario>
void slides_by_the_rule() {
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    const auto with = [&](talus::pair_rules rules) {
      return kept_speed<Scenario>(ranks, [&](auto& w, auto, auto) { w.pair_rules(rules); });
    };
    // The mean, 0.3, takes 0.3 of gravity.
    CHECK(kept_speed<Scenario>(ranks, [](auto&, auto, auto) {}) ==
          doctest::Approx(1.7).epsilon(0.02));
    CHECK(with({.friction = pair_rule::mean}) == doctest::Approx(1.7).epsilon(0.02));
    CHECK(with({.friction = pair_rule::least}) == doctest::Approx(2).epsilon(1e-9));
    CHECK(with({.friction = pair_rule::product}) == doctest::Approx(2).epsilon(1e-9));
    // Properties of the pair win over every rule.
    for (const pair_rule rule : {pair_rule::mean, pair_rule::least, pair_rule::table})
      CHECK(kept_speed<Scenario>(ranks, [&](auto& w, auto a, auto b) {
              w.pair_rules({.friction = rule});
              w.material_pair(b, a, {.friction = 0.1});
              w.material_pair(a, a, {}), w.material_pair(b, b, {});
            }) == doctest::Approx(1.9).epsilon(0.02));
  }
}

std::string warned(int ranks, const std::vector<real>& frictions, auto&& set_up) {
  std::vector<std::string> words(static_cast<std::size_t>(ranks));
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<scenes::solids> w(link, cells{.lower = {-4}, .upper = {4}});
    std::vector<material_id> m;
    for (const real friction : frictions) m.push_back(w.material({.friction = friction}));
    set_up(w, m);
    w.synchronize();
    words[static_cast<std::size_t>(w.rank())] = detail::half_frictionless(w);
  });
  for (const std::string& of_rank : words) CHECK(of_rank == words[0]);
  return words[0];
}

}  // namespace

TEST_CASE("a pair of materials follows from the two by the rule that is set") {
  material_table all;
  const auto a = all.add({.restitution = 0.5, .friction = 0.8, .dynamic_friction = 0.4});
  const auto b = all.add({.restitution = 0.25, .friction = 0.5});
  CHECK(all.pair(a, b).friction == 0.65);
  const auto before = all.revision();
  all.set_rules({.restitution = pair_rule::product, .friction = pair_rule::least});
  CHECK(all.revision() > before);
  const auto c = all.add({.restitution = 1, .friction = 0});
  CHECK(all.pair(a, b).restitution == 0.125);
  CHECK(all.pair(b, a).friction == 0.5);
  CHECK(all.pair(a, b).dynamic_friction == 0.4);
  CHECK(all.pair(a, c).friction == 0);
  CHECK(all.pair(c, b).restitution == 0.25);
  all.set_rules({.restitution = pair_rule::least, .friction = pair_rule::product});
  CHECK(all.pair(a, b).restitution == 0.25);
  CHECK(all.pair(a, b).friction == 0.4);
  CHECK(all.pair(a, b).dynamic_friction == 0.2);
  all.set_pair(b, a, {.restitution = 1, .friction = 3});
  CHECK(all.pair(a, b).friction == 3);
  CHECK(all.by_rule(a, b).friction == 0.4);
  CHECK(all.describe_rules() ==
        "of two materials: friction by the product, restitution by the least; 1 with values of "
        "their own");
  all.set_rules({.friction = pair_rule::table});
  CHECK(all.pair(a, b).restitution == 1);
  CHECK_THROWS_WITH_AS(
      (void)all.pair(c, b),
      "the materials 2 and 1 may touch, and world.pair_rules takes the friction of a pair from the "
      "table, which has no entry for them: add one by world.material_pair",
      std::runtime_error);
  all.set_rules({});
  CHECK(all.pair(a, c).friction == 0.4);
  CHECK_THROWS_WITH_AS(all.set_rules({.restitution = static_cast<pair_rule>(7)}),
                       "the rule of a pair of materials is mean, least, product or table, but is 7",
                       std::invalid_argument);
}

TEST_CASE("a sphere slides on a plane without friction by the rule, hard contacts") {
  slides_by_the_rule<scenes::solids>();
}

TEST_CASE("a sphere slides on a plane without friction by the rule, soft contacts") {
  slides_by_the_rule<soft_scene>();
}

TEST_CASE("a sphere rebounds by the rule for restitution") {
  for (const auto& [rule, kept] :
       {std::pair{pair_rule::mean, 0.5}, std::pair{pair_rule::least, 0.2},
        std::pair{pair_rule::product, 0.16}}) {
    threads::launch({.ranks = 1}, [rule = rule, kept = kept](threads::link& link) {
      world<scenes::solids> w(link, cells{.lower = {-4}, .upper = {4}});
      const auto ball = w.material({.restitution = 0.8}), floor = w.material({.restitution = 0.2});
      w.pair_rules({.restitution = rule});
      w.global([&](auto& scope) { scope.add(plane{}, floor); });
      const auto h = w.add(body{
          .shape = sphere{0.5}, .position = {0, 0, 0.6}, .material = ball, .velocity = {0, 0, -4}});
      for (int k = 0; k < 20; ++k) w.step(0.01);
      CHECK(w[h].velocity()[2] == doctest::Approx(4 * kept).epsilon(1e-6));
    });
  }
}

TEST_CASE("materials that are frictionless in name only are told, once, with a way out") {
  const auto platen = [](auto& w, const auto& m) {
    w.global([&](auto& scope) { scope.add(plane{}, m[1]); });
    w.add_if_local(body{.shape = sphere{0.5}, .position = {1, 0, 1}, .material = m[0]});
  };
  for (const int ranks : {1, 2})
    CHECK(warned(ranks, {0.5, 0}, platen) ==
          "material 1 (of a plane) has no friction and material 0 (of a sphere) has 0.5, and their "
          "contacts take the mean, 0.25: for a frictionless plane call "
          "world.pair_rules with .friction = pair_rule::least, or give the pair a value of its own "
          "by world.material_pair");
  // Grains that share their material with a wall are what the platen meets.
  CHECK(
      warned(1, {0.5, 0}, [&](auto& w, const auto& m) {
        w.global([&](auto& scope) { scope.add(plane{.offset = -1}, m[0]); });
        platen(w, m);
      }).find("material 1 (of a plane) has no friction and material 0 (of a sphere) has 0.5") == 0);
  // A sphere on one rank and a box on another are told, too.
  CHECK(warned(2, {0.5, 0.3, 0}, [](auto& w, const auto& m) {
          w.add_if_local(body{.shape = sphere{0.5}, .position = {-2, 0, 1}, .material = m[0]});
          w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {2, 0, 1}, .material = m[2]});
        }).find("material 2 (of a box) has no friction and material 0 (of a sphere) has 0.5") == 0);
  CHECK(warned(1, {0.5, 0.1}, platen).empty());
  CHECK(warned(1, {0, 0}, platen).empty());
  CHECK(warned(1, {0.5, 0}, [&](auto& w, const auto& m) {
          platen(w, m);
          w.pair_rules({.friction = pair_rule::least});
        }).empty());
  CHECK(warned(1, {0.5, 0}, [&](auto& w, const auto& m) {
          platen(w, m);
          w.material_pair(m[0], m[1], {.friction = 0.25});
        }).empty());
  // Without bodies of one of the materials, or where neither of the bodies moves.
  CHECK(warned(1, {0.5, 0.2, 0}, platen).empty());
  CHECK(warned(1, {0.5, 0}, [](auto& w, const auto& m) {
          w.global([&](auto& scope) {
            scope.add(plane{}, m[0]);
            scope.add(plane{.normal = {1, 0, 0}, .offset = -3}, m[1]);
          });
        }).empty());
}
