#pragma once
// The numbers of which the monitors of one rank consist: to store them in a checkpoint.
#include "talus/world/monitors.hpp"

namespace talus::detail {

/// What all ranks together have: the sum of a number over the ranks, or the largest.
enum class over_ranks { sum, largest };

/// Calls f(number, over_ranks) for the parts of what is stored.
template <class F>
class number_visitor {
 public:
  explicit number_visitor(F& f) : f_(f) {}

  void sum(double& x) { f_(x, over_ranks::sum); }
  void sum(vec3& v) {
    for (int k = 0; k < 3; ++k) sum(v[k]);
  }
  template <class Value>
  void sum(compensated_sum<Value>& x) {
    x.each_part([&](Value& part) { sum(part); });
  }
  void sum(std::uint64_t& n) {
    auto x = static_cast<double>(n);
    sum(x);
    n = x >= 0 && x < 9e15 ? static_cast<std::uint64_t>(x) : 0;
  }
  void largest(double& x) { f_(x, over_ranks::largest); }
  void largest(bool& b) {
    double x = b;
    largest(x);
    b = x != 0;
  }
  template <class... Numbers>
  void sums(Numbers&... numbers) {
    (sum(numbers), ...);
  }

 private:
  F& f_;
};

template <class F>
void each_number(energy_record& r, F&& f) {
  number_visitor visit(f);
  for (energy_sums* s : {&r.before, &r.after}) visit.sums(s->kinetic, s->potential, s->scale);
  for (energy_flows* e : {&r.step, &r.total})
    visit.sums(e->work, e->friction, e->impact, e->damping, e->correction, e->scheme, e->sleep);
  visit.sums(r.initial, r.changes, r.closure, r.scale);
  visit.largest(r.worst);
  visit.largest(r.started);
}
template <class F>
void each_number(spring_record& r, F&& f) {
  number_visitor visit(f);
  visit.sums(r.spring_power, r.dashpot_power, r.friction_power);
  visit.sums(r.normal, r.across_before, r.across, r.yielded);
  visit.sums(r.start, r.across_at_start, r.stored, r.moved);
  visit.largest(r.started);
}
template <class F>
void each_number(momentum_record& r, F&& f) {
  number_visitor visit(f);
  visit.sums(r.before, r.after, r.gravity, r.forces, r.damping, r.ground, r.ground_force);
  visit.sums(r.mass, r.size);
}
template <class F>
void each_number(overlap_record& r, F&& f) {
  number_visitor visit(f);
  visit.sums(r.sum, r.count);
  visit.largest(r.deepest);
  visit.largest(r.worst);
}

/// Calls f(name, record) for the monitors that the scenario names.
template <class Scenario, class F>
void each_monitor(monitor_records<typename Scenario::features>& all, F&& f) {
  if constexpr (watches<Scenario, energy_ledger>) f("energy", all.energy);
  if constexpr (!std::is_empty_v<decltype(all.springs)>) f("springs", all.springs);
  if constexpr (watches<Scenario, momentum_balance>) f("momentum", all.momentum);
  if constexpr (watches<Scenario, penetration_monitor>) f("overlaps", all.overlaps);
}

}  // namespace talus::detail
