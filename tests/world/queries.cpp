// Queries while bodies move: on 1, 2 and 4 ranks, in periodic space, after a restart; their
// messages, filters and refusals.
// timeout: 300
// alone
#include <array>
#include <cstdio>
#include <limits>
#include <map>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/filters.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <tuple>

#include "../tutorial/ranks.hpp"
#include "query_check.hpp"

using namespace talus;
using tutorial::refused;

namespace {

using clump = union_of<sphere>;
using scene = scenario<bodies<sphere, box, clump, plane>, hard_contact<coulomb_friction>,
                       solver<coloured_gauss_seidel>,
                       decomposition<periodic<grid<dynamic, dynamic>, along::y>>,
                       features<contact_filters, checkpoints, orientation>>;
constexpr real endless = std::numeric_limits<real>::infinity();

template <class World>
void fill(World& w) {
  const auto stuff = w.material({.density = 1, .friction = 0.3});
  w.gravity({0, 0, -5});
  w.global([&](auto& all) {
    all.add(plane{{0, 0, 1}, 0}, stuff);
    all.add(plane{{1, 0, 0}, -4}, stuff);
    all.add(plane{{-1, 0, 0}, -4}, stuff);
    all.add(body<box>{.shape = {{0.5, 0.5, 9}}, .position = {3.5, 1, 0}, .material = stuff});
  });
  const clump two({{.shape = sphere{0.35}, .at = {{-0.2, 0, 0}, {1, 0, 0, 0}}},
                   {.shape = sphere{0.25}, .at = {{0.3, 0, 0}, {1, 0, 0, 0}}}});
  random_stream random(3);
  for (int k = 0; k < 105; ++k) {
    const vec3 at(-3.2 + 1.05 * (k % 6), -2.4 + 1.2 * (k / 6 % 5), 0.6 + 1.1 * (k / 30));
    const vec3 v = random.uniform(vec3(-4, -4, -2), vec3(4, 4, 2));
    const auto add = [&](const auto& shape) {
      const auto made = w.add_if_local(body<std::remove_cvref_t<decltype(shape)>>{
          .shape = shape, .position = at, .material = stuff, .velocity = v, .fixed = k == 62});
      if (made && k % 4 == 0) w[*made].template set<contact_groups>(1u << 5 | 1u);
    };
    if (k % 3 == 0)
      add(sphere{0.4});
    else if (k % 3 == 1)
      add(box{{0.7, 0.6, 0.5}});
    else
      add(two);
  }
}
template <class Program>
void on_ranks(int x, int y, Program&& program) {
  CAPTURE(x * y);
  threads::launch({.ranks = x * y}, [&](threads::link& link) {
    world<scene> w(link, {{.cells = {x, y}, .lower = {-4, -3}, .upper = {4, 3}}}, reach{1.2});
    fill(w);
    program(w);
  });
}

struct questions {
  std::vector<ray> rays;
  std::vector<shape_path> paths;
  std::vector<pose> poses;
  std::vector<vec3> points;

  explicit questions(int count) {
    generator random;
    for (int k = 0; k < count; ++k) {
      const vec3 from = random.point(vec3(4, k % 2 == 0 ? 3 : 10, 3)) + vec3(0, 0, 3);
      const vec3 d = random.direction();
      rays.push_back({.from = from, .direction = 3 * d, .length = 14});
      paths.push_back({.from = from, .direction = d, .length = 14, .orientation = random.turn()});
      poses.push_back({from, random.turn()});
      points.push_back(from);
    }
  }
};
constexpr int around = 6;  // periods that these questions may reach

/// The answers to all questions, in one list on all ranks. Those of each rank are compared with
/// brute force if `check`.
template <class World>
std::vector<query_hit> ask_all(World& w, const questions& q, bool check) {
  const box tool{{0.5, 0.3, 0.8}};
  const auto by_ray = [&](std::size_t k, const auto& s, const pose& at, const vec3& shift) {
    return detail::ray_meets(s, at, q.rays[k].from - shift, unit(q.rays[k].direction), 14);
  };
  const auto by_path = [&](std::size_t k, const auto& s, const pose& at, const vec3& shift) {
    return detail::shape_meets(tool, pose{q.paths[k].from - shift, q.paths[k].orientation}, s, at,
                               unit(q.paths[k].direction), 14);
  };
  std::vector<query_hit> mine;
  const auto take = [&](const auto& found, bool single, auto&& look) {
    for (std::size_t k = 0; k < q.rays.size(); ++k) {
      std::size_t n = 0;
      const bool here = is_mine(w, k, n);
      std::vector<query_hit> hits;
      if (here) {
        if constexpr (requires { found[n].id; }) {
          if (found[n]) hits.push_back(found[n]);
        } else {
          hits = found[n];
        }
        mine.insert(mine.end(), hits.begin(), hits.end());
      }
      if (!check) continue;
      // Global bodies are not repeated, but a way in the periodic box comes back to them: where all
      // their sides are along y, as those of the planes here, the two are the same.
      auto expected = by_brute_force(
          w, around,
          [&](const auto& s, const pose& at, const vec3& shift) { return look(k, s, at, shift); });
      const auto other = [](const query_hit& hit) { return hit.global && hit.kind == 1; };
      const bool posts = std::any_of(hits.begin(), hits.end(), other);
      expected.erase(std::remove_if(expected.begin(), expected.end(), other), expected.end());
      hits.erase(std::remove_if(hits.begin(), hits.end(), other), hits.end());
      if (single && posts) continue;
      if (single && expected.size() > 1) expected.resize(1);
      std::sort(hits.begin(), hits.end());
      CAPTURE(k);
      if (here) check_alike(hits, expected, 1e-9);
    }
  };
  take(cast_rays(w, share_of(w, q.rays)), true, by_ray);
  take(cast_rays_through(w, share_of(w, q.rays)), false, by_ray);
  take(cast_shape(w, tool, share_of(w, q.paths)), true, by_path);
  const auto nearest = nearest_bodies(w, share_of(w, q.points));
  const auto overlaps = find_overlaps(w, tool, share_of(w, q.poses));
  for (std::size_t k = 0; k < q.points.size(); ++k) {
    std::size_t n = 0;
    const bool here = is_mine(w, k, n);
    if (here) {
      REQUIRE(nearest[n]);
      mine.push_back(nearest[n]);
      mine.insert(mine.end(), overlaps[n].begin(), overlaps[n].end());
    }
    if (!check) continue;
    const vec3 home = w.periodic_space().wrapped(q.points[k]), moved = q.points[k] - home;
    const auto near = by_brute_force(w, 1, [&](const auto& s, const pose& at, const vec3& shift) {
      return detail::nearest_on_shape(s, at, home - shift, endless);
    });
    auto deep = by_brute_force(w, 1, [&](const auto& s, const pose& at, const vec3& shift) {
      return detail::overlap_probe<box>{tool}.meets(
          s, at, home - shift, detail::question{.turn = q.poses[k].orientation}, 0);
    });
    std::sort(deep.begin(), deep.end(), [](auto& x, auto& y) { return x.id < y.id; });
    if (!here) continue;
    CHECK(nearest[n].id == near[0].id);
    CHECK(nearest[n].distance == doctest::Approx(near[0].distance).epsilon(1e-9));
    CHECK(vec3(nearest[n].point - near[0].point - moved).norm() < 1e-9);
    REQUIRE(overlaps[n].size() == deep.size());
    for (std::size_t i = 0; i < deep.size(); ++i) {
      CHECK(overlaps[n][i].id == deep[i].id);
      CHECK(overlaps[n][i].distance == doctest::Approx(deep[i].distance).epsilon(1e-9));
    }
  }
  // In an order that does not depend on the ranks.
  auto all = gathered(w, mine, {});
  std::sort(all.begin(), all.end(), [](const query_hit& x, const query_hit& y) {
    return std::tie(x.distance, x.id, x.point[0], x.point[1], x.normal[0]) <
           std::tie(y.distance, y.id, y.point[0], y.point[1], y.normal[0]);
  });
  return all;
}

}  // namespace

TEST_CASE(
    "while bodies move, answers are those of brute force, and the same bits on any ranks and "
    "after a restart") {
  const std::string file = "queries.h5";
  std::vector<query_hit> first, later;
  for (const auto& [x, y] : {std::pair{1, 1}, {2, 1}, {2, 2}}) {
    on_ranks(x, y, [&](auto& w) {
      const questions q(40);
      const auto start = ask_all(w, q, true);  // before any step
      for (int k = 0; k < 60; ++k) w.step(0.005);
      const auto one = ask_all(w, q, true);
      (void)write_checkpoint(w, file);
      for (int k = 0; k < 60; ++k) {
        w.step(0.005);
        if (k % 20 == 0) CHECK_FALSE(ask_all(w, q, false).empty());  // changes nothing
      }
      const auto two = ask_all(w, q, false);
      if (w.rank() != 0) return;
      CHECK(one.size() > 100);
      CHECK_FALSE(start == one);
      if (w.ranks() > 1) {
        CHECK(one == first);
        CHECK(two == later);
      }
      first = one, later = two;
    });
  }
  for (const auto& [x, y] : {std::pair{2, 2}, {1, 2}, {1, 1}}) {
    on_ranks(x, y, [&](auto& w) {
      (void)read_checkpoint(w, file);
      const questions q(40);
      const auto one = ask_all(w, q, true);
      for (int k = 0; k < 60; ++k) w.step(0.005);
      const auto two = ask_all(w, q, false);
      if (w.rank() != 0) return;
      CHECK(one == first);
      CHECK(two == later);
    });
  }
  std::remove(file.c_str());
}

TEST_CASE("ten thousand rays cost one gathering and two messages between each two ranks") {
  on_ranks(2, 2, [](auto& w) {
    for (int k = 0; k < 10; ++k) w.step(0.005);
    const questions q(10000);
    const traffic before = w.link().counters();
    const auto hits = cast_rays(w, q.rays);
    const traffic sent = w.link().counters() - before;
    CHECK(sent.messages == 6);
    CHECK(sent.collectives == 1);
    CHECK(std::count_if(hits.begin(), hits.end(), [](const query_hit& h) { return bool(h); }) >
          5000);
    // The same questions from all ranks have the same answers.
    const auto same = gathered(w, hits, {});
    for (std::size_t k = 0; k + 4 <= same.size(); k += 4)
      REQUIRE(
          (!same[k] || (same[k].distance == same[k + 3].distance && same[k].id == same[k + 3].id)));
  });
}

TEST_CASE("a region, filters, and a body that a ray passes") {
  on_ranks(2, 2, [](auto& w) {
    for (int k = 0; k < 20; ++k) w.step(0.005);
    const box_region where{{-2, -1, 0}, {1, 2, 2}};
    std::vector<query_hit> own, of_global;
    std::array<std::uint64_t, 2> counted{};
    w.for_each_local([&](const auto& b) {
      if (!where.contains(b.position())) return;
      ++counted[0];
      counted[1] += (b.template get<contact_groups>() & 1u << 5) != 0;
    });
    w.link().reduce(reduction::sum, std::span<std::uint64_t>(counted));
    const auto found = bodies_within(w, where), few = bodies_within(w, where, {.groups = 1u << 5});
    CHECK(found.size() == counted[0]);
    CHECK(few.size() == counted[1]);
    CHECK(few.size() > 2);
    for (const query_hit& hit : found) CHECK(where.contains(hit.point));
    CHECK(bodies_within(w, box_region{{3, 0, -1}, {4, 2, 1}}, {.movable = false}).size() == 1);

    const questions q(200);
    const auto all = cast_rays_through(w, q.rays);
    const auto only = cast_rays(w, q.rays, {.groups = 1u << 5}),
               still = cast_rays(w, q.rays, {.movable = false}),
               loose = cast_rays(w, q.rays, {.fixed = false});
    auto passing = q.rays;
    for (std::size_t k = 0; k < passing.size(); ++k)
      if (!all[k].empty()) passing[k].except = all[k][0].id;
    const auto second = cast_rays(w, passing);
    std::map<system_id, bool> in_group;
    for (const query_hit& hit :
         bodies_within(w, box_region{{-9, -9, -9}, {9, 9, 9}}, {.groups = 1u << 5}))
      in_group[hit.id] = true;
    std::map<system_id, bool> stays;
    for (const query_hit& hit :
         bodies_within(w, box_region{{-9, -9, -9}, {9, 9, 9}}, {.movable = false}))
      stays[hit.id] = true;
    const auto fixed = [&](const query_hit& h) { return h.global || stays.count(h.id) > 0; };
    int grouped = 0;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const auto first_with = [&](auto&& test) {
        for (const query_hit& hit : all[k])
          if (test(hit)) return hit;
        return query_hit{};
      };
      CHECK(only[k] == first_with([&](const query_hit& h) { return in_group.count(h.id) > 0; }));
      CHECK(second[k] == first_with([&](const query_hit& h) { return h.id != passing[k].except; }));
      CHECK(still[k] == first_with(fixed));
      CHECK(loose[k] == first_with([&](const query_hit& h) { return !fixed(h); }));
      grouped += bool(only[k]);
    }
    CHECK(grouped > 10);
  });
}

TEST_CASE("what cannot be asked is refused on all ranks, with the numbers") {
  const real nan = std::numeric_limits<real>::quiet_NaN();
  const auto on_rank_1 = [](const ray& wrong) {
    return [wrong] {
      on_ranks(2, 1, [&](auto& w) {
        std::vector<ray> rays(3, ray{.length = 1});
        if (w.rank() == 1) rays[2] = wrong;
        (void)cast_rays(w, rays);
      });
    };
  };
  refused<std::invalid_argument>(
      on_rank_1({.from = {nan, 0, 0}, .length = 1}),
      "question 2 of rank 1 to cast_rays starts at (nan, 0, 0): give a finite place");
  refused<std::invalid_argument>(on_rank_1({.direction = {0, 0, 0}, .length = 1}),
                                 "question 2 of rank 1 to cast_rays has the direction (0, 0, 0): "
                                 "give one that is finite and not zero");
  refused<std::invalid_argument>(
      on_rank_1({.length = -1}),
      "question 2 of rank 1 to cast_rays has the length -1: give one of 0 or more");
  refused<std::invalid_argument>(
      on_rank_1({.direction = {0, 1, 0}}),
      "question 2 of rank 1 to cast_rays goes inf far in the direction (0, 1, 0), over more than "
      "1000000 periods of 6: give a .length, since a way in periodic space does not end");
  refused<std::runtime_error>(
      [] {
        on_ranks(2, 1, [](auto& w) {
          if (w.rank() == 0)
            (void)cast_rays(w, {});
          else
            (void)nearest_bodies(w, {});
        });
      },
      "rank 0 called cast_rays while rank 1 called nearest_bodies: all ranks call a query "
      "together, "
      "those without questions with an empty list");
  refused<std::runtime_error>(
      [] { on_ranks(2, 1, [](auto& w) { w.exclusive(0, [&] { (void)cast_rays(w, {}); }); }); },
      "cast_rays was called inside an exclusive section ...");
  refused<std::invalid_argument>(
      [] {
        on_ranks(1, 1, [](auto& w) {
          (void)find_overlaps(w, sphere{1}, std::array{pose{{0, 0, 0}, {2, 0, 0, 0}}});
        });
      },
      "question 0 of rank 0 to find_overlaps has an orientation of norm 2: give a unit quaternion");
  on_ranks(2, 1, [](auto& w) {
    CHECK_THROWS_AS((void)cast_shape(w, sphere{-1}, std::vector<shape_path>{}),
                    std::invalid_argument);
  });
}
