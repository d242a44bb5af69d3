// The same bits from processes that a user has connected by hand as from one rank.
// ranks: 1 2 4 7 9 19
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <array>
#include <talus/mpi.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/by_hand.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/scene/lattice.hpp>

using namespace talus;

int main(int argc, char** argv) {
  doctest::Context context(argc, argv);
  if (detail::find_launcher().rank != 0) context.setOption("minimal", true);
  return context.run();
}

namespace {

constexpr real side = 4.2;

template <class Transport>
using heap = scenario<bodies<sphere, box, plane>, solver<reproducible>, decomposition<by_hand>,
                      transport<Transport>>;

enum class how { as_is, to_a_tolerance, released };

/// Slabs along x; every rank describes the domains of the others.
void connect_slabs(auto& w) {
  const int n = w.ranks();
  const auto right_of = [&](int k) { return half_space(1, 0, 0, side * k / n); };
  const auto left_of = [&](int k) { return half_space(-1, 0, 0, -side * k / n); };
  for (int k = 0; k < n; ++k) {
    if (k == w.rank()) continue;
    if (k == 0)
      w.connect(k, left_of(1));
    else if (k == n - 1)
      w.connect(k, right_of(k));
    else
      w.connect(k, intersect(right_of(k), left_of(k + 1)));
  }
}

template <class Transport>
std::string digest_of(typename Transport::link& link, how what) {
  world<heap<Transport>> w(link);
  connect_slabs(w);
  w.material({.restitution = 0.3, .friction = 0.4});
  w.gravity({0, 0, -10});
  w.global([&](auto& scope) {
    scope.add(plane{}, {});
    for (const vec3& n : {vec3(1, 0, 0), vec3(0, 1, 0)}) {
      scope.add(plane{.normal = n}, {});
      scope.add(plane{.normal = -n, .offset = -side}, {});
    }
  });
  w.fill(simple_cubic{.spacing = 0.85, .origin = {0.43, 0.43, 0.45}} &
             box_region{{0, 0, 0}, {side, side, 3.2}},
         [](const site& at, random_stream& random) -> std::variant<body<sphere>, body<box>> {
           const vec3 push = random.uniform(vec3(-3, -2, -2), vec3(3, 2, 2));
           if (random.uniform(0, 1) < 0.3)
             return body{.shape = box{{0.6, 0.5, 0.4}}, .position = at.position, .velocity = push};
           return body{.shape = sphere{random.uniform(0.3, 0.4)},
                       .position = at.position,
                       .velocity = push};
         });
  w.synchronize();
  if (what == how::to_a_tolerance) w.solver().tolerance = 1e-3;
  for (int k = 0; k < (what == how::as_is ? 200 : 80); ++k) {
    if (what == how::released && (k == 20 || k == 50))
      w.for_each_local([&](auto& b) {
        if (value_of(b.id()) % 5 == 0 && k == 20) b.fix();
        if (b.is_fixed() && k == 50) b.release();
      });
    w.step(1.0 / 240);
  }
  return state_digest(w);
}

}  // namespace

TEST_CASE("processes connected by hand end with the bits of one rank alone") {
  const std::array all{how::as_is, how::to_a_tolerance, how::released};
  std::vector<std::string> of_processes;
  bool speaks = false;
  mpi::launch({}, [&](mpi::link& link) {
    speaks = link.rank() == 0;
    for (const how what : all) of_processes.push_back(digest_of<mpi>(link, what));
  });
  if (!speaks) return;
  serial::link alone;
  for (std::size_t k = 0; k < all.size(); ++k) {
    CAPTURE(k);
    CHECK(of_processes[k] == digest_of<serial>(alone, all[k]));
  }
}
