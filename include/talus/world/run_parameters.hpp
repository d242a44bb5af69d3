#pragma once
// Parameters of a run that its user may change between steps, for checkpoints.
#include <array>
#include <cstddef>

namespace talus::detail {

/// Parameters of a run, in the order in which they are stored.
inline constexpr std::array parameter_names{"dt",         "gravity_x",      "gravity_y",
                                            "gravity_z",  "damping",        "iterations",
                                            "tolerance",  "max_iterations", "correction_iterations",
                                            "correction", "sleeping_speed", "sleeping_time"};
using parameters = std::array<double, parameter_names.size()>;

/// Calls f(number, value) for those of this scenario.
template <class State, class F>
void each_parameter(State& s, F&& f) {
  f(0, s.dt);
  for (int k = 0; k < 3; ++k) f(static_cast<std::size_t>(1 + k), s.gravity[k]);
  f(4, s.damping);
  if constexpr (!State::law::soft) {
    f(5, s.settings.iterations);
    f(6, s.settings.tolerance);
    f(7, s.settings.max_iterations);
    f(8, s.settings.correction_iterations);
    f(9, s.settings.correction);
  }
  if constexpr (State::sleeps) {
    f(10, s.sleep.settings.speed);
    f(11, s.sleep.settings.time);
  }
}
template <class State>
[[nodiscard]] parameters parameters_of(State& s) {
  parameters all{};
  each_parameter(s, [&](std::size_t k, auto& value) { all[k] = static_cast<double>(value); });
  return all;
}

}  // namespace talus::detail
