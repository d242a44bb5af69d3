#pragma once
// Spheres and boxes that fly towards a common centre, without gravity: contacts across all
// boundaries of the ranks, bodies that migrate, and no external forces.
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/world/world.hpp>

template <class Transport, class Correction>
struct collision_cloud {
  using scenario_type = talus::scenario<
      talus::bodies<talus::sphere, talus::box>, Transport,
      talus::hard_contact<talus::coulomb_friction, talus::newton_restitution, Correction>,
      talus::decomposition<talus::grid<talus::dynamic, talus::dynamic>>>;
  static constexpr double extent = 6;

  struct outcome {
    talus::motion before, after;
    std::uint64_t collided = 0;  ///< contacts that carried an impulse, summed over the steps
  };

  static talus::grid<talus::dynamic, talus::dynamic> cells() {
    return {.lower = {-extent, -extent}, .upper = {extent, extent}};
  }
  static double momentum_scale(const talus::motion& m) {
    return std::sqrt(2 * m.mass * m.kinetic_energy);
  }
  template <class World>
  static void set_up(World& w) {
    const auto stuff = w.material({.density = 1.5, .restitution = 0.4, .friction = 0.3});
    w.seed(7);
    const auto sites = talus::simple_cubic{.spacing = 1.3} &
                       talus::box_region{{-extent, -extent, -1.5}, {extent, extent, 1.5}};
    w.fill(sites, [&](const talus::site& site, talus::random_stream& random) {
      const double radius = random.uniform(0.3, 0.6);
      return talus::body{
          .shape = talus::sphere{radius},
          .position = site.position,
          .material = stuff,
          .velocity =
              -1.0 * site.position + random.uniform(talus::vec3(-1, -1, -1), talus::vec3(1, 1, 1)),
          .angular_velocity = random.uniform(talus::vec3(-2, -2, -2), talus::vec3(2, 2, 2))};
    });
    w.fill(talus::simple_cubic{.spacing = 3.9, .origin = {0.65, 0.65, 2.6}} &
               talus::box_region{{-extent, -extent, 2.5}, {extent, extent, 2.7}},
           [&](const talus::site& site, talus::random_stream& random) {
             return talus::body{.shape = talus::box{.size = {0.9, 0.7, 0.5}},
                                .position = site.position,
                                .material = stuff,
                                .velocity = -1.0 * site.position,
                                .orientation = random.rotation()};
           });
  }
  static outcome run(typename scenario_type::transport::link& link, int steps) {
    talus::world<scenario_type> w(link, cells());
    set_up(w);
    w.synchronize();
    outcome r;
    r.before = talus::measure_motion(w);
    for (int k = 0; k < steps; ++k) {
      w.step(0.005);
      talus::detail::state_of(w).each_contact_list([&](const auto& list) {
        list.each([&](const auto& c, bool counts) {
          r.collided += counts && c.impulse().squaredNorm() > 0;
        });
      });
    }
    r.after = talus::measure_motion(w);
    link.reduce(talus::reduction::sum, std::span(&r.collided, 1));
    return r;
  }
};
