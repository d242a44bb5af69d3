#pragma once
// Packings of spheres from elsewhere, as comma-separated tables.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/input_file.hpp"
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

namespace detail {

/// The fields of a line, without blanks around them.
template <class String>
[[nodiscard, gnu::cold]] std::vector<String> fields_of(const String& line) {
  std::vector<String> fields;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(',', at), line.size());
    const String field = line.substr(at, end - at);
    const auto first = field.find_first_not_of(" \t\r"), last = field.find_last_not_of(" \t\r");
    fields.push_back(first == String::npos ? String() : field.substr(first, last - first + 1));
    at = end + 1;
  }
  return fields;
}

}  // namespace detail

/// Reads spheres from a table: a first line with the names of the columns, in any order, of which
/// x, y, z and r are needed and vx, vy and vz are known (others are left out), and then a line for
/// each sphere. Empty lines, and those that begin with #, are skipped. Each rank reads the file by
/// itself. Throws runtime_error, with file and line, where the file cannot be read, a column is
/// missing or there twice, or a line has other fields than the first one, something that is not a
/// finite number, or a radius that is not positive.
template <class String = std::string>
[[nodiscard, gnu::cold]] packing read_packing(const String& file) {
  if (detail::is_folder(file))
    detail::fail<std::runtime_error>("the packing {} is a folder: name the file in it",
                                     std::string(file));
  std::ifstream in(file);
  if (!in) detail::fail<std::runtime_error>("the packing {} cannot be read", std::string(file));
  const auto refuse = [&](std::size_t line, const std::string& what) {
    detail::fail<std::runtime_error>("{}, line {}: {}", std::string(file), line, what);
  };
  static constexpr const char* names[] = {"x", "y", "z", "r", "vx", "vy", "vz"};
  constexpr std::size_t none = ~std::size_t{0};
  std::size_t column[7] = {none, none, none, none, none, none, none}, columns = 0;
  detail::plain_vector<packed_sphere> spheres;
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    if (number == 1 && line.starts_with(detail::byte_order_mark))
      line.erase(0, detail::byte_order_mark.size());
    const auto fields = detail::fields_of(line);
    if ((fields.size() == 1 && fields[0].empty()) || line[0] == '#') continue;
    if (columns == 0) {
      columns = fields.size();
      for (std::size_t c = 0; c < columns; ++c)
        for (std::size_t k = 0; k < 7; ++k)
          if (fields[c] == names[k]) {
            if (column[k] != none)
              refuse(number, detail::compose("the column {} is there twice", names[k]));
            column[k] = c;
          }
      for (std::size_t k = 0; k < 4; ++k)
        if (column[k] == none)
          refuse(number, detail::compose("there is no column {}: the first line names the columns, "
                                         "of which x, y, z and r are needed",
                                         names[k]));
      continue;
    }
    if (fields.size() != columns)
      refuse(number, detail::compose("it has {} fields, and the first line {} columns",
                                     fields.size(), columns));
    real value[7] = {};
    for (std::size_t k = 0; k < 7; ++k) {
      if (column[k] == none) continue;
      const std::string& text = fields[column[k]];
      char* end = nullptr;
      value[k] = std::strtod(text.c_str(), &end);
      if (text.empty() || *end != 0 || !std::isfinite(value[k]))
        refuse(number, detail::compose("{} is '{}', which is no finite number", names[k], text));
    }
    if (!(value[3] > 0))
      refuse(number, detail::compose("the radius r is {}, and must be positive", value[3]));
    spheres.push_back(
        {vec3(value[0], value[1], value[2]), value[3], vec3(value[4], value[5], value[6])});
  }
  if (columns == 0)
    detail::fail<std::runtime_error>(
        "the packing {} is empty: its first line names the columns x, y, z and r",
        std::string(file));
  return packing(std::move(spheres));
}

}  // namespace talus
