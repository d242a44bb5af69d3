#pragma once
// The definitions of shape_surface.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/shape_surface.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE void add_turned(surface_faces& out, std::span<const outline_point> outline) {
  constexpr std::uint32_t n = sides_of_round;
  const auto ring = [&](std::uint32_t k) { return k * n; };
  const auto rings = static_cast<std::uint32_t>(outline.size());
  for (const outline_point& p : outline)
    for (std::uint32_t side = 0; side < n; ++side) {
      const real angle = 2 * pi * side / n;
      out.points.emplace_back(p.radius * std::cos(angle), p.radius * std::sin(angle), p.z);
    }
  std::vector<std::uint32_t> below, above;
  for (std::uint32_t side = 0; side < n; ++side) {
    below.push_back(n - 1 - side);
    above.push_back(ring(rings - 1) + side);
  }
  out.add_face(below);
  for (std::uint32_t k = 0; k + 1 < rings; ++k)
    for (std::uint32_t side = 0; side < n; ++side) {
      const std::uint32_t next = (side + 1) % n;
      out.add_face({ring(k) + side, ring(k) + next, ring(k + 1) + next, ring(k + 1) + side});
    }
  out.add_face(above);
}

TALUS_HDF5_INLINE void add_surface(surface_faces& out, const box& b) {
  const vec3 half = real(0.5) * b.size;
  for (int corner = 0; corner < 8; ++corner)
    out.points.emplace_back((corner & 1) != 0 ? half[0] : -half[0],
                            (corner & 2) != 0 ? half[1] : -half[1],
                            (corner & 4) != 0 ? half[2] : -half[2]);
  out.add_face({0, 2, 3, 1});
  out.add_face({4, 5, 7, 6});
  out.add_face({0, 1, 5, 4});
  out.add_face({2, 6, 7, 3});
  out.add_face({0, 4, 6, 2});
  out.add_face({1, 3, 7, 5});
}

TALUS_HDF5_INLINE void add_surface(surface_faces& out, const cylinder& c) {
  const outline_point outline[] = {{c.radius, -c.length / 2}, {c.radius, c.length / 2}};
  add_turned(out, outline);
}

TALUS_HDF5_INLINE void add_surface(surface_faces& out, const capsule& c) {
  constexpr int steps = 4;  // from the equator of a cap almost to its pole, which is a small face
  std::vector<outline_point> outline;
  for (const int end : {-1, 1})
    for (int k = 0; k <= steps; ++k) {
      const real angle = pi / 2 * (end < 0 ? steps - k : k) / (steps + real(0.5));
      outline.push_back({c.radius * std::cos(angle),
                         static_cast<real>(end) * (c.length / 2 + c.radius * std::sin(angle))});
    }
  add_turned(out, outline);
}

}  // namespace talus::detail
