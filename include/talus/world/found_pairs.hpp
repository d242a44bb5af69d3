#pragma once
// Pairs of bodies that may touch, as they were found last; see world/close_pairs.hpp.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "talus/contact/place.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

struct close_pair {
  std::uint32_t i, j;  ///< indices into the bodies of two shapes
  history_place last;  ///< where the history keeps what their contacts had in the last step
};

/// One list for each pair of shapes, and where the bodies were when the pairs were found.
struct found_pairs {
  struct body {
    system_id id = no_id;
    vec3 position{0, 0, 0};
    real reach = 0;  ///< with its skin
  };
  std::vector<plain_vector<close_pair>> lists;
  plain_vector<body> bodies;
  bool known = false;
  int steps = 0;  ///< for which they have held
  int pause = 0;  ///< steps for which keeping pairs is not worth it: bodies move too fast

  [[nodiscard]] std::size_t bytes() const {
    std::size_t sum = bodies.capacity() * sizeof(body);
    for (const auto& list : lists) sum += list.capacity() * sizeof(close_pair);
    return sum;
  }
};

}  // namespace talus::detail
