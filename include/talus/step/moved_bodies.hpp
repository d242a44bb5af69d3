#pragma once
// A joint and the bodies of joints, while these are moved to where the joints hold.
#include <cstddef>
#include <cstdint>

#include "talus/constraint/joint_geometry.hpp"
#include "talus/constraint/line_writer.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/articulations.hpp"
#include "talus/state/joint_table.hpp"

namespace talus::detail {

/// A joint, with its bodies in the numbers of joint_table::ends, or of an island.
struct moved_joint {
  std::uint32_t kind;  ///< its place in joints<...>
  joint_key key;
  const joint_frames* frames;
  const void* anchors;
  void (*write)(const void*, line_writer&);
  const joint_coordinates* coordinates;  ///< at the start of the step, or in its middle
  joint_view solved;                     ///< its rows in the solver
  std::int32_t a, b;
  std::size_t first = 0;  ///< of its rows here
  real arm = 0;           ///< the sum of its arms
  real length = 0;        ///< the sum of the lengths of which its errors consist
};

/// A body of joints after the integration of a step.
struct moved_body {
  enum class change : std::uint8_t { none, position, step };
  joint_end end;
  vec3 inertia{0, 0, 0};                ///< principal moments
  mat3 inverse_inertia = mat3::Zero();  ///< as the solver has it
  vec3 turn{0, 0, 0};                   ///< by the position correction
  change by_joints = change::none;

  [[nodiscard]] real inverse_mass() const { return end.moves ? end.inverse_mass : real(0); }
};

/// Bodies of joints with changes of their velocities, or displacements.
class moved_bodies {
 public:
  explicit moved_bodies(const plain_vector<moved_body>& of)
      : of_(of), motions_(of.size(), body_motion{}) {}
  /// Moments of inertia that are added to those of a body, if the sum is positive definite.
  void stiffen(std::int32_t k, const mat3& by) {
    if (added_.empty()) added_.assign(of_.size(), mat3::Zero());
    added_[index(k)] += by;
  }
  void end_stiffening() { added_.clear(); }
  [[nodiscard]] std::size_t size() const { return of_.size(); }
  [[nodiscard]] bool moves(std::int32_t k) const { return of_[index(k)].end.moves; }
  [[nodiscard]] real inverse_mass(std::int32_t k) const { return of_[index(k)].inverse_mass(); }
  [[nodiscard]] const mat3& own_inverse_inertia(std::int32_t k) const {
    return of_[index(k)].inverse_inertia;
  }
  [[nodiscard]] mat3 inverse_inertia(std::int32_t k) const {
    const mat3& own = own_inverse_inertia(k);
    if (added_.empty()) return own;
    const mat3 sum = own.inverse() + added_[index(k)];
    const real minor = sum(0, 0) * sum(1, 1) - sum(0, 1) * sum(1, 0);
    const bool definite = sum(0, 0) > 0 && minor > 0 && sum.determinant() > 0;
    return definite ? sum.inverse() : own;
  }
  [[nodiscard]] const body_motion& motion(std::int32_t k) const { return motions_[index(k)]; }
  void add(std::int32_t k, const body_motion& d) {
    body_motion& x = motions_[index(k)];
    x.v += d.v, x.w += d.w;
  }
  void set(std::int32_t k, const body_motion& to) { motions_[index(k)] = to; }
  void clear() { motions_.assign(of_.size(), body_motion{}); }

 private:
  static std::size_t index(std::int32_t k) { return static_cast<std::size_t>(k); }
  const plain_vector<moved_body>& of_;
  plain_vector<body_motion> motions_;
  plain_vector<mat3> added_;
};

}  // namespace talus::detail
