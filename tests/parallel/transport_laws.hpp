#pragma once
// The laws of every transport. Each law runs a program on `ranks` ranks, which throws if the law is
// violated: launch() must report that, for any transport.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "talus/concepts.hpp"
#include "talus/core/error.hpp"
#include "talus/core/id.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/parallel/launch_settings.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/parallel/traffic.hpp"

namespace talus::transport_laws {

using detail::byte_buffer;

inline void demand(bool holds, const std::string& law) {
  if (!holds) throw std::logic_error("law broken: " + law);
}

template <std::derived_from<std::exception> Error, class F>
void demand_error(F&& f, const std::string& law, const std::string& part_of_text = "") {
  try {
    f();
  } catch (const Error& e) {
    demand(std::string(e.what()).find(part_of_text) != std::string::npos,
           law + ": the message lacks '" + part_of_text + "': " + e.what());
    return;
  }
  demand(false, law + ": no error");
}

/// Ranks at ring distances 1 and 2, each once, itself not among them.
inline std::vector<int> around(int rank, int ranks) {
  std::vector<int> near;
  for (const int d : {1, 2, ranks - 1, ranks - 2}) near.push_back((rank + d + ranks) % ranks);
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::erase(near, rank);
  return near;
}

template <class Link>
std::vector<neighbour_message> parcels_around(const Link& l) {
  std::vector<neighbour_message> neighbour_messages;
  for (const int rank : around(l.rank(), l.size())) neighbour_messages.push_back({rank});
  return neighbour_messages;
}

/// Content that depends on sender, receiver and time.
inline void fill(byte_buffer& out, int from, int to, int step, std::size_t size) {
  out.resize(size);
  std::uint64_t state = detail::mix(detail::mix(from * 100003ull + to) + step);
  for (std::byte& b : out) b = std::byte((state = state * 6364136223846793005ull + 1) >> 56);
}
inline void demand_content(const byte_buffer& in, int from, int to, int step, std::size_t size) {
  byte_buffer expected;
  fill(expected, from, to, step, size);
  demand(in.size() == size, fmt::format("{} bytes came from {} to {} in step {}, not {}", in.size(),
                                        from, to, step, size));
  demand(in == expected, fmt::format("content from {} to {} in step {}", from, to, step));
}
/// Sizes unknown to the receiver: many empty, some of thousands of bytes, a few of a megabyte.
inline std::size_t some_size(int from, int to, int step) {
  const auto h = detail::mix(detail::mix(from * 7919ull + to) + step);
  if (h % 4 == 0) return 0;
  if (h % 61 == 1) return 1'000'000 + h % 1000;
  return (h >> 8) % 9000;
}
inline std::size_t fixed_size(int from, int to) { return 48u * ((from * 3 + to * 5) % 13); }

template <class Link>
void exchange_unknown(Link& l, std::vector<neighbour_message>& neighbour_messages, int step) {
  const int me = l.rank();
  for (neighbour_message& p : neighbour_messages)
    fill(p.out, me, p.rank, step, some_size(me, p.rank, step));
  l.start(neighbour_messages);
  l.finish(neighbour_messages);
  for (const neighbour_message& p : neighbour_messages) {
    demand_content(p.in, p.rank, me, step, some_size(p.rank, me, step));
    demand(p.out.empty(), "out is empty after finish");
  }
}
template <class Link>
void exchange_fixed(Link& l, std::vector<neighbour_message>& neighbour_messages, int step) {
  const int me = l.rank();
  for (neighbour_message& p : neighbour_messages) {
    fill(p.out, me, p.rank, step, fixed_size(me, p.rank));
    p.in.resize(fixed_size(p.rank, me));
  }
  l.start_fixed(neighbour_messages);
  l.finish_fixed(neighbour_messages);
  for (const neighbour_message& p : neighbour_messages) {
    demand_content(p.in, p.rank, me, step, fixed_size(p.rank, me));
    demand(p.out.size() == fixed_size(me, p.rank), "out keeps its size after finish_fixed");
  }
}

template <concepts::transport Transport>
void on_ranks(int ranks, auto&& main) {
  Transport::launch(launch_settings{.ranks = ranks}, main);
}

template <concepts::transport Transport>
void knows_itself(int ranks) {
  on_ranks<Transport>(ranks, [&](auto& l) {
    demand(l.size() == ranks, "size is what was asked for");
    demand(l.rank() >= 0 && l.rank() < ranks, "rank is in range");
    demand(!(l.alone && ranks > 1), "alone means one rank");
    std::vector<std::uint64_t> seen(ranks);
    seen[l.rank()] = 1;
    l.reduce(reduction::sum, std::span(seen));
    demand(std::ranges::count(seen, 1u) == ranks, "each rank is there once");
  });
}

template <concepts::transport Transport>
void delivers_in_order(int ranks, int steps = 60) {
  on_ranks<Transport>(ranks, [&](auto& l) {
    auto neighbour_messages = parcels_around(l);
    for (int step = 0; step < steps; ++step) exchange_unknown(l, neighbour_messages, step);
    for (int step = 0; step < steps; ++step) exchange_fixed(l, neighbour_messages, step);
  });
}

/// Ranks are as far apart as their connections allow, and the kinds of calls alternate.
template <concepts::transport Transport>
void keeps_apart_what_drifts(int ranks, int steps = 60) {
  on_ranks<Transport>(ranks, [&](auto& l) {
    std::mt19937 random(static_cast<unsigned>(l.rank()));
    auto neighbour_messages = parcels_around(l);
    auto few = neighbour_messages;  // another set of parcels between the same ranks
    for (int step = 0; step < steps; ++step) {
      if (random() % 8 == 0)
        std::this_thread::sleep_for(std::chrono::microseconds(random() % 2000));
      if (step % 20 == 19) {  // also a collective in between
        const byte_buffer mine(l.rank() + 1, std::byte(step));
        const auto all = l.gather_all(mine);
        for (int r = 0; r < ranks; ++r)
          demand(all[r] == byte_buffer(r + 1, std::byte(step)), "gather_all amid exchanges");
        (void)l.gather(mine);
      }
      step % 3 ? exchange_fixed(l, neighbour_messages, step) : exchange_unknown(l, few, step);
    }
  });
}

/// Ranks in a row, each connected to the next only: the ends may be many steps apart.
template <concepts::transport Transport>
void lets_ends_drift(int ranks, int steps = 40) {
  on_ranks<Transport>(ranks, [&](auto& l) {
    std::vector<neighbour_message> neighbour_messages;
    for (const int r : {l.rank() - 1, l.rank() + 1})
      if (r >= 0 && r < ranks) neighbour_messages.push_back({r});
    for (int step = 0; step < steps; ++step) {
      if (step == 10 && l.rank() == ranks - 1)
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      exchange_fixed(l, neighbour_messages, step);
    }
  });
}

template <concepts::transport Transport>
void exchanges_nothing(int ranks) {
  on_ranks<Transport>(ranks, [&](auto& l) {
    std::vector<neighbour_message> none;
    l.start(none);
    l.finish(none);
    l.start_fixed(none);
    l.finish_fixed(none);
    auto neighbour_messages = parcels_around(l);  // and empty messages
    l.start_fixed(neighbour_messages);
    l.finish_fixed(neighbour_messages);
    l.start(neighbour_messages);
    l.finish(neighbour_messages);
    for (const neighbour_message& p : neighbour_messages)
      demand(p.in.empty(), "an empty message is empty");
  });
}

template <concepts::transport Transport>
void talks_to_itself(int ranks) {
  on_ranks<Transport>(ranks, [&](auto& l) {
    const int me = l.rank(), next = (me + 1) % ranks, last = (me + ranks - 1) % ranks;
    std::vector<neighbour_message> neighbour_messages{{me}, {me}};
    for (int step = 0; step < 3; ++step) {
      for (int k = 0; k < 2; ++k) fill(neighbour_messages[k].out, me, me, 2 * step + k, 100 + k);
      l.start(neighbour_messages);
      l.finish(neighbour_messages);
      for (int k = 0; k < 2; ++k)
        demand_content(neighbour_messages[k].in, me, me, 2 * step + k, 100 + k);
    }
    // Several connections to one neighbour, as in a periodic domain: in the order of the lists.
    neighbour_messages = {{next}, {next}, {last}, {last}};
    for (int k = 0; k < 4; ++k) {
      fill(neighbour_messages[k].out, me, neighbour_messages[k].rank, k, 64);
      neighbour_messages[k].in.resize(64);
    }
    l.start_fixed(neighbour_messages);
    l.finish_fixed(neighbour_messages);
    for (int k = 0; k < 4; ++k)
      demand_content(neighbour_messages[k].in, neighbour_messages[k].rank, me,
                     ranks > 2 ? (k + 2) % 4 : k, 64);
  });
}

template <concepts::transport Transport>
void has_collectives(int ranks) {
  on_ranks<Transport>(ranks, [&](auto& l) {
    const int me = l.rank();
    for (int round = 0; round < 3; ++round) {
      byte_buffer mine;
      fill(mine, me, 0, round, some_size(me, 0, round) % 5000);
      const auto at_root = l.gather(mine);
      demand(std::ssize(at_root) == (me == 0 ? ranks : 0), "gather has a result on rank 0 only");
      for (const auto& all : {at_root, l.gather_all(mine)})
        for (int r = 0; r < std::ssize(all); ++r)
          demand_content(all[r], r, 0, round, some_size(r, 0, round) % 5000);
      l.barrier();
      byte_buffer said;
      if (me == 0)
        fill(said, 0, 0, round, 777 * round);
      else
        said.resize(33);
      l.broadcast(said);
      demand_content(said, 0, 0, round, 777 * round);
    }
    const auto value = [](int r) { return std::sin(r + 0.3) * std::pow(10.0, r % 7); };
    std::vector<double> sums{value(me), -value(me), 0.1}, low = sums, high = sums;
    l.reduce(reduction::sum, std::span(sums));
    l.reduce(reduction::min, std::span(low));
    l.reduce(reduction::max, std::span(high));
    std::vector<double> expected{value(0), -value(0), 0.1};
    double least = value(0), most = value(0);
    for (int r = 1; r < ranks; ++r) {
      expected[0] += value(r), expected[1] += -value(r), expected[2] += 0.1;
      least = std::min(least, value(r)), most = std::max(most, value(r));
    }
    demand(std::memcmp(sums.data(), expected.data(), 24) == 0, "sums run from rank 0, to the bit");
    demand(low == std::vector{least, -most, 0.1}, "min");
    demand(high == std::vector{most, -least, 0.1}, "max");
    for (const auto how : {reduction::sum, reduction::min, reduction::max}) {
      double x = me == ranks / 2 ? std::numeric_limits<double>::quiet_NaN() : me;
      l.reduce(how, std::span(&x, 1));
      demand(std::isnan(x), "a NaN of one rank is not lost");
    }
    const std::uint64_t big = std::uint64_t{1} << 60;
    std::uint64_t n[] = {big + me};
    l.reduce(reduction::max, std::span<std::uint64_t>(n));
    demand(n[0] == big + ranks - 1, "max of counts is exact");
    const std::uint64_t huge = ~std::uint64_t{0} - ranks;
    std::uint64_t ends[] = {me == 0 ? huge : std::uint64_t{1}};
    l.reduce(reduction::max, std::span<std::uint64_t>(ends));
    demand(ends[0] == huge, "the max of counts holds above 2^63");
    ends[0] = me == 0 ? 1 : huge;
    l.reduce(reduction::min, std::span<std::uint64_t>(ends));
    demand(ends[0] == 1, "the min of counts holds above 2^63");
    n[0] = big + me;
    l.reduce(reduction::min, std::span<std::uint64_t>(n));
    demand(n[0] == big, "min of counts is exact");
    n[0] = me + 1;
    l.reduce(reduction::sum, std::span<std::uint64_t>(n));
    demand(n[0] == std::uint64_t(ranks) * (ranks + 1) / 2, "sum of counts is exact");
    l.reduce(reduction::sum, std::span<double>{});
  });
}

/// Ranks continue with exchanges, other collectives and much drift between the two halves.
template <concepts::transport Transport>
void reduces_while_it_goes_on(int ranks, int rounds = 40) {
  on_ranks<Transport>(ranks, [&](auto& l) {
    const int me = l.rank();
    std::mt19937 random(static_cast<unsigned>(7 + me));
    auto neighbour_messages = parcels_around(l);
    const auto value = [](int r, int round) { return std::sin(r + 0.1 * round) * (1 + r % 3); };
    for (int round = 0; round < rounds; ++round) {
      const auto how = static_cast<reduction>(round % 3);
      std::vector<double> values{value(me, round), 1.0 * me, 0.1}, expected = values;
      if (round % 5 == 0) expected = values = {};  // an empty reduction is allowed too
      l.start_reduce(how, std::span<const double>(values));
      l.reduce(how, std::span(expected));  // a collective in between
      for (int k = 0; k < round % 4; ++k) exchange_fixed(l, neighbour_messages, 4 * round + k);
      if (random() % 8 == 0)
        std::this_thread::sleep_for(std::chrono::microseconds(random() % 2000));
      l.finish_reduce(std::span(values));
      demand(std::memcmp(values.data(), expected.data(), 8 * values.size()) == 0,
             "the same as reduce, to the bit");
    }
    const traffic before = l.counters();
    double x = me == ranks - 1 ? std::numeric_limits<double>::quiet_NaN() : me;
    demand_error<std::logic_error>([&] { l.finish_reduce(std::span(&x, 1)); },
                                   "finish_reduce without start_reduce");
    l.start_reduce(reduction::max, std::span<const double>(&x, 1));
    demand_error<std::logic_error>(
        [&] { l.start_reduce(reduction::max, std::span<const double>(&x, 1)); },
        "two reductions at a time");
    demand_error<std::logic_error>([&] { l.finish_reduce({}); }, "another number of values");
    l.finish_reduce(std::span(&x, 1));
    demand(std::isnan(x), "a NaN of one rank is not lost");
    demand(l.counters() - before == traffic{0, 0, 1}, "it counts as one collective");
  });
}

template <concepts::transport Transport>
void counts_what_it_sends(int ranks) {
  on_ranks<Transport>(ranks, [&](auto& l) {
    demand(l.counters() == traffic{}, "counters begin at 0");
    auto neighbour_messages = parcels_around(l);
    std::uint64_t bytes = 0;
    for (int step = 0; step < 5; ++step) {
      for (const neighbour_message& p : neighbour_messages)
        bytes += some_size(l.rank(), p.rank, step) + fixed_size(l.rank(), p.rank);
      exchange_unknown(l, neighbour_messages, step);
      exchange_fixed(l, neighbour_messages, step);
    }
    const traffic exchanged = l.counters();
    demand(exchanged == traffic{10 * neighbour_messages.size(), bytes, 0},
           "one message a neighbour_message, all bytes");
    byte_buffer some(10);
    double x = 1;
    std::uint64_t n = 1;
    l.barrier();
    (void)l.gather(some);
    (void)l.gather_all(some);
    l.broadcast(some);
    l.reduce(reduction::sum, std::span(&x, 1));
    l.reduce(reduction::max, std::span(&n, 1));
    demand(l.counters() - exchanged == traffic{0, 0, 6},
           "each collective counts once, and only so");
  });
}

template <concepts::transport Transport>
void refuses_misuse(int ranks) {
  on_ranks<Transport>(ranks, [&](auto& l) {
    std::vector<neighbour_message> neighbour_messages{{l.rank()}}, others = neighbour_messages,
                                                                   wrong{{ranks}};
    demand_error<std::invalid_argument>([&] { l.start(wrong); }, "no such rank",
                                        fmt::format("rank {}, but", ranks));
    wrong[0].rank = -1;
    demand_error<std::invalid_argument>([&] { l.start_fixed(wrong); }, "no rank");
    demand_error<std::logic_error>([&] { l.finish(neighbour_messages); }, "finish without start");
    l.start(neighbour_messages);
    demand_error<std::logic_error>([&] { l.start(others); }, "two at a time");
    demand_error<std::logic_error>([&] { l.finish(others); }, "other neighbour_messages");
    demand_error<std::logic_error>([&] { l.finish_fixed(neighbour_messages); }, "the other finish");
    demand_error<std::logic_error>([&] { l.barrier(); }, "a collective inside an exchange");
    l.finish(neighbour_messages);
    for (const std::size_t size : {8u, 16u}) {    // less and more than expected
      neighbour_messages[0].rank = l.rank() ^ 1;  // a pair
      if (neighbour_messages[0].rank >= ranks) neighbour_messages[0].rank = l.rank();
      neighbour_messages[0].out.resize(size);
      neighbour_messages[0].in.resize(12);
      l.start_fixed(neighbour_messages);
      demand_error<std::runtime_error>([&] { l.finish_fixed(neighbour_messages); }, "a wrong size",
                                       "expected 12 bytes from rank");
    }
    exchange_unknown(l, neighbour_messages, 3);  // and it still works
    demand(l.counters().collectives == 0, "what is refused is not counted");
  });
}

template <concepts::transport Transport>
void obeys_all(int ranks) {
  knows_itself<Transport>(ranks);
  delivers_in_order<Transport>(ranks);
  keeps_apart_what_drifts<Transport>(ranks);
  lets_ends_drift<Transport>(ranks);
  exchanges_nothing<Transport>(ranks);
  talks_to_itself<Transport>(ranks);
  has_collectives<Transport>(ranks);
  reduces_while_it_goes_on<Transport>(ranks);
  counts_what_it_sends<Transport>(ranks);
  refuses_misuse<Transport>(ranks);
}

}  // namespace talus::transport_laws
