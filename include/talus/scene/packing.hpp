#pragma once
// Packings of spheres from elsewhere, as tables of text.
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/scene/site.hpp"

namespace talus {

/// A sphere of a packing.
struct packed_sphere {
  vec3 position{0, 0, 0};
  real radius = 0;
  vec3 velocity{0, 0, 0};
};

/// Spheres by their number; a set of sites at their centres, numbered likewise:
///   const packing heap = read_packing("heap.csv");
///   world.fill(heap, [&](const site& s) {
///     return body{.shape = sphere{heap[s.index].radius}, .position = s.position};
///   });
class packing {
 public:
  explicit packing(detail::plain_vector<packed_sphere> spheres) : spheres_(std::move(spheres)) {}

  [[nodiscard]] std::size_t size() const { return spheres_.size(); }
  [[nodiscard]] const packed_sphere& operator[](std::uint64_t i) const { return spheres_[i]; }
  template <class F>
  void for_each_in(const vec3& lower, const vec3& upper, F&& f) const {
    for (std::size_t i = 0; i < spheres_.size(); ++i)
      if (detail::between(lower, spheres_[i].position, upper))
        f(site{spheres_[i].position, {1, 0, 0, 0}, i});
  }

 private:
  detail::plain_vector<packed_sphere> spheres_;
};

/// Reads spheres from a table: a first line with the names of the columns, in any order and case,
/// of which x, y, z and r are needed and vx, vy and vz are known (others are left out), and then a
/// line for each sphere. Commas, semicolons, tabs or blanks separate the fields, as in the first
/// line; fields may stand in quotes. Empty lines, and those that begin with #, are skipped. Each
/// rank reads the file by itself. Throws runtime_error, with file and line, where the file cannot
/// be read, a column is missing or there twice, or a line has other fields than the first one,
/// something that is not a finite number, or a radius that is not positive.
[[nodiscard]] packing read_packing(const std::string& file);

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/scene/packing_definitions.hpp"
#endif
