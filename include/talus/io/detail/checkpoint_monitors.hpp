#pragma once
// Sums of monitors, and of user-defined features, in a checkpoint: one row for each rank, so that a
// run on as many ranks continues with the same sums to the bit. On another number of ranks the
// first one takes all.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/io/detail/checkpoint_reader.hpp"
#include "talus/io/detail/checkpoint_team.hpp"
#include "talus/io/detail/file_kind.hpp"
#include "talus/state/monitor_numbers.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Calls f(path, record) for the checkpointed data of the features of a scenario: the records of
/// its monitors, and the states of user-defined features that declare it.
template <class Scenario, class F>
void each_stored_record(world_state<Scenario>& s, F&& f) {
  const auto of_monitor = [&](const char* name, auto& record) {
    f(std::string("/monitors/") + name, record);
  };
  each_record_of(s.monitors, of_monitor);
  [&]<class... Features>(type_list<Features...>) {
    const auto of_own = [&]<class Feature>(type_list<Feature>) {
      if constexpr (has_own_state<Feature, Scenario>)
        if constexpr (requires(number_visitor<F> & visit) {
                        own_state<Feature>(s).each_number(visit);
                      })
          f(std::string("/features/") + Feature::name, own_state<Feature>(s));
    };
    (of_own(type_list<Features>{}), ...);
  }(typename Scenario::features{});
}

/// Calls f(path, list) for the lists that the states of features name.
template <class Scenario, class F>
void each_stored_list(world_state<Scenario>& s, F&& f) {
  [&]<class... Features>(type_list<Features...>) {
    [[maybe_unused]] const auto of_own = [&]<class Feature>(type_list<Feature>) {
      if constexpr (has_own_state<Feature, Scenario>) {
        int count = 0;
        const auto number = [&](std::vector<std::uint64_t>& list) {
          f("/lists/" + std::string(Feature::name) + '_' + std::to_string(count++), list);
        };
        list_visitor visit(number);
        if constexpr (requires { own_state<Feature>(s).each_list(visit); })
          own_state<Feature>(s).each_list(visit);
      }
    };
    (of_own(type_list<Features>{}), ...);
  }(typename Scenario::features{});
}

template <class Scenario>
[[gnu::cold]] void put_lists(world_state<Scenario>& s, std::vector<small_dataset>& out) {
  each_stored_list(s, [&](const std::string& path, const std::vector<std::uint64_t>& list) {
    out.push_back(numbers_dataset<std::uint64_t>(path, list));
  });
}
template <class Scenario>
[[gnu::cold]] void get_lists(const checkpoint_reader& in, world_state<Scenario>& s) {
  each_stored_list(s, [&](const std::string& path, std::vector<std::uint64_t>& list) {
    if (in.has(path)) list = in.integers(path);
  });
}

/// The columns of a record: its numbers, and as many for each of its sums as the longest one needs.
struct record_columns {
  /// For each sum at least; files of earlier versions have so many.
  static constexpr std::uint64_t least = 4;
  static constexpr std::uint64_t most = 48;  ///< all digits of a sum

  std::uint64_t numbers = 0, sums = 0, parts = least;

  [[nodiscard]] std::uint32_t width() const {
    return static_cast<std::uint32_t>(numbers + sums * parts);
  }
  void operator()(double&, over_ranks) { ++numbers; }
  void operator()(const signed_sum& x) {
    ++sums;
    parts = std::max<std::uint64_t>(parts, parts_of(x).size());
  }
};

/// Writes the numbers of a record as one row.
struct record_writer {
  byte_writer out;
  std::uint64_t parts;

  void operator()(double& x, over_ranks) { out.put(x); }
  void operator()(const signed_sum& x) {
    std::vector<double> each = parts_of(x);
    each.resize(parts);
    for (const double part : each) out.put(part);
  }
};

/// Reads the numbers of a record from the row of this rank, or as those of all rows on rank 0.
struct record_reader {
  const std::vector<double>& rows;
  std::size_t width, parts, rank, ranks, at = 0;

  [[nodiscard]] bool own() const { return rows.size() == ranks * width; }
  /// Calls f(number) for `count` columns of the rows that count here.
  template <class F>
  void each(std::size_t count, F&& f) {
    for (std::size_t row = own() ? rank : 0; row * width < rows.size(); ++row) {
      for (std::size_t k = 0; k < count; ++k) f(rows[row * width + at + k]);
      if (own()) break;
    }
    at += count;
  }
  void operator()(double& x, over_ranks means) {
    signed_sum sum;
    double largest = 0, mine = 0;
    each(1, [&](double value) { sum += value, mine = value, largest = std::max(largest, value); });
    x = own() ? mine : means == over_ranks::largest ? largest : rank > 0 ? 0 : sum.value();
  }
  void operator()(signed_sum& x) {
    signed_sum sum;
    each(parts, [&](double part) { sum += part; });
    x = own() || rank == 0 ? sum : signed_sum{};
  }
};

/// Collective.
template <class Scenario>
[[gnu::cold]] void put_monitors(checkpoint_team& team, world_state<Scenario>& s,
                                std::vector<small_dataset>& out) {
  each_stored_record(s, [&](const std::string& path, auto& record) {
    record_columns columns;
    each_number(record, columns);
    team.most(std::span(&columns.parts, 1));
    byte_buffer mine;
    record_writer writer{byte_writer(mine), columns.parts};
    each_number(record, writer);
    std::vector<double> rows;
    for (const byte_buffer& each : team.gather(mine)) {
      byte_reader from(each);
      for (std::uint32_t k = 0; k < columns.width(); ++k) rows.push_back(from.get<double>());
    }
    out.push_back(numbers_dataset<double>(path, rows, columns.width()));
  });
}

/// A monitor that was absent in the run that wrote the file starts from zero.
template <class Scenario>
[[gnu::cold]] void get_monitors(const checkpoint_reader& in, world_state<Scenario>& s) {
  each_stored_record(s, [&](const std::string& path, auto& record) {
    if (!in.has(path)) return;
    record_columns columns;
    each_number(record, columns);
    columns.parts = record_columns::least;
    const std::uint32_t stored = in.width(path);
    while (columns.sums > 0 && columns.width() < stored && columns.parts < record_columns::most)
      ++columns.parts;
    const std::vector<double> rows = in.reals(path, checkpoint_reader::any, columns.width());
    record_reader reader{.rows = rows,
                         .width = columns.width(),
                         .parts = columns.parts,
                         .rank = static_cast<std::size_t>(s.link->rank()),
                         .ranks = static_cast<std::size_t>(s.link->size())};
    each_number(record, reader);
  });
}

}  // namespace talus::detail
