#pragma once
// Refers to a joint of a world.
#include <stdexcept>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/state/joint_table.hpp"

namespace talus {

template <class Scenario>
class world;

/// A joint that world.join(...) made; a value on all ranks, as long as its world. The ranks that
/// own one of its bodies hold the joint: only these know its impulse.
template <class Scenario, class Kind>
class joint_handle {
 public:
  /// The type of the impulse: a vector for a ball_joint.
  using impulse_type = typename detail::joint_record<Kind>::impulse_type;

  joint_handle(world<Scenario>& w, const detail::joint_key& key) : world_(&w), key_(key) {}

  /// Whether this rank holds the joint: it owns one of the bodies that can move, and the joint was
  /// not released.
  [[nodiscard]] bool known() const { return world_->find_joint(*this) != nullptr; }
  /// The impulse of the joint on its first body in the last step, in the world. Throws
  /// invalid_argument on a rank that does not hold the joint.
  [[nodiscard]] impulse_type impulse() const {
    if (const auto* r = world_->find_joint(*this)) return r->impulse;
    detail::fail<std::invalid_argument>(
        "rank {} does not hold this {}: it was released, or its bodies live on other ranks (ask "
        "known())",
        world_->rank(), Kind::name);
  }
  /// The mean force on its first body in the last step: the impulse over the length of the step, 0
  /// before the first. Throws as impulse().
  [[nodiscard]] impulse_type force() const {
    const real dt = world_->state_.dt;
    return (dt > 0 ? 1 / dt : real(0)) * impulse();
  }
  /// Removes the joint. All ranks call it alike; throws runtime_error in an exclusive section.
  void release() { world_->release(*this); }

  /// The bodies, in the order in which they were joined, and the number of the joint.
  [[nodiscard]] const detail::joint_key& key() const { return key_; }

 private:
  world<Scenario>* world_;
  detail::joint_key key_;
};

}  // namespace talus
