#pragma once
// The memory of soft contacts whose law reaches beyond touch, with a mark of those that act: the
// law remembers bodies within its range, also while they are apart and without force.
#include <type_traits>

namespace talus::detail {

template <class Memory>
struct acting_memory : Memory {
  bool acts = false;  ///< it carried a force when it was recorded

  acting_memory() = default;
  acting_memory(const Memory& m, bool acts_now = false) : Memory(m), acts(acts_now) {}

  /// Calls f(name, value) for the columns of a checkpoint.
  template <class Self, class F>
  static void each_column(Self& m, F&& f) {
    using base = std::conditional_t<std::is_const_v<Self>, const Memory, Memory>;
    Memory::each_column(static_cast<base&>(m), f);
    f("acts", m.acts);
  }
};

/// Whether a contact with this memory carried a force in the step that recorded it. Of hard
/// contacts the memory is the impulse.
template <class Memory>
[[nodiscard]] bool has_acted(const Memory& m) {
  if constexpr (requires { m.squaredNorm(); })
    return m[0] != 0 || m[1] != 0 || m[2] != 0;
  else if constexpr (requires { m.acts; })
    return m.acts;
  else
    return true;
}

}  // namespace talus::detail
