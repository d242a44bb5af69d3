#pragma once
// Tables of all bodies and of all contacts, for files and for other programs.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/math.hpp"
#include "talus/core/output_file.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/unit_names.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// Columns of equal length, on rank 0. On other ranks they are empty.
class data_table {
 public:
  /// A column: numbers, whole numbers (ids), or words (names of shapes).
  struct column {
    std::string name;       ///< as "velocity_x"
    std::string dimension;  ///< as "L/T", or in units of the world; empty for names and ids
    std::variant<std::vector<double>, std::vector<std::uint64_t>, std::vector<std::string_view>>
        values{};
  };

  data_table() = default;
  data_table(std::vector<column> columns, bool here) : columns_(std::move(columns)), here_(here) {}

  /// Number of rows.
  [[nodiscard]] std::size_t rows() const;
  /// All columns.
  [[nodiscard]] const std::vector<column>& columns() const { return columns_; }
  /// A column of numbers. Throws invalid_argument, with the names, if there is none of this name.
  [[nodiscard]] const std::vector<double>& numbers(std::string_view name) const;
  /// A column of whole numbers: ids and the like. Throws likewise.
  [[nodiscard]] const std::vector<std::uint64_t>& whole_numbers(std::string_view name) const;
  /// A column of names. Throws likewise.
  [[nodiscard]] const std::vector<std::string_view>& words(std::string_view name) const;
  /// Writes the table as comma-separated values, the names of the columns with their units first.
  /// Replaces only a file that is such a table. Throws runtime_error if it cannot be written, on
  /// rank 0 alone: other ranks write nothing.
  void write_csv(const std::string& file) const;

 private:
  template <class T>
  [[nodiscard]] const std::vector<T>& values_of(std::string_view name, const char* kind) const;

  std::vector<column> columns_;
  bool here_ = false;
};

namespace detail {

/// A row of the table of bodies, as ranks send it.
struct body_table_row {
  std::uint64_t id = 0;
  std::uint32_t shape = 0, material = 0;
  std::array<double, 15> values{};       ///< position, orientation, velocities, radius, mass
  std::array<std::uint32_t, 2> flags{};  ///< fixed, global
  friend bool operator<(const body_table_row& x, const body_table_row& y) { return x.id < y.id; }
};
/// A row of the table of contacts, as ranks send it.
struct contact_table_row {
  std::uint64_t a = 0, b = 0, feature = 0;
  std::array<std::uint32_t, 2> shapes{};
  std::array<double, 11> values{};  ///< point, normal, gap, force, force along the normal
  friend bool operator<(const contact_table_row& x, const contact_table_row& y) {
    if (x.a != y.a) return x.a < y.a;
    return x.b != y.b ? x.b < y.b : x.feature < y.feature;
  }
};

/// Collective: the rows of all ranks in order, on rank 0.
template <class Link, class Row>
[[nodiscard]] std::vector<Row> gathered_rows(Link& link, const std::vector<Row>& mine) {
  static_assert(std::is_trivially_copyable_v<Row>);
  byte_buffer bytes(mine.size() * sizeof(Row));
  if (!mine.empty()) std::memcpy(bytes.data(), mine.data(), bytes.size());
  std::vector<Row> all;
  for (const byte_buffer& theirs : link.gather(bytes)) {
    if (theirs.empty()) continue;
    const std::size_t before = all.size();
    all.resize(before + theirs.size() / sizeof(Row));
    std::memcpy(all.data() + before, theirs.data(), theirs.size());
  }
  if (link.rank() != 0) all.clear();
  std::sort(all.begin(), all.end());
  return all;
}

/// The radius of a sphere, of another shape that of the ball of equal volume (length); 0 of a shape
/// without a volume.
template <class Shape>
[[nodiscard]] real radius_of_equal_ball(const Shape& shape) {
  if constexpr (requires { shape.radius; } && Shape::isotropic)
    return shape.radius;
  else if constexpr (Shape::finite && !requires { Shape::immovable; })
    return portable::cbrt(3 / (4 * pi) * shape.volume());
  else
    return (void)shape, 0;
}

using shape_names = std::vector<std::string_view>;
[[nodiscard, gnu::cold]] data_table table_of(const std::vector<body_table_row>& rows,
                                             const shape_names& shapes, const unit_names& units,
                                             bool here);
[[nodiscard, gnu::cold]] data_table table_of(const std::vector<contact_table_row>& rows,
                                             const shape_names& shapes, const unit_names& units,
                                             bool here);

/// The names of the shapes of a scenario, in the order of each_shape().
template <class Scenario>
[[nodiscard]] shape_names names_of_shapes(const world_state<Scenario>& s) {
  shape_names names;
  s.each_shape([&](const auto& b) {
    names.emplace_back(std::remove_cvref_t<decltype(b.movable)>::shape_type::name);
  });
  return names;
}

}  // namespace detail

/// Collective: all bodies, global ones too, on rank 0, by their ids: their state, radius (of a
/// sphere, or of the ball of equal volume; 0 of planes and surfaces), mass (0 of what has none),
/// material, and whether they are fixed or global. docs/output.md lists the columns. The same on
/// any ranks. Costs one message of 152 bytes per body to rank 0.
template <class Scenario>
[[nodiscard]] data_table body_table(world<Scenario>& w) {
  w.require_all_ranks("body_table");
  const auto& s = detail::view_of(w);
  std::vector<detail::body_table_row> mine;
  std::uint32_t shape = 0;
  const auto add = [&](const auto& store, std::size_t count, bool global) {
    for (std::size_t i = 0; i < count; ++i) {
      const vec3 &x = store.position[i], &v = store.velocity[i], &turn = store.angular_velocity[i];
      const quat q = store.pose(i).orientation;
      const double mass = mass_of(store, i, s.materials);
      mine.push_back({value_of(store.id[i]),
                      shape,
                      static_cast<std::uint32_t>(store.material[i]),
                      {x[0], x[1], x[2], q.x(), q.y(), q.z(), q.w(), v[0], v[1], v[2], turn[0],
                       turn[1], turn[2], detail::radius_of_equal_ball(store.shape[i]), mass},
                      {store.fixed(i) || global ? 1u : 0u, global ? 1u : 0u}});
    }
  };
  s.each_shape([&](const auto& b) {
    add(b.movable, b.movable.locals, false);
    if (w.rank() == 0) add(b.global, b.global.size(), true);
    ++shape;
  });
  return detail::table_of(detail::gathered_rows(w.link(), mine), detail::names_of_shapes(s),
                          w.units(), w.rank() == 0);
}

/// Collective: the contacts that carry a force, those of for_each_contact(), on rank 0, by the ids
/// of their bodies: the bodies and their shapes, feature, point, normal, gap and force.
/// docs/output.md lists the columns. The same rows on any ranks. Costs one pass over the contacts
/// and one message of 120 bytes per contact to rank 0.
template <class Scenario>
[[nodiscard]] data_table contact_table(world<Scenario>& w) {
  w.require_all_ranks("contact_table");
  auto& s = detail::state_of(w);
  const detail::body_places<Scenario> places(s);
  const detail::shape_names names = detail::names_of_shapes(s);
  std::vector<detail::contact_table_row> mine;
  const auto shape_of = [&](system_id id) {
    std::uint32_t number = 0;
    places.visit(id, [&](const auto& store, std::size_t, bool) {
      const char* const name = std::remove_cvref_t<decltype(store)>::shape_type::name;
      while (number + 1 < names.size() && names[number] != name) ++number;
    });
    return number;
  };
  detail::each_loaded_contact(s, places, [&](const loaded_contact& c, bool counts) {
    if (!counts) return;
    const vec3 &p = c.point, &n = c.normal, &f = c.force;
    mine.push_back(
        {value_of(c.a),
         value_of(c.b),
         c.feature,
         {shape_of(c.a), shape_of(c.b)},
         {p[0], p[1], p[2], n[0], n[1], n[2], c.gap, f[0], f[1], f[2], c.normal_force()}});
  });
  return detail::table_of(detail::gathered_rows(w.link(), mine), names, w.units(), w.rank() == 0);
}

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/observe/tables_definitions.hpp"
#endif
