#pragma once
// The work available for islands that sweeps do not solve, and the record of skipped islands.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace talus::detail {

/// In floating-point operations of this rank. Each step adds to the budget of islands in which
/// sweeps would fail, at most as much as about seven sweeps take, or 2e8; the rest is kept for a
/// step in which much must be solved at once, up to fifty times of that (or 2e9). All others, where
/// a solution is only better than sweeps, share a small part of the time that sweeps take.
class island_budget {
 public:
  static constexpr double least = 2e8;
  static constexpr double per_contact = 4000;
  static constexpr double least_kept = 2e9;
  static constexpr double kept_per_contact = 2e5;
  static constexpr double least_spare = 1e5;
  static constexpr double spare_per_contact = 400;  ///< less than a tenth of ten sweeps
  static constexpr double least_kept_spare = 5e6;
  static constexpr double kept_spare_per_contact = 4000;

  /// Whether to search for islands in this step: not for some steps after pause().
  [[nodiscard]] bool due() {
    ++steps_;
    if (wait_ > 0) --wait_;
    if (long_wait_ > 0) --long_wait_;
    if (pause_ == 0) return true;
    --pause_;
    return false;
  }
  void pause() { pause_ = 7; }

  /// Whether to look for long islands besides those that the spare work suffices for: not for some
  /// steps after one in which those that may be long have not been, as in heaps.
  [[nodiscard]] bool looks_for_long() const { return long_wait_ == 0; }
  void note_long(bool found) { long_wait_ = found ? 0 : least_wait; }

  /// Whether to look for large islands that can be balanced, see support_balance. Each failure
  /// doubles the steps until the next attempt.
  [[nodiscard]] bool balances() const { return wait_ == 0; }
  void balanced() { patience_ = least_wait; }
  void not_balanced() { wait_ = patience_ = std::min(2 * patience_, most_wait); }
  void need_no_balance() { wait_ = least_wait; }

  /// Whether stacks of many rows were balanced last time, so that bodies stand on each other.
  [[nodiscard]] bool stands() const { return stands_; }
  void note_stack(bool balanced) { stands_ = balanced; }

  /// Whether the last step ended with nothing left for sweeps to change: then the next may need
  /// only one.
  [[nodiscard]] bool settled() const { return settled_; }
  void settle(bool now) { settled_ = now; }
  /// Estimate of the error of velocities for the largest change in a sweep, from the last search.
  [[nodiscard]] double errors_per_change() const { return errors_; }
  void note_errors(double per_change) { errors_ = per_change; }
  void forget_errors() { errors_ = unknown; }

  /// The available budget now, with so many contacts.
  [[nodiscard]] double open(std::size_t contacts) {
    const auto n = static_cast<double>(contacts);
    const double most = std::max(least_kept, kept_per_contact * n);
    const double more = kept_ + steps_ * std::max(least, per_contact * n);
    kept_ = kept_ < 0 ? most : std::max(kept_, std::min(most, more));
    const double most_spare = std::max(least_kept_spare, kept_spare_per_contact * n);
    const double more_spare = spare_ + steps_ * std::max(least_spare, spare_per_contact * n);
    spare_ = std::min(most_spare, more_spare);
    steps_ = 0;
    return kept_;
  }
  void close(double left) { spent_ += kept_ - left, kept_ = left; }

  /// For islands in which sweeps would not fail.
  [[nodiscard]] double spare() const { return std::max(spare_, 0.); }
  void spend_spare(double operations) { spent_ += operations, spare_ -= operations; }

  /// An island that was left to the sweeps because its solution would have cost too much.
  void skip(std::size_t contacts) {
    ++skipped_;
    skipped_contacts_ = std::max(skipped_contacts_, static_cast<std::uint64_t>(contacts));
  }
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }  ///< in all steps of this run
  [[nodiscard]] std::uint64_t skipped_contacts() const { return skipped_contacts_; }  ///< at most
  void solved() { ++solved_; }
  [[nodiscard]] double spent() const { return spent_; }                   ///< in all steps
  [[nodiscard]] std::uint64_t islands_solved() const { return solved_; }  ///< in all steps

  /// Sets the state of the beginning of a run, except for the counts.
  void begin_afresh() {
    pause_ = 0, steps_ = 0, wait_ = 0, long_wait_ = 0, patience_ = least_wait, kept_ = -1;
    spare_ = unknown;
    settled_ = stands_ = false, errors_ = unknown;
  }

 private:
  static constexpr double unknown = std::numeric_limits<double>::infinity();
  static constexpr int least_wait = 8, most_wait = 512;
  int pause_ = 0, steps_ = 0;
  int wait_ = 0, patience_ = least_wait;  ///< steps, for large islands
  int long_wait_ = 0;
  bool settled_ = false, stands_ = false;
  double errors_ = unknown;
  double spare_ = unknown;  ///< at first the largest amount that may be kept
  double kept_ = -1;        ///< negative: likewise
  double spent_ = 0;
  std::uint64_t solved_ = 0, skipped_ = 0, skipped_contacts_ = 0;
};

}  // namespace talus::detail
