// Bodies are sorted in memory by their positions in space.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <random>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

constexpr int side = 22;  // a cube of so many bodies along each edge

/// Sites of a cubic lattice in a random order, numbered as in space.
std::vector<int> scattered_sites() {
  std::vector<int> sites(side * side * side);
  for (int k = 0; k < std::ssize(sites); ++k) sites[static_cast<std::size_t>(k)] = k;
  std::shuffle(sites.begin(), sites.end(), std::mt19937(7));
  return sites;
}
vec3 place_of_site(int k) { return vec3(k % side, k / side % side, k / side / side); }

template <class World>
real scatter(const World& w) {
  const auto& store = talus::detail::state_of(w).template of<sphere>().movable;
  return detail::scatter_of(std::span<const vec3>(store.position).first(store.locals));
}

/// Scatters the bodies when it is time to sort them.
template <class State>
void scatter_bodies(State& s) {
  auto& store = s.template of<sphere>().movable;
  detail::plain_vector<std::uint32_t> order(store.locals);
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<std::uint32_t>(k);
  std::shuffle(order.begin(), order.end(), std::mt19937(11));
  store.permute_locals(order);
  s.steps = detail::steps_between_sorts;
}

}  // namespace

TEST_CASE("bodies that were made in any order are sorted, and each keeps what is its own") {
  using cloud = scenario<bodies<sphere>, transport<serial>, features<user_ids, forces>>;
  serial::link link;
  world<cloud> w(link);
  const auto heavy = w.material({.density = 2}), light = w.material({.density = 1});
  struct own {
    int site;
    real radius;
  };
  std::map<system_id, own> made;
  for (const int k : scattered_sites()) {
    const real radius = 0.1 + 1e-5 * k;
    const auto h = w.add(body{.shape = sphere{radius},
                              .position = place_of_site(k),
                              .material = k % 2 ? heavy : light,
                              .velocity = {1e-3 * k, 0, 0},
                              .user_id = static_cast<std::uint32_t>(k)});
    made[h.id] = {k, radius};
  }
  CHECK(scatter(w) > 5);
  for (int step = 0; step < 3; ++step) w.step(0.001);
  CHECK(scatter(w) < 3);
  std::size_t seen = 0, wrong = 0;
  w.for_each_local([&](const auto& b) {
    const own& o = made.at(b.id());
    const int k = o.site;
    ++seen;
    wrong += b.shape().radius != o.radius || b.user_id() != static_cast<std::uint32_t>(k) ||
             b.material() != (k % 2 ? heavy : light) || b.velocity() != vec3(1e-3 * k, 0, 0) ||
             (b.position() - place_of_site(k) - vec3(3e-6 * k, 0, 0)).norm() > 1e-12;
  });
  CHECK(seen == made.size());
  CHECK(wrong == 0);
}

TEST_CASE("bodies that are in order already are left as they are") {
  using cloud = scenario<bodies<sphere>, transport<serial>>;
  for (const bool flat : {false, true}) {
    CAPTURE(flat);
    serial::link link;
    world<cloud> w(link);
    w.material({});
    std::vector<system_id> order;
    for (int k = 0; k < side * side * side; ++k) {
      const vec3 at = flat ? vec3(k % 104, k / 104, 0) : place_of_site(k);
      order.push_back(w.add(body{.shape = sphere{0.4}, .position = at}).id);
    }
    w.step(0.001);
    const auto& id = talus::detail::state_of(w).of<sphere>().movable.id;
    CHECK(std::equal(id.begin(), id.end(), order.begin(), order.end()));
  }
}

TEST_CASE("sorting between two steps loses neither contacts nor momentum nor copies on any rank") {
  using cloud = scenario<bodies<sphere>, decomposition<grid<dynamic>>, transport<threads>,
                         hard_contact<no_correction>>;
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<cloud> w(link);
      w.decompose({.cells = {ranks, 1, 1}, .lower = {.x = 0}, .upper = {.x = side - 1.0}});
      w.material({.restitution = 0.5, .friction = 0.3});
      std::mt19937 random(3);
      std::uniform_real_distribution<real> some(-1, 1);
      for (int k = 0; k < side * side * side; ++k) {  // sorted, but not by the curve
        const vec3 v(some(random), some(random), some(random));
        w.add_if_local(body{.shape = sphere{0.499}, .position = place_of_site(k), .velocity = v});
      }
      w.synchronize();
      const motion before = measure_motion(w);
      for (int step = 0; step < 3; ++step) {
        if (step == 2) {  // while the history and the neighbour list are in use
          scatter_bodies(const_cast<detail::world_state<cloud>&>(talus::detail::state_of(w)));
        }
        w.step(0.01);
      }
      CHECK(scatter(w) < 3);
      const motion after = measure_motion(w);
      std::uint64_t contacts = 0;
      talus::detail::state_of(w).each_contact_list([&](const auto& list) {
        list.each([&](const auto& c, bool counts) {
          contacts += counts && c.impulse().squaredNorm() > 0;
        });
      });
      link.reduce(reduction::sum, std::span(&contacts, 1));
      if (link.rank() != 0) return;
      CHECK(after.bodies == before.bodies);
      CHECK(contacts > 1000);
      CHECK((after.momentum - before.momentum).norm() < 1e-10);
    });
  }
}
