#pragma once
// Triangles as files hold them, with corners of their own, to triangles that share corners and
// edges: corners that differ by round-off are merged, triangles without an area or given twice are
// dropped, and an edge on which further corners lie is divided there.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/shape/triangle_tree.hpp"

namespace talus {

/// What was found in the triangles of a surface. Places are in the coordinates of the triangles.
struct surface_report {
  std::size_t merged = 0;        ///< corners at some distance from that which they were merged with
  std::size_t without_area = 0;  ///< triangles dropped because corners coincide or lie in a line
  std::size_t doubled = 0;       ///< triangles dropped because others have the same corners
  std::size_t levelled = 0;      ///< corners moved into the plane of the triangles around them
  std::vector<vec3> joined;  ///< corners on an edge of another triangle, which was divided there
  /// The middle of each edge that one triangle alone has: the rim of the surface, or a hole.
  std::vector<vec3> open_edges;
  std::vector<vec3> shared_edges;  ///< likewise of three triangles or more

  /// One line, with the first place of each kind.
  [[nodiscard]] std::string text() const {
    const auto places = [](const char* what, const std::vector<vec3>& all) {
      std::string line = std::to_string(all.size()) + " " + what;
      return all.empty() ? line : line + " (the first at " + detail::text(all[0]) + ")";
    };
    return std::to_string(merged) + " corners merged, " + std::to_string(without_area) +
           " triangles without an area and " + std::to_string(doubled) + " given twice dropped, " +
           std::to_string(levelled) + " corners moved into the plane around them, " +
           places("corners on an edge joined", joined) + ", " + places("open edges", open_edges) +
           ", " + places("edges of three triangles or more", shared_edges);
  }
};

namespace detail {

/// Corners nearer to each other than this part of the radius of the surface are one: some times the
/// round-off of numbers in single precision.
inline constexpr real weld_part = 1e-6;

/// Whether the corners of a triangle coincide or lie in a line, but for a part of its longest edge.
/// Files have such triangles at any place: they must not determine the size of the surface.
[[nodiscard]] inline bool is_line(const vec3& a, const vec3& b, const vec3& c) {
  const real longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  return longest == 0 ||
         triangle_tree::twice_area(a, b, c).norm() / longest <= real(0.5) * weld_part * longest;
}

class triangle_welder {
  using corners = triangle_tree::corners;
  using edge = std::pair<std::uint32_t, std::uint32_t>;

 public:
  /// A welder of triangles around the origin, within a positive radius.
  triangle_welder(real radius, surface_report& report)
      : near_(weld_part * radius), cell_(16 * near_), report_(report) {}

  /// A triangle of finite corners.
  void add(const std::array<vec3, 3>& t) {
    keep({number_of(t[0]), number_of(t[1]), number_of(t[2])});
  }
  void finish() {
    drop_doubled();
    divide_edges();
    drop_unused();
    for (const auto& [e, users] : users_of_edges())
      if (users.size() != 2)
        (users.size() == 1 ? report_.open_edges : report_.shared_edges)
            .push_back(real(0.5) * (points[e.first] + points[e.second]));
  }

  plain_vector<vec3> points;
  plain_vector<corners> faces;

 private:
  using cell = std::array<std::int64_t, 3>;
  struct hash {
    std::size_t operator()(const cell& c) const {
      std::uint64_t h = 0;
      for (const std::int64_t k : c)
        h = (h ^ static_cast<std::uint64_t>(k)) * 0x9e3779b97f4a7c15ull, h ^= h >> 29;
      return h;
    }
  };
  [[nodiscard]] cell cell_at(const vec3& p) const {
    cell c;
    for (int k = 0; k < 3; ++k)
      c[static_cast<std::size_t>(k)] = static_cast<std::int64_t>(std::floor(p[k] / cell_));
    return c;
  }
  /// The nearest of the points so far that is near enough, or a new one.
  std::uint32_t number_of(const vec3& p) {
    const vec3 reach(near_, near_, near_);
    const cell low = cell_at(p - reach), high = cell_at(p + reach);
    std::uint32_t best = triangle_tree::none;
    real least = near_ * near_;
    for (cell c = low; c[0] <= high[0]; ++c[0])
      for (c[1] = low[1]; c[1] <= high[1]; ++c[1])
        for (c[2] = low[2]; c[2] <= high[2]; ++c[2])
          if (const auto in = cells_.find(c); in != cells_.end())
            for (const std::uint32_t k : in->second)
              if (const real square = (points[k] - p).squaredNorm(); square <= least)
                if (best == triangle_tree::none || square < least) best = k, least = square;
    if (best != triangle_tree::none) {
      report_.merged += least > 0;
      return best;
    }
    best = static_cast<std::uint32_t>(points.size());
    points.push_back(p);
    cells_[cell_at(p)].push_back(best);
    return best;
  }
  /// Whether its height is above the tolerance.
  [[nodiscard]] bool has_area(const corners& f) const {
    const vec3 &a = points[f[0]], &b = points[f[1]], &c = points[f[2]];
    const real longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    return triangle_tree::twice_area(a, b, c).norm() > near_ * longest;
  }
  void keep(const corners& face) {
    if (has_area(face))
      faces.push_back(face);
    else
      ++report_.without_area;
  }
  void drop_doubled() {
    std::map<corners, std::uint32_t> known;
    std::size_t kept = 0;
    for (const corners& f : faces) {
      corners sorted = f;
      std::sort(sorted.begin(), sorted.end());
      if (known.try_emplace(sorted, 0).second)
        faces[kept++] = f;
      else
        ++report_.doubled;
    }
    faces.resize(kept);
  }
  [[nodiscard]] std::map<edge, plain_vector<std::uint32_t>> users_of_edges() const {
    std::map<edge, plain_vector<std::uint32_t>> users;
    for (std::uint32_t t = 0; t < faces.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = faces[t][k], b = faces[t][(k + 1) % 3];
        users[{std::min(a, b), std::max(a, b)}].push_back(t);
      }
    return users;
  }
  /// A triangle with the corners on each of its edges, from corner k to the next.
  struct part {
    corners face;
    std::array<plain_vector<std::uint32_t>, 3> on;
  };
  /// Divides the triangles of open edges on which other corners of open edges lie.
  void divide_edges() {
    std::map<edge, plain_vector<std::uint32_t>> on_edge;
    plain_vector<std::uint32_t> ends;
    for (const auto& [e, users] : users_of_edges())
      if (users.size() == 1) on_edge[e], ends.push_back(e.first), ends.push_back(e.second);
    if (on_edge.empty()) return;
    std::sort(ends.begin(), ends.end());
    ends.resize(static_cast<std::size_t>(std::unique(ends.begin(), ends.end()) - ends.begin()));
    std::array<plain_vector<std::uint32_t>, 3> along;  // the same by each coordinate
    for (int axis = 0; axis < 3; ++axis) {
      auto& list = along[static_cast<std::size_t>(axis)] = ends;
      std::sort(list.begin(), list.end(), [&](std::uint32_t a, std::uint32_t b) {
        const real x = points[a][axis], y = points[b][axis];
        return x != y ? x < y : a < b;
      });
    }
    bool any = false;
    for (auto& [e, list] : on_edge) {
      find_on_edge(e, along, list);
      any = any || !list.empty();
      for (const std::uint32_t v : list) report_.joined.push_back(points[v]);
    }
    if (!any) return;
    std::vector<part> waiting;
    const plain_vector<corners> given = std::move(faces);
    faces.clear();
    for (const corners& f : given) {
      waiting.push_back({f, {}});
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = f[k], b = f[(k + 1) % 3];
        const auto at = on_edge.find({std::min(a, b), std::max(a, b)});
        if (at == on_edge.end()) continue;
        auto& on = waiting.back().on[k] = at->second;
        if (b < a) std::reverse(on.begin(), on.end());
      }
      while (!waiting.empty()) {
        const part p = std::move(waiting.back());
        waiting.pop_back();
        if (!divide(p, waiting)) keep(p.face);
      }
    }
  }
  void find_on_edge(const edge& e, const std::array<plain_vector<std::uint32_t>, 3>& along,
                    plain_vector<std::uint32_t>& found) const {
    const vec3 &a = points[e.first], &b = points[e.second];
    const std::uint32_t *first = nullptr, *last = nullptr;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& list = along[static_cast<std::size_t>(axis)];
      const real low = std::min(a[axis], b[axis]) - near_,
                 high = std::max(a[axis], b[axis]) + near_;
      const auto* const from =
          std::lower_bound(list.begin(), list.end(), low,
                           [&](std::uint32_t v, real x) { return points[v][axis] < x; });
      const auto* const to = std::upper_bound(
          from, list.end(), high, [&](real x, std::uint32_t v) { return x < points[v][axis]; });
      if (first == nullptr || to - from < last - first) first = from, last = to;
    }
    const real length = (b - a).norm();
    const vec3 way = (b - a) / length;
    plain_vector<plain_pair<real, std::uint32_t>> places;
    for (; first != last; ++first) {
      const vec3 d = points[*first] - a;
      const real x = way.dot(d);
      if (x > near_ && x < length - near_ && (d - x * way).norm() <= near_)
        places.push_back({x, *first});
    }
    std::sort(places.begin(), places.end(),
              [](const auto& p, const auto& q) { return p.first < q.first; });
    for (const auto& p : places) found.push_back(p.second);
  }
  /// Puts the two parts of a triangle with a corner on one of its edges on the list. The edge
  /// between them is not divided again, so that this ends whatever lies there.
  static bool divide(const part& p, std::vector<part>& waiting) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = p.face[k], b = p.face[(k + 1) % 3], c = p.face[(k + 2) % 3];
      const auto& on = p.on[k];
      if (on.empty()) continue;
      // (Both triangles of an edge divide it in the same order.)
      const std::size_t middle = a < b ? on.size() / 2 : on.size() - 1 - on.size() / 2;
      const std::uint32_t v = on[middle];
      if (v == c) continue;
      part left{{a, v, c}, {}}, right{{v, b, c}, {}};
      left.on[2] = p.on[(k + 2) % 3], right.on[1] = p.on[(k + 1) % 3];
      for (std::size_t n = 0; n < on.size(); ++n)
        if (n != middle) (n < middle ? left : right).on[0].push_back(on[n]);
      waiting.push_back(std::move(right)), waiting.push_back(std::move(left));
      return true;
    }
    return false;
  }
  /// Removes the corners of dropped triangles.
  void drop_unused() {
    plain_vector<std::uint32_t> now(points.size(), triangle_tree::none);
    std::uint32_t count = 0;
    for (const corners& f : faces)
      for (const std::uint32_t v : f) now[v] = 0;
    for (std::size_t v = 0; v < points.size(); ++v)
      if (now[v] == 0) points[count] = points[v], now[v] = count++;
    points.resize(count);
    for (corners& f : faces)
      for (std::uint32_t& v : f) v = now[v];
  }

  real near_, cell_;
  surface_report& report_;
  std::unordered_map<cell, plain_vector<std::uint32_t>, hash> cells_;
};

}  // namespace detail
}  // namespace talus
