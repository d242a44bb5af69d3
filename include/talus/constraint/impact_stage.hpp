#pragma once
// The order in which the sweeps of a step treat impacts.
#include <limits>
namespace talus::detail {

/// What a sweep does with impacts before it solves a contact. After the first sweep, contacts with
/// a gap are *released* if other impulses drive them together: the limit -gap/dt would stop the
/// surfaces without rebound. In the last sweeps they are *struck*: each rebounds as an impact of
/// its two bodies alone, with all impulses of impacts before *held*. From then on contacts that
/// have rebounded add what the limit needs, and take nothing back.
enum class impact_stage : char { none, release, strike };

/// Which sweeps of a step release and strike. With a tolerance, strikes begin when the solution
/// before them is reached.
class impact_schedule {
 public:
  impact_schedule(int sweeps, bool by_tolerance, bool strikes)
      : strikes_(strikes),
        first_(strikes && !by_tolerance && sweeps >= 3 ? sweeps - (3 * sweeps + 5) / 10 : never) {}
  [[nodiscard]] impact_stage stage(int k) const {
    if (k >= first_) return impact_stage::strike;
    return strikes_ && k == 1 ? impact_stage::release : impact_stage::none;
  }
  /// The first sweep that strikes.
  [[nodiscard]] int first() const { return first_; }
  /// The sweeps before `k` have reached the solution. Returns whether strikes are still to come.
  [[nodiscard]] bool begins(int k) {
    if (!strikes_ || first_ < never) return false;
    first_ = k;
    return true;
  }

 private:
  static constexpr int never = std::numeric_limits<int>::max();
  bool strikes_;
  int first_;
};

}  // namespace talus::detail
