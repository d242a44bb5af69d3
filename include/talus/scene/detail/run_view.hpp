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
#include "talus/core/shown_text.hpp"
#include "talus/io/view_page.hpp"
#include "talus/io/view_scene.hpp"
#include "talus/observe/residual.hpp"
#include "talus/observe/time_series.hpp"
#include "talus/scene/detail/run_guard.hpp"
#include "talus/scene/options.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// Frames of a page, unless the user says otherwise: 200, fewer of many bodies (64 MB), at least
/// 20.
[[nodiscard, gnu::cold]] inline std::uint64_t usual_view_frames(std::uint64_t bodies) {
  return std::clamp<std::uint64_t>(
      (std::uint64_t{64} << 20) / (16 * std::max<std::uint64_t>(bodies, 1)), 20, 200);
}

/// The page of one rank's world; its file is on rank 0.
template <class Scenario>
class run_view {
 public:
  run_view(world<Scenario>& w, const options& o, std::string name)
      : w_(w),
        name_(std::move(name)),
        every_(o.view_every),
        by_itself_(o.view_every == 0),
        colour_(o.colour),
        restart_(o.restart),
        frames_(o.view_contacts) {
    if (w.rank() == 0) page_ = std::make_unique<view_page>(o.view, o.force);
  }
  /// Collective, after each step.
  void step() {
    if (every_ > 0 && w_.steps() % every_ == 0) add();
  }
  /// Collective, at the start of each simulate() of so many steps more.
  [[gnu::cold]] void begin(std::uint64_t steps) {
    // The interval is that of the first call, and of one after a call that has ended early.
    if (by_itself_ && steps > 0 && (every_ == 0 || w_.steps() < planned_end_)) {
      const std::uint64_t frames = count_usual_frames();
      const std::uint64_t own = std::max<std::uint64_t>(1, (steps + frames - 1) / frames);
      every_ = every_ == 0 ? own : std::min(every_, own);
    }
    planned_end_ = w_.steps() + steps;
    if (!begun_) add();
    begun_ = true;
  }
  /// Collective: adds the present state, if it is not there yet, and completes the page.
  [[gnu::cold]] void finish() {
    by_itself_ = false;
    add();
    if (!page_) return;
    std::string names;
    view_json end, dimensions;
    for (const recorded_value& r : w_.records().all()) {
      (names += names.empty() ? "" : ",") += detail::quoted_text(r.name);
      if (!r.dimension.empty()) dimensions.add_text(r.name, r.dimension);
    }
    end.add_raw("recorded", "[" + names + "]");
    end.add_raw("dimensions", dimensions.str());
    page_->finish(describe(end));
  }

 private:
  [[nodiscard, gnu::cold]] std::uint64_t count_usual_frames() {
    std::uint64_t bodies = w_.local_bodies();
    w_.link().reduce(reduction::sum, std::span(&bodies, 1));
    return usual_view_frames(bodies);
  }
  [[gnu::cold]] void add() {
    if (last_ == w_.steps()) return;
    last_ = w_.steps();
    add_frame();
    steps_.push_back(last_);
    if (by_itself_) thin_out();
  }
  /// Nobody knows at the first call of simulate() how many steps the others make. With half as many
  /// frames again as usual, the interval doubles, and the frames between are removed.
  [[gnu::cold]] void thin_out() {
    const std::uint64_t most = 3 * count_usual_frames() / 2;
    if (steps_.size() <= most) return;
    while (steps_.size() > most) {
      every_ *= 2;
      const std::uint64_t first = steps_[0];
      std::size_t kept = 0;
      for (const std::uint64_t step : steps_)
        if (step == first || step % every_ == 0) steps_[kept++] = step;
      steps_.resize(kept);
    }
    last_ = steps_.back();
    if (page_) page_->keep(std::span<const std::uint64_t>(steps_.data(), steps_.size()));
  }
  [[gnu::cold]] void add_frame() {
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
    page_->add(frame, w_.steps(), page_->frames() == 0 ? describe(view_json{}) : std::string());
  }
  /// What the page says of the run: also materials, and the view of the program.
  [[nodiscard, gnu::cold]] std::string describe(view_json about) {
    about.add_text("name", name_);
    about.add_text("policies", policies_in_use(view_of(w_)));
    about.add_raw("soft", Scenario::contact_law::soft ? "true" : "false");
    const material_table& materials = view_of(w_).materials;
    about.add_raw("materials", view_materials(materials));
    const std::string own = shape_numbers(typename Scenario::shapes{}).others();
    if (!own.empty()) about.add_text("shapes", own);
    if (!colour_.empty()) about.add_text("colour", colour_);
    if (w_.look()) about.add_raw("look", view_look(*w_.look()));
    view_json units;
    units.add_text("L", in_units("L", w_.units()));
    units.add_text("M", in_units("M", w_.units()));
    units.add_text("T", in_units("T", w_.units()));
    about.add_raw("units", units.str());
    if (!restart_.empty() && !begun_)
      about.add_raw("notes",
                    "[" +
                        quoted_text(compose("The page begins at step {}, where the run was "
                                            "restarted from {}.",
                                            w_.steps(), restart_)) +
                        "]");
    return about.str();
  }
  /// What the page plots. The record of residuals stays as it is: a run with a page has the same
  /// results as one without.
  [[nodiscard]] view_json measure() {
    view_json values;
    // Contacts are found in a step: after a restart they are unknown until the first one.
    const bool known = begun_ || restart_.empty();
    for (const measured& m : measure_run(w_))
      if (m.name != "step" && m.name != "time" && (known || m.name != "contacts"))
        values.add(m.name, m.value);
    if constexpr (!Scenario::contact_law::soft && !Scenario::template has_feature<residual_monitor>)
      if (w_.steps() > 0 && known) {
        auto& kept = state_of(w_).convergence;
        const auto before = kept;
        const contact_residual r = measure_residual(w_);
        kept = before;
        values.add("contact_residual", r.value), values.add("contact_residual_max", r.max);
      }
    for (const recorded_value& r : w_.records().all()) values.add(r.name, r.value);
    return values;
  }

  world<Scenario>& w_;
  std::string name_;
  std::uint64_t every_;
  bool by_itself_;                          ///< the interval follows the length of the run
  std::string colour_;                      ///< of bodies at the beginning; empty: as usual
  std::string restart_;                     ///< the checkpoint with which the run began, or empty
  plain_vector<std::uint64_t> steps_;       ///< of the frames
  std::uint64_t last_ = ~std::uint64_t{0};  ///< step of the last frame
  std::uint64_t planned_end_ = 0;           ///< of the present call of simulate()
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
  w.monitor_each_step("page of --view", [view] { view->step(); });
  return view;
}

}  // namespace talus::detail
