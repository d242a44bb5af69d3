#pragma once
// A table of the bonds that break during a run.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/output_file.hpp"
#include "talus/core/run_lock.hpp"
#include "talus/scenario/scenario.hpp"
#include "talus/world/bonds.hpp"
#include "talus/world/world.hpp"

namespace talus {

namespace detail {

inline constexpr std::string_view breaks_head =
    "step,time,x,y,z,normal_x,normal_y,normal_z,mode,a,b\n";
inline constexpr output_kind breaks_output{
    "a table of broken bonds", [](std::string_view head) { return head.starts_with(breaks_head); },
    false};

/// The open table, which one run at a time writes. Exceptions begin with the name of the file.
class breaks_file {
 public:
  explicit breaks_file(std::string file) : file_(std::move(file)) {
    const bool stream = is_stream(file_);
    const output_target target =
        stream ? output_target{} : inspect_target(file_, breaks_output, false);
    if (!target.objection.empty()) fail<std::runtime_error>("{} {}", file_, target.objection);
    if (!stream) lock_.emplace(file_, file_);
    with_name([&] { id_ = begin_output(file_, breaks_head, breaks_output, false); });
  }
  breaks_file(const breaks_file&) = delete;
  breaks_file& operator=(const breaks_file&) = delete;
  ~breaks_file() { ::close(id_); }
  void add(const std::string& lines) const {
    with_name([&] { add_to_output(id_, file_, lines); });
  }

 private:
  template <class F>
  void with_name(F&& f) const {
    try {
      f();
    } catch (const std::exception& e) {
      fail<std::runtime_error>("{} {}", file_, e.what());
    }
  }
  std::string file_;
  std::optional<run_lock> lock_;
  int id_ = -1;
};

/// A broken bond, as ranks send it.
struct break_record {
  std::uint64_t a = 0, b = 0;
  std::array<double, 6> place{};  ///< point and normal
  bond_break how = bond_break::none;
};

/// Collective: the broken bonds of all ranks that `seen` does not have yet, on the first rank; by
/// their ids.
template <class World>
[[nodiscard]] std::vector<break_record> new_breaks(
    World& w, std::set<std::pair<std::uint64_t, std::uint64_t>>& seen) {
  std::vector<break_record> mine;
  for_each_bond(w, [&](const bond_view& b) {
    if (b.broken == bond_break::none) return;
    const auto [low, high] = std::minmax({value_of(b.a), value_of(b.b)});
    if (seen.insert({low, high}).second)
      mine.push_back({low,
                      high,
                      {b.point[0], b.point[1], b.point[2], b.normal[0], b.normal[1], b.normal[2]},
                      b.broken});
  });
  byte_buffer bytes(mine.size() * sizeof(break_record));
  if (!mine.empty()) std::memcpy(bytes.data(), mine.data(), bytes.size());
  const std::vector<byte_buffer> of_ranks = w.link().gather(bytes);
  std::vector<break_record> all = std::move(mine);
  for (std::size_t rank = 1; rank < of_ranks.size(); ++rank)
    for (std::size_t at = 0; at < of_ranks[rank].size(); at += sizeof(break_record)) {
      break_record r;
      std::memcpy(&r, of_ranks[rank].data() + at, sizeof r);
      if (seen.insert({r.a, r.b}).second) all.push_back(r);
    }
  std::sort(all.begin(), all.end(), [](const break_record& x, const break_record& y) {
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  });
  return all;
}

}  // namespace detail

/// Writes the bonds that break from now on to a file of comma-separated values: step and time of
/// the look, place midway between the bodies, unit normal of the bond, mode (tension, shear or
/// range), and the ids of both bodies. Bonds are looked at every so many steps; one whose bodies
/// part beyond the range of the law between two looks is not found. Collective, as is each look.
/// Throws runtime_error alike on all ranks if the file cannot be written, or is not such a table.
template <class Scenario>
void record_breaks(world<Scenario>& w, const std::string& file, every often) {
  (void)detail::require_bond_law<Scenario>();
  w.require_all_ranks("record_breaks", false);
  using pairs = std::set<std::pair<std::uint64_t, std::uint64_t>>;
  const auto seen = std::make_shared<pairs>();
  (void)detail::new_breaks(w, *seen);
  const bool first = w.rank() == 0;
  const auto out = std::make_shared<std::optional<detail::breaks_file>>();
  const auto on_first = [file, first](auto& link, auto&& write) {
    std::string why;
    if (first) try {
        write();
      } catch (const std::exception& e) {
        why = e.what();
      }
    std::uint64_t failed = why.empty() ? 0 : 1;
    link.reduce(reduction::sum, std::span(&failed, 1));
    if (failed != 0)
      detail::fail<std::runtime_error>("the table of broken bonds {}",
                                       why.empty() ? file + " cannot be written" : why);
  };
  on_first(w.link(), [&] { out->emplace(file); });
  w.observe("table of broken bonds", often, [seen, out, on_first](auto& now) {
    const auto found = detail::new_breaks(now, *seen);
    on_first(now.link(), [&] {
      std::string lines;
      for (const detail::break_record& r : found) {
        const char* mode = r.how == bond_break::tension ? "tension"
                           : r.how == bond_break::shear ? "shear"
                                                        : "range";
        char line[320];
        std::snprintf(line, sizeof line, "%llu,%.9g,%.9g,%.9g,%.9g,%.6g,%.6g,%.6g,%s,%llu,%llu\n",
                      static_cast<unsigned long long>(now.steps()), now.time(), r.place[0],
                      r.place[1], r.place[2], r.place[3], r.place[4], r.place[5], mode,
                      static_cast<unsigned long long>(r.a), static_cast<unsigned long long>(r.b));
        lines += line;
      }
      (*out)->add(lines);
    });
  });
}

}  // namespace talus
