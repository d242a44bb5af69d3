#pragma once
// Triangles of a surface, their connectivity, and a tree of bounding boxes that finds those near a
// body. All bodies of that form share it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/shared_data.hpp"
#include "talus/shape/nearest_on_triangle.hpp"

namespace talus::detail {

/// Vertices are about the centre of their box.
struct triangle_tree {
  using corners = std::array<std::uint32_t, 3>;
  static constexpr std::uint32_t none = ~std::uint32_t{0};

  /// A node holds the triangles order[first, first + count), or, where count is 0, the two nodes
  /// after it: its own successor, and `first`.
  struct node {
    vec3 lower{0, 0, 0}, upper{0, 0, 0};
    std::uint32_t first = 0, count = 0;
  };

  plain_vector<vec3> vertices;
  plain_vector<corners> triangles;
  plain_vector<vec3> normals;        ///< of each triangle, by the order of its corners, unit length
  plain_vector<corners> neighbours;  ///< beyond the edge from corner k to the next, or none
  plain_vector<std::uint32_t> around_begin, around;  ///< vertices joined to a vertex by an edge
  plain_vector<std::uint32_t> first_of;              ///< lowest triangle that has the vertex
  plain_vector<char> frayed;  ///< whether a vertex has edges without a unique neighbour
  plain_vector<std::uint32_t> order;
  plain_vector<node> nodes;
  real bounding_radius = 0, area = 0;
  vec3 half{0, 0, 0};  ///< of the box around all
  bool sharp = false;  ///< whether two triangles meet at less than a right angle
  content_id id;

  [[nodiscard]] const vec3& corner(std::uint32_t triangle, std::size_t k) const {
    return vertices[triangles[triangle][k]];
  }

  [[nodiscard]] static bool boxes_overlap(const vec3& low, const vec3& high, const vec3& lower,
                                          const vec3& upper) {
    return low[0] <= upper[0] && low[1] <= upper[1] && low[2] <= upper[2] && high[0] >= lower[0] &&
           high[1] >= lower[1] && high[2] >= lower[2];
  }
  /// Whether the box around triangle t overlaps this one.
  [[nodiscard]] bool overlaps(std::uint32_t t, const vec3& lower, const vec3& upper) const {
    const vec3 &a = corner(t, 0), &b = corner(t, 1), &c = corner(t, 2);
    return boxes_overlap(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), lower, upper);
  }
  /// Calls f(number) for the triangles whose boxes overlap this one, in an order that depends on
  /// the mesh alone.
  template <class F>
  void each_within(const vec3& lower, const vec3& upper, F&& f) const {
    std::array<std::uint32_t, 64> waiting;  // halving 2^32 triangles goes 32 levels deep
    std::size_t size = 0;
    waiting[size++] = 0;
    while (size > 0) {
      const std::uint32_t at = waiting[--size];
      const node& n = nodes[at];
      if (!boxes_overlap(n.lower, n.upper, lower, upper)) continue;
      if (n.count == 0) {
        waiting[size++] = n.first;
        waiting[size++] = at + 1;
        continue;
      }
      for (std::uint32_t k = n.first; k < n.first + n.count; ++k) {
        const std::uint32_t t = order[k];
        if (overlaps(t, lower, upper)) f(t);
      }
    }
  }

  /// From valid vertices and triangles.
  [[nodiscard]] static triangle_tree build(plain_vector<vec3> points, plain_vector<corners> faces) {
    triangle_tree m;
    m.vertices = std::move(points);
    m.triangles = std::move(faces);
    m.measure();
    m.connect();
    m.order.resize(m.triangles.size());
    std::iota(m.order.begin(), m.order.end(), 0u);
    m.divide(0, static_cast<std::uint32_t>(m.order.size()));
    m.find_sharp_edges();
    byte_buffer bytes;
    byte_writer out(bytes);
    out.put(std::span<const vec3>(m.vertices)), out.put(std::span<const corners>(m.triangles));
    m.id = id_of_content(bytes);
    return m;
  }

  void pack(byte_writer& out) const {
    out.put(std::span<const vec3>(vertices)), out.put(std::span<const corners>(triangles));
  }
  /// Throws runtime_error for invalid numbers, which a damaged file may contain.
  static triangle_tree unpack(byte_reader& in) {
    auto points = in.get_all<vec3>();
    auto faces = in.get_all<corners>();
    bool good = !faces.empty();
    for (const vec3& p : points) good = good && p.allFinite();
    for (const corners& c : faces)
      for (const std::uint32_t k : c) good = good && k < points.size();
    for (std::size_t t = 0; good && t < faces.size(); ++t)
      good = twice_area(points[faces[t][0]], points[faces[t][1]], points[faces[t][2]]).norm() > 0;
    if (!good) throw std::runtime_error("is damaged: a triangle_mesh makes no sense");
    return build(std::move(points), std::move(faces));
  }

  [[nodiscard]] static vec3 twice_area(const vec3& a, const vec3& b, const vec3& c) {
    return (b - a).cross(c - a);
  }

 private:
  void measure() {
    vec3 upper = vertices[0], lower = upper;
    for (const vec3& v : vertices) {
      bounding_radius = std::max(bounding_radius, v.norm());
      lower = lower.cwiseMin(v), upper = upper.cwiseMax(v);
    }
    half = upper.cwiseMax(-lower);
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      const vec3 twice = twice_area(corner(t, 0), corner(t, 1), corner(t, 2));
      area += real(0.5) * twice.norm();
      normals.push_back(twice.normalized());
    }
  }

  using edge = std::pair<std::uint32_t, std::uint32_t>;
  /// From an edge into triangle t, across the edge; unit length.
  [[nodiscard]] vec3 into(std::uint32_t t, const edge& e) const {
    const vec3 along = (vertices[e.second] - vertices[e.first]).normalized();
    const vec3 way = (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3 - vertices[e.first];
    return (way - along.dot(way) * along).normalized();
  }

  void connect() {
    std::map<edge, plain_vector<std::uint32_t>> users;
    first_of.assign(vertices.size(), none);
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
        users[{std::min(a, b), std::max(a, b)}].push_back(t);
        first_of[a] = std::min(first_of[a], t);
      }
    neighbours.resize(triangles.size());
    frayed.assign(vertices.size(), 0);
    std::vector<plain_vector<std::uint32_t>> joined(vertices.size());
    for (auto& [e, list] : users) {
      // A triangle that lies on another one, as two that divide a square otherwise, ends with it.
      if (list.size() == 2 && (into(list[0], e) - into(list[1], e)).norm() <= real(1e-6))
        list.clear();
      if (list.size() != 2) frayed[e.first] = frayed[e.second] = 1;
      joined[e.first].push_back(e.second);
      joined[e.second].push_back(e.first);
    }
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
        const auto& list = users.at({std::min(a, b), std::max(a, b)});
        // (An edge of three triangles has no unique neighbour.)
        neighbours[t][k] = list.size() != 2 ? none : list[0] == t ? list[1] : list[0];
      }
    for (const auto& list : joined) {
      around_begin.push_back(static_cast<std::uint32_t>(around.size()));
      for (const std::uint32_t v : list) around.push_back(v);
    }
    around_begin.push_back(static_cast<std::uint32_t>(around.size()));
  }

  void find_sharp_edges() {
    const real near = real(1e-7) * bounding_radius;
    for (std::uint32_t t = 0; t < triangles.size() && !sharp; ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const vec3 middle = real(0.5) * (corner(t, k) + corner(t, (k + 1) % 3));
        const edge e(triangles[t][k], triangles[t][(k + 1) % 3]);
        const auto meet = [&](std::uint32_t other) {
          sharp = sharp || into(t, e).dot(into(other, e)) > real(1e-6);
        };
        if (neighbours[t][k] != none) {
          meet(neighbours[t][k]);
          continue;
        }
        const vec3 reach(near, near, near);
        each_within(middle - reach, middle + reach, [&](std::uint32_t other) {
          const vec3 p =
              nearest_on_triangle(middle, corner(other, 0), corner(other, 1), corner(other, 2)).at;
          if (other != t && (p - middle).norm() <= near) meet(other);
        });
      }
  }

  /// Appends the node of order[from, to) and all below it: halves along the longest side.
  void divide(std::uint32_t from, std::uint32_t to) {
    constexpr std::uint32_t few = 4;
    const auto at = nodes.size();
    nodes.push_back({});
    constexpr real infinity = std::numeric_limits<real>::infinity();
    vec3 lower(infinity, infinity, infinity), upper = -lower;
    for (std::uint32_t k = from; k < to; ++k)
      for (std::size_t c = 0; c < 3; ++c) {
        const vec3& v = corner(order[k], c);
        lower = lower.cwiseMin(v), upper = upper.cwiseMax(v);
      }
    nodes[at].lower = lower, nodes[at].upper = upper;
    if (to - from <= few) {
      nodes[at].first = from, nodes[at].count = to - from;
      return;
    }
    int axis = 0;
    (upper - lower).maxCoeff(&axis);
    const auto middle = from + (to - from) / 2;
    const auto place = [&](std::uint32_t t) {
      return corner(t, 0)[axis] + corner(t, 1)[axis] + corner(t, 2)[axis];
    };
    std::nth_element(order.begin() + from, order.begin() + middle, order.begin() + to,
                     [&](std::uint32_t a, std::uint32_t b) {
                       const real x = place(a), y = place(b);
                       return x != y ? x < y : a < b;
                     });
    divide(from, middle);
    nodes[at].first = static_cast<std::uint32_t>(nodes.size());
    divide(middle, to);
  }
};

}  // namespace talus::detail
