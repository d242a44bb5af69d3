#pragma once
// features<penetration_monitor>: its record. Overlaps are recorded when contacts are made.
#include <algorithm>
#include <cstdint>

#include "talus/core/exact_sum.hpp"
#include "talus/core/math.hpp"
#include "talus/state/monitors.hpp"
#include "talus/state/state.hpp"

namespace talus {
namespace detail {

struct overlap_record {
  exact_sum sum;  ///< of the last step
  double deepest = 0;
  std::uint64_t count = 0;
  double worst = 0;  ///< of all steps

  void reset() { sum = {}, deepest = 0, count = 0; }
  void add(real gap) {
    if (!(gap < 0)) return;
    sum += -gap, ++count;
    deepest = std::max(deepest, -gap);
    worst = std::max(worst, -gap);
  }
  template <class Visitor>
  void each_number(Visitor& visit) {
    visit.sums(sum, count);
    visit.largest(deepest);
    visit.largest(worst);
  }
};

}  // namespace detail

struct penetration_monitor::record {
  detail::overlap_record overlaps;

  template <class F>
  void each_record(F&& f) {
    f("overlaps", overlaps);
  }
};

struct penetration_monitor::hooks {
  template <class Scenario>
  static void before_detect(detail::world_state<Scenario>& s) {
    s.monitors.overlaps.reset();
  }
};

}  // namespace talus
