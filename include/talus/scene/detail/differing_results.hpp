#pragma once
// Whether the ranks of a run return the same results, of which rank 0 reports its own.
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/observe/summary_figures.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus::detail {

/// A sentence about results that differ between ranks; empty if they are alike, to the bit.
/// Collective.
template <class Link>
[[gnu::cold]] std::string differing_results(Link& link, const results& own) {
  const auto least = [&](std::span<std::uint64_t> v) { link.reduce(reduction::min, v); };
  const auto most = [&](std::span<std::uint64_t> v) { link.reduce(reduction::max, v); };

  std::array<std::uint64_t, 1> fewest{own.size()}, all{own.size()};
  least(fewest);
  most(all);
  if (fewest != all)
    return compose(
        "ranks return between {} and {} results, and those of rank 0 are reported: return the same "
        "results on all ranks",
        fewest[0], all[0]);

  std::vector<std::uint64_t> low, high;
  for (const auto& [name, value] : own) low.push_back(std::bit_cast<std::uint64_t>(value));
  high = low;
  least(low);
  most(high);
  const auto differs = std::ranges::mismatch(low, high).in1;
  if (differs == low.end()) return {};
  const auto& [name, value] = own[static_cast<std::size_t>(differs - low.begin())];
  std::array<double, 1> smallest{value}, largest{value};
  link.reduce(reduction::min, std::span<double>(smallest));
  link.reduce(reduction::max, std::span<double>(largest));
  return compose(
      "ranks return different results, and those of rank 0 are reported: '{}' is {} on rank 0, and "
      "from {} to {} over all ranks; combine the values before they are returned, as by "
      "world.link().reduce(reduction::max, values)",
      name, text(value, 5), text(smallest[0], 5), text(largest[0], 5));
}

/// Warns if the ranks return different results: in the log of the program and, unless `quiet`, on
/// standard error. Collective.
template <class Link, class Log>
[[gnu::cold]] void mention_results(Log& log, const std::string& program, Link& link,
                                   const results& own, bool quiet) {
  const std::string words = differing_results(link, own);
  if (link.rank() == 0 && !words.empty())
    log.say(compose("{}: warning: {}\n", program, words), quiet);
}

}  // namespace talus::detail
