#pragma once
// The time that ranks wait for each other before a report names the rank that keeps them waiting,
// and before the run ends.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "talus/core/error.hpp"
#include "talus/parallel/launch_settings.hpp"

namespace talus::detail {

/// The settings and the last reports, for the ranks of a process.
class wait_monitor {
  using clock = std::chrono::steady_clock;

 public:
  wait_monitor() = default;  ///< reports nothing
  explicit wait_monitor(const launch_settings& how)
      : patience_(how.patience), give_up_(how.give_up), report_(how.report) {}
  wait_monitor(wait_monitor&& other) noexcept
      : patience_(other.patience_), give_up_(other.give_up_), report_(std::move(other.report_)) {}
  wait_monitor& operator=(wait_monitor&& other) noexcept;

  [[nodiscard]] bool active() const { return patience_ > 0; }
  [[nodiscard]] double patience() const { return patience_; }
  /// Seconds of waiting after which the run ends; 0: never.
  [[nodiscard]] double end_after() const { return give_up_ > 0 ? patience_ + give_up_ : 0; }

  /// True for one caller in each period of ten times the patience, and for one that ends the run.
  [[nodiscard]] bool mine_to_report(bool ends);
  [[gnu::cold]] void report(const std::string& stuck, const std::string& waiting, bool ends) const {
    report_(text(stuck, waiting, ends));
  }
  [[nodiscard, gnu::cold]] std::string text(const std::string& stuck, const std::string& waiting,
                                            bool ends) const;

 private:
  double patience_ = 0, give_up_ = 0;
  std::function<void(const std::string&)> report_;
  std::atomic<std::int64_t> silent_until_ = 0;  ///< milliseconds
  std::atomic<bool> ends_ = false;
};

/// The time of one wait.
class wait_clock {
  using clock = std::chrono::steady_clock;

 public:
  explicit wait_clock(const wait_monitor& how) : how_(how), began_(clock::now()) {}

  /// Time until the next check: first the patience, then a second or the rest until the end of the
  /// run.
  [[nodiscard]] std::chrono::duration<double> next() const;
  /// Whether the wait has exceeded the limit of the run.
  [[nodiscard]] bool passed() const {
    return how_.end_after() > 0 && seconds() >= how_.end_after();
  }
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(clock::now() - began_).count();
  }

 private:
  const wait_monitor& how_;
  clock::time_point began_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/parallel/detail/wait_watch_definitions.hpp"
#endif
