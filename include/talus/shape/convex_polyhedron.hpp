#pragma once
// The convex hull of points: wedges of an arch, grains, any convex body with flat faces. Bodies of
// one form share its surface: a copy of the shape costs a reference.
#include <memory>
#include <span>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/shape/chord.hpp"
#include "talus/shape/detail/build_mesh.hpp"
#include "talus/shape/polyhedron_mesh.hpp"

namespace talus {

/// Made from points in any frame; the hull, its volume, centre of mass and inertia are computed
/// once. The frame of the body has its origin at the centre of mass and its axes along the
/// principal axes: `frame()` gives it in the coordinates of the points, and `placed(shape, pose)`
/// of shape/frame.hpp gives the pose of a body whose points lie at the given coordinates.
class convex_polyhedron {
 public:
  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "convex_polyhedron";

  /// An empty value, to be assigned to.
  convex_polyhedron() = default;
  /// The hull of the points. Points inside it, or within half a millionth of the extent of a face
  /// plane or an edge, do not become vertices. Throws invalid_argument for points that span no
  /// volume, are not finite, have an extent below 1e-100 or above 1e100, or make more than
  /// 1,000,000 vertices or a face of more than 64 corners.
  template <class Real = real>
  explicit convex_polyhedron(const std::vector<vector3<Real>>& points)
      : mesh_(std::make_shared<const polyhedron_mesh>(
            detail::build_mesh<Real>({points.data(), points.data() + points.size()}))) {}

  /// Throws invalid_argument if there are no vertices.
  void validate() const {
    if (mesh_ == nullptr)
      detail::fail<std::invalid_argument>(
          "a convex_polyhedron without vertices is no body: make it from at least four points");
  }

  [[nodiscard]] const polyhedron_mesh& mesh() const { return *mesh_; }
  /// The form of the shape, with its faces and edges, for the general contact search.
  [[nodiscard]] mesh_form form() const { return {mesh_.get()}; }
  /// The frame of the body in the coordinates of the points.
  [[nodiscard]] const pose& frame() const { return mesh_->measured.frame; }
  /// Corners of the hull in the frame of the body.
  [[nodiscard]] std::span<const vec3> vertices() const { return mesh_->vertices; }

  /// Distance of its furthest point from the centre.
  [[nodiscard]] real bounding_radius() const { return mesh_->measured.bounding_radius; }
  /// Volume.
  [[nodiscard]] real volume() const { return mesh_->measured.volume; }
  /// Principal moments per unit mass.
  [[nodiscard]] const vec3& inertia() const { return mesh_->measured.inertia; }
  /// Vertex furthest along `direction`; of equals, the first.
  [[nodiscard]] vec3 support(const vec3& direction) const {
    return mesh_->vertices[mesh_->furthest(direction)];
  }
  /// Distance of the furthest point from the point p.
  [[nodiscard]] real reach_from(const vec3& p) const {
    real square = 0;
    for (const vec3& v : mesh_->vertices) {
      const real x = v[0] - p[0], y = v[1] - p[1], z = v[2] - p[2];
      square = std::max(square, x * x + y * y + z * z);
    }
    return std::sqrt(square);
  }
  /// The part of the line p + t d inside it.
  [[nodiscard]] talus::chord chord(const vec3& p, const vec3& d) const {
    talus::chord c;
    const polyhedron_mesh& m = mesh();
    for (std::size_t f = 0; f < m.faces(); ++f)
      c = detail::shared(
          c, detail::chord_below(m.normals[f].dot(p), m.normals[f].dot(d), m.offsets[f]));
    return c;
  }
  /// Half edges of the smallest box about the centre of mass, parallel to the axes of the world,
  /// that contains the body at a pose.
  [[nodiscard]] vec3 half_extents(const pose& at) const {
    vec3 half(0, 0, 0);
    for (const vec3& v : mesh_->vertices) {
      const vec3 p = rotated(at.orientation, v);
      for (int i = 0; i < 3; ++i) half[i] = std::max(half[i], std::abs(p[i]));
    }
    return half;
  }

  template <class Writer>
  void pack(Writer& out) const {
    detail::put_shared(out, mesh_);
  }
  template <class Reader>
  static convex_polyhedron unpack(Reader& in) {
    convex_polyhedron p;
    p.mesh_ = detail::get_shared<polyhedron_mesh>(in);
    return p;
  }

  /// Equal in every vertex and face.
  friend bool operator==(const convex_polyhedron& a, const convex_polyhedron& b) {
    return a.mesh_ == b.mesh_ || (a.mesh_ && b.mesh_ && a.mesh_->id == b.mesh_->id);
  }

 private:
  std::shared_ptr<const polyhedron_mesh> mesh_;
};

}  // namespace talus
