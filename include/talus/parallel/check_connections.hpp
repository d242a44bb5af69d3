#pragma once
// Checks that the connections of all ranks are consistent, by comparing the connections of the
// ranks and by sampling points on and around every boundary.
#include "talus/parallel/detail/check_connections.hpp"
#include "talus/parallel/domain.hpp"

namespace talus {

/// The flaws in the connections of a job, element r of `all` being the connections of rank r.
/// `partition` decides the ownership; without one each rank owns the points that no connected rank
/// claims. At most one flaw of a kind is reported for a pair of ranks. A pure function.
template <concepts::partition Partition>
[[nodiscard]] std::vector<connection_flaw> check_connections(
    std::span<const std::vector<connection>> all, const Partition& cells,
    const connection_check& settings = {}) {
  const detail::partition_rule<Partition> rule{cells};
  return detail::connection_checker(all, rule, settings).run();
}
template <class = void>  // compiled only in programs that call it
[[nodiscard]] std::vector<connection_flaw> check_connections(
    std::span<const std::vector<connection>> all, const connection_check& settings = {}) {
  const detail::hand_rule rule{all};
  return detail::connection_checker(all, rule, settings).run();
}

/// Checks the connections of all ranks of a job; to be called on every rank. `gather(buffer)`
/// returns the buffers of all ranks, on every rank (a collective call). Each rank samples its own
/// boundaries. Throws runtime_error with the same message on all ranks if anything is wrong.
template <concepts::decomposition Decomposition, class Gather>
void check_connections(const domain<Decomposition>& mine, Gather&& gather,
                       connection_check settings = {}) {
  detail::byte_buffer out;
  detail::byte_writer writer(out);
  writer.put(mine.connections().size());
  for (const connection& c : mine.connections()) c.write(writer);
  std::vector<std::vector<connection>> all;
  for (const detail::byte_buffer& in : gather(out)) {
    detail::byte_reader reader(in);
    auto& list = all.emplace_back();
    for (auto n = reader.get<std::size_t>(); n > 0; --n) list.push_back(connection::read(reader));
  }

  settings.first = mine.rank();
  settings.last = mine.rank() + 1;
  std::vector<connection_flaw> flaws;
  if constexpr (concepts::generating_decomposition<Decomposition>) {
    if (mine.partition()) flaws = check_connections(all, *mine.partition(), settings);
  } else {
    flaws = check_connections(all, settings);
  }

  out.clear();
  for (const connection_flaw& f : flaws) {
    writer.put(f.kind), writer.put(f.rank), writer.put(f.other);
    writer.put(std::span<const char>(f.message));
  }
  std::vector<connection_flaw> merged;
  for (const detail::byte_buffer& in : gather(out))
    for (detail::byte_reader reader(in); !reader.empty();) {
      connection_flaw f{reader.get<flaw>(), reader.get<int>(), reader.get<int>(), {0, 0, 0}, {}};
      const auto text = reader.get_all<char>();
      f.message.assign(text.begin(), text.end());
      if (!detail::known(merged, f)) merged.push_back(std::move(f));
    }
  if (!merged.empty()) throw std::runtime_error(detail::summary(merged));
}

}  // namespace talus
