#pragma once
// The statements of POV-Ray's scene language for bodies and domains.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "talus/body/material.hpp"
#include "talus/concepts.hpp"
#include "talus/geometry/half_space.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/capsule.hpp"
#include "talus/shape/cylinder.hpp"
#include "talus/shape/ellipsoid.hpp"
#include "talus/shape/plane.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/shape/superellipsoid.hpp"
#include "talus/shape/support_surface.hpp"

namespace talus::detail {

/// A growing text; numbers have seven digits.
class povray_text {
 public:
  povray_text& operator<<(std::string_view s) {
    text_.append(s);
    return *this;
  }
  povray_text& operator<<(real x) {
    char digits[32];
    const auto end =
        std::to_chars(digits, digits + sizeof digits, x, std::chars_format::general, 7).ptr;
    text_.append(digits, end);
    return *this;
  }
  povray_text& operator<<(const vec3& v) {
    return *this << "<" << v[0] << "," << v[1] << "," << v[2] << ">";
  }
  [[nodiscard]] const std::string& str() const { return text_; }
  void clear() { text_.clear(); }

 private:
  std::string text_;
};

/// From the frame of a body to that of the world.
void add_placement(povray_text& out, const pose& p);

/// A colour with red, green and blue in [0, 1].
[[nodiscard]] vec3 colour_of_hue(real hue, real saturation = 0.75, real brightness = 0.9);
/// Colours of neighbouring numbers differ: steps of the golden ratio around the circle of hues.
[[nodiscard]] vec3 colour_of_number(int number);
/// The colour that a material has, or one of its own by its number.
[[nodiscard]] vec3 colour_of_material(const material& m, material_id number);
/// Whether a program tells materials apart for those who look: one has a name or a colour.
[[nodiscard, gnu::cold]] bool shows_materials(const material_table& all);
/// From blue (0) over green to red (1).
[[nodiscard]] inline vec3 colour_of_part(real part) {
  return colour_of_hue((1 - std::clamp(part, real{0}, real{1})) * 2 / 3);
}

}  // namespace talus::detail

namespace talus {

// The form of a shape in the frame of the body, without placement and colour. Other convex shapes
// are drawn by their support functions; a shape with a better picture has such a function in its
// namespace.

inline void povray_form(detail::povray_text& out, const sphere& s) {
  out << "sphere{<0,0,0>," << s.radius;
}
inline void povray_form(detail::povray_text& out, const ellipsoid& e) {
  out << "sphere{<0,0,0>,1 scale " << e.radii;
}
inline void povray_form(detail::povray_text& out, const superellipsoid& s) {
  out << "superellipsoid{<" << 2 / s.n2 << "," << 2 / s.n1 << "> scale " << s.radii;
}
void povray_form(detail::povray_text& out, const box& b);
inline void povray_form(detail::povray_text& out, const plane& p) {
  out << "plane{" << p.unit_normal() << "," << p.offset;
}
void povray_form(detail::povray_text& out, const cylinder& c);
void povray_form(detail::povray_text& out, const capsule& c);
/// A shape with flat faces, as triangles: an intersection of planes has no bounds for POV-Ray, so
/// every ray would be tested against every face.
template <class Shape>
requires requires(const Shape& s) { s.mesh().normals; }
void povray_form(detail::povray_text& out, const Shape& s) {
  const auto& mesh = s.mesh();
  out << "mesh{";
  for (std::size_t f = 0; f < mesh.faces(); ++f) {
    const auto corners = mesh.face(f);
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
      out << "triangle{" << mesh.vertices[corners[0]] << "," << mesh.vertices[corners[k]] << ","
          << mesh.vertices[corners[k + 1]] << "}";
  }
}
/// A surface of triangles.
template <class Shape>
requires requires(const Shape& s) { s.tree().triangles; }
void povray_form(detail::povray_text& out, const Shape& s) {
  const auto& tree = s.tree();
  out << "mesh{";
  for (std::uint32_t t = 0; t < tree.triangles.size(); ++t)
    out << "triangle{" << tree.corner(t, 0) << "," << tree.corner(t, 1) << "," << tree.corner(t, 2)
        << "}";
}
/// Any other convex shape, as smooth triangles.
template <concepts::convex_shape Shape>
requires(!requires(const Shape& s) { s.mesh().normals; }) void povray_form(detail::povray_text& out,
                                                                           const Shape& s) {
  const detail::support_surface drawn = detail::surface_of_support(s);
  out << "mesh{";
  for (const auto& triangle : drawn.triangles) {
    out << "smooth_triangle{";
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t p = triangle[static_cast<std::size_t>(k)];
      out << drawn.points[p] << "," << drawn.normals[p] << (k < 2 ? "," : "}");
    }
  }
}
/// A shape made of parts.
template <class Shape>
requires requires(const Shape& s) {
  s.each_part([](const auto&, const pose&) {});
}
void povray_form(detail::povray_text& out, const Shape& s) {
  out << "union{";
  s.each_part([&](const auto& shape, const pose& at) {
    povray_form(out, shape);
    out << " ";
    detail::add_placement(out, at);
    out << "}";
  });
}

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/io/povray_text_definitions.hpp"
#endif
