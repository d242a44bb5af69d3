#pragma once
// Time stepping of a world. Member functions of world.
#include "talus/world/world.hpp"

namespace talus {

template <class Scenario>
body_count world<Scenario>::audit() {
  sections_.require_all_ranks("audit", rank());
  note_reading("world.audit");
  const body_count here = detail::count_owned(state_);
  std::array<std::uint64_t, 4> sums{here.bodies, here.ids, state_.made.bodies, state_.made.ids};
  state_.link->reduce(reduction::sum, std::span(sums));
  const body_count all{sums[0], sums[1]}, expected{sums[2], sums[3]};
  if (all != expected) {
    const detail::surplus difference(all, expected);
    detail::fail<std::runtime_error>(
        "{} {} after {} steps: all ranks together own {} bodies, but {} were created and not "
        "destroyed{}",
        difference.text(),
        difference.bodies < 0   ? "is lost"
        : difference.bodies > 0 ? "is there twice"
                                : "is there",
        state_.steps, all.bodies, expected.bodies,
        detail::owners_text(state_, difference.single() ? difference.id : no_id));
  }
  return all;
}

template <class Scenario>
void world<Scenario>::synchronize() {
  sections_.require_all_ranks("synchronize", rank());
  detail::close_ledger(state_);
  require_domain();
  if constexpr (!link_type::alone) {
    require_two_sided_connections();
    detail::match_connections(state_);
    detail::share_connections(state_);
    for (int round = 0;; ++round) {
      std::uint64_t passing = detail::migrate(state_, false);
      state_.link->reduce(reduction::sum, std::span(&passing, 1));
      if (passing == 0) break;
      if (round > ranks())
        detail::fail<std::runtime_error>(
            "{} bodies do not find the way to the rank that owns their centre: check_connections() "
            "says what is missing",
            passing);
    }
    detail::refuse_closed_faces(state_, false);
    state_.choice.reach.clear();  // domains may have changed
    // The first round sends the reach of bodies to every neighbour, the second uses it. The reach
    // of copies that the first brought is sent by the second and used by the third.
    for (int round = 0; round < 3; ++round) detail::share_shadow_copies(state_, true);
  }
  if constexpr (detail::world_state<Scenario>::filters) detail::note_filters(state_);
  if constexpr (detail::world_state<Scenario>::sleeps) detail::note_sleepers(state_);
  state_.note_changes_sent();
  rewired_ = false;
  synchronized_ = true;
}

template <class Scenario>
void world<Scenario>::step(real dt) {
  sections_.require_all_ranks("step", rank());
  if (sections_.global)
    detail::fail<std::logic_error>(
        "step was called inside a global section on rank {}: close the section first", rank());
  detail::require_positive(dt, "the time step dt");
  if constexpr (keeps) {
    if (keeper_.hooks != nullptr) keeper_.hooks->refuse_step_before_restart();
    if (!keeper_.given) keeper_.note_given(detail::parameters_of(state_));
  }
  if constexpr (!Scenario::contact_law::soft) {
    const solver_settings& how = state_.settings;
    if (!(how.tolerance >= 0 && how.tolerance < 1) || how.max_iterations < 1)
      detail::fail<std::invalid_argument>(
          "the tolerance of the solver is a contact residual in (0, 1), or 0 for a fixed number of "
          "iterations, and at least 1 iteration is allowed for it, but they are {} and {}",
          how.tolerance, how.max_iterations);
    if (how.iterations < 1 || how.correction_iterations < 0 ||
        !(how.correction >= 0 && how.correction <= 1))
      detail::fail<std::invalid_argument>(
          "the solver needs at least 1 iteration, 0 of the correction, and a part of the overlap "
          "in "
          "[0, 1] to correct, but has {}, {} and {}",
          how.iterations, how.correction_iterations, how.correction);
    // Neighbours receive the reach of bodies in a step before the step.
    if (dt > state_.dt) state_.dt = dt, state_.changed = true;
  }
  if (!synchronized_) synchronize();
  if (rewired_)
    detail::fail<std::runtime_error>(
        "rank {} changed its connections and then called step: call synchronize() on all ranks "
        "first",
        rank());
  if constexpr (balances) look_at_balance_if_due();
  const traffic before = state_.link->counters();
  if constexpr (balances)
    detail::step_with_clock(state_, dt);
  else
    detail::step(state_, dt);
  if (balances || !simulating_) detail::close_ledger(state_);
  const traffic sent = state_.link->counters() - before;
  state_.sent.messages_max = std::max(state_.sent.messages_max, sent.messages);
  state_.sent.bytes_max = std::max(state_.sent.bytes_max, sent.bytes);
  state_.sent.collectives += sent.collectives;
}

template <class Scenario>
void world<Scenario>::stop() {
  if (!simulating_)
    detail::fail<std::logic_error>(
        "stop was called on rank {} while no simulate() is under way: call it in a function given "
        "to world.observe(...), or give the condition to world.stop_when(...)",
        rank());
  stop_asked_ = true;
}

/// Whether the call of simulate() ends with the present step, alike on all ranks.
template <class Scenario>
bool world<Scenario>::ends_now(const simulation& s) {
  if (s.stop_when && state_.steps % s.check_every == 0) {
    detail::close_ledger(state_);
    stop_asked_ = s.stop_when() || stop_asked_;
    agree_ = true;
  }
  if (std::exchange(agree_, false) && ranks() > 1) {
    const detail::stage_clock clock(state_.seconds.exchange);
    double any = stop_asked_;
    state_.link->reduce(reduction::max, std::span(&any, 1));
    stop_asked_ = any != 0;
  }
  return std::exchange(stop_asked_, false);
}

template <class Scenario>
void world<Scenario>::simulate(const simulation& s) {
  sections_.require_all_ranks("simulate", rank());
  detail::require_positive(s.dt, "the time step dt");
  if (s.check_every == 0)
    detail::fail<std::invalid_argument>(
        "simulate was told to ask its condition every 0 steps: give .check_every = 1 or more");
  if (simulating_)
    detail::fail<std::logic_error>(
        "simulate was called on rank {} while another call is under way: let that one end first",
        rank());
  state_.dt = s.dt;
  ++simulations_;
  last_step_ = state_.steps + s.steps;
  stopped_ = false;
  std::size_t steps = s.steps;
  detail::checkpoint_hooks* hooks = nullptr;
  bool restarted = false;
  [[maybe_unused]] std::size_t number_of_checkpoints = 0;
  if constexpr (keeps) {
    if (keeper_.hooks) number_of_checkpoints = state_.functions.number("checkpoints");
    keeper_.note_given(detail::parameters_of(state_));
    keeper_.course.begin(s.steps, state_.steps);
    if (hooks = keeper_.hooks.get(); hooks != nullptr) {
      const detail::restart_plan plan = hooks->begin(s);
      stopped_ = plan.stopped;
      if (stopped_) keeper_.course.stop(), last_step_ = state_.steps;
      if (plan.skips) {
        keeper_.course.end(state_.steps);
        keeper_.after_call = detail::parameters_of(state_);
        return;
      }
      steps = plan.steps;
      restarted = plan.restarts;
    }
  }
  if (!restarted) synchronize();
  // An exception ends it, too.
  struct mark {
    bool& set;
    explicit mark(bool& b) : set(b) { set = true; }
    ~mark() { set = false; }
  } const under_way(simulating_);
  stop_asked_ = agree_ = false;
  laps clock(state_);
  call(starters_, clock);
  for (std::size_t k = 0; k < steps; ++k) {
    if constexpr (keeps)
      if (hooks != nullptr) hooks->before_step(), clock.lap(number_of_checkpoints);
    if (state_.single_steps != nullptr)
      state_.single_steps->measure(state_.steps + 1, [&] { step(s.dt); });
    else
      step(s.dt);
    clock.lap(0);  // other work of steps
    if constexpr (keeps)
      if (hooks != nullptr) hooks->after_step(), clock.lap(number_of_checkpoints);
    call(observers_, clock);
    if (ends_now(s)) {
      stopped_ = true;
      last_step_ = state_.steps;
      if constexpr (keeps) keeper_.course.stop();
    }
    if (s.stop_when) clock.lap(state_.functions.number(detail::name_of_conditions));
    call(writers_, clock);
    if constexpr (keeps)
      if (hooks != nullptr) {
        hooks->after_observers(stopped_ || k + 1 == steps);
        clock.lap(number_of_checkpoints);
      }
    if (stopped_) break;
  }
  if constexpr (keeps) {
    keeper_.course.end(state_.steps);
    keeper_.after_call = detail::parameters_of(state_);
    if (hooks != nullptr) hooks->end_call();
  }
  detail::close_ledger(state_);
  (void)audit();
}

}  // namespace talus
