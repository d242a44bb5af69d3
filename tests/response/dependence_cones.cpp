// Each rank gets the contacts on which its own depend within a sweep by colours, from any number of
// ranks, and no others.
#include <doctest/doctest.h>

#include <random>
#include <set>
#include <talus/solver/dependence_cones.hpp>
#include <vector>

using namespace talus::detail;

namespace {

struct contact {
  std::int32_t a, b;
  std::uint32_t colour;

  friend bool operator<(const contact& x, const contact& y) {
    return std::tie(x.a, x.b) < std::tie(y.a, y.b);
  }
};
using contacts = std::set<contact>;

/// Contacts of `bodies` bodies in the order of their places, between bodies that are near each
/// other; some contacts have one body that moves. No two of a body have the same colour.
contacts some_contacts(std::int32_t bodies, std::uint32_t seed) {
  std::mt19937 random(seed);
  contacts all;
  std::vector<std::set<std::uint32_t>> taken(static_cast<std::size_t>(bodies));
  for (int k = 0; k < 3 * bodies; ++k) {
    const auto a = static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(bodies));
    const auto b = a + 1 + static_cast<std::int32_t>(random() % 6);
    const std::int32_t other = b < bodies ? b : -1;
    std::uint32_t colour = random() % 3;
    const auto is_taken = [&](std::int32_t i) {
      return i >= 0 && taken[static_cast<std::size_t>(i)].contains(colour);
    };
    if (all.contains({a, other, 0})) continue;
    while (is_taken(a) || is_taken(other)) ++colour;
    for (const std::int32_t i : {a, other})
      if (i >= 0) taken[static_cast<std::size_t>(i)].insert(colour);
    all.insert({a, other, colour});
  }
  return all;
}

bool touches(const contact& c, std::int32_t body) { return c.a == body || c.b == body; }

/// What the contacts of a rank depend on within a sweep, its own contacts left out.
template <class Owner>
contacts cone_of(const contacts& all, int rank, Owner&& owner) {
  const auto own = [&](const contact& c) {
    return owner(c.a) == rank || (c.b >= 0 && owner(c.b) == rank);
  };
  contacts cone, next;
  for (const contact& c : all)
    if (own(c)) next.insert(c);
  while (!next.empty()) {
    const contact c = *next.begin();
    next.erase(next.begin());
    if (!own(c)) cone.insert(c);
    for (const std::int32_t body : {c.a, c.b})
      for (const contact& d : all)
        if (body >= 0 && owner(body) != rank && touches(d, body) && d.colour < c.colour &&
            !own(d) && !cone.contains(d))
          next.insert(d);
  }
  return cone;
}

/// Rounds of messages among ranks of which all are connected.
struct team {
  std::vector<dependence_cones> ranks;
  std::vector<contacts> received;
  int rounds = 0;

  template <class Owner>
  team(const contacts& all, std::int32_t bodies, int size, Owner&& owner)
      : ranks(static_cast<std::size_t>(size)), received(ranks.size()) {
    for (int r = 0; r < size; ++r) {
      dependence_cones& cones = ranks[static_cast<std::size_t>(r)];
      cones.start(r, static_cast<std::size_t>(bodies), ranks.size() - 1);
      for (std::int32_t i = 0; i < bodies; ++i) cones.set_owner(i, owner(i));
      for (int n = 0, other = 0; other < size; ++other) {
        if (other == r) continue;
        cones.lines[static_cast<std::size_t>(n)].rank = other;
        cones.lines[static_cast<std::size_t>(n++)].open = true;
      }
      for (const contact& c : all) {
        const bool owns_a = owner(c.a) == r, owns_b = c.b >= 0 && owner(c.b) == r;
        if (owns_a || owns_b)
          cones.add({owns_a ? c.a : c.b, owns_a ? c.b : c.a, 0, 0, 0, 1}, c.colour);
      }
    }
    for (bool more = true; more; ++rounds) {
      for (auto& cones : ranks) cones.find(rounds == 0);
      for (auto& from : ranks)
        for (auto& l : from.lines)
          if (l.open) send(from, l);
      more = false;
      std::vector<std::vector<char>> open(ranks.size());
      for (std::size_t r = 0; r < ranks.size(); ++r)
        for (auto& l : ranks[r].lines)
          open[r].push_back(l.more || line_to(l.rank, static_cast<int>(r)).more);
      for (std::size_t r = 0; r < ranks.size(); ++r)
        for (std::size_t n = 0; n < open[r].size(); ++n)
          ranks[r].lines[n].open = open[r][n], more = more || open[r][n];
      REQUIRE(rounds < 50);
    }
  }
  dependence_cones::line& line_to(int from, int to) {
    for (auto& l : ranks[static_cast<std::size_t>(from)].lines)
      if (l.rank == to) return l;
    throw std::logic_error("no such line");
  }
  void send(const dependence_cones& from, const dependence_cones::line& l) {
    dependence_cones& to = ranks[static_cast<std::size_t>(l.rank)];
    for (const auto& level : l.levels) to.raise_known(l.sent[level.body], level.level);
    for (const auto& p : l.units) {
      const known_unit& u = from.unit(p);
      if (to.received(u.a, p.colour)) continue;
      to.note_received(u.a, p.colour);
      if (u.b >= 0) to.note_received(u.b, p.colour);
      arriving.push_back({&to, u, p.colour});
      const bool swapped = u.b >= 0 && u.b < u.a;
      received[static_cast<std::size_t>(l.rank)].insert(
          {swapped ? u.b : u.a, swapped ? u.a : u.b, p.colour});
    }
    deliver();
  }
  struct arrival {
    dependence_cones* to;
    known_unit unit;
    std::uint32_t colour;
  };
  std::vector<arrival> arriving;
  void deliver() {
    for (const arrival& one : arriving) one.to->add(one.unit, one.colour);
    arriving.clear();
  }
};

template <class Owner>
int rounds_of(std::int32_t bodies, int size, std::uint32_t seed, Owner&& owner) {
  const contacts all = some_contacts(bodies, seed);
  const team t(all, bodies, size, owner);
  for (int r = 0; r < size; ++r) {
    const contacts expected = cone_of(all, r, owner),
                   &found = t.received[static_cast<std::size_t>(r)];
    CAPTURE(r);
    CHECK(found.size() == expected.size());
    for (const contact& c : expected) CHECK(found.contains(c));
  }
  return t.rounds;
}

}  // namespace

TEST_CASE("two ranks send each other the contacts of their cones in one message each") {
  for (std::uint32_t seed = 1; seed < 9; ++seed)
    CHECK(rounds_of(80, 2, seed, [](std::int32_t body) { return body < 40 ? 0 : 1; }) == 1);
}

TEST_CASE("where three and five ranks meet, contacts of third ranks travel in further rounds") {
  int most = 0;
  for (std::uint32_t seed = 1; seed < 9; ++seed) {
    most = std::max(most, rounds_of(60, 3, seed, [](std::int32_t body) { return body / 20; }));
    most = std::max(most, rounds_of(60, 5, seed, [](std::int32_t body) { return body / 3 % 5; }));
  }
  CHECK(most > 1);
}
