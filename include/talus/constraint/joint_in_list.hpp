#pragma once
// The rows of a joint as an element of a constraint list. Lists of joints stand beside those of
// contacts in all solvers.
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>

namespace talus::detail {

/// The properties of a joint that lists read, and where its record is.
template <class Row>
struct joint_in_list : Row {
  static constexpr bool is_joint = true;
  static constexpr bool paired = true;     ///< something immovable is in the solver's arrays, too
  static constexpr bool manifolds = true;  ///< two bodies may have several joints
  static constexpr std::size_t streams = 1;
  std::uint32_t record = 0;
};

/// A constraint of a joint, whose impulses have no bounds.
template <class Constraint>
concept is_joint = requires {
  requires std::remove_cvref_t<Constraint>::is_joint;
};

/// Whether some of a tuple of lists hold joints.
template <class Lists>
inline constexpr bool has_joints = false;
template <class... List>
inline constexpr bool has_joints<std::tuple<List...>> =
    (is_joint<typename std::remove_cvref_t<List>::contact_type> || ...);

}  // namespace talus::detail
