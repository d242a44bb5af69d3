#pragma once
// What one rank contributes to a frame of the viewer's page, and its message to rank 0.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Shapes by number, as the page has them; the first six as in the output for ParaView. Those that
/// have other numbers there follow after the plane.
enum class view_shape : std::uint8_t { sphere, box, capsule, cylinder, polyhedron, mesh, plane };

inline constexpr std::uint8_t view_wall = 1, view_global = 2;  ///< flags of a body

/// A body, or a part of a union.
struct view_body {
  system_id id = no_id;
  std::uint32_t part = 0, rank = 0;
  view_shape shape = view_shape::sphere;
  std::uint8_t flags = 0, asleep = 0, unused = 0;
  std::uint16_t material = 0, unused_too = 0;
  std::uint64_t form = 0;  ///< identifies its faces; 0: the shape needs none
  std::array<float, 3> size{};
  float mass = 0;  ///< of the whole body, in its first part
  vec3 position{0, 0, 0}, velocity{0, 0, 0};
  quat orientation{1, 0, 0, 0};
};
/// A contact that carries a force.
struct view_contact {
  system_id a = no_id, b = no_id;
  std::uint64_t feature = 0;
  vec3 point{0, 0, 0}, force{0, 0, 0};
};
/// A joint, with its points in the frames of its bodies.
struct view_joint {
  system_id a = no_id, b = no_id;
  std::uint64_t number = 0;
  vec3 on_a{0, 0, 0}, on_b{0, 0, 0};

  friend bool operator<(const view_joint& x, const view_joint& y) {
    if (x.a != y.a) return value_of(x.a) < value_of(y.a);
    return x.b != y.b ? value_of(x.b) < value_of(y.b) : x.number < y.number;
  }
};
/// The domain of a rank is where normal . x >= distance for all its planes.
struct view_plane {
  vec3 normal{0, 0, 1};
  double distance = 0;
};
/// The faces of a form, as triangles.
struct view_form {
  std::uint64_t id = 0;
  plain_vector<float> points;
  plain_vector<std::uint32_t> corners;
};

struct view_part {
  std::array<double, 4> seconds{};  ///< of the stages so far: detect, respond, integrate, exchange
  plain_vector<view_body> bodies;
  plain_vector<view_contact> contacts;
  plain_vector<view_joint> joints;
  plain_vector<view_plane> domain;
  std::vector<view_form> forms;  ///< those that this rank has not sent before

  [[nodiscard, gnu::cold]] byte_buffer packed() const;
  [[nodiscard, gnu::cold]] static view_part unpacked(std::span<const std::byte> bytes);
};

/// Adds a form made of faces, given as corners of polygons one after the other and the end of each,
/// unless `sent` has it. Returns its identity.
[[gnu::cold]] std::uint64_t add_form(view_part& to, plain_vector<std::uint64_t>& sent,
                                     std::span<const vec3> points,
                                     std::span<const std::uint32_t> corners,
                                     std::span<const std::uint32_t> ends);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/io/detail/view_part_definitions.hpp"
#endif
