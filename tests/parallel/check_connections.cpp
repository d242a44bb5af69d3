#include "talus/parallel/check_connections.hpp"

#include <doctest/doctest.h>

#include "talus/parallel/by_hand.hpp"
#include "talus/parallel/grid.hpp"

using namespace talus;
using plane = half_space;

namespace {

using lists = std::vector<std::vector<connection>>;

lists pair(any_geometry of_1, any_geometry of_0) {
  return {{{1, std::move(of_1), 0}}, {{0, std::move(of_0), 0}}};
}

lists quadrants() {
  const plane left(-1, 0, 0, 0), right(1, 0, 0, 0), lower(0, -1, 0, 0), upper(0, 1, 0, 0);
  return {{{1, right, 0}, {2, upper, 0}, {3, intersect(right, upper), 0}},
          {{0, left, 0}, {2, intersect(left, upper), 0}, {3, upper, 0}},
          {{0, lower, 0}, {1, intersect(right, lower), 0}, {3, right, 0}},
          {{0, intersect(left, lower), 0}, {1, lower, 0}, {2, left, 0}}};
}

template <class Decomposition>
lists generated(const Decomposition& d, int ranks) {
  lists all;
  for (int r = 0; r < ranks; ++r) {
    const domain<Decomposition> mine(d, r, ranks);
    all.emplace_back(mine.connections().begin(), mine.connections().end());
  }
  return all;
}

const connection_flaw* find(const std::vector<connection_flaw>& flaws, flaw kind) {
  for (const auto& f : flaws)
    if (f.kind == kind) return &f;
  return nullptr;
}

/// There is a flaw of the kind, and its message has all the parts.
void finds(const std::vector<connection_flaw>& flaws, flaw kind,
           std::initializer_list<const char*> parts) {
  const connection_flaw* found = find(flaws, kind);
  for (const auto& f : flaws) INFO(f.message);
  REQUIRE(found);
  for (const char* part : parts) {
    INFO(found->message);
    CHECK(found->message.find(part) != std::string::npos);
  }
}

}  // namespace

TEST_CASE("consistent connections have no flaws") {
  CHECK(check_connections(pair(plane(1, 1, 0, -1.4), plane(-1, -1, 0, 1.4))).empty());
  CHECK(check_connections(pair(intersect(plane(1, 0, 0, 2), plane(0, 1, 0, 1)),
                               merge(plane(-1, 0, 0, -2), plane(0, -1, 0, -1))))
            .empty());
  CHECK(check_connections(quadrants()).empty());
  const grid<3, 3, 2> cells{.lower = {0, 0, 0}, .upper = {3, 1, 1}};
  CHECK(check_connections(generated(cells, 18), cells.resolve(18)).empty());
  CHECK(check_connections(lists(1)).empty());
}

TEST_CASE("a one-sided connection names both ranks, the plane and what to call") {
  const auto flaws = check_connections(lists{{{1, plane(1, 0, 0, 2), 0}}, {}});
  CHECK(flaws.size() == 1);
  finds(flaws, flaw::one_sided,
        {"rank 0 is connected to rank 1, but rank 1 is not connected to rank 0", "x >= 2",
         "(2, 0, 0)", "call connect(0, ...) on rank 1", "disconnect(1) on rank 0"});
  auto corner = quadrants();
  corner[3].erase(corner[3].begin());
  finds(check_connections(corner), flaw::one_sided, {"rank 0 is connected to rank 3"});
}

TEST_CASE("missing connections are found across faces and corners") {
  const auto none = check_connections(lists(2));
  CHECK(none.size() == 1);
  finds(none, flaw::missing,
        {"ranks 0 and 1 both own the point (", "call connect(1, ...) on rank 0"});

  auto corner = quadrants();
  corner[0].pop_back();
  corner[3].erase(corner[3].begin());
  const auto flaws = check_connections(corner);
  CHECK(flaws.size() == 1);
  finds(flaws, flaw::missing,
        {"ranks 0 and 3 meet at (", "call connect(3, ...) on rank 0", "connect(0, ...) on rank 3"});

  const grid<2, 2> cells;
  auto some = generated(cells, 4);
  some[1].pop_back();
  some[3].erase(some[3].begin() + 1);
  finds(check_connections(some, cells.resolve(4)), flaw::missing, {"ranks 1 and 3 are neighbours"});
}

TEST_CASE("planes that differ by 1e-9, or by one bit, are a mismatch") {
  const auto gap = check_connections(pair(plane(1, 0, 0, 2), plane(-1, 0, 0, -2 - 1e-9)));
  CHECK(gap.size() == 1);
  finds(gap, flaw::mismatch,
        {"ranks 0 and 1 draw their boundary differently", "rank 0 gives x >= 2,",
         "rank 1 gives -x >= -2.000000001", "1e-09 off", "none of the ranks owns the point (2",
         "all signs reversed"});
  CHECK(gap[0].point[0] == doctest::Approx(2));
  finds(check_connections(pair(plane(1, 0, 0, 2), plane(-1, 0, 0, -2 + 1e-9))), flaw::mismatch,
        {"both ranks own the point (2"});
  for (const real toward : {0.0, 10.0})
    finds(check_connections(
              pair(plane(1, 1, 0, -1.4), plane(-1, -1, 0, std::nextafter(1.4, toward)))),
          flaw::mismatch, {"draw their boundary differently"});
  finds(check_connections(pair(plane(1, 1, 0, 2), plane(-1, -1.000001, 0, -2))), flaw::mismatch,
        {"draw their boundary differently"});
  // One face of many, in the middle of a set that fits otherwise.
  auto all = quadrants();
  all[3][2].geometry = plane(-1, 0, 0, -1e-9);
  finds(check_connections(all), flaw::mismatch,
        {"rank 2 gives x >= 0", "rank 3 gives -x >= -1e-09"});
}

TEST_CASE("a normal with the wrong sign is called by its name") {
  finds(check_connections(pair(plane(1, 0, 0, 2), plane(1, 0, 0, 2))), flaw::mismatch,
        {"ranks 0 and 1 place each other on the same side", "x >= 2",
         "the normal points towards the remote rank", "the point (2, "});
}

TEST_CASE("gaps and overlaps name the ranks, both pictures and a point") {
  const auto gap = check_connections(pair(plane(1, 0, 0, 0), plane(-1, 0, 0, -1)));
  CHECK(gap.size() == 1);
  finds(gap, flaw::gap,
        {"no rank owns the point (", "rank 0 gives x >= 0 for rank 1",
         "rank 1 gives -x >= -1 for rank 0"});
  CHECK(gap[0].point[0] >= 0);
  CHECK(gap[0].point[0] <= 1);
  const auto overlap = check_connections(pair(plane(1, 0, 0, 1), plane(-1, 0, 0, 0)));
  CHECK(overlap.size() == 1);
  finds(overlap, flaw::overlap, {"ranks 0 and 1 both own the point (", "x >= 1", "-x >= 0"});
  // The displacement forgotten when the normal was reversed.
  CHECK(!check_connections(pair(plane(1, 1, 0, -1.4), plane(-1, -1, 0, -1.4))).empty());
}

TEST_CASE("a rank that takes a point for another rank's is told so") {
  auto all = quadrants();
  all[0][2].geometry = intersect(plane(1, 0, 0, 0), plane(0, 1, 0, 3));
  finds(check_connections(all), flaw::mismatch, {"belongs to rank 3", "in the eyes of rank 0"});

  const grid<2, 2> cells;
  auto moved = generated(cells, 4);
  moved[0][0].geometry = plane(1, 0, 0, 0.5);
  const auto flaws = check_connections(moved, cells.resolve(4));
  CHECK(flaws.size() == 1);
  finds(flaws, flaw::mismatch,
        {"belongs to rank 1", "in the eyes of rank 0", "lies outside of the region given for it",
         "x >= 0.5"});
}

TEST_CASE("large jobs are checked in part by every rank") {
  const grid<16, 16> cells{.lower = {0, 0}, .upper = {16, 16}};
  auto all = generated(cells, 256);
  const auto resolved = cells.resolve(256);
  CHECK(check_connections(all, resolved, {.samples = 20}).empty());
  std::erase_if(all[100], [](const connection& c) { return c.rank == 101; });
  CHECK(check_connections(all, resolved, {.first = 0, .last = 50}).empty());
  finds(check_connections(all, resolved, {.first = 101, .last = 102}), flaw::one_sided,
        {"rank 101 is connected to rank 100, but"});
}

TEST_CASE("the check of a job throws the same message on every rank") {
  std::vector<domain<by_hand>> domains;
  for (int r = 0; r < 3; ++r) domains.emplace_back(by_hand{}, r, 3);
  domains[0].connect(1, 1, 0, 0, 0);
  domains[1].connect(0, -1, 0, 0, 0), domains[1].connect(2, 1, 0, 0, 1);
  domains[2].connect(1, -1, 0, 0, -1);
  // Simulates all ranks in turn: the first gather of each returns everybody's first buffer, and so
  // on.
  const auto play = [&] {
    std::vector<std::string> messages;
    std::vector<detail::byte_buffer> first(3), second(3);
    for (int pass = 0; pass < 3; ++pass) {
      messages.clear();
      for (int r = 0; r < 3; ++r) {
        int call = 0;
        const auto gather = [&](const detail::byte_buffer& mine) {
          auto& buffers = call++ == 0 ? first : second;
          buffers[r] = mine;
          if (pass == 0 && &buffers == &first && r < 2)
            return std::vector<detail::byte_buffer>(3, detail::byte_buffer(sizeof(std::size_t)));
          return buffers;
        };
        try {
          check_connections(domains[r], gather);
          messages.emplace_back();
        } catch (const std::runtime_error& e) {
          messages.emplace_back(e.what());
        }
      }
    }
    return messages;
  };
  CHECK(play() == std::vector<std::string>(3));
  domains[1].disconnect(2);
  const auto messages = play();
  CHECK(messages[0] == messages[1]);
  CHECK(messages[1] == messages[2]);
  CHECK(messages[0].find("do not fit together") != std::string::npos);
  CHECK(messages[0].find("rank 2 is connected to rank 1, but") != std::string::npos);
}
