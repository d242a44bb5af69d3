#pragma once
// The data that a rank writes to a checkpoint: its rows of all tables, and on rank 0 the
// description of the whole run.
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/io/detail/checkpoint_bodies.hpp"
#include "talus/io/detail/checkpoint_contacts.hpp"
#include "talus/io/detail/checkpoint_course.hpp"
#include "talus/io/detail/checkpoint_interactions.hpp"
#include "talus/io/detail/checkpoint_joints.hpp"
#include "talus/io/detail/checkpoint_monitors.hpp"
#include "talus/io/detail/checkpoint_parameters.hpp"
#include "talus/io/detail/checkpoint_writer.hpp"
#include "talus/world/fresh_start.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// Names and rows of a scenario's tables, for both directions.
template <class Scenario, class F>
void each_table_of_bodies(held_bodies<Scenario>& s, const char* group, F&& f) {
  s.each_shape([&](auto& b) {
    using store = std::remove_cvref_t<decltype(b.movable)>;
    f(b, table_of_shape<store, typename Scenario::shapes>(group));
  });
}

/// The rows of this rank.
template <class Scenario>
[[nodiscard]] std::vector<table_part> tables_of(world_state<Scenario>& s) {
  std::vector<table_part> tables;
  each_table_of_bodies(s, "bodies", [&](auto& b, const std::string& path) {
    if constexpr (std::remove_cvref_t<decltype(b)>::shape_type::finite)
      tables.push_back(part_of(b.movable, b.movable.locals, path));
  });
  each_table_of_bodies(s, "globals", [&](auto& b, const std::string& path) {
    tables.push_back(part_of(b.global, s.link->rank() == 0 ? b.global.size() : 0, path));
  });
  const known_places known = places_of_known(s);
  tables.push_back(part_of_contacts(s.history, known, "/contacts"));
  if constexpr (world_state<Scenario>::sleeps)
    tables.push_back(part_of_contacts(s.sleep.contacts, known, "/sleeping_contacts"));
  add_joint_tables(s, tables);
  return tables;
}

/// The names of the numbers of shapes, for programs that read the columns `shape`.
template <class... Shapes>
void put_numbers_of_shapes(type_list<Shapes...>, std::vector<small_dataset>& out) {
  [[maybe_unused]] const auto put = [&]<class Shape>(type_list<Shape>) {
    if constexpr (requires { Shape::numbers; }) {
      std::string names;
      for (const char* const one : Shape::numbers) names += std::string(one) + '\n';
      out.push_back(text_dataset(std::string("/shapes/") + Shape::name, names));
    }
  };
  (put(type_list<Shapes>{}), ...);
}

/// The lengths of the steps so far, each with the fastest approach on any rank. Collective.
template <class Scenario>
[[gnu::cold]] void put_step_lengths(checkpoint_team& team, const world_state<Scenario>& s,
                                    std::vector<small_dataset>& out) {
  step_lengths lengths = s.lengths;
  lengths.note(s.soft.fastest_approach);
  std::vector<double> rows;
  for (const auto& x : lengths.all()) rows.insert(rows.end(), {x.dt, x.fastest});
  byte_buffer mine;
  for (const double x : rows) byte_writer(mine).put(x);
  for (const byte_buffer& each : team.gather(mine)) {
    byte_reader from(each);
    for (double& x : rows) x = std::max(x, from.get<double>());
  }
  out.push_back(numbers_dataset<double>("/run/step_lengths", rows, 2));
}

/// The description of the run by rank 0. Collective.
template <class Scenario>
[[nodiscard, gnu::cold]] std::vector<small_dataset> facts_of(world<Scenario>& w,
                                                             checkpoint_team& team,
                                                             const pending_wakes& wakes) {
  using access = checkpoint_access;
  auto& s = state_of(w);
  auto& keeper = access::keeper(w);
  std::vector<small_dataset> out;
  for (const scenario_mark& m : marks_of<Scenario>())
    out.push_back(text_dataset("/scenario/" + m.name, m.text));
  out.push_back(text_dataset("/scenario/policies", policies_in_use(s)));
  put_numbers_of_shapes(typename Scenario::shapes{}, out);
  if (!keeper.configuration.empty())
    out.push_back(text_dataset("/run/configuration", keeper.configuration));
  byte_buffer mine;
  byte_writer(mine).put(access::added_here(w));
  std::vector<std::uint64_t> added;
  for (const byte_buffer& each : team.gather(mine))
    added.push_back(byte_reader(each).get<std::uint64_t>());
  added.insert(added.end(), keeper.added_elsewhere.begin(), keeper.added_elsewhere.end());
  const auto whole = [&](const char* path, std::uint64_t value) {
    out.push_back(numbers_dataset<std::uint64_t>(path, std::span(&value, 1)));
  };
  whole("/run/steps", s.steps);
  whole("/run/seed", access::seed(w));
  whole("/run/fills", access::fills(w));
  whole("/run/attempts", access::attempts(w));
  if constexpr (world_state<Scenario>::has_joints) whole("/run/joints", s.joints.made);
  whole("/run/ranks", static_cast<std::uint64_t>(w.ranks()));
  out.push_back(numbers_dataset<std::uint64_t>("/run/added_by_rank", added));
  out.push_back(numbers_dataset<double>("/run/time", std::span(&s.time, 1)));
  out.push_back(numbers_dataset<double>(
      "/run/clock", std::array{s.clock.origin, static_cast<double>(s.clock.first), s.clock.dt}));
  const parameters now = parameters_of(s);
  const parameters first = keeper.given.value_or(now);
  out.push_back(numbers_dataset<double>("/parameters/at_first", first));
  out.push_back(numbers_dataset<double>("/parameters/at_last", now));
  std::string names;
  for (const char* name : parameter_names) names += std::string(name) + '\n';
  out.push_back(text_dataset("/parameters/names", names));
  if constexpr (world_state<Scenario>::balances)
    out.push_back(numbers_dataset<double>("/run/cuts", access::cuts(w)));
  if constexpr (!world_state<Scenario>::law::soft || monitored<Scenario, residual_monitor>) {
    const talus::convergence& c = s.convergence;
    out.push_back(numbers_dataset<double>(
        "/run/convergence",
        std::array{static_cast<double>(c.iterations), static_cast<double>(c.iterations_max),
                   c.residual, c.residual_worst, static_cast<double>(c.steps_above)}));
  }
  // The third number is not in use: the flags of bodies say it.
  out.push_back(numbers_dataset<std::uint64_t>(
      "/run/waking", std::array{wakes.all, wakes.spreads, std::uint64_t{0}}));
  const auto materials = numbers_of(s.materials), pairs = numbers_of_pairs(s.materials);
  out.push_back(numbers_dataset<double>("/materials/each", materials, 8));
  out.push_back(numbers_dataset<double>("/materials/own_pairs", pairs, 5));
  if (s.materials.rules() != pair_rules{})
    out.push_back(numbers_dataset<double>("/materials/rules", numbers_of(s.materials.rules())));
  put_interactions(s, out);
  put_kept(team, "/kept", keeper.values, out);
  if (!keeper.meters.empty()) put_kept(team, "/meters", keeper.meters, out);
  put_kept_after_calls(keeper.kept_after_calls, out);
  if constexpr (world_state<Scenario>::law::soft) put_step_lengths(team, s, out);
  put_monitors(team, s, out);
  put_lists(s, out);
  put_course(keeper.course.parts(s.steps), out);
  put_records(w.records(), out);
  put_once(keeper.once, out);
  return out;
}

}  // namespace talus::detail
