#pragma once
// A surface of triangles: the walls of a machine, a landscape. It has no inside and no mass: its
// bodies are global, or fixed.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/shape/level_triangles.hpp"
#include "talus/shape/near_triangles.hpp"
#include "talus/shape/triangle_tree.hpp"
#include "talus/shape/weld_triangles.hpp"

namespace talus {

/// Made from triangles in any frame. The frame of the body has its origin in the centre of the box
/// around them, and their axes: `placed(mesh, pose)` of shape/frame.hpp gives the pose of a body
/// whose triangles lie at the given coordinates. Both sides of a triangle repel bodies. Inner edges
/// have no effect if the surface is flat there or bends inwards.
class triangle_mesh {
 public:
  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr bool immovable = true;  ///< bodies of it are global or fixed
  static constexpr const char* name = "triangle_mesh";
  static constexpr std::size_t max_triangles = std::size_t{1} << 28;

  using triangle = std::array<vec3, 3>;

  /// An empty value, to be assigned to.
  triangle_mesh() = default;
  /// Corners within a millionth of the radius of the surface are merged, triangles without an area
  /// or given twice are dropped, and edges on which other corners lie are divided there. Triangles
  /// with common edges that lie in a plane, but for that distance, are moved into it. `report`,
  /// unless null, gets what was found. Throws invalid_argument, with its number, for a triangle
  /// whose corners are not finite, and if no triangle is left, or areas would not be numbers.
  explicit triangle_mesh(const std::vector<triangle>& triangles, surface_report* report = nullptr)
      : data_(std::make_shared<const detail::triangle_tree>(build(triangles, report))),
        frame_{centre_of(triangles), {1, 0, 0, 0}} {}

  /// Throws invalid_argument if there are no triangles.
  void validate() const {
    if (data_ == nullptr)
      detail::fail<std::invalid_argument>(
          "a triangle_mesh without triangles is no body: make it from a list, or by read_stl");
  }

  [[nodiscard]] const detail::triangle_tree& tree() const { return *data_; }
  /// Calls f(number) for the triangles whose boxes overlap the box `centre` ± `reach`, in the frame
  /// of the body. `size` is the bounding radius of what is there.
  template <class F>
  void each_within(const vec3& centre, const vec3& reach, real /*size*/, F&& f) const {
    data_->each_within(centre - reach, centre + reach, f);
  }
  using near_lists = detail::near_triangle_lists;
  /// The surface as seen from body i: it searches only among the triangles that `lists` keep near
  /// that body. It is number j of `surfaces`.
  [[nodiscard]] detail::surface_near_body near(near_lists& lists, std::size_t i, std::size_t j,
                                               std::size_t surfaces) const {
    return lists.of(i, j, surfaces, data_);
  }
  /// Number of triangles.
  [[nodiscard]] std::size_t triangles() const { return data_->triangles.size(); }
  /// The frame of the body in the coordinates of the triangles.
  [[nodiscard]] const pose& frame() const { return frame_; }
  /// Distance of its furthest point from the centre.
  [[nodiscard]] real bounding_radius() const { return data_->bounding_radius; }
  /// Area of the surface, used in place of the volume.
  [[nodiscard]] real volume() const { return data_->area; }
  /// An upper bound of the inertia of a shell about each axis; no motion uses it.
  [[nodiscard]] vec3 inertia() const {
    const real square = data_->bounding_radius * data_->bounding_radius;
    return {square, square, square};
  }
  /// Vertex furthest along `direction`; of equals, the first.
  [[nodiscard]] vec3 support(const vec3& direction) const {
    const vec3* best = &data_->vertices[0];
    for (const vec3& v : data_->vertices)
      if (direction.dot(v) > direction.dot(*best)) best = &v;
    return *best;
  }
  /// Distance of the furthest point from the point p.
  [[nodiscard]] real reach_from(const vec3& p) const {
    real square = 0;
    for (const vec3& v : data_->vertices) square = std::max(square, (v - p).squaredNorm());
    return std::sqrt(square);
  }
  [[nodiscard]] vec3 half_extents(const pose& at) const {
    vec3 half(0, 0, 0);
    for (const vec3& v : data_->vertices)
      half = half.cwiseMax(rotated(at.orientation, v).cwiseAbs());
    return half;
  }

  void pack(detail::byte_writer& out) const {
    out.put(frame_.position);
    detail::put_shared(out, data_);
  }
  static triangle_mesh unpack(detail::byte_reader& in) {
    triangle_mesh m;
    m.frame_.position = in.get<vec3>();
    m.data_ = detail::get_shared<detail::triangle_tree>(in);
    return m;
  }

  /// Equal in every triangle.
  friend bool operator==(const triangle_mesh& a, const triangle_mesh& b) {
    return a.data_ == b.data_ || (a.data_ && b.data_ && a.data_->id == b.data_->id);
  }

 private:
  [[nodiscard]] static vec3 centre_of(const std::vector<triangle>& triangles) {
    constexpr real infinity = std::numeric_limits<real>::infinity();
    vec3 lower(infinity, infinity, infinity), upper = -lower;
    for (const triangle& t : triangles)
      if (!detail::is_line(t[0], t[1], t[2]))
        for (const vec3& v : t) lower = lower.cwiseMin(v), upper = upper.cwiseMax(v);
    if (!(lower[0] <= upper[0])) return {0, 0, 0};
    return lower + real(0.5) * (upper - lower);
  }
  [[nodiscard]] static detail::triangle_tree build(const std::vector<triangle>& triangles,
                                                   surface_report* report) {
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (const vec3& v : triangles[t])
        if (!detail::finite(v))
          detail::fail<std::invalid_argument>(
              "triangle {} of a triangle_mesh has a corner at {}: all must be finite", t,
              detail::text(v));
    const vec3 centre = centre_of(triangles);
    real radius = 0;
    for (const triangle& t : triangles)
      if (!detail::is_line(t[0], t[1], t[2]))
        for (const vec3& v : t) radius = std::max(radius, (v - centre).norm());
    // Squares of areas are numbers up to there.
    if (!(radius < real(1e70)))
      detail::fail<std::invalid_argument>(
          "the corners of a triangle_mesh may be up to 1e70 from the centre, but one is at {}: "
          "give "
          "them in other units",
          radius);
    surface_report unused;
    surface_report& found = report == nullptr ? unused : *report;
    found = {};
    detail::triangle_welder welder(radius, found);
    if (radius > real(1e-70)) {
      for (const triangle& t : triangles)
        if (detail::is_line(t[0], t[1], t[2]))
          ++found.without_area;
        else
          welder.add({t[0] - centre, t[1] - centre, t[2] - centre});
      welder.finish();
    }
    found.levelled = detail::triangle_leveller(welder.points, welder.faces,
                                               detail::weld_part * radius, real(1e-13) * radius)
                         .level();
    for (auto* places : {&found.joined, &found.open_edges, &found.shared_edges})
      for (vec3& p : *places) p += centre;
    auto& faces = welder.faces;
    if (faces.empty() || faces.size() > max_triangles)
      detail::fail<std::invalid_argument>(
          "a triangle_mesh has from 1 to {} triangles with an area, but {} of {} have one",
          max_triangles, faces.size(), triangles.size());
    return detail::triangle_tree::build(std::move(welder.points), std::move(faces));
  }

  std::shared_ptr<const detail::triangle_tree> data_;
  pose frame_;
};

}  // namespace talus
