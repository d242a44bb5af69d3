// timeout: 300
// Sleeping and waking islands, and continuous collision: the same bits on any number of ranks, for
// any decomposition.
#include "reproducible.hpp"

#include <atomic>
#include <talus/scene/lattice.hpp>

namespace {

template <class... Features>
using heap = scenario<bodies<sphere, box, plane>, solver<reproducible>, transport<threads>,
                      decomposition<any_decomposition>, features<Features...>>;

/// Separate piles, of which each falls asleep by itself, and walls of boxes through all domains.
template <class World>
void piles(World& w) {
  const auto sites =
      simple_cubic{.spacing = 0.8, .origin = {-3.6, -3.6, 0.4}} & vertical_cylinder{.radius = 2.6};
  w.fill(sites.first(90), [](const site& place, random_stream& random) {
    return body{.shape = sphere{random.uniform(0.2, 0.39)}, .position = place.position};
  });
  for (int k = 0; k < 7; ++k)
    w.add_if_local(body{.shape = box{{0.99, 0.5, 0.5}}, .position = {k - 3.2, 3, 0.25}});
}
/// Added and removed, so that islands wake by an impact, by a loss and by the user.
template <class World>
void disturb(World& w, int k) {
  if (k % 60 == 30)
    w.add_if_local(body{
        .shape = sphere{0.3}, .position = {0.05 * k - 3.2, 2.9, 2}, .velocity = {0.5, 0.1, -4}});
  if (k == 210)
    w.destroy_if([](const auto& b) {
      const vec3& x = b.position();
      return (x[0] < -1.4 && std::abs(x[1]) < 1) || (x[0] < -3 && x[1] < -3 && x[2] < 0.5);
    });
  if (k == 250)
    w.for_each_local([](auto& b) {
      if (b.position()[0] > 2.8 && b.position()[1] > 2.5) b.set_velocity({-3, 0, 0});
    });
}

}  // namespace

TEST_CASE("islands fall asleep and wake with the same bits on any ranks") {
  std::atomic<int> slept = 0, awake = 0, woken = 0;
  check_same<heap<sleeping>>(
      300,
      [](auto& w) {
        w.sleeping({.speed = 0.15, .time = 0.1});
        piles(w);
        for (int i = 0; i < 3; ++i)  // a stack that loses its lowest box
          w.add_if_local(
              body{.shape = box{{0.5, 0.5, 0.5}}, .position = {-3.3, -3.3, 0.5 * i + 0.25}});
      },
      [&](auto& w, int k) {
        w.for_each_local([&](const auto& b) {
          if (k == 209) slept += b.is_asleep(), awake += !b.is_asleep();
          if (k == 214) woken += !b.is_asleep();
        });
        disturb(w, k);
      });
  CHECK(slept > 8 * 20);     // in each of the 8 runs
  CHECK(woken > awake + 8);  // the islands that rested on the destroyed bodies
}

TEST_CASE("bullets that wake what they strike leave the bits the same on any ranks") {
  std::atomic<int> slept = 0, inside = 0;
  check_same<heap<sleeping, continuous_collision>>(
      160,
      [](auto& w) {
        w.sleeping({.speed = 0.15, .time = 0.1});
        piles(w);
      },
      [&](auto& w, int k) {
        if (k == 120) {
          w.for_each_local([&](const auto& b) { slept += b.is_asleep(); });
          w.add_if_local(
              body{.shape = sphere{0.1}, .position = {-3.9, 3, 0.25}, .velocity = {300, 0, 0}});
          w.add_if_local(
              body{.shape = sphere{0.1}, .position = {3, 0.1, 3.8}, .velocity = {-20, 0, -500}});
        }
        if (k == 159)
          w.for_each_local([&](const auto& b) {
            inside += std::abs(b.position()[0]) < 4 && std::abs(b.position()[1]) < 4 &&
                      b.position()[2] > 0;
          });
      });
  CHECK(slept > 8 * 20);
  CHECK(inside == 8 * 99);
}
