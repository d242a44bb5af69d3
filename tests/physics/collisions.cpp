// Collisions of spheres and boxes in free space: momenta to round-off, energy never gained.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>

using namespace talus;
using space = scenario<bodies<sphere, box>, transport<serial>,
                       hard_contact<coulomb_friction, newton_restitution, no_correction>>;

namespace {

constexpr real dt = 1.0 / 240;

class dice {
 public:
  explicit dice(unsigned seed) : engine_(seed) {}
  real between(real a, real b) { return std::uniform_real_distribution<real>(a, b)(engine_); }
  vec3 vector(real size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  quat rotation() {
    return quat(between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)).normalized();
  }

 private:
  std::mt19937 engine_;
};

struct balance {
  real momentum = 0, spin = 0, energy = 0;  ///< relative; of energy, the gain
  int hits = 0;
};

/// Two bodies that fly at each other, `count` times; the largest errors.
template <class A, class B, class MakeA, class MakeB>
balance collide_often(unsigned seed, int count, const material& m, MakeA&& make_a, MakeB&& make_b) {
  INFO("seed ", seed);
  dice random(seed);
  balance worst;
  for (int k = 0; k < count; ++k) {
    serial::link link;
    world<space> w(link);
    w.material(m);
    const vec3 v = random.vector(2) + vec3(3, 0, 0);
    w.add(body<A>{.shape = make_a(random),
                  .position = vec3(-1.2, 0, 0) + random.vector(0.2),
                  .velocity = v,
                  .angular_velocity = random.vector(4),
                  .orientation = random.rotation()});
    w.add(body<B>{.shape = make_b(random),
                  .position = vec3(1.2, 0, 0) + random.vector(0.2),
                  .velocity = -v,
                  .angular_velocity = random.vector(4),
                  .orientation = random.rotation()});
    const auto before = measure_motion(w);
    std::size_t touched = 0;
    for (int i = 0; i < 240; ++i) {
      w.step(dt);
      for (const auto& e : talus::detail::state_of(w).history.entries())
        touched += e.memory.norm() > 0;
    }
    const auto after = measure_motion(w);
    const real scale = std::sqrt(2 * before.mass * before.kinetic_energy);
    worst.hits += touched > 0;
    worst.momentum = std::max(worst.momentum, (after.momentum - before.momentum).norm() / scale);
    worst.spin =
        std::max(worst.spin, (after.angular_momentum - before.angular_momentum).norm() / scale);
    const real gain = after.kinetic_energy / before.kinetic_energy - 1;
    if (touched) worst.energy = std::max(worst.energy, gain);
  }
  return worst;
}

void judge(const std::string& what, const balance& b, int hits) {
  MESSAGE(what, ": ", b.hits, " hits, errors of momentum ", b.momentum, ", of angular momentum ",
          b.spin, ", energy gained ", b.energy);
  CHECK(b.hits > hits);
  CHECK(b.momentum < 1e-13);
  CHECK(b.spin < 1e-12);
}

const auto a_ball = [](dice& d) { return sphere{d.between(0.4, 0.9)}; };
const auto a_box = [](dice& d) {
  return box{{d.between(0.4, 1.5), d.between(0.4, 1.5), d.between(0.4, 1.5)}};
};

}  // namespace

TEST_CASE("two bodies that collide keep their momenta to round-off and gain no energy") {
  for (const material& m : {material{.density = 2, .restitution = 0, .friction = 0.4},
                            material{.density = 2, .restitution = 0.6, .friction = 0.4},
                            material{.density = 2, .restitution = 1, .friction = 0}}) {
    CAPTURE(m.restitution);
    const auto spheres = collide_often<sphere, sphere>(1, 100, m, a_ball, a_ball);
    const auto mixed = collide_often<sphere, box>(2, 100, m, a_ball, a_box);
    const auto boxes = collide_often<box, box>(3, 100, m, a_box, a_box);
    judge("spheres", spheres, 30);
    judge("sphere and box", mixed, 30);
    judge("boxes", boxes, 30);
    CHECK(spheres.energy < 1e-12);
    // Elastic boxes: bounded by the error of their free rotation.
    CHECK(mixed.energy < (m.restitution == 1 ? 1e-10 : 1e-12));
    CHECK(boxes.energy < (m.restitution == 1 ? 1e-10 : 1e-12));
  }
}

TEST_CASE("a sphere that hits the face of a box centrally rebounds with e, the masses in between") {
  for (const real e : {0.0, 0.3, 1.0}) {
    CAPTURE(e);
    serial::link link;
    world<space> w(link);
    w.material({.density = 3, .restitution = e, .friction = 0.3});
    const auto ball =
        w.add(body{.shape = sphere{0.5}, .position = {-0.77, 0, 0}, .velocity = {4, 0, 0}});
    const auto block =
        w.add(body{.shape = box{{0.5, 1, 1}}, .position = {0, 0, 0}, .velocity = {-1, 0, 0}});
    const real ma = w[ball].mass(), mb = w[block].mass();
    for (int k = 0; k < 24; ++k) w.step(dt);
    const real centre = (4 * ma - mb) / (ma + mb);
    CHECK(std::abs(w[ball].velocity()[0] - (centre - e * 5 * mb / (ma + mb))) < 1e-12);
    CHECK(std::abs(w[block].velocity()[0] - (centre + e * 5 * ma / (ma + mb))) < 1e-12);
    CHECK(w[ball].angular_velocity().norm() < 1e-12);
    CHECK(w[block].angular_velocity().norm() < 1e-12);
  }
}
