#pragma once
// The version of talus; CMakeLists.txt has the same.

namespace talus {

inline constexpr const char* version = "0.1.0";

}  // namespace talus
