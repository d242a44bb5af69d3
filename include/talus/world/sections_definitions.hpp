#pragma once
// The definitions of sections.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/world/sections.hpp"

namespace talus::detail {

TALUS_INLINE void open_sections::require_all_ranks(const char* what, int rank) const {
  if (exclusive)
    fail<std::runtime_error>(
        "{} was called inside an exclusive section on rank {}, but all ranks must take part: "
        "move "
        "the call behind the section",
        what, rank);
}

TALUS_INLINE void open_sections::refuse_in_global(const char* what, int rank) const {
  if (global)
    fail<std::logic_error>(
        "{} was called inside a global section on rank {}, but each body it makes belongs to one "
        "rank: call it outside of the section, or use add",
        what, rank);
}

}  // namespace talus::detail

namespace talus {

TALUS_INLINE exclusive_section::exclusive_section(detail::open_sections& open, int wanted, int rank,
                                                  int ranks)
    : open_(open) {
  if (open.exclusive)
    detail::fail<std::runtime_error>(
        "an exclusive section was opened inside another one on rank {}: close the first before "
        "the "
        "second",
        rank);
  if (open.global)
    detail::fail<std::logic_error>(
        "an exclusive section was opened inside a global section on rank {}: global bodies are "
        "made "
        "alike on all ranks, so put the section before or behind it",
        rank);
  if (wanted < 0 || wanted >= ranks)
    detail::fail<std::invalid_argument>(
        "there is no rank {} for an exclusive section: this job has {} rank(s), numbered from 0",
        wanted, ranks);
  active_ = wanted == rank;
  open_.exclusive = active_;
}

TALUS_INLINE global_section::global_section(detail::open_sections& open, int rank) : open_(open) {
  if (open.global)
    detail::fail<std::runtime_error>(
        "a global section was opened inside another one on rank {}: one is enough", rank);
  if (open.exclusive)
    detail::fail<std::logic_error>(
        "a global section was opened inside an exclusive section on rank {}: global bodies must "
        "be "
        "made on all ranks, so move it behind the section",
        rank);
  open_.global = true;
}

}  // namespace talus
