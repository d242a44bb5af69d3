#pragma once
// The order in which the sweeps of a step treat impacts.
namespace talus::detail {

/// What a sweep does with impacts before it solves a contact. After the first sweep, contacts with a
/// gap are *released* if other impulses drive them together: the limit -gap/dt would stop the
/// surfaces without rebound. In the last sweeps they are *struck*: each rebounds as an impact of its
/// two bodies alone, with all impulses of impacts before *held*. From then on contacts that have
/// rebounded add what the limit needs, and take nothing back.
enum class impact_stage : char { none, release, strike };

/// The first of `count` sweeps that strikes.
[[nodiscard]] inline int first_strike(int count) {
  return count < 3 ? count : count - (3 * count + 5) / 10;
}

/// The stage of sweep `k` of `count`.
[[nodiscard]] inline impact_stage stage_of(int k, int count) {
  if (k >= first_strike(count)) return impact_stage::strike;
  return k == 1 ? impact_stage::release : impact_stage::none;
}

}  // namespace talus::detail
