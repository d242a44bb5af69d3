#pragma once
// Sums of monitors in a checkpoint: one row for each rank, so that a run on as many ranks goes on
// with the same sums to the bit. On another number of ranks the first one takes all.
#include <algorithm>
#include <string>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/io/detail/checkpoint_reader.hpp"
#include "talus/io/detail/checkpoint_team.hpp"
#include "talus/io/detail/file_kind.hpp"
#include "talus/world/monitor_numbers.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

/// Collective.
template <class Scenario>
[[gnu::cold]] void put_monitors(checkpoint_team& team, world_state<Scenario>& s,
                                std::vector<small_dataset>& out) {
  each_monitor<Scenario>(s.monitors, [&](const char* name, auto& record) {
    byte_buffer mine;
    std::uint32_t width = 0;
    each_number(record, [&](double& x, over_ranks) { byte_writer(mine).put(x), ++width; });
    std::vector<double> rows;
    for (const byte_buffer& each : team.gather(mine)) {
      byte_reader from(each);
      for (std::uint32_t k = 0; k < width; ++k) rows.push_back(from.get<double>());
    }
    out.push_back(numbers_dataset<double>(std::string("/monitors/") + name, rows, width));
  });
}

/// A monitor that the run that wrote did not have begins anew.
template <class Scenario>
[[gnu::cold]] void get_monitors(const checkpoint_reader& in, world_state<Scenario>& s) {
  each_monitor<Scenario>(s.monitors, [&](const char* name, auto& record) {
    const std::string path = std::string("/monitors/") + name;
    if (!in.has(path)) return;
    std::uint32_t width = 0;
    each_number(record, [&](double&, over_ranks) { ++width; });
    const std::vector<double> rows = in.reals(path, checkpoint_reader::any, width);
    const auto rank = static_cast<std::size_t>(s.link->rank()),
               ranks = static_cast<std::size_t>(s.link->size());
    std::size_t at = 0;
    each_number(record, [&](double& x, over_ranks means) {
      if (rows.size() == ranks * width) {
        x = rows[rank * width + at++];
        return;
      }
      double all = 0;
      for (std::size_t k = at; k < rows.size(); k += width)
        all = means == over_ranks::sum ? all + rows[k] : std::max(all, rows[k]);
      x = means == over_ranks::sum && rank > 0 ? 0 : all;
      ++at;
    });
  });
}

}  // namespace talus::detail
