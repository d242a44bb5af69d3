#pragma once
// The marker for sizes of a decomposition that are known only at run time.
namespace talus {

/// In place of a size in a type: chosen at run time.
inline constexpr int dynamic = -1;

}  // namespace talus
