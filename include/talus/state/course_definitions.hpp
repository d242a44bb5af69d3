#pragma once
// The definitions of course.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/state/course.hpp"

namespace talus::detail {

TALUS_INLINE void course::begin(std::uint64_t asked, std::uint64_t steps) {
  now_ = course_part{.asked = asked};
  from_ = steps;
}

TALUS_INLINE void course::end(std::uint64_t steps) {
  if (!now_) return;
  now_->taken = steps - from_;
  now_->calls = 1;
  if (!past_.empty() && past_.back().alike(*now_))
    ++past_.back().calls;
  else
    past_.push_back(*now_);
  now_.reset();
}

TALUS_INLINE std::vector<course_part> course::parts(std::uint64_t steps) const {
  std::vector<course_part> all = past_;
  if (now_) all.push_back({now_->asked, steps - from_, now_->stopped ? 1u : 0u, now_->stopped});
  return all;
}

TALUS_INLINE std::uint64_t past_course::calls() const {
  std::uint64_t n = 0;
  for (const course_part& p : parts_) n += std::max<std::uint64_t>(p.calls, 1);
  return n;
}

TALUS_INLINE const course_part* past_course::find(std::uint64_t call) const {
  for (const course_part& p : parts_) {
    const std::uint64_t n = std::max<std::uint64_t>(p.calls, 1);
    if (call < n) return &p;
    call -= n;
  }
  return nullptr;
}

}  // namespace talus::detail
