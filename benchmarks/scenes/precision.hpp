#pragma once
// One point of a work-precision plot: a scene run with one engine and one setting, its cost in CPU
// seconds per simulated second and its error, both measured alike for all engines.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "checker.hpp"
#include "crate_checker.hpp"
#include "pile_scene.hpp"
#include "protocol.hpp"
#include "small_scenes.hpp"

namespace bench {

/// What to run: 0 stands for a scene's or an engine's own value.
struct setting {
  std::string scene;
  double dt = 0;
  int iterations = 0;
  double size = 0;  ///< bodies of a pile, base of a pyramid, density ratio, friction, restitution

  static setting from(arguments& args) {
    const auto number = [&](const char* name) {
      const std::string text = args.text(name, "0");
      char* end = nullptr;
      const double value = std::strtod(text.c_str(), &end);
      if (end == text.c_str() || *end != 0 || !(value >= 0))
        throw std::invalid_argument(std::string("--") + name + " needs a number, not " + text);
      return value;
    };
    setting s;
    s.scene = args.text("scene", "roll");
    s.dt = number("dt");
    s.iterations = static_cast<int>(args.count("iterations", 0));
    s.size = number("size");
    return s;
  }
};

/// Steps of an engine with a clock: the whole run, or the part asked for.
template <class Engine>
class timed_run {
 public:
  timed_run(const scene& s, int iterations) : engine_(s, iterations), dt_(s.dt) {}

  /// f(time, engine) after each step; its time does not count.
  template <class F>
  void advance(double seconds, F&& f) {
    const auto n = std::llround(seconds / dt_);
    for (long long k = 1; k <= n; ++k) {
      const double start = cpu_seconds();
      engine_.step();
      cpu_ += cpu_seconds() - start;
      time_ += dt_;
      f(time_, engine_);
    }
  }
  /// Without looking: one clock for all steps.
  void advance(double seconds) {
    const auto n = std::llround(seconds / dt_);
    const double start = cpu_seconds();
    for (long long k = 0; k < n; ++k) engine_.step();
    cpu_ += cpu_seconds() - start;
    time_ += static_cast<double>(n) * dt_;
  }
  void forget_cost() { cpu_ = 0, from_ = time_; }
  [[nodiscard]] double cost() const { return cpu_ / (time_ - from_); }
  [[nodiscard]] const Engine& engine() const { return engine_; }

 private:
  Engine engine_;
  double dt_, time_ = 0, from_ = 0, cpu_ = 0;
};

namespace detail {

/// Energy and angular momentum of a free box about its centre.
inline void free_motion(const crate& c, double& energy, double& momentum) {
  const auto axes = axes_of(c);
  const double m = c.density * c.size[0] * c.size[1] * c.size[2];
  energy = momentum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double p = c.size[(k + 1) % 3], q = c.size[(k + 2) % 3];
    const double inertia = m / 12 * (p * p + q * q), spin = dot(c.spin, axes[k]);
    energy += 0.5 * inertia * spin * spin;
    momentum += inertia * inertia * spin * spin;
  }
  momentum = std::sqrt(momentum);
}

/// Something that is not a number becomes a huge error: it is one.
inline double finite_or_huge(double x) { return std::isfinite(x) ? x : 1e300; }

}  // namespace detail

/// Runs a scene; adds cost, error and what else tells about the run.
template <class Engine>
void run_precision(const setting& chosen, const std::string& curve) {
  const auto with = [&](scene s) {
    if (chosen.dt > 0) s.dt = chosen.dt;
    return s;
  };
  const auto size = [&](double usual) { return chosen.size > 0 ? chosen.size : usual; };
  record out;
  const auto report = [&](const auto& run, const scene& s, const char* measure, double error) {
    out.add("curve", curve);
    out.add("engine", Engine::name());
    out.add("scene", s.name);
    out.add("size", chosen.size);
    out.add("dt", s.dt);
    out.add("iterations", run.engine().iterations());
    out.add("iterations_chosen", chosen.iterations > 0);
    out.add("dt_chosen", chosen.dt > 0);
    out.add("cost", run.cost());
    out.add("measure", measure);
    out.add("error", detail::finite_or_huge(error));
    out.add("scene_digest", digest(s));
  };

  if (chosen.scene == "pile") {
    const scene s = with(pile_scene(static_cast<std::size_t>(size(1000))));
    timed_run<Engine> run(s, chosen.iterations);
    run.advance(3);
    run.forget_cost();
    run.advance(0.5);
    const auto balls = run.engine().balls();
    const auto found = check(balls, s.walls, s.blocks);
    report(run, s, "mean overlap over mean radius",
           found.not_finite > 0 ? NAN : found.penetration_mean);
    out.add("overlap_max", found.penetration_max);
    out.add("overlapping_pairs", found.overlapping_pairs);
    out.add("contacts", run.engine().contacts());
    out.add("kinetic_energy_per_body", kinetic_energy(balls, s.density).mean);
    out.add("escaped", found.not_finite + found.behind_walls);
  } else if (chosen.scene == "heavy" || chosen.scene == "pyramid") {
    const bool heavy = chosen.scene == "heavy";
    const scene s =
        with(heavy ? heavy_scene(size(100)) : pyramid_scene(static_cast<std::size_t>(size(10))));
    timed_run<Engine> run(s, chosen.iterations);
    run.advance(5);
    const auto crates = run.engine().crates();
    const auto found = check(crates, s.walls);
    double moved = 0;
    for (std::size_t i = 0; i < crates.size(); ++i) {
      const double way = norm(minus(crates[i].centre, s.crates[i].centre));
      moved = way > moved || !std::isfinite(way) ? detail::finite_or_huge(way) : moved;
    }
    report(run, s, "largest displacement over edge", moved);
    out.add("overlap_mean", found.mean);
    out.add("overlap_max", found.max);
    out.add("stands", moved < 0.5);
  } else if (chosen.scene == "spin") {
    const scene s = with(spin_scene());
    timed_run<Engine> run(s, chosen.iterations);
    double energy0 = 0, momentum0 = 0, energy_error = 0, momentum_error = 0;
    detail::free_motion(s.crates[0], energy0, momentum0);
    int flips = 0;
    double side = 1;
    // Ten looks a second suffice, so that the clock and the looking cost nothing.
    const double between = 0.1;
    for (int k = 0; k < 600; ++k) {
      run.advance(between);
      const crate c = run.engine().crates()[0];
      double energy = 0, momentum = 0;
      detail::free_motion(c, energy, momentum);
      energy_error = std::max(energy_error, detail::finite_or_huge(std::abs(energy / energy0 - 1)));
      momentum_error =
          std::max(momentum_error, detail::finite_or_huge(std::abs(momentum / momentum0 - 1)));
      const double now = dot(c.spin, axes_of(c)[0]);
      if (now * side < 0) ++flips, side = now;
    }
    report(run, s, "largest relative error of energy", energy_error);
    out.add("momentum_error", momentum_error);
    out.add("flips", flips);
  } else if (chosen.scene == "creep" || chosen.scene == "slide") {
    const bool creep = chosen.scene == "creep";
    const scene s = with(incline_scene(size(creep ? 0.6 : 0.4)));
    timed_run<Engine> run(s, chosen.iterations);
    const auto down = [&](const vec& v) { return dot(v, {std::sqrt(0.75), 0, -0.5}); };
    if (creep) {
      run.advance(0.5);  // settling into the plane is not creep
      const vec before = run.engine().crates()[0].centre;
      run.advance(10);
      report(run, s, "way in 10 s, over edge",
             std::abs(down(minus(run.engine().crates()[0].centre, before))));
    } else {
      run.advance(2);
      const double v = 2 * gravity * (0.5 - size(0.4) * std::sqrt(0.75));
      const double found = down(run.engine().crates()[0].velocity);
      report(run, s, "relative error of speed", std::abs(found / v - 1));
    }
  } else if (chosen.scene == "roll") {
    const scene s = with(roll_scene());
    timed_run<Engine> run(s, chosen.iterations);
    const double slips = 2 * 5 / (7 * 0.3 * gravity);
    const double way = 12 * 25 / (49 * 0.3 * gravity) + 25.0 / 7 * (2 - slips);
    run.advance(2);
    const ball b = run.engine().balls()[0];
    report(run, s, "relative error of way after 2 s", std::abs(b.position[0] / way - 1));
    out.add("speed_error", std::abs(b.velocity[0] / (25.0 / 7) - 1));
  } else if (chosen.scene == "bounce") {
    const double e = size(0.8);
    const scene s = with(bounce_scene(e));
    timed_run<Engine> run(s, chosen.iterations);
    const double all = std::sqrt(2 / gravity) * (1 + e) / (1 - e);
    double sum = 0;
    std::size_t looks = 0;
    run.advance(all, [&](double t, const Engine& engine) {
      sum += std::abs(engine.balls()[0].position[2] - 0.5 - bounce_height(t, e));
      ++looks;
    });
    report(run, s, "mean error of height over first height", sum / static_cast<double>(looks));
  } else {
    throw std::invalid_argument(
        "there is no scene '" + chosen.scene +
        "'; there are pile, heavy, pyramid, spin, creep, slide, roll, bounce");
  }
  out.write("");
}

}  // namespace bench
