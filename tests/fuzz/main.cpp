// fuzz_scenarios [--runs N] [--seed S] [--only FAMILY] [--seconds T] [--verbose] [--shrink], or
// fuzz_all. --only runs every seed with that family. --shrink looks for the smallest part of a
// mechanism that fails.
// Random scenarios from consecutive seeds, each checked against the invariants. A run that fails,
// crashes or hangs prints the one command that repeats it.
#define DOCTEST_CONFIG_IMPLEMENT  // the precompiled header refers to it
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <thread>

#include "plan.hpp"

namespace {

using clock_type = std::chrono::steady_clock;

struct family {
  const char* name;
  fuzz::outcome (*run)(const fuzz::plan&);
};
// Those that are compiled. A seed has one of the first seven, whichever of them are.
#ifdef TALUS_FUZZ_ALL
#define TALUS_IF_ALL(run) run
const char* const of_shapes = "shapes";
#else
#define TALUS_IF_ALL(run) nullptr
const char* const of_shapes = "few_shapes";  // other draws than with all of them
#endif
#ifdef TALUS_FUZZ_MECHANISMS
#define TALUS_IF_MECHANISMS(run) run
#else
#define TALUS_IF_MECHANISMS(run) nullptr
#endif
const family families[] = {
    {"spheres", fuzz::run_spheres},
    {"solids", TALUS_IF_ALL(fuzz::run_solids)},
    {"jacobi", TALUS_IF_ALL(fuzz::run_jacobi)},
    {"springs", fuzz::run_springs},
    {"pursued", TALUS_IF_ALL(fuzz::run_pursued)},
    {"alike", TALUS_IF_ALL(fuzz::run_alike)},
    {"around", TALUS_IF_ALL(fuzz::run_around)},
    {of_shapes, fuzz::run_shapes},
    {"mechanisms", TALUS_IF_MECHANISMS(fuzz::run_mechanisms)},
    {"mechanisms_around", TALUS_IF_ALL(TALUS_IF_MECHANISMS(fuzz::run_mechanisms_around))},
    {"midway", TALUS_IF_ALL(fuzz::run_midway)}};
constexpr std::uint64_t drawn = 7;
bool of_mechanisms(const family& f) { return std::strncmp(f.name, "mech", 4) == 0; }

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
  bool verbose = false, shrinks = false;
  std::string only, item;
  std::set<int> without;
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
    else if (word == "--shrink")
      shrinks = true;
    else if (word == "--without")
      for (std::stringstream items(value()); std::getline(items, item, ',');)
        without.insert(std::stoi(item));
    else {
      std::fprintf(
          stderr,
          "usage: %s [--runs N] [--seed S] [--only "
          "spheres|solids|jacobi|springs|pursued|alike|around|shapes|few_shapes|mechanisms|"
          "mechanisms_around|midway] [--seconds PER_RUN] [--verbose] [--shrink] "
          "[--without ITEM,ITEM]\n",
          argv[0]);
      return 2;
    }
  }
  for (const int s : {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS}) std::signal(s, say_repeat);
  std::thread(watch, seconds).detach();

  std::uint64_t done = 0, failed = 0, refused = 0, crossed = 0, contacts = 0, chaotic = 0;
  double momentum = 0, gain = -1, gain_with_rebound = -1;
  std::map<std::string, int> messages;
  const family* named = std::find_if(std::begin(families), std::end(families),
                                     [&](const family& f) { return only == f.name; });
  if (!only.empty() && (named == std::end(families) || named->run == nullptr)) {
    std::fprintf(stderr, "%s: no family %s is compiled here\n", argv[0], only.c_str());
    return 2;
  }
  for (std::uint64_t n = 0; n < runs; ++n) {
    fuzz::plan p = fuzz::draw(seed + n);
    const family& f = only.empty() ? families[(seed + n) % drawn] : *named;
    if (f.run == nullptr) continue;
    if (f.run == fuzz::run_shapes) p = fuzz::for_shapes(p);
    p.without = without, p.shrinks = shrinks;
    std::snprintf(repeat, sizeof repeat, "%s --only %s --runs 1 --seed %llu", argv[0], f.name,
                  static_cast<unsigned long long>(p.seed));
    const std::string says = of_mechanisms(f) ? "" : ", " + text(p);
    if (verbose) std::fprintf(stderr, "%s: %s%s\n", repeat, f.name, says.c_str());
    started = clock_type::now().time_since_epoch().count();
    try {
      const fuzz::outcome o = f.run(p);
      refused += !o.refused.empty();
      if (!o.refused.empty()) {
        ++messages[o.refused.substr(0, 24)];
        if (verbose) std::fprintf(stderr, "  it says: %s\n", o.refused.c_str());
      }
      crossed += o.crossed, contacts += o.contacts, chaotic += o.chaotic;
      momentum = std::max(momentum, o.momentum_error);
      double& most = p.restitution > 0 ? gain_with_rebound : gain;
      if (o.refused.empty()) most = std::max(most, o.energy_gain);
      if (verbose)
        std::fprintf(stderr, "  energy %+.3g, momentum %.3g\n", o.energy_gain, o.momentum_error);
    } catch (const std::exception& e) {
      ++failed;
      std::fprintf(stderr, "fuzz_scenarios: %s (%s%s)\n  repeat it with: %s\n", e.what(), f.name,
                   says.c_str(), repeat);
    }
    started = 0;
    ++done;
  }
  std::printf(
      "%llu runs from seed %llu: %llu failed, %llu ended with a message; %llu bodies crossed "
      "between "
      "ranks, %llu contacts acted; momentum of free clouds kept to %.2g, energy grew by at most "
      "%.2g "
      "of itself (%.2g with restitution), %llu mechanisms were chaotic\n",
      static_cast<unsigned long long>(done), static_cast<unsigned long long>(seed),
      static_cast<unsigned long long>(failed), static_cast<unsigned long long>(refused),
      static_cast<unsigned long long>(crossed), static_cast<unsigned long long>(contacts), momentum,
      gain, gain_with_rebound, static_cast<unsigned long long>(chaotic));
  return failed ? 1 : 0;
}
