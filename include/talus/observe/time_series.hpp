#pragma once
// A run as a table: one line of comma-separated values at a fixed interval of steps.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/output_file.hpp"
#include "talus/observe/monitors.hpp"
#include "talus/observe/motion.hpp"
#include "talus/observe/penetration.hpp"
#include "talus/state/contact_count.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// Collective: step, time, number of bodies and contacts, energy, momentum and overlap of the
/// present state, and the values of the monitors.
template <class Scenario>
[[nodiscard, gnu::cold]] detail::plain_vector<measured> measure_run(world<Scenario>& w) {
  const motion m = measure_motion(w);
  const penetration p = measure_penetration(w);
  std::uint64_t contacts = detail::count_contacts(detail::view_of(w));
  w.link().reduce(reduction::sum, std::span(&contacts, 1));
  constexpr const char *energy = "M L^2/T^2", *momentum = "M L/T";
  detail::plain_vector<measured> columns{
      {"step", "1", static_cast<double>(w.steps())},
      {"time", "T", w.time()},
      {"bodies", "1", static_cast<double>(m.bodies)},
      {"contacts", "1", static_cast<double>(contacts)},
      {"kinetic_energy", energy, m.kinetic_energy},
      {"potential_energy", energy, m.potential_energy},
      {"momentum_x", momentum, m.momentum[0]},
      {"momentum_y", momentum, m.momentum[1]},
      {"momentum_z", momentum, m.momentum[2]},
      {"max_speed", "L/T", m.max_speed},
      {"penetration_mean", "1", p.mean},
      {"penetration_max", "1", p.max},
  };
  // That number depends on the ranks. All others are the same on any ranks.
  for (const measured& m : measure_monitors(w).values)
    if (m.name != "energy_error_worst") columns.push_back(m);
  return columns;
}

/// Writes such a table on rank 0. The first line names the columns and their units: those of
/// world::units(), or M (mass), L (length) and T (time) where it gave none. Each line is one write:
/// a killed run keeps its lines.
class time_series {
 public:
  /// Opens the file; the first line replaces an existing file. An empty name means no file, and
  /// costs nothing. Throws runtime_error if it cannot be written. `speaks` is true on rank 0 alone.
  /// With `goes_on` the file stays, and go_on_from() is called before the first line.
  time_series(std::string file, bool speaks, bool goes_on = false);
  time_series(const time_series&) = delete;
  time_series& operator=(const time_series&) = delete;
  ~time_series();

  /// Collective: the line of the initial state of the run, if there is none yet. If a restart goes
  /// on with a line of this state that another state has written, returns a sentence on rank 0.
  template <class Scenario>
  [[nodiscard, gnu::cold]] std::string begin(world<Scenario>& w) {
    if (!sampled_) sample(w);
    if (name_.empty() || !std::exchange(goes_on_, false) || last_ != w.steps()) return "";
    const motion m = measure_motion(w);
    return speaks_ ? doubt({m.kinetic_energy, m.potential_energy}) : "";
  }
  /// Collective: adds a line for the present state, unless the last line is of the same step.
  template <class Scenario>
  [[gnu::cold]] void sample(world<Scenario>& w) {
    if (name_.empty() || last_ == w.steps()) return;
    sampled_ = true;
    last_ = w.steps();
    const detail::plain_vector<measured> columns = measure_run(w);
    if (speaks_) write(columns, w.records().all(), w.units());
  }

  /// Closes the file. Throws runtime_error if it then turns out that lines could not be written.
  [[gnu::cold]] void finish();

  /// On all ranks: the table continues after a restart at this step. Lines of later steps, which
  /// the earlier run had still written, are removed, as are those between two of `every` steps.
  [[gnu::cold]] void go_on_from(std::uint64_t step, std::uint64_t every);

 private:
  using records = std::vector<detail::recorded_value>;

  /// Whether the last line has other energies: then another run has written it.
  [[nodiscard, gnu::cold]] std::string doubt(const std::array<double, 2>& energies) const;
  [[noreturn, gnu::cold]] void fail_to_write(const std::string& why) const;
  [[gnu::cold]] void put(const std::string& text) const;
  /// Rewrites the lines for which keep(line, is the first) is true, as changed by it.
  template <class Keep>
  [[gnu::cold]] void rewrite(Keep&& keep) {
    std::string kept, line;
    bool head = true;
    std::FILE* const in = std::fopen(name_.c_str(), "r");
    if (in == nullptr && errno != ENOENT)
      fail_to_write("cannot be read: " + detail::system_words());
    for (int c; in != nullptr && (c = std::fgetc(in)) != EOF;) {
      if (c != '\n') {
        line += static_cast<char>(c);
        continue;
      }
      if (keep(line, std::exchange(head, false))) kept += line + '\n';
      line.clear();
    }
    if (in != nullptr) std::fclose(in);
    replace_by(kept);  // beside it, so that the table is complete at any time
  }
  /// Replaces the content of the file by a text, and keeps the file open for more lines.
  [[gnu::cold]] void replace_by(const std::string& text);
  [[nodiscard, gnu::cold]] static std::string head_of(std::string_view name,
                                                      std::string_view dimension,
                                                      const unit_names& units);
  /// The head of the table, with the user-defined columns behind the others, if it is still to be
  /// written. The lines before the first value of such a column are empty there.
  [[nodiscard, gnu::cold]] std::string head_line(const detail::plain_vector<measured>& columns,
                                                 const records& own, const unit_names& units);
  [[gnu::cold]] void write(const detail::plain_vector<measured>& columns, const records& own,
                           const unit_names& units);

  std::string name_;
  int id_ = -1;
  bool speaks_, begins_;  ///< on rank 0; the first line is still to come
  std::string behind_;    ///< commas of the columns for which this run has no value yet
  std::string head_;      ///< the first line; empty: there is none yet
  bool sampled_ = false;
  bool goes_on_ = false;   ///< with lines of an earlier run, which begin() has not compared yet
  std::string last_line_;  ///< of those
  std::uint64_t last_ = ~std::uint64_t{0};  ///< step of the last line
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/observe/time_series_definitions.hpp"
#endif
