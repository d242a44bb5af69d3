#include "talus/parallel/domain.hpp"

#include "decomposition_laws.hpp"
#include "talus/parallel/by_hand.hpp"
#include "talus/parallel/grid.hpp"

using namespace talus;
using doctest::Contains;
using hand = domain<by_hand>;

namespace {

std::vector<hand> ranks(int n) {
  std::vector<hand> domains;
  for (int r = 0; r < n; ++r) domains.emplace_back(by_hand{}, r, n);
  return domains;
}

/// Exactly one rank owns every point, and every rank computes the same owner (all are connected to
/// all).
std::size_t share_out(const std::vector<hand>& domains, std::size_t points, bool exact = true) {
  std::vector<half_space> planes;
  std::vector<std::vector<connection>> lists;
  for (const hand& d : domains) {
    lists.emplace_back(d.connections().begin(), d.connections().end());
    for (const connection& c : d.connections())
      for (const half_space& h : c.geometry.planes()) planes.push_back(h);
  }
  laws::hard_points source(planes, 4711);
  {
    laws::tally one("exactly one rank owns a point");
    laws::tally agree("all ranks agree on the owner");
    for (std::size_t i = 0; i < points; ++i) {
      const vec3 p = exact ? source.next() : source.anywhere();
      int claims = 0, owner = -1;
      for (const hand& d : domains)
        if (d.contains(p)) ++claims, owner = d.rank();
      one.expect(claims == 1, [&] { return fmt::format("{}: {}", claims, laws::show(p)); });
      for (const hand& d : domains)
        agree.expect(d.owner(p) == owner, [&] {
          return fmt::format("{} belongs to {}, rank {} says {}", laws::show(p), owner, d.rank(),
                             d.owner(p));
        });
    }
  }
  const auto flaws = check_connections(lists);
  INFO((flaws.empty() ? std::string() : flaws[0].message));
  CHECK(flaws.empty());
  return points;
}

}  // namespace

TEST_CASE("one plane between two ranks, in all five forms (Listings 6 and 7)") {
  const real d = std::sqrt(2.0);
  auto domains = ranks(2);
  const auto reconnect = [&](auto first, auto second) {
    for (auto& domain : domains)
      if (!domain.connections().empty()) domain.disconnect(1 - domain.rank());
    first(domains[0]), second(domains[1]);
    return domains[0].connections()[0].geometry;
  };
  const any_geometry listing6 = reconnect([&](auto& r) { r.connect(1, vec3(1.0, 1.0, 0.0), -d); },
                                          [&](auto& r) { r.connect(0, vec3(-1.0, -1.0, 0.0), d); });
  share_out(domains, 200'000);
  CHECK(domains[0].contains({-1.1, -1.0, 7}));
  CHECK(domains[1].contains({-0.9, -1.0, 7}));
  CHECK(domains[1].connections()[0].geometry == complement(listing6));

  CHECK(listing6 == reconnect([&](auto& r) { r.connect(1, 1, 1, 0, -d); },
                              [&](auto& r) { r.connect(0, -1, -1, 0, d); }));
  CHECK(listing6 == reconnect(
                        [&](auto& r) {
                          r.connect(1, half_space({1.0, 1.0, 0.0}, -d));
                        },
                        [&](auto& r) {
                          r.connect(0, half_space({-1.0, -1.0, 0.0}, d));
                        }));
  reconnect([&](auto& r) { r.connect(1, 3, 7, -2, 0.1, 0.2, 0.3); },
            [&](auto& r) { r.connect(0, -3, -7, 2, 0.1, 0.2, 0.3); });
  share_out(domains, 100'000);
  reconnect([&](auto& r) { r.connect(1, vec3(3, 7, -2), vec3(0.1, 0.2, 0.3), 0.5); },
            [&](auto& r) { r.connect(0, vec3(-3, -7, 2), vec3(0.1, 0.2, 0.3), 0.5); });
  share_out(domains, 100'000);
  CHECK(domains[0].connections()[0].overlap == 0.5);
  CHECK(domains[0].connections()[0].distance({0.1, 0.2, 0.3}) == doctest::Approx(-0.5));
}

TEST_CASE("a quarter space against its complement (Listing 8)") {
  auto domains = ranks(2);
  domains[0].connect(1, intersect(half_space(1.0, 0.0, 0.0, 2.0), half_space(0.0, 1.0, 0.0, 1.0)));
  domains[1].connect(0, merge(half_space(-1.0, 0.0, 0.0, -2.0), half_space(0.0, -1.0, 0.0, -1.0)));
  share_out(domains, 300'000);
  CHECK(domains[1].contains({2, 1, 0}));
  CHECK(domains[0].contains({2, 0, 0}));
}

TEST_CASE("four quadrants whose half-spaces overlap (Listing 19)") {
  const half_space left(-1, 0, 0, 0), right(1, 0, 0, 0), lower(0, -1, 0, 0), upper(0, 1, 0, 0);
  auto domains = ranks(4);
  domains[0].connect(1, right), domains[0].connect(2, upper);
  domains[0].connect(3, intersect(right, upper));
  domains[1].connect(0, left), domains[1].connect(2, intersect(left, upper));
  domains[1].connect(3, upper);
  domains[2].connect(0, lower), domains[2].connect(1, intersect(right, lower));
  domains[2].connect(3, right);
  domains[3].connect(0, intersect(left, lower)), domains[3].connect(1, lower);
  domains[3].connect(2, left);
  share_out(domains, 600'000);

  // The same ownership as the grid, on the boundaries too.
  const grid_cells cells = grid<2, 2>{}.resolve(4);
  laws::hard_points source({left, lower}, 5);
  laws::tally same("quadrants by hand own what the cells of grid<2, 2> own");
  for (int i = 0; i < 100'000; ++i) {
    const vec3 p = source.next();
    same.expect(domains[cells.owner(p)].contains(p), [&] { return laws::show(p); });
  }
}

TEST_CASE("eight octants and three sectors") {
  auto octants = ranks(8);
  for (int r = 0; r < 8; ++r)
    for (int s = 0; s < 8; ++s) {
      if (r == s) continue;
      std::vector<half_space> planes;
      for (int axis = 0; axis < 3; ++axis)
        if ((r ^ s) >> axis & 1)
          planes.push_back({s >> axis & 1 ? vec3(vec3::Unit(axis)) : vec3(-vec3::Unit(axis)), 0.0});
      octants[r].connect(s, any_geometry::cell(planes));
    }
  share_out(octants, 300'000);

  // Oblique planes that meet in a line: their numbers do not decide about the line itself.
  auto sectors = ranks(3);
  const auto boundary = [](int i) {  // between sector i - 1 and sector i
    const real angle = 2 * pi / 3 * i + 0.2;
    return half_space(-std::sin(angle), std::cos(angle), 0, 0);
  };
  for (int r = 0; r < 3; ++r)
    for (int s = 0; s < 3; ++s)
      if (r != s) sectors[r].connect(s, intersect(boundary(s), complement(boundary((s + 1) % 3))));
  share_out(sectors, 300'000, false);
}

TEST_CASE("a domain without connections, and the only rank of a job, own all of space") {
  CHECK(hand(by_hand{}, 2, 4).contains({1, 2, 3}));
  CHECK(hand(by_hand{}, 2, 4).owner({1, 2, 3}) == 2);
  const domain<grid<2, 2>> alone({}, 0, 1);
  CHECK(alone.connections().empty());
  CHECK(alone.contains({1, 2, 3}));
  CHECK(alone.owner({-1, 2, 3}) == 0);
  CHECK(alone.interior_distance({0, 0, 0}) == std::numeric_limits<real>::infinity());
  CHECK_THROWS_AS((domain<grid<3>>({}, 0, 1)), std::invalid_argument);
}

TEST_CASE("connections come in order of rank, can be found and removed") {
  auto domain = ranks(4)[1];
  domain.connect(3, 1, 0, 0, 0), domain.connect(0, -1, 0, 0, 0), domain.connect(2, 0, 1, 0, 0);
  CHECK(domain.connections()[0].rank == 0);
  CHECK(domain.connections()[2].rank == 3);
  CHECK(domain.find(2)->geometry == half_space(0, 1, 0, 0));
  domain.disconnect(2);
  CHECK(domain.find(2) == nullptr);
  CHECK(domain.connections().size() == 2);
  domain.connect(2, 0, 1, 0, 5);
  CHECK(domain.find(2)->geometry == half_space(0, 1, 0, 5));
}

TEST_CASE("points of ranks that a rank is not connected to have no owner that it knows") {
  const domain<grid<3>> first({.lower = {0}, .upper = {3}}, 0, 3);
  CHECK(first.owner({0, 0, 0}) == 0);
  CHECK(first.owner({1, 0, 0}) == 1);
  CHECK(first.owner({2, 0, 0}) == -1);
  CHECK(domain<grid<3>>({.lower = {0}, .upper = {3}}, 0, 3, 1.0).owner({2, 0, 0}) == 2);
}

TEST_CASE("regions within a distance are found, widened ones too") {
  domain<grid<3>> middle({.lower = {0}, .upper = {3}}, 1, 3);
  const auto within = [&](real x, real radius) {
    std::vector<int> found;
    middle.for_each_within({x, 0, 0}, radius,
                           [&](std::size_t i) { found.push_back(middle.connections()[i].rank); });
    return found;
  };
  CHECK(within(1.5, 0.4).empty());
  CHECK(within(1.5, 0.5) == std::vector<int>{0, 2});
  CHECK(within(1.2, 0.3) == std::vector<int>{0});
  CHECK(middle.interior_distance({1.2, 0, 0}) == doctest::Approx(0.2));
  const any_geometry geometry = middle.find(2)->geometry;
  middle.disconnect(2);
  middle.connect(2, geometry, 0.6);
  CHECK(within(1.5, 0.4) == std::vector<int>{2});
  CHECK(middle.interior_distance({1.2, 0, 0}) == doctest::Approx(0.2));
  CHECK(middle.interior_distance({1.5, 0, 0}) == doctest::Approx(-0.1));
}

TEST_CASE("wrong connections are refused with both ranks") {
  auto domain = ranks(3)[1];
  const auto refuses = [&](auto action, const char* text) {
    CHECK_THROWS_WITH_AS(action(), Contains(text), std::invalid_argument);
  };
  domain.connect(0, 1, 0, 0, 0);
  refuses([&] { domain.connect(3, 1, 0, 0, 0); },
          "rank 1 cannot connect to rank 3: this job has 3");
  refuses([&] { domain.connect(-1, 1, 0, 0, 0); }, "rank 1 cannot connect to rank -1");
  refuses([&] { domain.connect(1, 1, 0, 0, 0); }, "rank 1 cannot connect to itself");
  refuses([&] { domain.connect(0, 1, 0, 0, 0); }, "rank 1 is connected to rank 0 already");
  refuses([&] { domain.connect(2, 0, 0, 0, 0); }, "normal (0, 0, 0)");
  refuses([&] { domain.connect(2, 1, 0, 0, 0, -0.1); },
          "overlap dx of the connection from rank 1 to rank 2");
  refuses([&] { domain.connect(2, 1, 0, 0, 0, std::nan("")); }, "but is nan");
  refuses([&] { domain.connect(2, vec3(1, 0, 0), std::nan("")); }, "finite displacement");
  refuses([&] { domain.disconnect(2); }, "rank 1 is not connected to rank 2");
  refuses([&] { hand(by_hand{}, 3, 3); }, "there is no rank 3 in a job of 3");
  refuses([&] { talus::domain<grid<2, 2>>({}, 0, 3); }, "exactly 4 ranks, but there are 3");
}
