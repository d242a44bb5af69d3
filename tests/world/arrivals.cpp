// Bodies that arrive on a rank one by one, while little else happens that would hide an error.
#include <doctest/doctest.h>

#include <map>
#include <mutex>
#include <set>
#include <talus/observe/force.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/accelerated_jacobi.hpp>
#include <talus/world/world.hpp>
#include <tuple>

#include "../scenes/jacobi.hpp"
#include "../scenes/solids.hpp"

using namespace talus;
using detail::contact_part;

namespace {

struct in_order {
  bool operator()(const detail::contact_key& x, const detail::contact_key& y) const {
    return std::tuple(x.a, x.b, x.feature) < std::tuple(y.a, y.b, y.feature);
  }
};
using impulses = std::map<detail::contact_key, vec3, in_order>;

template <class World, class F>
void each_contact(World& w, F&& f) {
  talus::detail::state_of(w).each_contact_list([&](const auto& list) {
    for (const auto part : {contact_part::interior, contact_part::boundary})
      for (std::size_t i = 0; i < list.size(part); ++i)
        f(part, list.key(part, i), list.contact(part, i).impulse());
  });
}

}  // namespace

TEST_CASE_TEMPLATE(
    "bodies that cross a boundary in single file forget nothing and remember it once", Lane,
    scenes::solids, scenes::jacobi) {
  using state = detail::world_state<Lane>;
  for (const bool pile : {false, true}) {
    CAPTURE(pile);
    impulses before;
    std::mutex guard;
    std::size_t compared = 0, forgotten = 0, doubled = 0, crossed = 0, apart = 0;
    threads::launch({.ranks = 2}, [&](threads::link& link) {
      world<Lane> w(link, grid<2>{.lower = {-9}, .upper = {9}});
      const auto m = w.material({.friction = 0});
      w.gravity({0, 0, -10});
      w.global([&](auto& s) { s.add(plane{.normal = {0, 0, 1}}, m); });
      for (int k = 0; k < 6; ++k) {  // to the left and to the right
        const real to = k % 2 ? 1 : -1, x = -to * (0.7 + 0.9 * k);
        for (int high = 0; high < (pile ? 3 : 1); ++high) {
          const vec3 at{x, 3. * (k % 2), 0.5 + high}, v{2 * to, 0, 0};
          if (k % 3 == 2)
            w.add_if_local(
                body{.shape = box{{0.8, 1, 1}}, .position = at, .material = m, .velocity = v});
          else
            w.add_if_local(
                body{.shape = sphere{0.5}, .position = at, .material = m, .velocity = v});
        }
      }
      std::set<system_id> mine;
      for (int step = 0; step < 400; ++step) {
        w.step(0.01);
        std::set<system_id> now;
        w.for_each_local([&](const auto& b) { now.insert(b.id()); });
        if (link.rank() == 0) before.clear();
        link.barrier();
        {
          const std::lock_guard lock(guard);
          for (const auto id : now) crossed += step > 0 && !mine.contains(id);
          each_contact(w, [&](contact_part, const auto& key, const vec3& p) {
            const auto [old, first] = before.emplace(key, p);
            apart += !first && old->second != p;  // of two ranks that solve it
          });
          std::set<std::tuple<system_id, system_id, std::uint64_t>> kept;
          for (const auto& c : talus::detail::state_of(w).history.entries())
            doubled += !kept.emplace(c.key.a, c.key.b, c.key.feature).second;
        }
        mine = std::move(now);
        link.barrier();
        auto& s = const_cast<state&>(talus::detail::state_of(w));
        detail::detect(s);  // as the next step will
        s.each_contact_list([&](auto& list) { list.load_impulses(s.history); });
        const std::lock_guard lock(guard);
        each_contact(w, [&](contact_part, const auto& key, const vec3& p) {
          const auto old = before.find(key);
          if (old == before.end() || old->second.norm() < 1e-6) return;
          ++compared;
          forgotten += (p - old->second).norm() > 0.1 * old->second.norm();
        });
      }
    });
    CHECK(compared > 2000);
    CHECK(crossed >= (pile ? 18 : 6));
    CHECK(forgotten == 0);
    CHECK(doubled == 0);
    CHECK(apart == 0);
  }
}

TEST_CASE("two bodies that touch stay in contact while they come to a rank that has none") {
  using pair = scenario<bodies<sphere, box, plane>, decomposition<grid<2>>, transport<threads>,
                        hard_contact<no_correction>>;
  std::mutex guard;
  std::map<int, int> interior, boundary;  // by step
  constexpr int steps = 200;
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<pair> w(link, grid<2>{.lower = {-9}, .upper = {9}});
    const auto m = w.material({});
    for (const real x : {1., 2.99})
      w.add_if_local(body{
          .shape = sphere{1}, .position = {x + 2, 0, 0}, .material = m, .velocity = {-3, 0, 0}});
    for (int step = 0; step < steps; ++step) {
      w.step(0.01);
      const std::lock_guard lock(guard);
      each_contact(w, [&](contact_part part, const auto&, const vec3&) {
        ++(part == contact_part::interior ? interior : boundary)[step];
      });
    }
    if (link.rank() == 0) CHECK(w.local_bodies() == 2);
  });
  int missed = 0;
  for (int step = 0; step < steps; ++step)
    missed += !(interior[step] == 1 && boundary[step] == 0) &&
              !(interior[step] == 0 && boundary[step] == 2);
  CHECK(missed == 0);
}
