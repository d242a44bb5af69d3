#pragma once
// A run as a table: one line of comma-separated values for every so many steps.
#include <unistd.h>

#include <algorithm>
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
#include "talus/world/world.hpp"

namespace talus {

/// Writes such a table on rank 0. The first line names the columns and their dimensions (M mass, L
/// length, T time). Each line is on its way to the disk when it is written: a run that is killed
/// keeps them.
class time_series {
 public:
  /// Opens the file; the first line replaces what is there. An empty name means no file, and costs
  /// nothing. Throws runtime_error if it cannot be written. `speaks` is true on rank 0 alone.
  /// With `goes_on` the file stays, and go_on_from() is called before the first line.
  time_series(std::string file, bool speaks, bool goes_on = false)
      : name_(std::move(file)),
        speaks_(speaks && !name_.empty()),
        begins_(!goes_on && !detail::is_stream(name_)) {
    if (!speaks_) return;
    if (!begins_) file_ = std::fopen(name_.c_str(), goes_on ? "a+" : "a");
    if (begins_ ? !detail::part_file(name_).good() : file_ == nullptr)
      detail::fail<std::runtime_error>(
          "the file {} cannot be written: give --csv a file in a folder that exists and is "
          "writable",
          name_);
  }
  time_series(const time_series&) = delete;
  time_series& operator=(const time_series&) = delete;
  ~time_series() {
    if (file_ != nullptr) std::fclose(file_);
  }

  /// Collective: the line of the state in which the run begins, if there is none yet.
  template <class Scenario>
  [[gnu::cold]] void begin(world<Scenario>& w) {
    if (!sampled_) sample(w);
  }
  /// Collective: adds a line for the state as it is now, unless the last line is of the same step.
  template <class Scenario>
  [[gnu::cold]] void sample(world<Scenario>& w) {
    if (name_.empty() || last_ == w.steps()) return;
    sampled_ = true;
    last_ = w.steps();
    const motion m = measure_motion(w);
    const penetration p = measure_penetration(w);
    std::uint64_t contacts = 0;
    w.state().each_contact_list([&](const auto& list) {
      if constexpr (requires { list.counted(); })
        contacts += list.counted();
      else
        list.each([&](const auto&, bool counts_here) { contacts += counts_here; });
    });
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
    const auto more = measure_monitors(w).values;
    columns.append(more);
    if (speaks_) write(columns, w.records().all());
  }

  /// On all ranks: the table goes on after a restart in this step. Lines of later steps, which the
  /// run before had still written, go, and so do those between two of `every` steps.
  [[gnu::cold]] void go_on_from(std::uint64_t step, std::uint64_t every) {
    if (name_.empty()) return;
    sampled_ = true;  // by the run before
    if (step % every == 0) last_ = step;
    if (!speaks_ || detail::is_stream(name_)) return;
    rewrite([&](std::string& line, bool head) {
      if (head) return head_ = line, true;
      char* end = nullptr;
      const unsigned long long of = std::strtoull(line.c_str(), &end, 10);
      return end != line.c_str() && of <= step && of % every == 0;
    });
  }

 private:
  using records = std::vector<detail::recorded_value>;

  [[noreturn, gnu::cold]] void fail_to_write() const {
    detail::fail<std::runtime_error>(
        "the time series could not be written to {}: is the disk "
        "full?",
        name_);
  }
  /// Writes the lines for which keep(line, is the first) anew, as it leaves them.
  template <class Keep>
  [[gnu::cold]] void rewrite(Keep&& keep) {
    std::string kept, line;
    bool head = true;
    std::fflush(file_);
    std::FILE* const in = std::fopen(name_.c_str(), "r");
    if (in == nullptr) fail_to_write();
    for (int c; (c = std::fgetc(in)) != EOF;) {
      if (c != '\n') {
        line += static_cast<char>(c);
        continue;
      }
      if (keep(line, std::exchange(head, false))) kept += line + '\n';
      line.clear();
    }
    std::fclose(in);
    // Beside it, so that the table is whole at any time.
    std::fclose(std::exchange(file_, nullptr));
    replace_by(kept);
  }
  /// Of the whole file; it stays open for more.
  [[gnu::cold]] void replace_by(const std::string& text) {
    detail::part_file beside(name_);
    if (!beside.good() || !detail::write_text(beside.id(), text)) fail_to_write();
    const int whole = beside.rename_and_keep(name_);
    if (whole < 0 || (file_ = ::fdopen(whole, "a")) == nullptr) fail_to_write();
  }
  [[nodiscard, gnu::cold]] static std::string head_of(std::string_view name,
                                                      std::string_view dimension) {
    std::string head(name);
    if (!dimension.empty()) ((head += " [") += dimension) += "]";
    return head;
  }
  /// The head of the table, with the user's own columns behind the others. The lines before the
  /// first value of such a column have nothing there.
  [[gnu::cold]] void write_head(const detail::plain_vector<measured>& columns, const records& own) {
    std::string head;
    for (const measured& c : columns)
      (head += head.empty() ? "" : ",") += head_of(c.name, c.dimension);
    const auto standard = std::count(head.begin(), head.end(), ',');
    for (const detail::recorded_value& r : own) {
      for (const measured& c : columns)
        if (c.name == r.name)
          detail::fail<std::invalid_argument>(
              "world.record was given the name '{}', which is that of another column of the table "
              "{}: take another name",
              r.name, name_);
      head += "," + head_of(r.name, r.dimension);
    }
    const auto commas_of = [](std::string_view text) {
      return std::count(text.begin(), text.end(), ',');
    };
    behind_.clear();
    if (head == head_) return;
    if (head_.empty()) {
      if (std::fputs((head + "\n").c_str(), file_) < 0) fail_to_write();
    } else if (head_.starts_with(head + ",")) {  // columns of the run before that are still to come
      behind_.assign(static_cast<std::size_t>(commas_of(head_) - commas_of(head)), ',');
      return;
    } else if (head.starts_with(head_ + ",") && standard <= commas_of(head_) &&
               !detail::is_stream(name_)) {
      const std::string missing(static_cast<std::size_t>(commas_of(head) - commas_of(head_)), ',');
      rewrite([&](std::string& line, bool first) {
        if (first)
          line = head;
        else
          line += missing;
        return true;
      });
    } else {
      detail::fail<std::runtime_error>(
          "the table {} has other columns than this run would add to it: give --csv another file",
          name_);
    }
    head_ = std::move(head);
  }
  [[gnu::cold]] void write(const detail::plain_vector<measured>& columns, const records& own) {
    if (std::exchange(begins_, false)) replace_by("");
    write_head(columns, own);
    std::string line;
    for (const measured& c : columns) (line += line.empty() ? "" : ",") += detail::text(c.value);
    for (const detail::recorded_value& r : own) (line += ",") += detail::text(r.value);
    line += behind_ + "\n";
    if (std::fputs(line.c_str(), file_) < 0 || std::fflush(file_) != 0) fail_to_write();
  }

  std::string name_;
  std::FILE* file_ = nullptr;
  bool speaks_, begins_;  ///< on rank 0; the first line is still to come
  std::string behind_;    ///< commas of the columns for which this run has no value yet
  std::string head_;      ///< the first line; empty: there is none yet
  bool sampled_ = false;
  std::uint64_t last_ = ~std::uint64_t{0};  ///< step of the last line
};

}  // namespace talus
