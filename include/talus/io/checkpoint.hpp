#pragma once
// The state of a world in a file, from which another run continues: docs/checkpoints.md.
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/run_lock.hpp"
#include "talus/ghosts/conservation.hpp"
#include "talus/io/detail/checkpoint_bodies.hpp"
#include "talus/io/detail/checkpoint_contacts.hpp"
#include "talus/io/detail/checkpoint_content.hpp"
#include "talus/io/detail/checkpoint_course.hpp"
#include "talus/io/detail/checkpoint_joints.hpp"
#include "talus/io/detail/checkpoint_monitors.hpp"
#include "talus/io/detail/checkpoint_parameters.hpp"
#include "talus/io/detail/checkpoint_reader.hpp"
#include "talus/io/detail/checkpoint_writer.hpp"
#include "talus/world/fresh_start.hpp"
#include "talus/world/world.hpp"

namespace talus {

namespace detail {

/// More steps or iterations than any run makes; exact as a double.
inline constexpr std::uint64_t most_counted = std::uint64_t{1} << 52;

/// Throws runtime_error if the file is of another type of scenario.
template <class Scenario>
[[gnu::cold]] void require_same_scenario(const checkpoint_reader& in) {
  for (const scenario_mark& mine : marks_of<Scenario>()) {
    const std::string theirs = in.text("/scenario/" + mine.name);
    if (theirs != mine.text)
      fail<std::runtime_error>(
          "is of another scenario: that has {}, and this program {}; take the program that wrote "
          "it",
          theirs, mine.text);
  }
}

/// Reads the state of this rank from a file. Returns the changes by the set-up, in words, and adds
/// to `rows` how many bodies there are, and how many of them this rank has read.
template <class Scenario>
[[gnu::cold]] std::string read_rank(world<Scenario>& w, const std::string& file,
                                    std::array<std::uint64_t, 2>& rows, pending_wakes& wakes) {
  using access = checkpoint_access;
  auto& s = state_of(w);
  auto& keeper = access::keeper(w);
  const checkpoint_reader in(file);
  require_same_scenario<Scenario>(in);
  require_materials(in, s.materials);
  require_interactions(in, s);
  require_kept(in, keeper.values);
  get_kept(in, "/kept", w.rank(), keeper.values);
  if (in.has("/meters/names")) get_kept(in, "/meters", w.rank(), keeper.meters);

  const auto whole = [&](const char* path) { return in.integers(path, 1)[0]; };
  s.steps = whole("/run/steps");
  s.time = in.reals("/run/time", 1)[0];
  if (!std::isfinite(s.time) || s.steps > most_counted)
    fail<std::runtime_error>("is damaged: its step {} or its time {} makes no sense", s.steps,
                             s.time);
  s.clock = {};
  if (in.has("/run/clock")) {  // files of the first versions have none
    const auto c = in.reals("/run/clock", 3);
    if (!std::isfinite(c[0]) || !(c[2] >= 0) || !(c[1] >= 0 && c[1] <= double(s.steps)))
      fail<std::runtime_error>("is damaged: its clock of {}, {} and {} makes no sense", c[0], c[1],
                               c[2]);
    s.clock = {c[0], static_cast<std::uint64_t>(c[1]), c[2]};
  }
  keeper.restarted_at = s.steps;
  access::seed(w) = whole("/run/seed");
  access::fills(w) = whole("/run/fills");
  access::attempts(w) = whole("/run/attempts");
  const auto added = in.integers("/run/added_by_rank");
  const auto rank = static_cast<std::size_t>(w.rank()), ranks = static_cast<std::size_t>(w.ranks());
  access::added_here(w) = rank < added.size() ? added[rank] : 0;
  keeper.added_elsewhere.assign(
      added.begin() + static_cast<std::ptrdiff_t>(std::min(ranks, added.size())), added.end());
  const auto waking = in.integers("/run/waking", 3);
  wakes = {waking[0], waking[1]};

  const auto get = [&](const char* path) {
    const auto values = in.reals(path, parameter_names.size());
    parameters all;
    std::copy(values.begin(), values.end(), all.begin());
    return all;
  };
  keeper.given = parameters_of(s);
  const std::string changes =
      merge_parameters(s, get("/parameters/at_first"), get("/parameters/at_last"));
  keeper.after_call = parameters_of(s);
  get_monitors(in, s);
  get_lists(in, s);
  get_records(in, checkpoint_access::records(w));
  get_once(in, keeper.once);
  if constexpr (!world_state<Scenario>::law::soft || monitored<Scenario, residual_monitor>) {
    const auto c = in.reals("/run/convergence", 5);
    for (const std::size_t k : {0, 1, 4})
      if (!(c[k] >= 0 && c[k] <= static_cast<double>(most_counted)))
        fail<std::runtime_error>("is damaged: its count of iterations, {}, makes no sense", c[k]);
    s.convergence = {static_cast<std::uint64_t>(c[0]), static_cast<std::uint64_t>(c[1]), c[2], c[3],
                     static_cast<std::uint64_t>(c[4])};
  }

  if constexpr (world_state<Scenario>::law::soft) {
    s.lengths = {};
    s.soft.fastest_approach = 0;
    if (in.has("/run/step_lengths")) {  // files of earlier versions have none
      const auto rows = in.reals("/run/step_lengths", checkpoint_reader::any, 2);
      for (std::size_t k = 0; k + 1 < rows.size(); k += 2) {
        if (!(rows[k] > 0 && rows[k + 1] >= 0))
          fail<std::runtime_error>("is damaged: steps of {} with an approach by {} make no sense",
                                   rows[k], rows[k + 1]);
        s.lengths.change(static_cast<real>(rows[k]), 0);
        s.lengths.note(static_cast<real>(rows[k + 1]));
      }
    }
  }

  // On other numbers of ranks, moved cuts do not apply.
  if constexpr (world_state<Scenario>::balances)
    if (whole("/run/ranks") == ranks && in.has("/run/cuts"))
      access::place_cuts(w, in.reals("/run/cuts"));

  auto bounds = s.own.bounds();
  for (int k = 0; k < 3; ++k) {  // a margin for round-off of the corners
    bounds.first[k] -= 1e-9 * (1 + std::abs(bounds.first[k]));
    bounds.second[k] += 1e-9 * (1 + std::abs(bounds.second[k]));
  }
  const std::size_t materials = s.materials.size();
  each_table_of_bodies(s, "bodies", [&](auto& b, const std::string& path) {
    using store = std::remove_cvref_t<decltype(b.movable)>;
    if constexpr (store::shape_type::finite) {
      b.movable = {};
      table_reader table =
          in.table(path, columns_of<store>(), packs_itself<typename store::shape_type>);
      read_bodies(table, b.movable, bounds, materials,
                  [&](const vec3& p) { return s.own.contains(p); });
      rows[0] = rows[0] + table.rows();
      rows[1] = rows[1] + b.movable.locals;
    }
  });
  constexpr real infinity = std::numeric_limits<real>::infinity();
  const std::pair everywhere(vec3(-infinity, -infinity, -infinity),
                             vec3(infinity, infinity, infinity));
  each_table_of_bodies(s, "globals", [&](auto& b, const std::string& path) {
    using store = std::remove_cvref_t<decltype(b.global)>;
    b.global = {};
    table_reader table =
        in.table(path, columns_of<store>(), packs_itself<typename store::shape_type>);
    read_bodies(table, b.global, everywhere, materials, [](const vec3&) { return true; });
    b.global.locals = 0;
  });
  using history = std::remove_cvref_t<decltype(s.history)>;
  using memory = decltype(history::entry::memory);
  const id_table own = own_bodies(s);
  table_reader contacts = in.table("/contacts", columns_of_contacts<memory>(), false);
  s.history = read_contacts<history>(contacts, own, bounds);
  if constexpr (std::remove_cvref_t<decltype(s)>::law::soft) s.found.forget_places();
  read_joints(in, s, own, bounds);
  if constexpr (world_state<Scenario>::sleeps) {
    table_reader sleeping = in.table("/sleeping_contacts", columns_of_contacts<memory>(), false);
    s.sleep.contacts = read_contacts<history>(sleeping, own, bounds);
  }
  return changes;
}

/// write_checkpoint(); with `force` it also replaces a file that is not a checkpoint.
template <class Scenario>
[[gnu::cold]] void write_checkpoint_file(world<Scenario>& w, const std::string& file, bool force) {
  w.require_all_ranks("write_checkpoint");
  w.synchronize();
  team_over team(w.link());
  std::optional<run_lock> lock;
  const auto& hooks = checkpoint_access::keeper(w).hooks;
  team.together([&] {
    if (w.rank() == 0 && !(hooks && hooks->writes(file)))
      lock.emplace(file, "the checkpoint " + file);
  });
  const auto wakes = measure_pending_wakes(state_of(w));
  auto tables = tables_of(state_of(w));
  const auto facts = facts_of(w, team, wakes);
  checkpoint_kind kind;
  team_writer(team, kind, file, force).write(tables, facts);
  tables.clear();
  begin_afresh(w, wakes);
}

}  // namespace detail

/// Collective: writes the state of the world to a file, which replaces the checkpoint of that name
/// when it is complete, on the disk, and read back. The world then rebuilds its derived data, as
/// one that reads the file does, so that both continue alike to the bit. Throws runtime_error alike
/// on all ranks if the file cannot be written, if an existing file is not a checkpoint, and while
/// another run writes it; the existing file then stays unchanged.
template <class Scenario>
[[gnu::cold]] void write_checkpoint(world<Scenario>& w, const std::string& file) {
  if constexpr (detail::require_feature<Scenario, checkpoints>())
    detail::write_checkpoint_file(w, file, false);
}

/// Collective: replaces all bodies, and all other state on which the future depends, by that of a
/// file. The world must have its domain, its materials, and its kept variables. Any number of ranks
/// reads the file of any other. Returns, in words, which parameters differ from those of the run
/// that wrote it; empty if none. Throws runtime_error alike on all ranks if the file cannot be
/// read, is damaged, or is of another scenario.
template <class Scenario>
[[gnu::cold]] std::string read_checkpoint(world<Scenario>& w, const std::string& file) {
  std::string changes;
  if constexpr (detail::require_feature<Scenario, checkpoints>()) {
    w.require_all_ranks("read_checkpoint", false);
    detail::checkpoint_access::require_domain(w);
    detail::team_over team(w.link());
    std::array<std::uint64_t, 2> rows{};
    detail::pending_wakes wakes;
    team.together([&] {
      try {
        changes = detail::read_rank(w, file, rows, wakes);
      } catch (const std::bad_alloc&) {
        detail::fail<std::runtime_error>("the checkpoint {} asks for more memory than there is",
                                         file);
      } catch (const std::exception& e) {
        detail::fail<std::runtime_error>("the checkpoint {} {}", file, e.what());
      }
    });
    team.sum(std::span(&rows[1], 1));
    if (rows[0] != rows[1])
      detail::fail<std::runtime_error>(
          "the checkpoint {} holds {} bodies, but {} are in the domain of some rank: all space "
          "must belong to one rank each",
          file, rows[0], rows[1]);
    detail::take_stock(detail::state_of(w));
    std::array<double, 3> found{static_cast<double>(w.steps()), -static_cast<double>(w.steps()),
                                double(detail::twice_owned(detail::state_of(w)) != no_id)};
    w.link().reduce(reduction::max, std::span<double>(found));
    if (found[0] != -found[1])
      detail::fail<std::runtime_error>(
          "the checkpoint {} was of step {} for one rank and of step {} for another: it was "
          "replaced "
          "while it was read; start again",
          file, -found[1], found[0]);
    if (found[2] != 0)
      detail::fail<std::runtime_error>("the checkpoint {} holds a body twice", file);
    detail::begin_afresh(w, wakes);
  }
  return changes;
}

}  // namespace talus
