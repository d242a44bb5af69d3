#pragma once
// Exclusive and global sections: code for one rank only, and bodies for all of them.
#include <stdexcept>

#include "talus/core/error.hpp"

namespace talus {

namespace detail {

/// The sections that this rank is in.
struct open_sections {
  bool exclusive = false;
  bool global = false;

  /// Throws runtime_error in an exclusive section: `what` involves all ranks, so that calling it on
  /// one of them would wait for the others for ever. This also holds in a serial program.
  void require_all_ranks(const char* what, int rank) const;
  /// Throws logic_error in a global section, whose bodies `what` would not make global.
  void refuse_in_global(const char* what, int rank) const;
};

}  // namespace detail

/// In its lifetime, the code behind `if (section)` runs on one rank only; see world::exclusive.
class exclusive_section {
 public:
  /// Throws runtime_error inside another exclusive section, logic_error inside a global section,
  /// and invalid_argument for a rank that the job does not have.
  exclusive_section(detail::open_sections& open, int wanted, int rank, int ranks);
  exclusive_section(const exclusive_section&) = delete;
  exclusive_section& operator=(const exclusive_section&) = delete;
  ~exclusive_section() {
    if (active_) open_.exclusive = false;
  }
  /// Whether the section is for this rank.
  explicit operator bool() const { return active_; }

 private:
  detail::open_sections& open_;
  bool active_ = false;
};

/// In its lifetime, added bodies are global: known on all ranks, and fixed; see world::global.
class global_section {
 public:
  /// Throws runtime_error inside another global section and logic_error inside an exclusive one.
  global_section(detail::open_sections& open, int rank);
  global_section(const global_section&) = delete;
  global_section& operator=(const global_section&) = delete;
  ~global_section() { open_.global = false; }

 private:
  detail::open_sections& open_;
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/world/sections_definitions.hpp"
#endif
