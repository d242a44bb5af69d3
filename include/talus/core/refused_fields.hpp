#pragma once
// Refusal of a braced list with a field that an options struct lacks: one sentence lists the
// fields, instead of a list of candidates. Beside a function of such a struct stands
//
//   template <detail::sentence Fields = detail::fields::material>
//   detail::fields::no_material<Fields> material(...) TALUS_REFUSED;
// which overload resolution takes only if the braces fit no struct. g++ prints the sentence when it
// refuses the deleted function, clang when it instantiates the returned type.
#include <cstddef>

namespace talus::detail {

/// A text that can be a template argument.
template <std::size_t N>
struct sentence {
  char words[N];
  consteval sentence(const char (&text)[N]) : words() {
    for (std::size_t i = 0; i < N; ++i) words[i] = text[i];
  }
};
/// Whether the type with the sentence may be instantiated: yes with g++, which prints it before, no
/// with clang.
template <sentence>
#ifdef __clang__
inline constexpr bool unrefused = false;
#else
inline constexpr bool unrefused = true;
#endif

}  // namespace talus::detail

#ifdef __clang__
#define TALUS_REFUSED
#else
#define TALUS_REFUSED = delete
#endif
