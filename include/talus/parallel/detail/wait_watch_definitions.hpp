#pragma once
// The definitions of wait_monitor.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/detail/wait_monitor.hpp"

namespace talus::detail {

TALUS_INLINE wait_monitor& wait_monitor::operator=(wait_monitor&& other) noexcept {
  patience_ = other.patience_, give_up_ = other.give_up_;
  report_ = std::move(other.report_);
  return *this;
}

TALUS_INLINE bool wait_monitor::mine_to_report(bool ends) {
  if (ends) return !ends_.exchange(true);
  const std::int64_t now =
      std::chrono::duration_cast<std::chrono::milliseconds>(clock::now().time_since_epoch())
          .count();
  std::int64_t silent = silent_until_.load();
  return now >= silent && silent_until_.compare_exchange_strong(
                              silent, now + static_cast<std::int64_t>(1e4 * patience_));
}

TALUS_INLINE std::string wait_monitor::text(const std::string& stuck, const std::string& waiting,
                                            bool ends) const {
  return compose(
      "{} has kept others waiting for {} seconds{}: {} wait{}; look for a callback or "
      "a loop that does not end there{}",
      stuck, talus::detail::text(ends ? end_after() : patience_, 4),
      ends ? ", and the run ends" : "", waiting, waiting.find(',') == std::string::npos ? "s" : "",
      ends || give_up_ > 0 ? "" : ", or let --give-up SECONDS end such a run");
}

TALUS_INLINE std::chrono::duration<double> wait_clock::next() const {
  const double waited = seconds(), end = how_.end_after();
  if (waited < how_.patience()) return std::chrono::duration<double>(how_.patience() - waited);
  return std::chrono::duration<double>(end > 0 ? std::clamp(end - waited, 0.01, 1.0) : 1.0);
}

}  // namespace talus::detail
