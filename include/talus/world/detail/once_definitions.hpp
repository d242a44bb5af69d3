#pragma once
// Values that are computed once, and kept in checkpoints. A member function of world.
#include <concepts>
#include <cstring>
#include <type_traits>

#include "talus/core/bytes.hpp"
#include "talus/world/world.hpp"

namespace talus {

template <class Scenario>
template <class F>
auto world<Scenario>::once(const std::string& name, F&& f) {
  using value = std::invoke_result_t<F&>;
  constexpr bool nothing = std::is_void_v<value>;
  constexpr bool fits =
      nothing || (detail::plain_bytes<value> && std::default_initializable<value>);
  static_assert(fits,
                "world.once takes a function that returns nothing, or a value that owns no memory, "
                "such as a number, a vec3 or a handle: keep its parts one by one");
  if constexpr (detail::require_feature<Scenario, checkpoints>() && fits) {
    sections_.require_all_ranks("once", rank());
    if (const detail::once_value* const past = keeper_.find_once(name)) {
      if (keeper_.skipped > 0) fills_ = past->fills, attempts_ = past->attempts;
      if constexpr (nothing) {
        return;
      } else {
        if (past->bytes.size() != sizeof(value))
          detail::fail<std::runtime_error>(
              "the checkpoint has another type of value of world.once for '{}': its type must stay "
              "the same",
              name);
        value v;
        std::memcpy(static_cast<void*>(&v), past->bytes.data(), sizeof(value));
        return v;
      }
    } else {
      const auto added = added_here_;
      const auto before = state_.steps;
      const detail::parameters given = detail::parameters_of(state_);
      const auto note = [&](detail::byte_buffer bytes) {
        if (added_here_ != added)
          detail::fail<std::logic_error>(
              "a body was added by add(...) in world.once for '{}' on rank {}, and its id depends "
              "on "
              "the ranks: use add_if_local or fill, or add it outside",
              name, rank());
        if (state_.steps != before)
          detail::fail<std::logic_error>(
              "the function of world.once for '{}' makes steps, which a restart would leave out: "
              "call simulate outside of it",
              name);
        if (detail::parameters_of(state_) != given)
          detail::fail<std::logic_error>(
              "the function of world.once for '{}' changes a parameter of the world, such as "
              "gravity, which a restart would leave out: change it outside of world.once",
              name);
        keeper_.once.push_back({name, std::move(bytes), fills_, attempts_, true});
      };
      if constexpr (nothing) {
        f();
        note({});
      } else {
        const value v = f();
        const auto* const at = reinterpret_cast<const std::byte*>(&v);
        note({at, at + sizeof(value)});
        return v;
      }
    }
  } else {
    return f();
  }
}

}  // namespace talus
