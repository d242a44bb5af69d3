#pragma once
// Scenes of SimBenchmark (leggedrobotics/SimBenchmark), with its errors: against an exact motion,
// or against the energy of the start. All means are over all steps. A change of any number here
// invalidates earlier figures.
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "protocol.hpp"
#include "small_scenes.hpp"

namespace bench {

/// A box under 25 spheres, pushed with 150 N at an angle to x: it slides, and they roll on it.
struct rolling_motion {
  static constexpr double box_mass = 10, ball_mass = 1, push = 150, friction = 0.4;
  static constexpr int balls = 25;

  /// A sphere that rolls without slip on what accelerates with a, does so with 2/7 a.
  static constexpr double of_box = (push - friction * (box_mass + balls * ball_mass) * gravity) /
                                   (box_mass + balls * ball_mass * 2 / 7);
  static constexpr double of_ball = of_box * 2 / 7;

  static vec direction(double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    return {std::cos(angle), std::sin(angle), 0};
  }
};

inline scene rolling_scene(double dt) {
  using motion = rolling_motion;
  scene s = floor_scene("rolling", motion::friction);
  s.dt = dt;
  s.between_balls.friction = 0.8;
  s.density = motion::ball_mass / (4.0 / 3 * std::numbers::pi * 0.125);
  s.crates = {
      {.centre = {0, 0, 0.5 - 2e-5}, .size = {20, 20, 1}, .density = motion::box_mass / 400}};
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j)
      s.balls.push_back({.position = {2.0 * i - 4, 2.0 * j - 4, 1.5 - 6e-5}, .radius = 0.5});
  return s;
}

/// Spheres of radius 0.1 and 10 kg above a floor, without friction and without loss.
inline scene elastic_floor_scene(const char* name, double dt) {
  scene s = floor_scene(name, 0);
  s.dt = dt;
  s.between_balls.restitution = s.against_fixed.restitution = 1;
  s.density = 10 / (4.0 / 3 * std::numbers::pi * 1e-3);
  return s;
}
inline scene bouncing_scene(double dt) {
  scene s = elastic_floor_scene("bouncing", dt);
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 7; ++j)
      s.balls.push_back({.position = {1.0 * i, 1.0 * j, 5}, .radius = 0.1});
  return s;
}
inline scene elastic_scene(double dt) {
  scene s = elastic_floor_scene("elastic", dt);
  dice random(1, 0);
  for (int k = 0; k < 6; ++k)
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 6; ++i) {
        const vec jitter = random.between({0, 0, 0}, {1e-3, 1e-3, 1e-3});
        s.balls.push_back(
            {.position = {0.21 * i + jitter[0], 0.21 * j + jitter[1], 1.101 + 0.21 * k + jitter[2]},
             .radius = 0.1});
      }
  return s;
}

/// Of motion, rotation and height.
inline double mechanical_energy(const std::vector<ball>& balls, double density) {
  double sum = static_cast<double>(balls.size()) * kinetic_energy(balls, density).mean;
  for (const ball& b : balls) sum += mass(b, density) * gravity * b.position[2];
  return sum;
}

/// Mean of |v - exact|² of the box, plus its mean over the spheres.
template <class Engine>
double rolling_error(Engine& engine, const scene& s, double degrees, std::size_t steps,
                     stopwatch& watch) {
  using motion = rolling_motion;
  const vec to = motion::direction(degrees);
  const auto off = [&](const vec& v, double speed) {
    const vec d = minus(v, {speed * to[0], speed * to[1], 0});
    return dot(d, d);
  };
  double sum = 0;
  for (std::size_t k = 1; k <= steps; ++k) {
    watch.time([&] {
      engine.push(0, {motion::push * to[0], motion::push * to[1], 0});
      engine.step();
    });
    const double time = static_cast<double>(k) * s.dt;
    sum += off(engine.crates()[0].velocity, motion::of_box * time);
    for (const ball& b : engine.balls())
      sum += off(b.velocity, motion::of_ball * time) / motion::balls;
  }
  return sum / static_cast<double>(steps);
}

/// Root of the mean squared difference to the energy of the start, in joules.
template <class Engine>
double energy_error(Engine& engine, const scene& s, std::size_t steps, stopwatch& watch) {
  const double start = mechanical_energy(s.balls, s.density);
  double sum = 0;
  for (std::size_t k = 0; k < steps; ++k) {
    watch.time([&] { engine.step(); });
    const double off = mechanical_energy(engine.balls(), s.density) - start;
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(steps));
}

template <class Engine>
void run_simbench(arguments args) {
  const auto name = args.text("scene", "rolling");
  const auto angle = args.count("angle", 60);
  const auto rate = args.count("rate", 1000);
  const auto iterations = args.count("iterations", 0);
  const auto most = args.count("steps", 0);
  const auto file = args.json_file();
  if (!args.done()) return;
  if (rate == 0) throw std::invalid_argument("--rate needs to be at least 1");
  const double dt = 1.0 / static_cast<double>(rate);
  const bool rolls = name == "rolling";
  if (!rolls && name != "bouncing" && name != "elastic")
    throw std::invalid_argument("there is no scene '" + name +
                                "'; there are rolling, bouncing, elastic");
  const scene s = rolls                ? rolling_scene(dt)
                  : name == "bouncing" ? bouncing_scene(dt)
                                       : elastic_scene(dt);
  const std::size_t seconds = rolls ? 4 : name == "bouncing" ? 20 : 10;
  const std::size_t steps = most > 0 ? most : seconds * rate;

  Engine engine(s, static_cast<int>(iterations));
  stopwatch watch;
  const double error = rolls ? rolling_error(engine, s, static_cast<double>(angle), steps, watch)
                             : energy_error(engine, s, steps, watch);
  record out;
  out.add("engine", Engine::name());
  out.add("scene", s.name);
  out.add("angle", rolls ? angle : 0);
  out.add("rate", rate);
  out.add("steps", steps);
  out.add("iterations", engine.iterations());
  out.add("error", std::isfinite(error) ? error : 1e300);
  out.add("measure", rolls ? "mean squared error of velocity, m²/s²" : "RMS error of energy, J");
  out.add("cpu_seconds_per_simulated_second", 1e-3 * watch.mean() * static_cast<double>(rate));
  out.add("bodies", s.balls.size() + s.crates.size());
  out.add("scene_digest", digest(s));
  out.write(file);
}

}  // namespace bench
