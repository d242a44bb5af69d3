// HARD: scenes that stand still, or should: stacks, towers, pyramids, walls, heavy loads on light
// bodies. A matrix of each scene on 1, 2 and 4 ranks, with both solvers and both integrators:
// error, cost, and whether all ranks end with the same bits.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iostream>
#include <mutex>
#include <stdexcept>
#include <string>
#include <talus/core/clock.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "scenes/protocol.hpp"
#include "scenes/report.hpp"

namespace {

using namespace talus;

template <class Integrator>
using scene_of = scenario<bodies<sphere, box, plane>, solver<nonlinear_gauss_seidel, reproducible>,
                          integrator<Integrator>, transport<threads>,
                          decomposition<grid<dynamic, dynamic, dynamic>>>;

constexpr real g = 9.81;

/// A body of a scene; edges of 0 make a sphere of diameter 1.
struct part {
  vec3 edges;
  vec3 at;
  real density = 1;
};
struct hard_scene {
  std::string name;
  std::vector<part> parts;
  bool shaft = false;  ///< four walls around a column of width 1
  real seconds = 5;
};

const vec3 cube(1, 1, 1), ball(0, 0, 0);

hard_scene column(const std::string& name, const vec3& edges, int count, real top) {
  hard_scene s{name, {}, edges == ball};
  for (int k = 0; k < count; ++k) s.parts.push_back({edges, {0, 0, k + 0.5}, 1});
  s.parts.back().density = top;
  return s;
}
hard_scene pyramid(int rows) {
  hard_scene s{"pyramid of " + std::to_string(rows), {}};
  for (int row = 0; row < rows; ++row)
    for (int k = 0; k < rows - row; ++k)
      s.parts.push_back({cube, {1.02 * (k - 0.5 * (rows - row - 1)), 0, row + 0.5}});
  return s;
}
hard_scene wall(int size) {
  hard_scene s{"wall of " + std::to_string(size), {}};
  for (int row = 0; row < size; ++row)
    for (int k = 0; k < size; ++k)
      s.parts.push_back({cube, {k - 0.5 * size + 0.5 + (row % 2 == 0 ? 0 : 0.25), 0, row + 0.5}});
  return s;
}
hard_scene plate(int side, real density) {
  hard_scene s{"plate on " + std::to_string(side * side), {}, false, 3};
  const real spacing = 1.02;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j)
      s.parts.push_back(
          {ball, {spacing * (i - 0.5 * (side - 1)), spacing * (j - 0.5 * (side - 1)), 0.5}});
  s.parts.push_back({{side * spacing, side * spacing, 1}, {0, 0, 1.5}, density});
  return s;
}
std::vector<hard_scene> all_scenes() {
  return {column("stack of 10", cube, 10, 1),
          column("stack of 20", cube, 20, 1),
          column("10 boxes, top 1e3", cube, 10, 1e3),
          column("10 boxes, top 1e4", cube, 10, 1e4),
          column("30 boxes, top 1e3", cube, 30, 1e3),
          column("10 spheres, top 1e3", ball, 10, 1e3),
          column("10 spheres, top 1e4", ball, 10, 1e4),
          pyramid(10),
          pyramid(30),
          wall(10),
          plate(4, 1e4),
          plate(10, 1e4),
          plate(30, 1e4)};
}

struct found {
  double cpu = 0, drift = 0, kinetic = 0, mean = 0, deepest = 0;
  std::string digest;
};

/// Cuts through the middle of the scene: across x and y, or one above the other.
grid<dynamic, dynamic, dynamic> cuts(const hard_scene& s, int ranks, bool across) {
  real wide = 1, high = 1;
  for (const part& p : s.parts)
    wide = std::max(wide, std::abs(p.at[0]) + 1), high = std::max(high, p.at[2] + 1);
  if (across)
    return {.cells = {1, 1, ranks}, .lower = {-wide, -wide, 0}, .upper = {wide, wide, high}};
  return {.cells = {std::min(ranks, 2), std::max(1, ranks / 2), 1},
          .lower = {-wide, -wide, 0},
          .upper = {wide, wide, high}};
}

template <class Integrator>
found hold(const hard_scene& s, int ranks, bool across, bool same_bits, real dt) {
  using scene = scene_of<Integrator>;
  found r;
  std::mutex one_by_one;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<scene> w(link, cuts(s, ranks, across));
    if (same_bits) w.use_solver_on_request();
    w.gravity({0, 0, -g});
    const auto light = w.material({.density = 1, .friction = 0.5});
    w.global([&](auto& scope) {
      scope.add(plane{}, light);
      if (s.shaft)
        for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
          scope.add(plane{.normal = n, .offset = -0.5}, light);
    });
    std::vector<std::pair<system_id, vec3>> starts;
    for (const part& p : s.parts) {
      const auto note = [&](const auto& made) {
        if (made) starts.emplace_back(made->id, p.at);
      };
      if (p.edges == ball)
        note(w.add_if_local(
            body{.shape = sphere{0.5}, .position = p.at, .material = light, .density = p.density}));
      else
        note(w.add_if_local(body{
            .shape = box{p.edges}, .position = p.at, .material = light, .density = p.density}));
    }
    const double began = talus::detail::thread_seconds();
    const int steps = static_cast<int>(std::lround(s.seconds / dt));
    for (int k = 0; k < steps; ++k) w.step(dt);
    const double cpu = talus::detail::thread_seconds() - began;
    // (No body leaves the domain that owns it at the start, where the scene stands.)
    double drift = 0;
    w.for_each_local([&](const auto& b) {
      double least = 1e300;
      for (const part& p : s.parts) least = std::min(least, double((b.position() - p.at).norm()));
      for (const auto& [id, at] : starts)
        if (id == b.id()) least = (b.position() - at).norm();
      drift = std::max(drift, least);
    });
    const motion m = measure_motion(w);
    const penetration p = measure_penetration(w);
    const std::string digest = state_digest(w);
    const std::lock_guard lock(one_by_one);
    r.cpu += cpu;
    r.drift = std::max(r.drift, drift);
    if (link.rank() != 0) return;
    r.kinetic = m.kinetic_energy / (m.mass * g), r.mean = p.mean, r.deepest = p.max;
    r.digest = digest;
  });
  return r;
}

void run(bench::arguments args) {
  const auto only = args.text("only", "");
  const auto rate = args.count("rate", 240);
  const auto file = args.json_file();
  if (!args.done()) return;
  std::string rows;
  for (const hard_scene& s : all_scenes()) {
    if (s.name.find(only) == std::string::npos) continue;
    for (const bool midpoint : {false, true})
      for (const bool same_bits : {false, true})
        for (const auto& [ranks, across] :
             {std::pair{1, false}, {2, false}, {4, false}, {2, true}, {4, true}}) {
          const real dt = 1. / static_cast<double>(rate);
          const found r = midpoint ? hold<moreau_midpoint>(s, ranks, across, same_bits, dt)
                                   : hold<semi_implicit_euler>(s, ranks, across, same_bits, dt);
          bench::record out;
          out.add("scene", s.name);
          out.add("solver", same_bits ? "coloured_gauss_seidel" : "nonlinear_gauss_seidel");
          out.add("integrator", midpoint ? "moreau_midpoint" : "semi_implicit_euler");
          out.add("ranks", ranks);
          out.add("cuts", ranks == 1 ? "none" : across ? "across" : "along");
          out.add("bodies", s.parts.size());
          out.add("dt", dt);
          out.add("seconds", s.seconds);
          out.add("cpu_seconds", r.cpu);
          out.add("drift", r.drift);
          out.add("kinetic_energy", r.kinetic);
          out.add("penetration_mean", r.mean);
          out.add("penetration_max", r.deepest);
          out.add("state_digest", r.digest);
          std::fprintf(
              stderr, "%-20s %-22s %-19s %d ranks %-6s: drift %.1e, overlap %.1e, %.2f s\n",
              s.name.c_str(), same_bits ? "coloured_gauss_seidel" : "nonlinear_gauss_seidel",
              midpoint ? "moreau_midpoint" : "semi_implicit_euler", ranks,
              ranks == 1 ? ""
              : across   ? "across"
                         : "along",
              r.drift, r.mean, r.cpu);
          std::string text = out.json();
          text.pop_back();
          rows += (rows.empty() ? "[\n" : ",\n") + text;
        }
  }
  if (rows.empty()) throw std::invalid_argument("no scene has '" + only + "' in its name");
  bench::record::write_text(rows + "\n]\n", file);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] { run({argc, argv}); });
}
