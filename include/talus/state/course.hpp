#pragma once
// The calls of simulate() of a run, in sequence: a restart finds its position among them.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace talus::detail {

/// Consecutive equal calls of simulate().
struct course_part {
  std::uint64_t asked = 0;  ///< requested steps of each call
  std::uint64_t taken = 0;  ///< steps that each made
  std::uint64_t calls = 0;  ///< 0: one call that had not ended
  bool stopped = false;     ///< whether stop() or a condition ended it

  [[nodiscard]] bool alike(const course_part& x) const {
    return asked == x.asked && taken == x.taken && stopped == x.stopped;
  }
};

class course {
 public:
  void begin(std::uint64_t asked, std::uint64_t steps);
  /// The call under way ends with this step.
  void stop() {
    if (now_) now_->stopped = true;
  }
  void end(std::uint64_t steps);
  /// All calls so far; the present one ends after that step.
  [[nodiscard]] std::vector<course_part> parts(std::uint64_t steps) const;

 private:
  std::vector<course_part> past_;
  std::optional<course_part> now_;
  std::uint64_t from_ = 0;  ///< the first step of the present call
};

/// The calls of the run that wrote a checkpoint, in their order.
class past_course {
 public:
  past_course() = default;
  explicit past_course(std::vector<course_part> parts) : parts_(std::move(parts)) {}

  [[nodiscard]] bool known() const { return !parts_.empty(); }
  /// The calls of that run, including the last one.
  [[nodiscard]] std::uint64_t calls() const;
  /// The call of that number, from 0; nothing after the last.
  [[nodiscard]] const course_part* find(std::uint64_t call) const;

 private:
  std::vector<course_part> parts_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/state/course_definitions.hpp"
#endif
