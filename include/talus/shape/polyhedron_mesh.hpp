#pragma once
// The surface of a convex polyhedron in the frame of its body: corners, flat faces, edges, and
// their connectivity. All bodies of that form share it.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/shared_data.hpp"

namespace talus {

struct polyhedron_mesh {
  /// An edge runs from `from` to `to` around `left`, and back around `right`.
  struct edge {
    std::uint32_t from, to, left, right;
  };
  struct measures {
    real volume = 0;
    real bounding_radius = 0;
    real half_width = 0;    ///< half the smallest distance of a face from the corner opposite
    real inner_radius = 0;  ///< of a ball about the centre of mass that is inside
    vec3 inertia{0, 0, 0};  ///< principal moments per unit mass
    pose frame;             ///< of the body, in the coordinates of the user
  };
  static constexpr std::size_t max_vertices = 1000000;
  static constexpr std::size_t max_corners = 64;  ///< of one face

  detail::plain_vector<vec3> vertices;
  detail::plain_vector<vec3> normals;  ///< of each face, outwards, unit length
  detail::plain_vector<real> offsets;  ///< of each face: n.x <= offset inside
  detail::plain_vector<std::uint32_t>
      face_begin;  ///< where the corners of a face begin; one more at the end
  detail::plain_vector<std::uint32_t> corners;       ///< counterclockwise as seen from outside
  detail::plain_vector<std::uint32_t> corner_edges;  ///< the edge from a corner to the next
  detail::plain_vector<edge> edges;
  detail::plain_vector<std::uint32_t> around_begin;  ///< where the faces around a vertex begin
  detail::plain_vector<std::uint32_t> around;
  measures measured;
  detail::content_id id;

  [[nodiscard]] std::size_t faces() const { return normals.size(); }
  [[nodiscard]] std::span<const std::uint32_t> face(std::size_t f) const {
    return std::span(corners).subspan(face_begin[f], face_begin[f + 1] - face_begin[f]);
  }
  [[nodiscard]] std::span<const std::uint32_t> edges_of_face(std::size_t f) const {
    return std::span(corner_edges).subspan(face_begin[f], face_begin[f + 1] - face_begin[f]);
  }
  [[nodiscard]] std::span<const std::uint32_t> faces_around(std::size_t vertex) const {
    return std::span(around).subspan(around_begin[vertex],
                                     around_begin[vertex + 1] - around_begin[vertex]);
  }
  /// Number of the vertex furthest along a direction, the first of equals.
  [[nodiscard]] std::size_t furthest(const vec3& direction) const {
    const real x = direction[0], y = direction[1], z = direction[2];
    std::size_t best = 0;
    real most = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const vec3& v = vertices[i];
      const real height = x * v[0] + y * v[1] + z * v[2];
      if (i == 0 || height > most) most = height, best = i;
    }
    return best;
  }

  /// Throws runtime_error for indices of vertices, faces or edges out of range, which a damaged
  /// file may contain.
  [[gnu::cold]] void require_sound() const {
    const auto parts = [](const auto& begin, std::size_t lists, std::size_t entries) {
      bool good = begin.size() == lists + 1 && begin[0] == 0 && begin[lists] == entries;
      for (std::size_t k = 0; good && k < lists; ++k) good = begin[k] < begin[k + 1];
      return good;
    };
    const auto below = [](const auto& numbers, std::size_t limit) {
      bool good = true;
      for (const std::uint32_t n : numbers) good = good && n < limit;
      return good;
    };
    bool good = vertices.size() >= 4 && vertices.size() <= max_vertices && faces() >= 4 &&
                offsets.size() == faces() && corner_edges.size() == corners.size() &&
                parts(face_begin, faces(), corners.size()) &&
                parts(around_begin, vertices.size(), around.size()) &&
                below(corners, vertices.size()) && below(corner_edges, edges.size()) &&
                below(around, faces());
    for (std::size_t f = 0; good && f < faces(); ++f)
      good = face(f).size() >= 3 && face(f).size() <= max_corners && detail::finite(normals[f]) &&
             std::isfinite(offsets[f]);
    for (const edge& e : edges)
      good = good && e.from < vertices.size() && e.to < vertices.size() && e.left < faces() &&
             e.right < faces();
    for (const vec3& v : vertices) good = good && detail::finite(v);
    const measures& m = measured;
    good = good && m.volume > 0 && m.bounding_radius > 0 && m.half_width > 0 &&
           m.inner_radius >= 0 && m.inertia.minCoeff() > 0 &&
           detail::finite(vec3(m.volume, m.bounding_radius, m.half_width)) &&
           std::isfinite(m.inner_radius) && detail::finite(m.inertia) &&
           detail::finite(m.frame.position) &&
           std::abs(m.frame.orientation.squaredNorm() - 1) < 1e-6;
    if (!good) throw std::runtime_error("is damaged: a convex_polyhedron makes no sense");
  }

  /// Packs it into a message and unpacks it. (Templates here and in the shapes: compiled only in
  /// programs that send bodies.)
  template <class Writer>
  void pack(Writer& out) const {
    const auto all = [&](const auto& values) { out.put(std::span(values)); };
    all(vertices), all(normals), all(offsets), all(face_begin), all(corners), all(corner_edges);
    all(edges), all(around_begin), all(around);
    out.put(measured.volume), out.put(measured.bounding_radius), out.put(measured.half_width);
    out.put(measured.inner_radius), out.put(measured.inertia), out.put(measured.frame.position);
    out.put(measured.frame.orientation), out.put(id);
  }
  template <class Reader>
  static polyhedron_mesh unpack(Reader& in) {
    polyhedron_mesh m;
    const auto all = [&](auto& values) {
      values =
          in.template get_all<typename std::remove_reference_t<decltype(values)>::value_type>();
    };
    all(m.vertices), all(m.normals), all(m.offsets), all(m.face_begin), all(m.corners);
    all(m.corner_edges), all(m.edges), all(m.around_begin), all(m.around);
    m.measured.volume = in.template get<real>();
    m.measured.bounding_radius = in.template get<real>();
    m.measured.half_width = in.template get<real>();
    m.measured.inner_radius = in.template get<real>();
    m.measured.inertia = in.template get<vec3>();
    m.measured.frame.position = in.template get<vec3>();
    m.measured.frame.orientation = in.template get<quat>();
    m.id = in.template get<detail::content_id>();
    m.require_sound();
    return m;
  }
};

/// The form of all points within `rounding` of a convex polyhedron (see convex_form.hpp).
struct mesh_form {
  static constexpr int order = 4;
  const polyhedron_mesh* mesh = nullptr;  ///< outlives the form
  real rounding = 0;                      ///< length
  [[nodiscard]] int corners() const {
    std::uint32_t most = 0;
    for (std::size_t f = 0; f < mesh->faces(); ++f)
      most = std::max(most, mesh->face_begin[f + 1] - mesh->face_begin[f]);
    return static_cast<int>(most);
  }
};

}  // namespace talus
