#pragma once
// How a decomposition says that a size of it is known only when the program runs.
namespace talus {

/// In place of a size in a type: chosen when the program runs.
inline constexpr int dynamic = -1;

}  // namespace talus
