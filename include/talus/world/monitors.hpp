#pragma once
// What the monitors of a scenario hold on one rank. Sums over ranks are made when somebody asks
// (observe/), never in a step.
#include <algorithm>
#include <cstdint>

#include "talus/body/features.hpp"
#include "talus/core/compensated_sum.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

/// Energy that came into the motion of the bodies, or left it. Each entry is computed by itself.
struct energy_flows {
  double work = 0;        ///< done by forces and torques of the user, and by fixed bodies with a
                          ///< velocity on what they carry along
  double friction = 0;    ///< dissipated by tangential impulses
  double impact = 0;      ///< dissipated by normal impulses
  double damping = 0;     ///< dissipated by damping
  double correction = 0;  ///< added by the correction of overlaps
  double scheme = 0;      ///< added by the time stepping: -m g^2 dt^2/2 per step of a free fall,
                          ///< and what the scheme of rotation does
  double sleep = 0;       ///< dissipated where islands went to sleep

  [[nodiscard]] double net() const {
    return work + correction + scheme - friction - impact - damping - sleep;
  }
  energy_flows& operator+=(const energy_flows& x) {
    work += x.work, friction += x.friction, impact += x.impact;
    damping += x.damping, correction += x.correction, scheme += x.scheme;
    sleep += x.sleep;
    return *this;
  }
};

namespace detail {

/// Kinetic and potential energy, and the sum of their absolute values over the bodies.
struct energy_sums {
  double kinetic = 0, potential = 0, scale = 0;
};

struct energy_record {
  /// Of one body over a step: half the sum of its velocities before and after. With it the work of
  /// impulses that act together is the sum of their works.
  struct mean_velocity {
    vec3 v, w;
  };
  struct running_flows {
    compensated_sum<double> work, friction, impact, damping, correction, scheme, sleep;
    [[nodiscard]] energy_flows value() const {
      return {work.value(),       friction.value(), impact.value(), damping.value(),
              correction.value(), scheme.value(),   sleep.value()};
    }
  };

  running_flows running;      ///< of the step under way
  double exchanged = 0;       ///< sum of the absolute values of what contacts give, in this step
  energy_sums before, after;  ///< of the last step
  energy_flows step, total;
  double initial = 0;  ///< energy at the start of the first step
  double changes = 0;  ///< of energy by the user, between the steps
  double closure = 0;  ///< what the last step's entries leave open
  double scale = 0;    ///< of the energies that met in the last step
  double worst = 0;    ///< largest |closure| over scale of all steps
  bool started = false;
  plain_vector<mean_velocity> mean;  ///< of all bodies known here, in the solver's order
};

/// Of soft contacts, beside the energy_record: what their springs hold, of contacts that count
/// here.
struct spring_record {
  /// Of fixed bodies that move, on others; for the present forces.
  compensated_sum<double> spring_power, dashpot_power, friction_power;
  /// Energies when forces were last measured: along the normal, and across it (and of rolling)
  /// before and after the springs were brought forward; what yielded between.
  compensated_sum<double> normal, across_before, across, yielded;
  compensated_sum<double> released;  ///< of `normal`, given up when the memory changed
  double start = 0;                  ///< energy at the start of the step
  double across_at_start = 0;
  double stored = 0;  ///< and at its end
  double moved = 0;   ///< energy of the bodies that came to this rank within the step
  bool started = false;

  void measure_anew() {
    spring_power = dashpot_power = friction_power = {};
    normal = across_before = across = yielded = released = {};
  }
};

struct momentum_record {
  compensated_sum<vec3> before, after;  ///< momentum of the bodies owned here
  compensated_sum<vec3> gravity, forces, damping;
  compensated_sum<vec3> ground;  ///< from global and fixed bodies
  vec3 ground_force{0, 0, 0};    ///< of soft contacts, now
  double mass = 0, size = 0;     ///< of the bodies that can move; sum of |m v|
};

struct overlap_record {
  double sum = 0, deepest = 0;  ///< of the last step
  std::uint64_t count = 0;
  double worst = 0;  ///< of all steps

  void reset() { sum = 0, deepest = 0, count = 0; }
  void add(real gap) {
    if (!(gap < 0)) return;
    sum -= gap, ++count;
    deepest = std::max(deepest, -gap);
    worst = std::max(worst, -gap);
  }
};

template <int>
struct no_record {};

template <class Features, class Feature, class Record, int Number>
using record_for = std::conditional_t<contains_type<Features, Feature>, Record, no_record<Number>>;

/// One record for each monitor that is named; empty without any.
template <class Features>
struct monitor_records {
  [[no_unique_address]] record_for<Features, energy_ledger, energy_record, 0> energy;
  [[no_unique_address]] record_for<Features, split_contact_forces, spring_record, 3> springs;
  [[no_unique_address]] record_for<Features, momentum_balance, momentum_record, 1> momentum;
  [[no_unique_address]] record_for<Features, penetration_monitor, overlap_record, 2> overlaps;
};

template <class Scenario, class Feature>
inline constexpr bool watches = contains_type<typename Scenario::features, Feature>;

}  // namespace detail
}  // namespace talus
