// Contacts of capsules, cylinders, polyhedra and unions: symmetries, planes, rest, degenerate
// positions, and a box given as a polyhedron.
#include <doctest/doctest.h>

#include "solids.hpp"

using namespace solids;

namespace {

convex_polyhedron block(const vec3& size) {
  std::vector<vec3> corners;
  for (unsigned c = 0; c < 8; ++c)
    corners.push_back(size.cwiseProduct(vec3((c & 1u) - 0.5, (c >> 1 & 1u) - 0.5, (c >> 2) - 0.5)));
  return convex_polyhedron(corners);
}
/// With edges of 1, standing on its face z = 0.
convex_polyhedron tetrahedron() {
  const real h = std::sqrt(2 / 3.), r = 1 / std::sqrt(3.);
  return convex_polyhedron({{r, 0, 0}, {-r / 2, 0.5, 0}, {-r / 2, -0.5, 0}, {0, 0, h}});
}
template <class Shape>
solid at(const Shape& s, const vec3& p, const quat& q = {1, 0, 0, 0}) {
  return {s, {p, q}};
}
const quat lying = rotation({0, 1, 0}, pi / 2);  // z to x

void check_near(const vec3& a, const vec3& b, real tolerance) {
  INFO("vector " << a[0] << " " << a[1] << " " << a[2]);
  INFO("wanted " << b[0] << " " << b[1] << " " << b[2]);
  CHECK((a - b).norm() <= tolerance);
}

}  // namespace

TEST_CASE("a pair of shapes has the same contacts in either order and wherever both are moved") {
  int same = 0, total = 0;
  for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
    generator random{std::mt19937_64(seed)};
    const solid a{random_shape(seed % 5, random), {random.point(1), random.turn()}};
    const solid b{random_shape(seed / 5 % 5, random), {random.point(1), random.turn()}};
    INFO("seed " << seed << ", " << a.name() << " and " << b.name());
    const real margin = 0.2;
    const contacts found = find(a, b, margin);
    const contacts again = find(a, b, margin);
    const contacts swapped = find(b, a, margin);
    CHECK(swapped.empty() == found.empty());
    REQUIRE(again.size() == found.size());
    if (found.empty()) continue;
    for (std::size_t k = 0; k < found.size(); ++k) {
      CHECK(again[k].point == found[k].point);
      CHECK(again[k].normal == found[k].normal);
      CHECK(again[k].gap == found[k].gap);
      CHECK(again[k].feature == found[k].feature);
    }
    if (seed % 5 != seed / 5 % 5) {
      REQUIRE(swapped.size() == found.size());
      for (std::size_t k = 0; k < found.size(); ++k) {
        CHECK(swapped[k].point == found[k].point);
        CHECK(swapped[k].normal == -found[k].normal);
        CHECK(swapped[k].gap == found[k].gap);
        CHECK(swapped[k].feature == found[k].feature);
      }
    } else {
      const real gap = smallest_gap(found), smallest = std::min(a.smallest(), b.smallest());
      CHECK(std::abs(smallest_gap(swapped) - gap) <= 0.011 * smallest + 0.11 * std::abs(gap));
    }

    ++total;
    const pose by{random.point(5), random.turn()};
    const contacts moved = find(a.moved(by), b.moved(by), margin);
    if (feature_ids(moved) != feature_ids(found)) continue;  // another of equally good choices
    ++same;
    for (std::size_t k = 0; k < found.size(); ++k) {
      CHECK(std::abs(moved[k].gap - found[k].gap) < 1e-7);
      // An iteration finds deep overlaps of curved surfaces.
      const real deep = std::max(real(0), -found[k].gap) / std::min(a.smallest(), b.smallest());
      check_near(moved[k].normal, by.orientation * found[k].normal, 5e-5 + 2e-3 * deep);
      if (found.size() > 1 || a.name() == "sphere" || b.name() == "sphere")
        check_near(moved[k].point, by.to_world(found[k].point), 1e-5);
    }
  }
  MESSAGE(total, " pairs that touch, ", same, " with the same features after a motion");
  CHECK(total > 2000);
  CHECK(same > 0.99 * total);
}

TEST_CASE("a shape on a plane: its lowest point is a contact, and no more than 16 are") {
  for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    solid a{random_shape(2 + seed % 3, random), {random.point(1), random.turn()}};
    if (seed % 2 == 0) a.at.orientation = rotation(random.direction(), random(0, 2e-3));
    if (seed % 4 == 0) a.at.orientation = a.at.orientation * lying;
    const plane floor{seed % 2 == 0 ? vec3(0, 0, 2) : random.point(1), random(-1, 1)};
    const vec3 up = floor.unit_normal();
    a.at.position += (random(-0.1, 0.12) - floor.distance(a.support(-up))) * up;
    const real lowest = floor.distance(a.support(-up)), margin = 0.1;
    contacts found;
    std::visit(
        [&](const auto& s) {
          collide_pair(s, a.at, floor, pose{}, margin,
                       [&](const contact_geometry& c) { found.push_back(c); });
        },
        a.shape);
    INFO(a.name());
    CHECK(found.empty() == (lowest > margin));
    if (found.empty()) continue;
    CHECK(found.size() <= (a.name() == "capsule" ? 2u : 16u));
    CHECK(feature_ids(found).size() == found.size());
    // A cylinder counts as upright within 1e-4.
    CHECK(std::abs(smallest_gap(found) - lowest) < (a.name() == "cylinder"  ? 3e-5
                                                    : a.name() == "capsule" ? 1e-12
                                                                            : 1e-4 * a.smallest()));
    for (const contact_geometry& c : found) {
      CHECK(c.normal == up);
      CHECK(c.gap <= margin);
      CHECK(floor.distance(c.point) == doctest::Approx(c.gap / 2).scale(1));
      const bool ball =
          a.name() == "capsule";  // the lowest points of its ends may lie inside if tilted
      CHECK(a.outside(c.point + 0.5 * c.gap * up) <= 1e-12);
      if (!ball) CHECK(a.outside(c.point + 0.5 * c.gap * up) >= -1e-12);
    }
  }
}

TEST_CASE("bodies lying and standing on a plane have the contacts that carry them") {
  const auto on_floor = [](const solid& a) {
    contacts found;
    std::visit(
        [&](const auto& s) {
          collide_pair(plane{}, pose{}, s, a.at, 0.01,
                       [&](const contact_geometry& c) { found.push_back(c); });
        },
        a.shape);
    for (const contact_geometry& c : found) CHECK(c.gap == doctest::Approx(-0.001));
    return found.size();
  };
  CHECK(on_floor(at(cylinder{0.5, 2}, {0, 0, 0.999})) == 16);
  CHECK(on_floor(at(cylinder{0.5, 2}, {0, 0, 0.499}, lying)) == 2);
  CHECK(on_floor(at(capsule{0.5, 2}, {0, 0, 0.499}, lying)) == 2);
  CHECK(on_floor(at(capsule{0.5, 2}, {0, 0, 1.499})) == 1);
  CHECK(on_floor(at(block({1, 2, 3}), {0, 0, 1.499})) == 4);
  const auto t = tetrahedron();
  const pose p = placed(t, {{0, 0, -0.001}});
  CHECK(on_floor({t, p}) == 3);
}

TEST_CASE("a resting body keeps its normal and its features while it trembles") {
  const real c = 0.5;
  const struct {
    const char* name;
    solid below, above;
    unsigned points;
  } scenes[] = {
      {"block on block", at(block({1, 1, 1}), {0, 0, 0}), at(block({1, 1, 1}), {0, 0, 1}), 4},
      {"block on box", at(box{}, {0, 0, 0}), at(block({1, 1, 1}), {0.2, 0.1, 1}), 4},
      {"block across block", at(block({4, 2, 1}), {0, 0, 0}),
       at(block({4, 2, 1}), {0.3, 0.2, 1}, rotation({0, 0, 1}, 1)), 6},
      {"standing cylinder on box", at(box{{3, 3, 1}}, {0, 0, 0}), at(cylinder{c, 1}, {0, 0, 1}),
       16},
      {"standing cylinder at the edge of a block", at(block({3, 3, 1}), {0, 0, 0}),
       at(cylinder{c, 1}, {1.3, 0, 1}), 13},
      {"box on standing cylinder", at(cylinder{c, 1}, {0, 0, 0}), at(box{}, {0.1, 0, 1}), 15},
      {"cylinder on cylinder", at(cylinder{c, 1}, {0, 0, 0}), at(cylinder{0.4, 1}, {0.1, 0, 1}),
       16},
      {"lying cylinder on box", at(box{{3, 3, 1}}, {0, 0, 0}),
       at(cylinder{c, 2}, {0.2, 0, 1}, lying), 2},
      {"lying cylinder on block, longer than it", at(block({1, 1, 1}), {0, 0, 0}),
       at(cylinder{c, 3}, {0.2, 0, 1}, lying), 2},
      {"lying capsule on box", at(box{{3, 3, 1}}, {0, 0, 0}), at(capsule{c, 2}, {0.2, 0, 1}, lying),
       2},
      {"lying capsule on block", at(block({3, 3, 1}), {0, 0, 0}),
       at(capsule{c, 2}, {0.2, 0, 1}, lying), 2},
      {"lying capsule on capsule", at(capsule{c, 2}, {0, 0, 0}, lying),
       at(capsule{c, 1}, {0.2, 0, 1}, lying), 2},
      {"lying cylinder on cylinder", at(cylinder{c, 2}, {0, 0, 0}, lying),
       at(cylinder{c, 2}, {0.2, 0.6, 0.8}, lying), 2},
      {"lying capsule on cylinder", at(cylinder{c, 2}, {0, 0, 0}, lying),
       at(capsule{c, 2}, {0.2, 0.6, 0.8}, lying), 2},
      {"capsule along the edge of a box", at(box{{3, 1, 1}}, {0, 0, 0}),
       at(capsule{0.3, 2}, {0.2, 0.5 + 0.18, 0.5 + 0.24}, lying), 2},
      {"cylinder along the edge of a block", at(block({3, 1, 1}), {0, 0, 0}),
       at(cylinder{0.3, 2}, {0.2, 0.5 + 0.18, 0.5 + 0.24}, lying), 2},
  };
  for (const auto& scene : scenes)
    for (const bool swap : {false, true}) {
      INFO("scene '" << std::string(scene.name) << "', swapped " << swap << ", seed 9");
      generator random{std::mt19937_64(9)};
      const real overlap = 1e-4;
      solid above = scene.above;
      const contacts first = find(scene.below, above, 0.02);
      REQUIRE(!first.empty());
      CHECK(std::abs(smallest_gap(first)) < 1e-12);
      above.at.position += overlap * deepest(first).normal;
      const contacts still = swap ? find(above, scene.below, 0.02) : find(scene.below, above, 0.02);
      CHECK(still.size() == scene.points);
      int kept = 0;
      for (int k = 0; k < 300; ++k) {
        solid now = above;
        now.at.position += random.point(3e-5);
        now.at.orientation = rotation(random.direction(), random(0, 3e-5)) * now.at.orientation;
        const contacts found = swap ? find(now, scene.below, 0.02) : find(scene.below, now, 0.02);
        kept += feature_ids(found) == feature_ids(still);
        CHECK((deepest(found).normal - deepest(still).normal).norm() < 3e-4);
      }
      CHECK(kept == 300);
    }
}

TEST_CASE("degenerate places give finite contacts with unit normals") {
  const std::vector<any_shape> shapes{
      sphere{0.5},      box{},         capsule{0.5, 1},   cylinder{0.5, 1},
      block({1, 1, 1}), tetrahedron(), box{{1, 1, 0.01}}, cylinder{0.5, 0.01},
      capsule{0.01, 1}};
  const std::vector<quat> turns{quat::Identity(),
                                lying,
                                rotation({1, 0, 0}, pi / 4),
                                rotation({0, 0, 1}, pi / 4),
                                rotation({0, 0, 1}, 1e-9),
                                rotation({1, 1, 0}, 1e-6),
                                rotation({1, 1, 1}, 2 * pi / 3),
                                rotation({1, -1, 0}, std::acos(std::sqrt(1 / 3.)))};
  std::vector<vec3> places;
  for (const real x : {0., 0.5, 1., 1e-200, 1e-12})
    for (const real y : {0., 0.5, 1.})
      for (const real z : {0., 0.5, std::sqrt(0.5), 1., 1 + 1e-9, 1 - 1e-9})
        places.push_back({x, y, z});
  int touching = 0;
  for (const auto& s : shapes)
    for (const auto& t : shapes)
      for (const quat& q : turns)
        for (const vec3& p : places) {
          const solid a{s, {{0, 0, 0}, q}}, b{t, {p, quat::Identity()}};
          const contacts found = find(a, b, 0.1);
          INFO(a.name() << " and " << b.name() << " at " << p[0] << " " << p[1] << " " << p[2]);
          bool good = found.size() <= 16;
          // (If two boxes meet only in a corner or an edge, points may coincide.)
          if (a.name() != "box" || b.name() != "box")
            good = good && feature_ids(found).size() == found.size();
          for (const contact_geometry& c : found)
            good = good && detail::finite(c.normal) && detail::finite(c.point) &&
                   std::abs(c.normal.norm() - 1) < 1e-9 && c.gap <= 0.1;
          CHECK(good);
          touching += !found.empty();
        }
  CHECK(touching > 20000);
}

// (Both keep a corner that lies outside of a side by less than a thousandth of the smallest extent:
// if the two differ about such a corner, it is slightly off.)
TEST_CASE("a box given as a polyhedron meets a box as a box does") {
  int faces = 0, points = 0, off = 0;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const auto size = [&] { return vec3{random(0.3, 2), random(0.3, 2), random(0.3, 2)}; };
    const box one{size()}, other{size()};
    const pose pa{random.point(1), random.turn()};
    pose pb{random.point(1), random.turn()};
    if (seed % 2 == 0) pb.orientation = pa.orientation * rotation(random.direction(), 0.02);
    const auto mesh = block(one.size);
    CHECK(mesh.volume() == doctest::Approx(one.volume()));
    const solid a{one, pa}, b{other, pb}, as_mesh{mesh, placed(mesh, pa)};
    const contacts exact = find(a, b, 0.1), found = find(as_mesh, b, 0.1);
    CHECK(exact.empty() == found.empty());
    if (exact.empty() || found.empty()) continue;
    const real gap = smallest_gap(exact), smallest = std::min(a.smallest(), b.smallest());
    CHECK(std::abs(smallest_gap(found) - gap) <= 0.011 * smallest + 0.11 * std::abs(gap));
    if (exact.size() != found.size() || (exact[0].normal - found[0].normal).norm() > 1e-6) continue;
    faces += exact.size() == 4;
    for (const contact_geometry& c : found) {
      real nearest = 1e9;
      for (const contact_geometry& e : exact)
        nearest = std::min(nearest, (c.point - e.point).norm());
      if (exact.size() == 4) continue;
      CHECK(nearest < 1e-2 * smallest);
      ++points, off += nearest > 1e-6;
    }
  }
  CHECK(points > 500);
  CHECK(off <= points / 500);
  MESSAGE(faces, " patches of four points with the same normal");
  CHECK(faces > 200);
}

TEST_CASE("a union has the contacts of its parts, which its features name") {
  using parts = union_of<sphere, box, capsule>;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    std::vector<parts::part> list;
    for (int n = 0; n < 5; ++n) {
      const pose where{random.point(1), random.turn()};
      if (n % 3 == 0) list.push_back({.shape = sphere{random(0.2, 0.6)}, .at = where});
      if (n % 3 == 1) list.push_back({.shape = box{{0.5, 0.4, 0.3}}, .at = where});
      if (n % 3 == 2) list.push_back({.shape = capsule{0.2, 0.7}, .at = where});
    }
    const parts u(list);
    const pose given{random.point(2), random.turn()}, pu = placed(u, given);
    const solid other{random_shape(seed % 5, random), {random.point(2), random.turn()}};
    const parts v(std::vector<parts::part>(list.begin() + 1, list.end()));
    const pose given_v{random.point(2), random.turn()}, pv = placed(v, given_v);
    check_near(given_frame(u, pu).position, given.position, 1e-12);

    const auto same = [&](const contact_geometry& a, const contact_geometry& b) {
      check_near(a.normal, b.normal, 1e-4);
      CHECK(std::abs(a.gap - b.gap) < 1e-7);
    };
    const auto part_at = [&](const parts::part& p, const pose& frame) {
      return detail::combined(frame, p.at);
    };
    // With another shape, with a plane, and with another union.
    contacts found, wanted, plane_found, plane_wanted, both, both_wanted;
    const plane floor{random.point(1), random(-1, 1)};
    const auto into = [](contacts& list) {
      return [&list](const contact_geometry& c) { list.push_back(c); };
    };
    const auto part_into = [](contacts& list, std::uint64_t bits) {
      return [&list, bits](contact_geometry c) {
        c.feature |= bits;
        list.push_back(c);
      };
    };
    std::visit([&](const auto& s) { collide_pair(u, pu, s, other.at, 0.1, into(found)); },
               other.shape);
    collide_pair(floor, pose{}, u, pu, 0.1, into(plane_found));
    collide_pair(u, pu, v, pv, 0.1, into(both));
    for (std::uint64_t n = 0; n < list.size(); ++n)
      std::visit(
          [&](const auto& s) {
            const pose here = part_at(list[n], given);
            std::visit(
                [&](const auto& t) {
                  collide_pair(s, here, t, other.at, 0.1, part_into(wanted, n << 32));
                },
                other.shape);
            collide_pair(floor, pose{}, s, here, 0.1, part_into(plane_wanted, n << 32));
            for (std::uint64_t m = 1; m < list.size(); ++m)
              std::visit(
                  [&](const auto& t) {
                    collide_pair(s, here, t, part_at(list[m], given_v), 0.1,
                                 part_into(both_wanted, n << 32 | (m - 1) << 48));
                  },
                  list[m].shape);
          },
          list[n].shape);
    const auto compare = [&](const contacts& a, const contacts& b) {
      CHECK(feature_ids(a).size() == a.size());
      CHECK(feature_ids(a) == feature_ids(b));
      for (const contact_geometry& c : a)
        for (const contact_geometry& d : b)
          if (c.feature == d.feature) same(c, d);
    };
    compare(found, wanted);
    compare(plane_found, plane_wanted);
    compare(both, both_wanted);
  }
}
