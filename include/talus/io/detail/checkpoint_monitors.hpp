#pragma once
// Sums of monitors, and of user-defined features, in a checkpoint: one row for each rank, so that a
// run on as many ranks continues with the same sums to the bit. On another number of ranks the
// first one takes all.
#include <algorithm>
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

/// Collective.
template <class Scenario>
[[gnu::cold]] void put_monitors(checkpoint_team& team, world_state<Scenario>& s,
                                std::vector<small_dataset>& out) {
  each_stored_record(s, [&](const std::string& path, auto& record) {
    byte_buffer mine;
    std::uint32_t width = 0;
    each_number(record, [&](double& x, over_ranks) { byte_writer(mine).put(x), ++width; });
    std::vector<double> rows;
    for (const byte_buffer& each : team.gather(mine)) {
      byte_reader from(each);
      for (std::uint32_t k = 0; k < width; ++k) rows.push_back(from.get<double>());
    }
    out.push_back(numbers_dataset<double>(path, rows, width));
  });
}

/// A monitor that was absent in the run that wrote the file starts from zero.
template <class Scenario>
[[gnu::cold]] void get_monitors(const checkpoint_reader& in, world_state<Scenario>& s) {
  each_stored_record(s, [&](const std::string& path, auto& record) {
    if (!in.has(path)) return;
    std::uint32_t width = 0;
    each_number(record, [&](double&, over_ranks) { ++width; });
    const std::vector<double> rows = in.reals(path, checkpoint_reader::any, width);
    const auto rank = static_cast<std::size_t>(s.link->rank()),
               ranks = static_cast<std::size_t>(s.link->size());
    std::size_t at = 0;
    signed_sum left;  // of a sum and its rest
    each_number(record, [&](double& x, over_ranks means) {
      if (rows.size() == ranks * width) {
        x = rows[rank * width + at++];
        return;
      }
      double largest = 0;
      if (means != over_ranks::rest) left = {};
      for (std::size_t k = at; k < rows.size(); k += width)
        left += rows[k], largest = std::max(largest, rows[k]);
      const double sum = left.value();
      left -= sum;
      x = means == over_ranks::largest ? largest : rank > 0 ? 0 : sum;
      ++at;
    });
  });
}

}  // namespace talus::detail
