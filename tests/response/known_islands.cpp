// The islands that parts of several ranks form, as far as a rank knows these.
#include <doctest/doctest.h>

#include <talus/solver/direct/known_islands.hpp>

using namespace talus;
using namespace talus::detail;

namespace {

constexpr std::uint64_t spheres = 1000;
constexpr system_id plate{5000};

/// A part of one sphere that touches the plate.
island_part sphere_part(std::uint64_t k) {
  island_part part;
  part.name = system_id{k};
  part.figures.contacts = 1, part.figures.bodies = 1;
  part.ties.push_back({part.name, plate});
  return part;
}
/// The plate of another rank, on the first `touched` spheres.
island_part plate_part(std::uint64_t touched) {
  island_part part;
  part.name = plate;
  part.figures.contacts = static_cast<std::uint32_t>(touched), part.figures.bodies = 1;
  for (std::uint64_t k = 0; k < touched; ++k) part.ties.push_back({plate, system_id{k}});
  return part;
}

}  // namespace

TEST_CASE("all parts of an island have one record of it, which is found once") {
  known_islands known;
  known.clear({});
  for (std::uint64_t k = 0; k < spheres; ++k) known.enter(sphere_part(k));
  CHECK(!known.island_of(system_id{3}).whole);
  CHECK(known.island_of(system_id{3}).names.size() == 1);
  known.enter(plate_part(spheres));
  const known_islands::island& one = known.island_of(system_id{3});
  CHECK(one.whole);
  CHECK(one.names.size() == spheres + 1);
  CHECK(one.names.front() == system_id{0});
  CHECK(one.names.back() == plate);
  CHECK(one.all.contacts == 2 * spheres);
  CHECK(one.all.bodies == spheres + 1);
  for (std::uint64_t k = 0; k < spheres; ++k) CHECK(&known.island_of(system_id{k}) == &one);
}

TEST_CASE("islands are whole on a line if all of their parts have travelled along it") {
  known_islands known;
  known.clear({});
  known.enter(sphere_part(0)), known.enter(sphere_part(1)), known.enter(plate_part(2));
  sorted_ids sent;
  CHECK(known.are_whole(sent));
  sent.insert(plate), sent.insert(system_id{0});
  CHECK(!known.are_whole(sent));
  sent.insert(system_id{1});
  CHECK(known.are_whole(sent));
}
