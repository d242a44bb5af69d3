#pragma once
// The definitions of tables.hpp, in the compiled part or in each program.
#include <exception>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/observe/tables.hpp"

namespace talus {

namespace detail {

inline constexpr output_kind row_file_output{
    "a table of bodies or contacts",
    [](std::string_view head) {
      return head.starts_with("id,shape,position_x") ||
             head.starts_with("id_a,id_b,shape_a,shape_b,feature,point_x");
    },
    false};

/// Adds columns of numbers, the values `from` and following of each row.
template <class Rows>
void add_numbers(std::vector<data_table::column>& columns, const Rows& rows, std::size_t from,
                 const std::string& name, std::string_view ends, const std::string& dimension) {
  for (std::size_t k = 0; k < (ends.empty() ? 1 : ends.size()); ++k) {
    std::vector<double> values;
    values.reserve(rows.size());
    for (const auto& r : rows) values.push_back(r.values[from + k] + 0.0);  // zero has no sign
    columns.push_back({ends.empty() ? name : name + "_" + ends[k], dimension, std::move(values)});
  }
}
/// Adds a column of whole numbers, or of words if f returns them.
template <class Rows, class F>
void add_others(std::vector<data_table::column>& columns, const Rows& rows, const char* name,
                F&& f) {
  std::vector<std::remove_cvref_t<decltype(f(rows.front()))>> values;
  values.reserve(rows.size());
  for (const auto& r : rows) values.push_back(f(r));
  columns.push_back({name, "", std::move(values)});
}

TALUS_INLINE data_table table_of(const std::vector<body_table_row>& rows, const shape_names& shapes,
                                 const unit_names& units, bool here) {
  std::vector<data_table::column> c;
  using row = body_table_row;
  add_others(c, rows, "id", [](const row& r) { return r.id; });
  add_others(c, rows, "shape", [&](const row& r) { return shapes[r.shape]; });
  add_numbers(c, rows, 0, "position", "xyz", in_units("L", units));
  add_numbers(c, rows, 3, "orientation", "xyzw", "");
  add_numbers(c, rows, 7, "velocity", "xyz", in_units("L/T", units));
  add_numbers(c, rows, 10, "angular_velocity", "xyz", in_units("1/T", units));
  add_numbers(c, rows, 13, "radius", "", in_units("L", units));
  add_numbers(c, rows, 14, "mass", "", in_units("M", units));
  add_others(c, rows, "material", [](const row& r) { return std::uint64_t{r.material}; });
  add_others(c, rows, "fixed", [](const row& r) { return std::uint64_t{r.flags[0]}; });
  add_others(c, rows, "global", [](const row& r) { return std::uint64_t{r.flags[1]}; });
  return {std::move(c), here};
}

TALUS_INLINE data_table table_of(const std::vector<contact_table_row>& rows,
                                 const shape_names& shapes, const unit_names& units, bool here) {
  std::vector<data_table::column> c;
  using row = contact_table_row;
  add_others(c, rows, "id_a", [](const row& r) { return r.a; });
  add_others(c, rows, "id_b", [](const row& r) { return r.b; });
  add_others(c, rows, "shape_a", [&](const row& r) { return shapes[r.shapes[0]]; });
  add_others(c, rows, "shape_b", [&](const row& r) { return shapes[r.shapes[1]]; });
  add_others(c, rows, "feature", [](const row& r) { return r.feature; });
  add_numbers(c, rows, 0, "point", "xyz", in_units("L", units));
  add_numbers(c, rows, 3, "normal", "xyz", "");
  add_numbers(c, rows, 6, "gap", "", in_units("L", units));
  add_numbers(c, rows, 7, "force", "xyz", in_units("M L/T^2", units));
  add_numbers(c, rows, 10, "normal_force", "", in_units("M L/T^2", units));
  return {std::move(c), here};
}

}  // namespace detail

TALUS_INLINE std::size_t data_table::rows() const {
  return columns_.empty() ? 0
                          : std::visit([](const auto& v) { return v.size(); }, columns_[0].values);
}

template <class T>
const std::vector<T>& data_table::values_of(std::string_view name, const char* kind) const {
  std::string names;
  for (const column& c : columns_) {
    const auto* const values = std::get_if<std::vector<T>>(&c.values);
    if (values == nullptr) continue;
    if (c.name == name) return *values;
    (names += names.empty() ? "" : ", ") += c.name;
  }
  detail::fail<std::invalid_argument>("the table has no column of {} '{}': it has {}", kind,
                                      std::string(name), names);
}
TALUS_INLINE const std::vector<double>& data_table::numbers(std::string_view name) const {
  return values_of<double>(name, "numbers");
}
TALUS_INLINE const std::vector<std::uint64_t>& data_table::whole_numbers(
    std::string_view name) const {
  return values_of<std::uint64_t>(name, "whole numbers");
}
TALUS_INLINE const std::vector<std::string_view>& data_table::words(std::string_view name) const {
  return values_of<std::string_view>(name, "words");
}

TALUS_INLINE void data_table::write_csv(const std::string& file) const {
  if (!here_) return;
  std::string all;
  for (const column& c : columns_) {
    (all += all.empty() ? "" : ",") += c.name;
    if (!c.dimension.empty()) ((all += " [") += c.dimension) += "]";
  }
  all += "\n";
  for (std::size_t i = 0; i < rows(); ++i) {
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      if (k > 0) all += ",";
      std::visit(
          [&](const auto& v) {
            if constexpr (std::is_same_v<decltype(v[i]), const double&>)
              all += detail::text(v[i]);
            else if constexpr (std::is_same_v<decltype(v[i]), const std::uint64_t&>)
              all += std::to_string(v[i]);
            else
              all += v[i];
          },
          columns_[k].values);
    }
    all += "\n";
  }
  try {
    detail::write_output(file, all, detail::row_file_output, false);
  } catch (const std::exception& e) {
    detail::fail<std::runtime_error>("the table {} {}", file, e.what());
  }
}

}  // namespace talus
