#pragma once
// Surfaces from STL files, the common export format of CAD programs: text or binary.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/input_file.hpp"
#include "talus/shape/triangle_mesh.hpp"

namespace talus {

namespace detail {

/// A binary STL has 80 bytes of title, the number of triangles, and 50 bytes for each: its normal,
/// which is ignored, three corners, and two further bytes. All numbers are little-endian.
[[nodiscard]] inline std::vector<triangle_mesh::triangle> triangles_of_binary_stl(
    std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  std::vector<triangle_mesh::triangle> triangles(count);
  const char* at = bytes.data() + 84;
  for (auto& t : triangles) {
    std::array<float, 9> numbers;
    std::memcpy(numbers.data(), at + 12, sizeof numbers);
    for (std::size_t k = 0; k < 3; ++k)
      t[k] = {numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]};
    at += 50;
  }
  return triangles;
}

/// Throws runtime_error, with the number of the line, for an invalid number.
[[nodiscard]] inline std::vector<triangle_mesh::triangle> triangles_of_text_stl(
    const std::string& text, const std::string& file) {
  std::vector<triangle_mesh::triangle> triangles;
  std::vector<vec3> corners;
  std::istringstream lines(text);
  std::string line, word;
  bool ended = false;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    if (!(words >> word)) continue;
    if (word == "vertex") {
      vec3 v;
      if (!(words >> v[0] >> v[1] >> v[2]))
        fail<std::runtime_error>("line {} of the STL file {} should be 'vertex x y z', but is '{}'",
                                 number, file, line);
      corners.push_back(v);
    } else if (word == "endfacet") {
      if (corners.size() != 3)
        fail<std::runtime_error>(
            "the facet that ends in line {} of the STL file {} has {} corners instead of 3", number,
            file, corners.size());
      triangles.push_back({corners[0], corners[1], corners[2]});
      corners.clear();
    } else if (word == "endsolid") {
      ended = true;
    }
  }
  if (!ended)
    fail<std::runtime_error>("the STL file {} ends without 'endsolid': it was cut off", file);
  return triangles;
}

}  // namespace detail

/// The surface in an STL file, text or binary, all lengths times `scale`. Throws runtime_error for
/// a file that cannot be read or is cut off, with the line of a text file, and invalid_argument as
/// triangle_mesh does. `report` gets what that finds: open edges, and corners that it joined.
[[nodiscard]] inline triangle_mesh read_stl(const std::string& file, real scale = 1,
                                            surface_report* report = nullptr) {
  detail::require_positive(scale, "the scale of an STL file");
  if (detail::is_folder(file))
    detail::fail<std::runtime_error>("the STL file {} is a folder: name the file in it", file);
  std::ifstream in(file, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  if (!in.is_open() || in.bad())
    detail::fail<std::runtime_error>(
        "the STL file {} cannot be read: is the name right, seen from the folder in which the "
        "program runs?",
        file);
  if (bytes.starts_with(detail::byte_order_mark)) bytes.erase(0, detail::byte_order_mark.size());
  std::uint32_t count = 0;
  if (bytes.size() >= 84) std::memcpy(&count, bytes.data() + 80, 4);
  // (Some binary files begin with the keyword of text files.)
  const bool binary = bytes.size() >= 84 && bytes.size() == 84 + 50 * std::size_t{count};
  if (!binary && bytes.compare(0, 5, "solid") != 0)
    detail::fail<std::runtime_error>(
        "{} is no STL file, or is cut off: it has {} bytes, and says that it holds {} triangles, "
        "which take {}",
        file, bytes.size(), count, 84 + 50 * std::size_t{count});
  auto triangles =
      binary ? detail::triangles_of_binary_stl(bytes) : detail::triangles_of_text_stl(bytes, file);
  for (auto& t : triangles)
    for (vec3& v : t) v *= scale;
  try {
    return triangle_mesh(triangles, report);
  } catch (const std::invalid_argument& e) {
    detail::fail<std::invalid_argument>("the STL file {}: {}", file, e.what());
  }
}

}  // namespace talus
