#pragma once
// Packings of spheres as tables of text.
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/scene/site.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/world/world.hpp"

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
  using site_type = site;

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
/// line for each sphere. Commas, semicolons, tabs, bars (|) or blanks separate the fields, as in
/// the first line; fields may stand in quotes. Empty lines, and those that begin with #, are
/// skipped. Each rank reads the file by itself. Throws runtime_error, with file and line, where the
/// file cannot be read, a column is missing or there twice, or a line has other fields than the
/// first one, something that is not a finite number, or a radius that is not positive.
[[nodiscard]] packing read_packing(const std::string& file);

namespace detail {

/// A sphere of a packing as ranks send it.
struct sent_sphere {
  std::uint64_t id = 0;
  real values[7] = {};  ///< position, radius, velocity
};

/// Writes the table of the spheres of all ranks, in the order of their ids. Returns why it cannot,
/// or nothing.
[[nodiscard]] std::string write_spheres(const std::string& file, plain_vector<sent_sphere> spheres);

}  // namespace detail

/// Collective: writes the spheres that can move to a table that read_packing reads with the same
/// values: position, radius and velocity in 17 digits, by the order in which they were added.
/// Angular velocities, materials and the memory of contacts are not in it; a checkpoint holds them.
/// Replaces an earlier packing. Throws runtime_error alike on all ranks if the file cannot be
/// written or is not a packing, or if a body of another shape can move.
template <class Scenario>
void write_packing(world<Scenario>& w, const std::string& file) {
  static_assert(detail::takes_shape<Scenario, sphere>,
                "write_packing writes spheres, and the scenario has none: name sphere in "
                "bodies<...>");
  w.require_all_ranks("write_packing");
  detail::plain_vector<detail::sent_sphere> spheres;
  std::uint64_t others = 0;
  w.for_each_local([&](const auto& b) {
    if (b.is_fixed()) return;
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(b.shape())>, sphere>) {
      const vec3 x = b.position(), v = b.velocity();
      spheres.push_back({value_of(b.id()), {x[0], x[1], x[2], b.shape().radius, v[0], v[1], v[2]}});
    } else {
      ++others;
    }
  });
  w.link().reduce(reduction::sum, std::span(&others, 1));
  if (others > 0)
    detail::fail<std::runtime_error>(
        "the packing {}: write_packing writes spheres, and of the bodies that can move {} have "
        "other shapes",
        file, others);
  detail::byte_buffer bytes(spheres.size() * sizeof(detail::sent_sphere));
  if (!bytes.empty()) std::memcpy(bytes.data(), spheres.data(), bytes.size());
  const std::vector<detail::byte_buffer> of_ranks = w.link().gather(bytes);
  std::string why;
  if (w.rank() == 0) {
    for (std::size_t rank = 1; rank < of_ranks.size(); ++rank)
      for (std::size_t at = 0; at < of_ranks[rank].size(); at += sizeof(detail::sent_sphere)) {
        detail::sent_sphere one;
        std::memcpy(&one, of_ranks[rank].data() + at, sizeof one);
        spheres.push_back(one);
      }
    why = detail::write_spheres(file, std::move(spheres));
  }
  bytes.resize(why.size());
  if (!why.empty()) std::memcpy(bytes.data(), why.data(), why.size());
  w.link().broadcast(bytes);
  if (bytes.empty()) return;
  why.resize(bytes.size());
  std::memcpy(why.data(), bytes.data(), bytes.size());
  detail::fail<std::runtime_error>("the packing {} {}", file, why);
}

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/scene/packing_definitions.hpp"
#endif
