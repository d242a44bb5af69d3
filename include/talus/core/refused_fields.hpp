#pragma once
// Braces with a field that an options struct does not have: instead of a list of candidates, one
// sentence with the fields there are. Beside a function of such a struct stands
//
//   template <detail::sentence Fields = detail::fields::material>
//   detail::fields::no_material<Fields> material(...) TALUS_REFUSED;
//
// which overload resolution takes only where the braces fit no struct. g++ says the sentence where
// it refuses the deleted function, clang where it makes the type that is returned.
#include <cstddef>

namespace talus::detail {

/// Words that can be an argument of a template.
template <std::size_t N>
struct sentence {
  char words[N];
  consteval sentence(const char (&text)[N]) : words() {
    for (std::size_t i = 0; i < N; ++i) words[i] = text[i];
  }
};
/// Whether the type that says the sentence may be made: with g++, which says it before, and never
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
