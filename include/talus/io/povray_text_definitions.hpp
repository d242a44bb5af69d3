#pragma once
// The definitions of povray_text.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/io/povray_text.hpp"

namespace talus::detail {

TALUS_INLINE void add_placement(povray_text& out, const pose& p) {
  const mat3 r = p.orientation.toRotationMatrix();
  out << "matrix<";
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) out << r(row, column) << ",";
  out << p.position[0] << "," << p.position[1] << "," << p.position[2] << ">";
}

TALUS_INLINE vec3 colour_of_hue(real hue, real saturation, real brightness) {
  const auto channel = [&](real n) {
    const real k = std::fmod(n + 6 * hue, 6);
    return brightness * (1 - saturation * std::clamp(std::min(k, 4 - k), real{0}, real{1}));
  };
  return {channel(5), channel(3), channel(1)};
}

TALUS_INLINE vec3 colour_of_number(int number) {
  const real turn = 0.6180339887498949 * number + 0.02;
  return colour_of_hue(turn - std::floor(turn), number % 2 == 0 ? 0.75 : 0.55,
                       number % 3 == 2 ? 0.7 : 0.92);
}

TALUS_INLINE vec3 colour_of_material(const material& m, material_id number) {
  return m.colour[0] == m.colour[0] ? m.colour : colour_of_number(static_cast<int>(number));
}

TALUS_INLINE bool shows_materials(const material_table& all) {
  for (std::size_t k = 0; k < all.size(); ++k) {
    const material& m = all[material_id{static_cast<std::uint16_t>(k)}];
    if (!m.name.text().empty() || m.colour[0] == m.colour[0]) return true;
  }
  return false;
}

}  // namespace talus::detail

namespace talus {

TALUS_INLINE void povray_form(detail::povray_text& out, const box& b) {
  const vec3 half = 0.5 * b.size;
  out << "box{" << vec3(-half) << "," << half;
}

TALUS_INLINE void povray_form(detail::povray_text& out, const cylinder& c) {
  const vec3 end{0, 0, 0.5 * c.length};
  out << "cylinder{" << vec3(-end) << "," << end << "," << c.radius;
}

TALUS_INLINE void povray_form(detail::povray_text& out, const capsule& c) {
  const vec3 end{0, 0, 0.5 * c.length};
  out << "merge{cylinder{" << vec3(-end) << "," << end << "," << c.radius << "}sphere{"
      << vec3(-end) << "," << c.radius << "}sphere{" << end << "," << c.radius << "}";
}

}  // namespace talus
