#pragma once
// The definitions of time_series.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/observe/time_series.hpp"

namespace talus {

TALUS_INLINE time_series::time_series(std::string file, bool speaks, bool goes_on)
    : name_(std::move(file)),
      speaks_(speaks && !name_.empty()),
      begins_(!goes_on && !detail::is_stream(name_)) {
  if (!speaks_) return;
  const bool stream = detail::is_stream(name_);
  if (stream) id_ = ::open(name_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (stream ? id_ < 0 : !detail::part_file(name_).good())
    fail_to_write("cannot be written: " + detail::words_of_failed_write(name_, 0, errno));
}

TALUS_INLINE time_series::~time_series() {
  if (id_ >= 0) ::close(id_);
}

TALUS_INLINE void time_series::finish() {
  try {
    if (id_ >= 0) detail::require_own_output(id_, name_);
  } catch (const std::exception& e) {
    fail_to_write(e.what());
  }
  if (id_ >= 0 && ::close(std::exchange(id_, -1)) != 0)
    fail_to_write("cannot be written: " + detail::words_of_failed_write(name_, 0, errno));
}

TALUS_INLINE void time_series::go_on_from(std::uint64_t step, std::uint64_t every) {
  if (name_.empty()) return;
  sampled_ = true;  // by the earlier run
  if (step % every == 0) last_ = step;
  goes_on_ = true;
  if (!speaks_ || detail::is_stream(name_)) return;
  rewrite([&](std::string& line, bool head) {
    if (head) return head_ = line, true;
    char* end = nullptr;
    const unsigned long long of = std::strtoull(line.c_str(), &end, 10);
    const bool kept = end != line.c_str() && of <= step && of % every == 0;
    if (kept) last_line_ = line;
    return kept;
  });
}

TALUS_INLINE std::string time_series::doubt(const std::array<double, 2>& energies) const {
  // The energies are the columns 4 and 5, after the step, the time and two counts.
  std::size_t at = 0;
  for (int column = 0; column < 4 && at != std::string::npos; ++column)
    at = last_line_.find(',', at == 0 ? 0 : at + 1);
  const char* from = at == std::string::npos ? nullptr : last_line_.c_str() + at + 1;
  const auto size = std::abs(energies[0]) + std::abs(energies[1]);
  for (const double energy : energies) {
    char* end = nullptr;
    const double written = from == nullptr ? energy : std::strtod(from, &end);
    if (from == nullptr || end == from) return "";
    if (!(std::abs(written - energy) <= 1e-9 * size))
      return detail::compose(
          "the table {} has the energy {} at this step, and the state of the checkpoint has {}: is "
          "it the table of another run?",
          name_, written, energy);
    from = *end == ',' ? end + 1 : nullptr;
  }
  return "";
}

TALUS_INLINE void time_series::fail_to_write(const std::string& why) const {
  detail::fail<std::runtime_error>("the time series {} (--csv) {}", name_, why);
}

TALUS_INLINE void time_series::put(const std::string& text) const {
  try {
    detail::add_to_output(id_, name_, text);
  } catch (const std::exception& e) {
    fail_to_write(e.what());
  }
}

TALUS_INLINE void time_series::replace_by(const std::string& text) {
  if (id_ >= 0) ::close(std::exchange(id_, -1));
  try {
    id_ = detail::make_output(name_, text);
  } catch (const std::exception& e) {
    fail_to_write(e.what());
  }
}

TALUS_INLINE std::string time_series::head_of(std::string_view name, std::string_view dimension,
                                              const unit_names& units) {
  std::string head(name);
  if (!dimension.empty()) ((head += " [") += detail::in_units(dimension, units)) += "]";
  return head;
}

TALUS_INLINE std::string time_series::head_line(const detail::plain_vector<measured>& columns,
                                                const records& own, const unit_names& units) {
  std::string head;
  for (const measured& c : columns)
    (head += head.empty() ? "" : ",") += head_of(c.name, c.dimension, units);
  const auto standard = std::count(head.begin(), head.end(), ',');
  for (const detail::recorded_value& r : own) {
    for (const measured& c : columns)
      if (c.name == r.name)
        detail::fail<std::invalid_argument>(
            "world.record was given the name '{}', which is that of another column of the table "
            "{}: take another name",
            r.name, name_);
    head += "," + head_of(r.name, r.dimension, units);
  }
  const auto commas_of = [](std::string_view text) {
    return std::count(text.begin(), text.end(), ',');
  };
  behind_.clear();
  if (head == head_) return {};
  std::string first;
  if (head_.empty()) {
    first = head + "\n";
  } else if (head_.starts_with(head + ",")) {  // columns of the earlier run that are still missing
    behind_.assign(static_cast<std::size_t>(commas_of(head_) - commas_of(head)), ',');
    return {};
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
  return first;
}

TALUS_INLINE void time_series::write(const detail::plain_vector<measured>& columns,
                                     const records& own, const unit_names& units) {
  const std::string head = head_line(columns, own, units);
  std::string line;
  for (const measured& c : columns) (line += line.empty() ? "" : ",") += detail::text(c.value);
  for (const detail::recorded_value& r : own) (line += ",") += detail::text(r.value);
  line = head + line + behind_ + "\n";
  if (std::exchange(begins_, false))
    replace_by(line);
  else
    put(line);
}

}  // namespace talus
