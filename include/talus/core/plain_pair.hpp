#pragma once
// Two values side by side. std::pair has an assignment of its own, so that its bytes may not be
// copied.
#include <compare>

namespace talus::detail {

template <class First, class Second>
struct plain_pair {
  First first;
  Second second;
  friend auto operator<=>(const plain_pair&, const plain_pair&) = default;
};
template <class First, class Second>
plain_pair(First, Second) -> plain_pair<First, Second>;

}  // namespace talus::detail
