#pragma once
// The page of --view during a run: frames at a fixed interval of steps, with values to plot.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/io/view_page.hpp"
#include "talus/io/view_scene.hpp"
#include "talus/observe/residual.hpp"
#include "talus/observe/time_series.hpp"
#include "talus/scene/detail/run_guard.hpp"
#include "talus/scene/options.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// Steps from one frame to the next, unless the user says otherwise: 200 frames, fewer of many
/// bodies (64 MB of frames), at least 20.
[[nodiscard, gnu::cold]] inline std::uint64_t usual_view_interval(std::uint64_t steps,
                                                                  std::uint64_t bodies) {
  const std::uint64_t frames = std::clamp<std::uint64_t>(
      (std::uint64_t{64} << 20) / (16 * std::max<std::uint64_t>(bodies, 1)), 20, 200);
  return std::max<std::uint64_t>(1, (steps + frames - 1) / frames);
}

/// The page of one rank's world; its file is on rank 0.
template <class Scenario>
class run_view {
 public:
  run_view(world<Scenario>& w, const options& o, std::string name)
      : w_(w), name_(std::move(name)), every_(o.view_every) {
    if (w.rank() == 0) page_ = std::make_unique<view_page>(o.view, o.force);
  }
  /// Collective, after each step.
  void step() {
    if (every_ > 0 && w_.steps() % every_ == 0) add();
  }
  /// Collective, at the start of each simulate() of so many steps more.
  [[gnu::cold]] void begin(std::uint64_t steps) {
    if (every_ == 0) {
      std::uint64_t bodies = w_.local_bodies();
      w_.link().reduce(reduction::sum, std::span(&bodies, 1));
      every_ = usual_view_interval(steps, bodies);
    }
    if (!begun_) add();
    begun_ = true;
  }
  /// Collective: adds the present state, if it is not there yet, and completes the page.
  [[gnu::cold]] void finish() {
    add();
    if (!page_) return;
    std::string names;
    for (const recorded_value& r : w_.records().all())
      (names += names.empty() ? "" : ",") += detail::quoted(r.name);
    view_json end;
    end.add_raw("recorded", "[" + names + "]");
    page_->finish(end.str());
  }

 private:
  [[gnu::cold]] void add() {
    if (last_ == w_.steps()) return;
    last_ = w_.steps();
    const view_json values = measure();
    const auto bytes = w_.link().gather(writer_.part_of(w_).packed());
    if (!page_) return;
    std::vector<view_part> parts;
    for (const byte_buffer& b : bytes) parts.push_back(view_part::unpacked(b));
    view_frame frame = frames_.make(parts);
    frame.head.add("step", static_cast<double>(w_.steps()));
    frame.head.add("time", w_.time());
    frame.head.add_raw("values", values.str());
    const vec3 g = w_.gravity();
    frame.head.add_raw("gravity", view_json::vector(g));
    if (!frame.warning.empty())
      say_in_run(compose("{}: warning: --view: step {}: {}\n", name_, w_.steps(), frame.warning));
    view_json about;
    about.add_text("name", name_);
    about.add_text("policies", policies_in_use(view_of(w_)));
    page_->add(frame, about.str());
  }
  /// What the page plots. The record of residuals stays as it is: a run with a page has the same
  /// results as one without.
  [[nodiscard]] view_json measure() {
    view_json values;
    for (const measured& m : measure_run(w_))
      if (m.name != "step" && m.name != "time") values.add(m.name, m.value);
    if constexpr (!Scenario::contact_law::soft && !Scenario::template has_feature<residual_monitor>)
      if (w_.steps() > 0) {
        auto& kept = state_of(w_).convergence;
        const auto before = kept;
        const contact_residual r = measure_residual(w_);
        kept = before;
        values.add("contact_residual", r.value), values.add("contact_residual_worst", r.max);
      }
    for (const recorded_value& r : w_.records().all()) values.add(r.name, r.value);
    return values;
  }

  world<Scenario>& w_;
  std::string name_;
  std::uint64_t every_;
  std::uint64_t last_ = ~std::uint64_t{0};  ///< step of the last frame
  bool begun_ = false;
  view_writer writer_;
  view_frames frames_;
  std::unique_ptr<view_page> page_;
};

/// The page that the options ask for, or null. Collective.
template <class Scenario>
[[nodiscard]] std::shared_ptr<run_view<Scenario>> attach_view(world<Scenario>& w, const options& o,
                                                              const std::string& name) {
  if (o.view.empty()) return nullptr;
  const auto view = std::make_shared<run_view<Scenario>>(w, o, name);
  w.before_simulating("page of --view", [&w, view, steps = o.steps] {
    view->begin(w.last_step() > w.steps() ? w.last_step() - w.steps() : steps);
  });
  w.after_each_step("page of --view", [view] { view->step(); });
  return view;
}

}  // namespace talus::detail
