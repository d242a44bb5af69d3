#pragma once
// The parts of a checkpoint that our own code parses, from any bytes: its first block, and the
// forms of polyhedra and unions. Checksums are corrected, because a fuzzer would hardly guess them.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <span>
#include <string>
#include <talus/io/detail/checkpoint_block.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/shape/union_of.hpp>
#include <vector>

namespace fuzz {

using clump = talus::union_of<talus::sphere, talus::box, talus::convex_polyhedron>;
enum class part : std::uint8_t { block, polyhedron, clump };

inline void require(bool condition) {
  if (!condition) std::abort();
}

inline void use_block(std::span<const std::byte> bytes) {
  namespace d = talus::detail;
  d::byte_buffer block(bytes.begin(), bytes.end());
  if (block.size() >= 40) {  // with valid checksums
    std::uint32_t length = 0;
    std::memcpy(&length, block.data() + 36, 4);
    if (length >= 8 && length <= block.size()) {
      const auto sum = d::checksum_of(std::span(block).first(length - 8));
      std::memcpy(block.data() + length - 8, &sum, 8);
    }
  }
  std::uint64_t file = block.size();
  if (block.size() >= 48) std::memcpy(&file, block.data() + 40, 8);
  const d::checkpoint_block b = d::read_block(block, file);
  std::uint64_t end = b.block_bytes;
  for (const d::byte_range& r : b.ranges) {
    require(r.first >= end && r.bytes <= file - r.first);
    end = r.first + r.bytes;
  }
  d::each_part_of_rest(b, [&](d::byte_range r) {
    require(r.bytes > 0 && r.first >= b.block_bytes && r.bytes <= file - r.first);
  });
}

/// The functions of a shape that contacts use.
template <class Shape>
void use_form(std::span<const std::byte> bytes) {
  talus::detail::byte_reader in(bytes);
  const Shape s = Shape::unpack(in);
  s.validate();
  require(s.volume() > 0 && std::isfinite(s.bounding_radius()));
  talus::vec3 sum(0, 0, 0);
  for (const talus::vec3& d : {talus::vec3(1, 0, 0), talus::vec3(-0.3, 0.5, 0.8)})
    sum += s.support(d);
  sum += s.half_extents({{1, 2, 3}, {1, 0, 0, 0}});
  if constexpr (requires { s.mesh(); }) {
    const talus::polyhedron_mesh& m = s.mesh();
    for (std::size_t f = 0; f < m.faces(); ++f) {
      for (const auto c : m.face(f)) sum += m.vertices[c];
      for (const auto e : m.edges_of_face(f)) sum += m.normals[m.edges[e].left];
    }
    for (std::size_t v = 0; v < m.vertices.size(); ++v)
      for (const auto f : m.faces_around(v)) sum += m.normals[f];
  } else {
    s.each_part_near({0, 0, 0}, 1,
                     [&](std::size_t, const auto&, const talus::pose& at) { sum += at.position; });
  }
  [[maybe_unused]] volatile talus::real used = sum[0] + sum[1] + sum[2];
}

/// "" if the bytes are accepted, else the reason; aborts if a promise does not hold.
inline std::string read_part(std::span<const std::byte> bytes) {
  if (bytes.empty()) return "empty";
  const auto rest = bytes.subspan(1);
  try {
    switch (static_cast<part>(static_cast<unsigned>(bytes[0]) % 3)) {
      case part::block:
        use_block(rest);
        break;
      case part::polyhedron:
        use_form<talus::convex_polyhedron>(rest);
        break;
      case part::clump:
        use_form<clump>(rest);
        break;
    }
  } catch (const std::bad_alloc&) {
    return "memory";
  } catch (const std::exception& e) {
    const std::string words = e.what();
    require(words.size() > 10);
    return words;
  }
  return "";
}

}  // namespace fuzz
