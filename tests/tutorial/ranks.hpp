#pragma once
// Tools that make the programs of docs/tutorial.md tests: several ranks in this process, numbers of
// all ranks together, and messages compared to the letter.
#include <doctest/doctest.h>

#include <array>
#include <span>
#include <string>
#include <talus/talus.hpp>
#include <typeinfo>

namespace talus::tutorial {

/// Runs program(world) on every one of several ranks.
template <class Scenario, class Program>
void on_ranks(int ranks, Program&& program) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link);
    program(w);
  });
}

/// A number of this rank, added up over all ranks. Collective.
template <class World>
[[nodiscard]] double sum_of(World& world, double mine) {
  world.link().reduce(reduction::sum, std::span(&mine, 1));
  return mine;
}
/// How many ranks own a point. Collective.
template <class World>
[[nodiscard]] int owners_of(World& world, const vec3& p) {
  return static_cast<int>(sum_of(world, world.contains(p)));
}

/// Points on a plane through the origin and some round-off off it, at all scales.
template <class F>
void near_plane(const vec3& normal, F&& f) {
  random_stream random(17);
  const vec3 n = unit(normal);
  for (int i = 0; i < 300; ++i) {
    vec3 p = std::pow(10, i % 6) * random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
    p -= n * n.dot(p);
    for (const real size : {-1e-15, 0., 1e-15}) f(vec3(p + size * p.norm() * n));
  }
}

/// Whether a message reads as expected. White space counts as one blank, "..." matches any text.
[[nodiscard]] inline bool reads(const std::string& message, const std::string& expected) {
  const auto words = [](const std::string& text) {
    std::string result;
    for (const char c : text) {
      const bool blank = c == ' ' || c == '\n';
      if (!blank) result += c;
      if (blank && !result.empty() && result.back() != ' ') result += ' ';
    }
    while (!result.empty() && result.back() == ' ') result.pop_back();
    return result;
  };
  const std::string said = words(message), wanted = words(expected);
  std::size_t at = 0, from = 0;
  for (std::size_t dots; (dots = wanted.find("...", from)) != std::string::npos; from = dots + 3) {
    const std::string part = wanted.substr(from, dots - from);
    const std::size_t found = said.find(part, at);
    if (found == std::string::npos || (from == 0 && found != 0)) return false;
    at = found + part.size();
  }
  const std::string rest = wanted.substr(from);
  return from == 0 ? said == rest : said.size() >= at + rest.size() && said.ends_with(rest);
}

/// The job ends with exactly this type of error and this message.
template <class Error, class Job>
void refused(Job&& job, const std::string& expected) {
  std::string said = "nothing was thrown";
  try {
    job();
  } catch (const Error& e) {
    said = e.what();
    CHECK(typeid(e) == typeid(Error));
  }
  INFO(said);
  CHECK(reads(said, expected));
}
/// The same on several ranks, each with a world.
template <class Scenario, class Error, class Program>
void refused_on(int ranks, Program&& program, const std::string& expected) {
  refused<Error>([&] { on_ranks<Scenario>(ranks, program); }, expected);
}

}  // namespace talus::tutorial
