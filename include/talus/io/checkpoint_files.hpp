#pragma once
// The checkpoints of a run<...>: when they are written (at a fixed number of steps, and on
// signals), and where simulate() continues from one.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "talus/core/clock.hpp"
#include "talus/core/run_lock.hpp"
#include "talus/io/checkpoint.hpp"
#include "talus/io/run_signals.hpp"
#include "talus/world/checkpoints.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

template <class Scenario>
class checkpoint_files final : public checkpoint_hooks {
  /// How often ranks exchange their received signals, in seconds of wall time.
  static constexpr double between_polls = 0.2;
  static constexpr std::uint64_t most_steps_between_polls = 1000;
  /// What a rank has heard, as numbers that are combined by their maximum: one above `end_by` is
  /// the signal that asks for the end.
  enum heard : int { nothing = 0, write = 1, end_by = 2 };

 public:
  /// Installs its hooks between the steps of the world. Collective; throws runtime_error if a file
  /// cannot be written or read, before anything is computed.
  static void attach(world<Scenario>& w, const checkpoint_plan& plan) {
    auto& hooks = checkpoint_access::keeper(w).hooks;
    hooks = std::make_unique<checkpoint_files>(w, plan);
    checkpoint_access::keeper(w).configuration = plan.configuration;
  }
  checkpoint_files(world<Scenario>& w, const checkpoint_plan& plan) : w_(w), plan_(plan) {
    team_over team(w.link());
    team.together([&] {
      if (plan_.from.empty()) return;
      try {
        const checkpoint_reader in(plan_.from);
        require_same_scenario<Scenario>(in);
        waiting_ = in.integers("/run/steps", 1)[0];
        past_ = get_course(in);
        get_once(in, checkpoint_access::keeper(w).once);
        kept_after_calls_ = get_kept_after_calls(in);
        if (in.has("/run/configuration")) configuration_ = in.text("/run/configuration");
      } catch (const std::exception& e) {
        const std::string why = e.what();
        fail<std::runtime_error>(
            "the checkpoint {} {}{}", plan_.from, why,
            why.starts_with("cannot be read:")
                ? "; --restart takes a file that --checkpoint has written: look "
                  "for it, or leave --restart out to begin at the beginning"
            : why.starts_with("is damaged:")
                ? "; copy it again from where it was written, or take an older one"
                : "");
      }
    });
    if (plan_.to.empty()) return;
    checkpoint_kind kind;
    const bool replaces = team_writer(team, kind, plan_.to, plan_.force).require_writable();
    team.together([&] {
      if (w.rank() == 0) take_lock(replaces);
    });
  }

  restart_plan begin(const simulation& s) override {
    next_poll_ = 0, between_ = 1;  // steps other than those before may take longer
    if (!waiting_) return {.steps = s.steps};
    auto& state = state_of(w_);
    const std::uint64_t call = calls_++;
    const course_part* const then = past_.find(call);
    const bool came_to_its_end = then != nullptr && then->calls > 0;
    const bool last_call = call + 1 >= past_.calls();
    if (came_to_its_end && !last_call && s.steps != then->asked)
      fail<std::runtime_error>(
          "the checkpoint {} is of a run whose call {} of simulate() was asked for {} steps, and "
          "here it is asked for {}: the calls before the checkpoint must be the same; to end one "
          "on a condition give it to world.stop_when(...) or .stop_when of simulate()",
          plan_.from, call + 1, then->asked, s.steps);
    const std::uint64_t taken = came_to_its_end && then->stopped ? then->taken : s.steps;
    if ((came_to_its_end && !last_call) || state.steps + taken < *waiting_) {
      state.time = state.clock.after(state.time, state.steps, taken, s.dt);
      state.steps += taken;
      auto& keeper = checkpoint_access::keeper(w_);
      ++keeper.skipped;
      // The program may read them now.
      if (call < kept_after_calls_.size())
        set_kept_in_order(kept_after_calls_[call], w_.rank(), keeper.values);
      keeper.kept_after_calls.push_back(call < kept_after_calls_.size() ? kept_after_calls_[call]
                                                                        : byte_buffer());
      return {.skips = true, .stopped = came_to_its_end && then->stopped};
    }
    const std::uint64_t last = state.steps + taken;
    const std::uint64_t seed = checkpoint_access::seed(w_);
    const std::string changes = read_checkpoint(w_, plan_.from);
    waiting_.reset();
    checkpoint_access::keeper(w_).skipped = 0;
    if (w_.rank() == 0 && plan_.tell) tell_of_seed(seed, checkpoint_access::seed(w_));
    if (w_.rank() == 0 && !changes.empty() && plan_.tell)
      plan_.tell(compose("goes on from {} with other parameters: {}", plan_.from, changes));
    if (w_.rank() == 0 && plan_.configured) plan_.configured(configuration_);
    if (w_.steps() > last)
      fail<std::runtime_error>(
          "the checkpoint {} is of step {} now, beyond step {}, with which this part of the run "
          "ends: another run has written it since this one began",
          plan_.from, w_.steps(), last);
    if (plan_.restarted) plan_.restarted(w_.steps());
    const bool stopped = came_to_its_end && then->stopped;
    if (stopped && w_.rank() == 0 && plan_.tell)
      plan_.tell(
          compose("goes on from {}: its call {} of simulate() was ended in step {} by stop() or "
                  "stop_when, and is not gone on with",
                  plan_.from, call + 1, w_.steps()));
    return {
        .steps = static_cast<std::size_t>(last - w_.steps()), .restarts = true, .stopped = stopped};
  }

  /// A poll is a reduction that overlaps with the computation of the step.
  void before_step() override {
    if (plan_.to.empty() || w_.steps() < next_poll_) return;
    const double now = wall_seconds();
    said_ = {
        static_cast<double>(hear()),
        (now - polled_) / static_cast<double>(std::max<std::uint64_t>(1, w_.steps() - polled_at_))};
    polled_ = now;
    polled_at_ = w_.steps();
    polling_ = true;
    if (reduces_beside_steps()) w_.link().start_reduce(reduction::max, said_);
  }
  void after_step() override {
    if (!std::exchange(polling_, false)) return;
    if (reduces_beside_steps())
      w_.link().finish_reduce(said_);
    else
      w_.link().reduce(reduction::max, std::span<double>(said_));
    asked_ = static_cast<int>(said_[0]);
    // At most twice as far ahead as the last time: steps may become slower.
    const double steps = std::min(between_polls / std::max(said_[1], 1e-9), 2.0 * between_);
    between_ = std::clamp(steps, 1.0, double{most_steps_between_polls});
    next_poll_ = w_.steps() + static_cast<std::uint64_t>(between_);
  }
  void after_observers(bool ends) override {
    if (plan_.to.empty()) return;
    const int asked = std::exchange(asked_, nothing);
    const std::uint64_t now = w_.steps();
    written_ = false;
    const bool late = plan_.out_of_time != nullptr && *plan_.out_of_time;
    const bool due =
        late || (plan_.every > 0 && now % plan_.every == 0) || (ends && now >= plan_.last);
    if (!due && asked == nothing) return;
    save();
    if (asked > end_by) throw ended_early{now, asked - end_by};
    if (late) throw ended_early{now, 0, ended_early::cause::time_limit};
  }
  void end_call() override {
    if (plan_.to.empty()) return;
    auto& keeper = checkpoint_access::keeper(w_);
    team_over team(w_.link());
    keeper.kept_after_calls.push_back(bytes_of_kept(team, keeper.values));
  }
  void finish() override {
    if (!written_) save();
  }
  [[nodiscard]] bool writes(const std::string& file) const override {
    return lock_ && lock_->is_of(file);
  }
  void refuse_step_before_restart() const override {
    if (waiting_)
      fail<std::logic_error>(
          "a step is to be taken before the run goes on from the checkpoint {}: only "
          "world.simulate(...) knows which steps it leaves out",
          plan_.from);
  }
  void refuse_reading(const std::string& what) const override {
    fail<std::runtime_error>(
        "the run goes on from the checkpoint {} of step {}, and {} looks at bodies after call {} "
        "of "
        "simulate(), which the restart leaves out, so they are those of the set-up: put what needs "
        "them into a function f of world.once(\"name\", f), whose value checkpoints keep; give a "
        "condition that ends a loop to world.stop_when(...) or .stop_when of simulate(), and "
        "measure "
        "in world.observe(...)",
        plan_.from, *waiting_, what, calls_);
  }
  void require_restarted() const override {
    if (!waiting_) return;
    if (calls_ < past_.calls())
      fail<std::runtime_error>(
          "the checkpoint {} is of step {}, in call {} of simulate(), but this run ends after {}: "
          "give --steps more, or, where a loop ends on a condition, give that to "
          "world.stop_when(...), which checkpoints keep (between calls that a restart leaves out "
          "the bodies are those of the set-up)",
          plan_.from, *waiting_, past_.calls(), counted_calls(calls_));
    fail<std::runtime_error>(
        "the checkpoint {} is of step {}, but this run ends with step {}: steps count from the "
        "beginning; give --steps more",
        plan_.from, *waiting_, w_.steps());
  }

 private:
  [[nodiscard]] static std::string counted_calls(std::uint64_t calls) {
    return compose("{} call{}", calls, calls == 1 ? "" : "s");
  }
  void save() {
    write_checkpoint_file(w_, plan_.to, plan_.force);
    written_ = true;
    heard_write_ = heard_signals().write;  // other ranks may have received it a step later
  }
  [[gnu::cold]] void take_lock(bool replaces) {
    lock_.emplace(plan_.to, "the checkpoint " + plan_.to);
    if (replaces && plan_.from != plan_.to && plan_.tell && !plan_.quiet)
      plan_.tell(compose("--checkpoint {} replaces a checkpoint of an earlier run", plan_.to));
  }
  [[gnu::cold]] void tell_of_seed(std::uint64_t given, std::uint64_t stored) const {
    if (given == stored) return;
    plan_.tell(
        compose("goes on from {} with its seed {}, not with the seed {} of this run: bodies are "
                "those of the file, and what world.fill and inflows draw from now on follows from "
                "its seed; begin without --restart for another one",
                plan_.from, stored, given));
  }
  [[nodiscard]] int hear() {
    if (const int signal = heard_signals().end; signal != 0) return end_by + signal;
    const unsigned writes = heard_signals().write;
    return std::exchange(heard_write_, writes) != writes ? write : nothing;
  }
  /// A link has one open reduction at a time, and some solvers have theirs in each step.
  [[nodiscard]] bool reduces_beside_steps() const {
    if constexpr (Scenario::contact_law::soft)
      return true;
    else
      return state_of(w_).settings.tolerance == 0 && !monitored<Scenario, residual_monitor>;
  }

  world<Scenario>& w_;
  checkpoint_plan plan_;
  std::optional<run_lock> lock_;               ///< on rank 0
  std::optional<std::uint64_t> waiting_;       ///< the step of the file that is to be read
  past_course past_;                           ///< of the run that wrote that file
  std::vector<byte_buffer> kept_after_calls_;  ///< of that run
  std::string configuration_;                  ///< of that run; empty if it is older than these
  std::uint64_t calls_ = 0;                    ///< of simulate(), until the file is read
  unsigned heard_write_ = 0;  ///< how often, in the last poll; listening began with the program
  std::array<double, 2> said_{};
  double polled_ = wall_seconds();
  std::uint64_t polled_at_ = 0, next_poll_ = 0;
  bool polling_ = false;
  double between_ = 1;  ///< steps from the last poll to the next
  int asked_ = nothing;
  bool written_ = true;  ///< the present state, or no step was made
};

}  // namespace talus::detail
