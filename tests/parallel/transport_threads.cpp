// alone
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <mutex>
#include <new>
#include <set>
#include <thread>
#include <vector>

#include "talus/parallel/threads.hpp"
#include "transport_laws.hpp"

#ifdef MPI_VERSION
#error "the transport threads includes MPI"
#endif

using namespace talus;
using namespace talus::transport_laws;
using namespace std::chrono_literals;

static_assert(concepts::transport<threads> && !threads::link::alone);

namespace {
std::atomic<long> allocations = 0;
}
#ifndef TALUS_THREAD_SANITIZER  // which replaces operator new itself: nothing is counted then
// Not inlined, otherwise the compiler compares its own new with this delete, and warns.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size ? size : 1)) return p;
  throw std::bad_alloc{};
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
#endif

TEST_CASE("threads obey the laws of transports") {
  for (const int ranks : {1, 2, 3, 4, 9}) {
    CAPTURE(ranks);
    obeys_all<threads>(ranks);
  }
}

TEST_CASE("threads: the number of ranks is the user's, else the decomposition's, else one") {
  const auto started = [](const launch_settings& s) {
    std::atomic<int> count = 0;
    threads::launch(s, [&](auto&) { ++count; });
    return count.load();
  };
  CHECK(started({}) == 1);
  CHECK(started({.default_ranks = 4}) == 4);
  CHECK(started({.ranks = 3, .default_ranks = 4}) == 3);
  CHECK_THROWS_AS(started({.ranks = -2}), std::invalid_argument);
}

TEST_CASE("threads: rank 0 runs on the calling thread, the others on their own") {
  std::mutex mutex;
  std::set<std::thread::id> ids;
  std::thread::id root;
  threads::launch({.ranks = 5}, [&](auto& l) {
    const std::lock_guard lock(mutex);
    ids.insert(std::this_thread::get_id());
    if (l.rank() == 0) root = std::this_thread::get_id();
  });
  CHECK(ids.size() == 5);
  CHECK(root == std::this_thread::get_id());
}

TEST_CASE("threads: a thousand ranks") {
  delivers_in_order<threads>(1024, 3);
  threads::launch({.ranks = 1024}, [&](auto& l) {
    std::uint64_t one = 1;
    l.reduce(reduction::sum, std::span(&one, 1));
    demand(one == 1024, "all are counted");
  });
}

TEST_CASE("threads: the iterations of a solver allocate nothing") {
  long before = -1, after = -1;
  threads::launch({.ranks = 4}, [&](auto& l) {
    auto neighbour_messages = parcels_around(l);
    const auto iterate = [&](int times) {
      for (int i = 0; i < times; ++i) {
        for (neighbour_message& p : neighbour_messages) {
          p.out.resize(fixed_size(l.rank(), p.rank));
          p.in.resize(fixed_size(p.rank, l.rank()));
        }
        l.start_fixed(neighbour_messages);
        l.finish_fixed(neighbour_messages);
      }
    };
    iterate(50);
    l.barrier();
    l.barrier();
    if (l.rank() == 0) before = allocations;
    iterate(500);
    if (l.rank() == 0) after = allocations;  // its neighbours may be iterating still
  });
  CHECK(after - before <= 16);  // of 2000 exchanges: the second barrier of the other ranks
}

TEST_CASE("threads: a blocked rank burns no core") {
  const auto cpu = std::clock();
  threads::launch({.ranks = 8}, [&](auto& l) {
    auto neighbour_messages = parcels_around(l);
    for (int step = 0; step < 4; ++step) {
      if (l.rank() == 0) std::this_thread::sleep_for(100ms);
      exchange_fixed(l, neighbour_messages, step);
      l.barrier();
    }
  });
  CHECK(double(std::clock() - cpu) / CLOCKS_PER_SEC < 0.15);
}

TEST_CASE("threads: an error on one rank ends all, whatever the others wait for") {
  struct custom : std::runtime_error {
    using std::runtime_error::runtime_error;
  };
  for (const int culprit : {0, 2, 6}) {
    std::atomic<int> ended_by_it = 0;
    const auto run = [&] {
      threads::launch({.ranks = 7}, [&](auto& l) {
        auto neighbour_messages = parcels_around(l);
        try {
          for (int step = 0;; ++step) {
            if (step == 20 && l.rank() == culprit) throw custom("rank is tired");
            exchange_unknown(l, neighbour_messages, step);
            if (l.rank() % 2)
              exchange_fixed(l, neighbour_messages, step);
            else
              exchange_fixed(l, neighbour_messages, step);
            if (step % 5 == 0) (void)l.gather_all(byte_buffer(10));
          }
        } catch (const aborted&) {
          ++ended_by_it;
          throw;
        }
      });
    };
    CHECK_THROWS_WITH_AS(run(), "rank is tired", custom);
    CHECK(ended_by_it == 6);
  }
}

TEST_CASE("threads: of many errors one is thrown") {
  for (int repeat = 0; repeat < 20; ++repeat) {
    try {
      threads::launch({.ranks = 16}, [&](auto& l) {
        l.barrier();
        detail::fail<std::range_error>("rank {}", l.rank());
      });
      FAIL("no error");
    } catch (const std::range_error& e) {
      CHECK(std::string(e.what()).starts_with("rank "));
    }
  }
}

TEST_CASE("threads: what would wait for ever is an error that says who waits for whom") {
  SUBCASE("a connection that only one side knows") {
    const auto run = [] {
      threads::launch({.ranks = 4}, [](auto& l) {
        std::vector<neighbour_message> neighbour_messages;
        if (l.rank() == 1) neighbour_messages.push_back({2});
        l.start(neighbour_messages);
        l.finish(neighbour_messages);
        l.barrier();
      });
    };
    CHECK_THROWS_WITH_AS(run(), doctest::Contains("rank 1 waits for a message from rank 2"),
                         std::logic_error);
  }
  SUBCASE("a rank that has ended") {
    const auto run = [] {
      threads::launch({.ranks = 3}, [](auto& l) {
        if (l.rank() == 2) return;
        l.barrier();
      });
    };
    CHECK_THROWS_WITH_AS(run(), doctest::Contains("rank 2 has ended"), std::logic_error);
  }
  SUBCASE("different collectives") {
    const auto run = [] {
      threads::launch({.ranks = 3}, [](auto& l) {
        if (l.rank() == 2)
          (void)l.gather_all({});
        else
          l.barrier();
      });
    };
    CHECK_THROWS_WITH_AS(run(), doctest::Contains("different collectives"), std::logic_error);
  }
  SUBCASE("different numbers of values") {
    const auto run = [] {
      threads::launch({.ranks = 3}, [](auto& l) {
        std::vector<double> values(l.rank() + 1);
        l.reduce(reduction::sum, std::span(values));
      });
    };
    CHECK_THROWS_AS(run(), std::logic_error);
  }
}

TEST_CASE("threads: launches may be nested and follow one another") {
  std::atomic<int> inner = 0;
  threads::launch({.ranks = 3}, [&](auto& outer) {
    threads::launch({.ranks = 2}, [&](auto& l) {
      auto neighbour_messages = parcels_around(l);
      exchange_unknown(l, neighbour_messages, outer.rank());
      ++inner;
    });
    outer.barrier();
  });
  CHECK(inner == 6);
}

TEST_CASE("threads refuse to be several processes of one job") {
  setenv("PMI_SIZE", "4", 1);
  setenv("PMI_RANK", "0", 1);
  CHECK_THROWS_WITH_AS(threads::launch({}, [](auto&) {}), doctest::Contains("talus/mpi.hpp"),
                       std::runtime_error);
  unsetenv("PMI_SIZE");
  unsetenv("PMI_RANK");
}

TEST_CASE("threads: ranks that end at the same time end well") {
  constexpr int rounds = 20000;
  std::vector<std::unique_ptr<detail::thread_team>> teams;
  for (int k = 0; k < rounds; ++k) teams.push_back(std::make_unique<detail::thread_team>(2));
  std::atomic<int> here = 0;
  const auto leave_all = [&](int rank) {
    for (int k = 0; k < rounds; ++k) {
      ++here;
      for (int spins = 0; here < 2 * (k + 1);)  // both at once
        if (++spins > 1000) std::this_thread::yield();
      teams[static_cast<std::size_t>(k)]->leave(rank);
    }
  };
  std::jthread other(leave_all, 1);
  leave_all(0);
  other.join();
  for (const auto& team : teams) CHECK_NOTHROW(team->rethrow());
}
