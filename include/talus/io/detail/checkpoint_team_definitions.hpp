#pragma once
// The definitions of checkpoint_team.hpp, in the compiled part or in each program.
#include "talus/io/detail/checkpoint_team.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE void checkpoint_team::agree(const std::string& problem) {
  std::uint64_t any = !problem.empty();
  most(std::span(&any, 1));
  if (any == 0) return;
  byte_buffer mine;
  for (const char c : problem) mine.push_back(static_cast<std::byte>(c));
  for (const byte_buffer& words : gather_all(mine))
    if (!words.empty())
      throw std::runtime_error(
          std::string(reinterpret_cast<const char*>(words.data()), words.size()));
}

}  // namespace talus::detail
