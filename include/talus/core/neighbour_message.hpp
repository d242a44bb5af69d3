#pragma once
// The messages between one rank and one of its neighbours in one exchange.
#include "talus/core/bytes.hpp"

namespace talus {

/// One message each way between this rank and `rank`, reused from exchange to exchange. From
/// start() to finish() neither buffer may be touched. After finish() `in` holds the message of the
/// neighbour and `out` is empty; after finish_fixed() `out` keeps its size, but not its content.
/// (Ranks inside one process swap buffers instead of copying them.)
struct neighbour_message {
  int rank = -1;
  detail::byte_buffer out{};
  detail::byte_buffer in{};
};

}  // namespace talus
