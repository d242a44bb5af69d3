// The scenes of SimBenchmark and their errors (./dev bench simbench): its energies and
// accelerations, and errors of motions that are known.
#include <doctest/doctest.h>

#include <cmath>

#include "../../benchmarks/scenes/simbench_protocol.hpp"

using namespace bench;

namespace {

/// The exact motion of `rolling`, and of spheres that rest: what it was not pushed with stays away.
struct exact_engine {
  explicit exact_engine(const scene& s) : s_(s) {}
  void push(std::size_t crate, const vec& force) { to_[crate] = force; }
  void step() {
    const double per_newton = s_.dt * rolling_motion::of_box / rolling_motion::push;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!s_.crates.empty()) s_.crates[0].velocity[k] += per_newton * to_[0][k];
      for (ball& b : s_.balls) b.velocity[k] += per_newton * to_[0][k] * 2 / 7;
    }
  }
  [[nodiscard]] const std::vector<ball>& balls() const { return s_.balls; }
  [[nodiscard]] const std::vector<crate>& crates() const { return s_.crates; }
  scene s_;
  std::array<vec, 1> to_{};
};

}  // namespace

TEST_CASE("scenes of SimBenchmark have its energies and accelerations") {
  CHECK(rolling_motion::of_box == doctest::Approx(0.7385).epsilon(1e-4));
  CHECK(rolling_motion::of_ball == doctest::Approx(0.211).epsilon(1e-4));
  const scene bouncing = bouncing_scene(1e-3), elastic = elastic_scene(1e-3);
  CHECK(mechanical_energy(bouncing.balls, bouncing.density) ==
        doctest::Approx(24034.5).epsilon(1e-6));
  CHECK(mechanical_energy(elastic.balls, elastic.density) == doctest::Approx(34465).epsilon(1e-4));
  CHECK(mass(rolling_scene(1e-3).balls[0], rolling_scene(1e-3).density) == doctest::Approx(1));
}

TEST_CASE("no spheres of the elastic block overlap at the start") {
  const scene s = elastic_scene(1e-3);
  for (std::size_t i = 0; i < s.balls.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const vec apart = minus(s.balls[i].position, s.balls[j].position);
      CHECK(dot(apart, apart) > 0.2 * 0.2);
    }
}

TEST_CASE("the exact motion has no error, and a wrong one that of its velocities") {
  const scene s = rolling_scene(0.01);
  stopwatch watch;
  exact_engine engine(s);
  CHECK(rolling_error(engine, s, 60, 100, watch) < 1e-25);
  struct held : exact_engine {
    using exact_engine::exact_engine;
    void step() {}
  } still(s);
  // Mean of t² over 100 steps of 10 ms, for the box and for the spheres.
  const double squares = 0.01 * 0.01 * 100 * 101 * 201 / 6 / 100;
  const double a = rolling_motion::of_box, b = rolling_motion::of_ball;
  CHECK(rolling_error(still, s, 90, 100, watch) == doctest::Approx((a * a + b * b) * squares));
}

TEST_CASE("the error of energy is the root of the mean square") {
  const scene s = bouncing_scene(0.01);
  struct falling : exact_engine {  // gains one joule a sphere in each step
    using exact_engine::exact_engine;
    void step() {
      for (ball& b : s_.balls) b.position[2] += 1 / (10 * gravity);
    }
  } engine(s);
  stopwatch watch;
  CHECK(energy_error(engine, s, 2, watch) == doctest::Approx(49 * std::sqrt(2.5)));
}
