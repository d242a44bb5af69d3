#pragma once
// Values that are computed once, and kept in checkpoints. A member function of world.
#include <array>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "talus/core/bytes.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/world/world.hpp"

#ifdef __has_builtin
#if __has_builtin(__builtin_clear_padding)
#define TALUS_CLEARS_PADDING
#endif
#endif

namespace talus {

namespace detail {

/// Collective: whether all ranks have this value. Values without == are compared by their bytes,
/// where the compiler can leave out bytes between members; elsewhere they count as equal.
template <class Link, class T>
[[nodiscard, gnu::cold]] bool alike_on_ranks(Link& link, int rank, const T& value) {
  T plain = value;
#ifdef TALUS_CLEARS_PADDING
  __builtin_clear_padding(&plain);
  constexpr bool compares = true;
#else
  constexpr bool compares =
      std::equality_comparable<T> || std::has_unique_object_representations_v<T>;
#endif
  if constexpr (!compares) return true;
  std::array<std::uint64_t, (sizeof(T) + 7) / 8> here{};
  std::memcpy(here.data(), &plain, sizeof(T));
  auto of_first = here;
  if (rank != 0) of_first.fill(0);
  link.reduce(reduction::sum, std::span<std::uint64_t>(of_first));
  double differs = here == of_first ? 0 : 1;
  if constexpr (std::equality_comparable<T>) {
    T first;
    std::memcpy(static_cast<void*>(&first), of_first.data(), sizeof(T));
    if (value == first) differs = 0;
  }
  link.reduce(reduction::max, std::span<double>(&differs, 1));
  return differs == 0;
}

}  // namespace detail

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
        if (!detail::alike_on_ranks(link(), rank(), v))
          detail::fail<std::logic_error>(
              "ranks have different values of world.once for '{}', and a restart has one for all "
              "of "
              "them: combine them, as by world.link().reduce(reduction::max, ...); a handle that "
              "add_if_local gives to one rank stays outside of world.once",
              name);
        return v;
      }
    }
  } else {
    return f();
  }
}

}  // namespace talus

#undef TALUS_CLEARS_PADDING
