#pragma once
// BED: spheres that rest under gravity in an open box, with the parameters of a usual simulation by
// the discrete element method; and its state as text, which other programs read.
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>

#include "scene.hpp"

namespace bench {

/// Units are metres, kilograms and seconds.
struct bed {
  static constexpr double radius = 0.005;  ///< mean; radii differ by up to a tenth
  static constexpr double youngs_modulus = 1e7, poisson_ratio = 0.3, density = 2500;
  static constexpr double restitution = 0.5, friction = 0.5, gravity = 9.81;

  scene start;   ///< a loose lattice, or the settled state
  double width;  ///< of the box

  explicit bed(std::uint64_t bodies) {
    const auto sites = static_cast<std::uint64_t>(std::ceil(std::cbrt(double(bodies)) - 1e-9));
    const double spacing = 2.05 * 1.1 * radius;
    width = spacing * static_cast<double>(sites);
    start.name = "bed";
    start.density = density;
    start.gravity = -gravity;
    start.between_balls = {.friction = friction, .restitution = restitution};
    start.walls = {
        {{0, 0, 1}, 0}, {{1, 0, 0}, 0}, {{-1, 0, 0}, -width}, {{0, 1, 0}, 0}, {{0, -1, 0}, -width}};
    for (std::uint64_t k = 0; k < bodies; ++k) {
      const std::uint64_t site[3] = {k % sites, k / sites % sites, k / sites / sites};
      dice roll(1, k);
      ball b;
      b.radius = roll.between(0.9 * radius, 1.1 * radius);
      const double play = 0.8 * (spacing / 2 - b.radius);
      for (std::size_t i = 0; i < 3; ++i)
        b.position[i] = spacing * (static_cast<double>(site[i]) + 0.5) + roll.between(-play, play);
      start.balls.push_back(b);
    }
  }
  /// A fifth of the time of a Rayleigh wave along the smallest sphere.
  [[nodiscard]] static double time_step() {
    const double shear = youngs_modulus / (2 * (1 + poisson_ratio));
    return 0.2 * std::numbers::pi * 0.9 * radius * std::sqrt(density / shear) /
           (0.1631 * poisson_ratio + 0.8766);
  }
  /// Kinetic energy of the centres of mass.
  [[nodiscard]] double kinetic_energy() const {
    double sum = 0;
    for (const ball& b : start.balls)
      for (const double v : b.velocity) sum += 0.5 * mass(b) * v * v;
    return sum;
  }
  /// A line for each body: position, radius, velocity, angular velocity.
  void write(const std::string& file) const {
    std::ostringstream out;
    out.precision(std::numeric_limits<double>::max_digits10);
    for (const ball& b : start.balls) {
      for (const double x : b.position) out << x << ' ';
      out << b.radius;
      for (const double v : b.velocity) out << ' ' << v;
      for (const double w : b.spin) out << ' ' << w;
      out << '\n';
    }
    write_file(out.str(), file, state_output);
  }
  /// Reads what write() wrote; or, without radii and spins, what another engine moved.
  void read(const std::string& file, bool moved_by_other) {
    std::ifstream in(file);
    for (ball& b : start.balls) {
      for (double& x : b.position) in >> x;
      if (!moved_by_other) in >> b.radius;
      for (double& v : b.velocity) in >> v;
      if (!moved_by_other)
        for (double& w : b.spin) in >> w;
    }
    if (!in) throw std::runtime_error("'" + file + "' has too few numbers for this scene");
  }

 private:
  [[nodiscard]] static double mass(const ball& b) {
    return density * 4 / 3 * std::numbers::pi * b.radius * b.radius * b.radius;
  }
};

}  // namespace bench
