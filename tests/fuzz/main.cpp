// fuzz_scenarios [--runs N] [--seed S] [--only FAMILY] [--seconds T] [--verbose], or fuzz_all
// Random scenarios from consecutive seeds, each checked against the invariants. A run that fails,
// crashes or hangs prints the one command that repeats it.
#define DOCTEST_CONFIG_IMPLEMENT  // the precompiled header refers to it
#include <doctest/doctest.h>
#include <unistd.h>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <thread>

#include "plan.hpp"

namespace {

using clock_type = std::chrono::steady_clock;

struct family {
  const char* name;
  fuzz::outcome (*run)(const fuzz::plan&);
};
// A seed has one family, whichever of them are compiled.
#ifdef TALUS_FUZZ_ALL
const family families[] = {{"spheres", fuzz::run_spheres}, {"solids", fuzz::run_solids},
                           {"jacobi", fuzz::run_jacobi},   {"springs", fuzz::run_springs},
                           {"pursued", fuzz::run_pursued}, {"alike", fuzz::run_alike},
                           {"around", fuzz::run_around}};
#else
const family families[] = {{"spheres", fuzz::run_spheres},
                           {"solids", nullptr},
                           {"jacobi", nullptr},
                           {"springs", fuzz::run_springs},
                           {"pursued", nullptr},
                           {"alike", nullptr},
                           {"around", nullptr}};
#endif

// Of the present run, for reports when it cannot report itself.
char repeat[200];
std::atomic<std::int64_t> started{0};  // ticks; 0: none

void say_repeat(int signal) {
  const char words[] = "\nfuzz_scenarios: the run crashed; repeat it with: ";
  [[maybe_unused]] auto n = write(2, words, sizeof words - 1);
  n = write(2, repeat, std::strlen(repeat));
  n = write(2, "\n", 1);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// Ends the program when one run takes longer than that.
void watch(int seconds) {
  for (;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    const std::int64_t from = started;
    if (from == 0) continue;
    const auto way = clock_type::now().time_since_epoch() - clock_type::duration(from);
    if (way < std::chrono::seconds(seconds)) continue;
    std::fprintf(stderr, "\nfuzz_scenarios: the run hangs for %d s; repeat it with: %s\n", seconds,
                 repeat);
    std::_Exit(3);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t runs = 100, seed = 1;
  int seconds = 60;
  bool verbose = false;
  std::string only;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    const auto value = [&]() -> std::string {
      if (k + 1 < argc) return argv[++k];
      std::fprintf(stderr, "fuzz_scenarios: %s needs a value\n", word.c_str());
      std::exit(2);
    };
    if (word == "--runs")
      runs = std::stoull(value());
    else if (word == "--seed")
      seed = std::stoull(value());
    else if (word == "--only")
      only = value();
    else if (word == "--seconds")
      seconds = std::stoi(value());
    else if (word == "--verbose")
      verbose = true;
    else {
      std::fprintf(stderr,
                   "usage: %s [--runs N] [--seed S] [--only "
                   "spheres|solids|jacobi|springs|pursued|alike|around] "
                   "[--seconds PER_RUN] [--verbose]\n",
                   argv[0]);
      return 2;
    }
  }
  for (const int s : {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS}) std::signal(s, say_repeat);
  std::thread(watch, seconds).detach();

  std::uint64_t done = 0, failed = 0, refused = 0, crossed = 0, contacts = 0;
  double momentum = 0, gain = -1, gain_with_rebound = -1;
  std::map<std::string, int> messages;
  for (std::uint64_t n = 0; n < runs; ++n) {
    const fuzz::plan p = fuzz::draw(seed + n);
    const family& f = families[(seed + n) % std::size(families)];
    if (f.run == nullptr || (!only.empty() && only != f.name)) continue;
    std::snprintf(repeat, sizeof repeat, "%s --runs 1 --seed %llu", argv[0],
                  static_cast<unsigned long long>(p.seed));
    if (verbose) std::fprintf(stderr, "%s: %s, %s\n", repeat, f.name, text(p).c_str());
    started = clock_type::now().time_since_epoch().count();
    try {
      const fuzz::outcome o = f.run(p);
      refused += !o.refused.empty();
      if (!o.refused.empty()) {
        ++messages[o.refused.substr(0, 24)];
        if (verbose) std::fprintf(stderr, "  it says: %s\n", o.refused.c_str());
      }
      crossed += o.crossed, contacts += o.contacts;
      momentum = std::max(momentum, o.momentum_error);
      double& most = p.restitution > 0 ? gain_with_rebound : gain;
      if (o.refused.empty()) most = std::max(most, o.energy_gain);
      if (verbose)
        std::fprintf(stderr, "  energy %+.3g, momentum %.3g\n", o.energy_gain, o.momentum_error);
    } catch (const std::exception& e) {
      ++failed;
      std::fprintf(stderr, "fuzz_scenarios: %s (%s, %s)\n  repeat it with: %s\n", e.what(), f.name,
                   text(p).c_str(), repeat);
    }
    started = 0;
    ++done;
  }
  std::printf(
      "%llu runs from seed %llu: %llu failed, %llu ended with a message; %llu bodies crossed "
      "between "
      "ranks, %llu contacts acted; momentum of free clouds kept to %.2g, energy grew by at most "
      "%.2g "
      "of itself (%.2g with restitution)\n",
      static_cast<unsigned long long>(done), static_cast<unsigned long long>(seed),
      static_cast<unsigned long long>(failed), static_cast<unsigned long long>(refused),
      static_cast<unsigned long long>(crossed), static_cast<unsigned long long>(contacts), momentum,
      gain, gain_with_rebound);
  return failed ? 1 : 0;
}
