#pragma once
// A run as a table: one line of comma-separated values for every so many steps.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

#include "talus/core/error.hpp"
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
  /// Opens the file, replacing one that is there; an empty name means no file, and costs nothing.
  /// Throws runtime_error if it cannot be written. `speaks` is true on rank 0 alone.
  /// With `goes_on` the file stays, and go_on_from() is called before the first line.
  time_series(std::string file, bool speaks, bool goes_on = false) : name_(std::move(file)) {
    if (name_.empty() || !speaks) return;
    file_ = std::fopen(name_.c_str(), goes_on ? "a+" : "w");
    if (file_ == nullptr)
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

  /// Collective: adds a line for the state as it is now, unless the last line is of the same step.
  template <class Scenario>
  [[gnu::cold]] void sample(world<Scenario>& w) {
    if (name_.empty() || (sampled_ && last_ == w.steps())) return;
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
    if (file_ != nullptr) write(columns);
  }

  /// On all ranks: the table goes on after a restart in this step. Lines of later steps, which the
  /// run before had still written, go, and so do those between two of `every` steps.
  [[gnu::cold]] void go_on_from(std::uint64_t step, std::uint64_t every) {
    if (name_.empty()) return;
    sampled_ = true;  // by the run before, if it is the time for a line
    last_ = step;
    if (file_ == nullptr) return;
    std::string kept, line;
    std::rewind(file_);
    for (int c; (c = std::fgetc(file_)) != EOF;) {
      line += static_cast<char>(c);
      if (c != '\n') continue;
      char* end = nullptr;
      const unsigned long long of = std::strtoull(line.c_str(), &end, 10);
      const bool values = end != line.c_str();
      if (!values || (of <= step && of % every == 0)) kept += line;
      headed_ = true;
      line.clear();
    }
    // Beside it, so that the table is whole at any time.
    const std::string beside = name_ + ".part";
    file_ = std::freopen(beside.c_str(), "w", file_);
    if (file_ == nullptr || std::fputs(kept.c_str(), file_) < 0 || std::fflush(file_) != 0 ||
        std::rename(beside.c_str(), name_.c_str()) != 0)
      fail_to_write();
  }

 private:
  [[noreturn, gnu::cold]] void fail_to_write() const {
    detail::fail<std::runtime_error>(
        "the time series could not be written to {}: is the disk "
        "full?",
        name_);
  }
  [[gnu::cold]] void write(const detail::plain_vector<measured>& columns) {
    std::string lines;
    const auto line = [&](auto&& text) {
      const char* separator = "";
      for (const measured& c : columns) {
        (lines += separator) += text(c);
        separator = ",";
      }
      lines += "\n";
    };
    if (!std::exchange(headed_, true))
      line([](const measured& c) {
        return std::string(c.name) + " [" + std::string(c.dimension) + "]";
      });
    line([](const measured& c) { return detail::text(c.value); });
    if (std::fputs(lines.c_str(), file_) < 0 || std::fflush(file_) != 0) fail_to_write();
  }

  std::string name_;
  std::FILE* file_ = nullptr;
  bool headed_ = false, sampled_ = false;
  std::uint64_t last_ = 0;
};

}  // namespace talus
