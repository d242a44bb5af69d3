#pragma once
// The conditions of every generated scenario: conservation of bodies, momentum and energy, restarts
// to the bit, and the same bits on any ranks if that is promised. See generate.py.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/events.hpp>
#include <talus/filters.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/overlaps.hpp>
#include <talus/parallel/reach.hpp>
#include <talus/world/world.hpp>
#include <vector>

namespace composition {

using namespace talus;

/// A generated scenario and its decomposition: `variant` 0 and 1 differ in the number of ranks, or
/// in the positions of the domains.
template <class Scenario, class Decompose>
class scene {
  using world_type = world<Scenario>;
  using link_type = typename world_type::link_type;
  template <class Feature>
  static constexpr bool has = Scenario::template has_feature<Feature>;
  static constexpr bool soft = Scenario::contact_law::soft;
  static constexpr bool same_bits = detail::solves_by_colours<typename Scenario::solver>;
  static constexpr bool mixed = !std::is_same_v<typename Scenario::precision, double>;
  static constexpr real dt = soft ? 1e-3 : 1.0 / 240;
  static constexpr int steps = 60;

 public:
  scene(int number, Decompose decompose) : number_(number), decompose_(decompose) {}

  void check() {
    conserves_momentum();
    const std::string whole = falls(0);
    if constexpr (same_bits && !link_type::alone) {
      const std::string other = falls(1);
      CHECK(whole == other);
    }
  }

 private:
  /// Runs main(world) on all ranks of a variant.
  template <class Main>
  void on(int variant, Main&& main) {
    if constexpr (link_type::alone) {
      typename Scenario::transport::link link;
      if constexpr (requires { decompose_.alone(); }) {
        world_type w(link, decompose_.alone());
        main(w);
      } else {
        world_type w(link);
        main(w);
      }
    } else {
      const auto [ranks, decomposition] = decompose_(variant);
      CAPTURE(ranks);
      Scenario::transport::launch({.ranks = ranks},
                                  [&, &decomposition = decomposition](auto& link) {
                                    world_type w(link, decomposition, reach{2});
                                    main(w);
                                  });
    }
  }
  void settings(world_type& w) {
    if constexpr (soft)
      w.material({.restitution = 0.4,
                  .friction = 0.4,
                  .stiffness = 500,
                  .youngs_modulus = 5e3,
                  .rolling_friction = 0.02});
    else
      w.material({.restitution = 0.3, .friction = 0.4});
    if constexpr (has<balancing>) w.balance({.every = 7, .above = 1.02, .by = balance_by::count});
    if constexpr (has<damping>) w.damping(0.9);
  }
  template <class Shape>
  static void add(world_type& w, const Shape& shape, const vec3& at, const vec3& v) {
    body<Shape> one{.shape = shape, .position = at, .velocity = v, .angular_velocity = v};
    if constexpr (has<user_ids>) one.user_id = 7;
    w.add_if_local(one);
  }
  /// 98 bodies of all shapes that move towards each other, and a bullet if bodies are followed.
  static void fill(world_type& w, real height) {
    random_stream random(7);
    int k = 0;
    for (int z = 0; z < 2; ++z)
      for (int y = 0; y < 7; ++y)
        for (int x = 0; x < 7; ++x, ++k) {
          const vec3 at{0.9 * x - 2.75, 0.9 * y - 2.65, height + 0.9 * z};
          const real r = random.uniform(0.3, 0.4);
          // (Soft contacts take smaller steps.)
          const vec3 v = (soft ? 4 : 1) * (random.uniform(vec3(-1, -1, -2), vec3(1, 1, 1)) -
                                           vec3(0.3 * at[0], 0.3 * at[1], 0));
          int which = 0;
          const auto chosen = [&, turn = k % finite_shapes](auto&& make) {
            if (which++ == turn) make();
          };
          chosen([&] { add(w, sphere{r}, at, v); });
          if constexpr (Scenario::template has_shape<box>)
            chosen([&] { add(w, box{{1.5 * r, 1.3 * r, r}}, at, v); });
          if constexpr (requires { typename Decompose::more_shapes; })
            Decompose::each_more_shape(r,
                                       [&](const auto& s) { chosen([&] { add(w, s, at, v); }); });
        }
    if constexpr (has<continuous_collision>)
      add(w, sphere{0.1}, {-3.6, 0.07, height + 0.45}, {60, 1, 0});
    if constexpr (has<contact_filters>) {  // a third of the bodies pass through each other
      w.template feature<contact_filters>().ignore(contact_group{1}, contact_group{1});
      w.for_each_local([](auto&& b) {
        if (value_of(b.id()) % 3 == 0) b.template set<contact_groups>(2);
      });
    }
  }
  static constexpr int finite_shapes =
      detail::filter_types<typename Scenario::shapes, detail::is_finite>::size;

  static std::uint64_t count(world_type& w) {
    double n = static_cast<double>(w.local_bodies());
    w.link().reduce(reduction::sum, std::span(&n, 1));
    return static_cast<std::uint64_t>(n);
  }

  /// A free cloud that collides: its momentum is conserved, on any ranks of its contacts.
  void conserves_momentum() {
    on(0, [&](world_type& w) {
      settings(w);
      if constexpr (has<damping>) w.damping(1);
      if constexpr (has<sleeping>) w.sleeping({.speed = 1e-9, .time = 1e9});
      fill(w, 0);
      w.synchronize();
      const motion before = measure_motion(w);
      const std::uint64_t bodies = count(w);
      const double scale = std::sqrt(2 * before.mass * before.kinetic_energy);
      for (int k = 0; k < steps; ++k) w.step(dt);
      const motion after = measure_motion(w);
      CHECK(count(w) == bodies);
      CHECK((after.momentum - before.momentum).norm() < (mixed ? 1e-5 : 1e-11) * scale);
      CHECK(after.kinetic_energy < 1.001 * before.kinetic_energy);
      CHECK(after.kinetic_energy < 0.999 * before.kinetic_energy);  // they have collided
      CHECK(std::isfinite(after.kinetic_energy));
    });
  }

  void begin(world_type& w) {
    settings(w);
    w.gravity({0, 0, -10});
    if constexpr (has<sleeping>) w.sleeping({.speed = 0.4, .time = 0.05});
    handle<plane> ground;
    w.global([&](auto& s) {
      ground = s.add(plane{.normal = {0, 0, 1}}, {});
      if constexpr (!detail::is_periodic<typename Scenario::decomposition>)
        for (const double side : {-1.0, 1.0})
          s.add(plane{.normal = {side, 0, 0}, .offset = -3.9}, {}),
              s.add(plane{.normal = {0, side, 0}, .offset = -3.9}, {});
    });
    // A sinking floor only removes energy.
    if constexpr (has<driven>)
      w.drive(ground, [](real) { return rigid_velocity{.velocity = {0, 0, -0.1}}; });
  }
  void run(world_type& w, int from, int to) {
    for (int k = from; k < to; ++k) {
      if constexpr (has<forces>)
        if (k % 10 == 3)
          w.for_each_local([](auto& b) { b.add_force(-0.2 * b.mass() * b.velocity()); });
      w.step(dt);
    }
  }
  /// A heap: no body is lost, energy does not grow, the books close, and a run from its middle ends
  /// with the same bits.
  std::string falls(int variant) {
    static std::atomic<int> unique{0};
    const auto file = std::filesystem::temp_directory_path() /
                      ("talus_composition_" + std::to_string(number_) + "_" +
                       std::to_string(unique++) + "_" + std::to_string(variant) + ".h5");
    std::string whole, resumed;
    std::uint64_t bodies = 0;
    on(variant, [&](world_type& w) {
      begin(w);
      fill(w, 0.47);
      w.synchronize();
      const std::uint64_t first = count(w);
      const motion before = measure_motion(w);
      const double energy = before.kinetic_energy + before.potential_energy;
      run(w, 0, steps / 2);
      write_checkpoint(w, file.string());
      run(w, steps / 2, steps);
      CHECK(count(w) == first);
      const motion after = measure_motion(w);
      CHECK(after.kinetic_energy + after.potential_energy < 1.01 * energy);
      books(w);
      const std::string digest = state_digest(w);
      if (w.rank() == 0) whole = digest, bodies = first;
    });
    on(variant, [&](world_type& w) {
      begin(w);
      read_checkpoint(w, file.string());
      run(w, steps / 2, steps);
      const std::uint64_t last = count(w);
      const std::string digest = state_digest(w);
      if (w.rank() == 0) {
        resumed = digest;
        CHECK(last == bodies);
      }
    });
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
    CHECK(resumed == whole);
    return whole;
  }
  static void books(world_type& w) {
    if constexpr (has<energy_ledger>) CHECK(measure_energy(w).worst < (mixed ? 1e-5 : 1e-9));
    if constexpr (has<momentum_balance>)
      CHECK(measure_momentum(w).error() < (mixed ? 1e-5 : 1e-10));
    if constexpr (has<penetration_monitor>) CHECK(measure_overlaps(w).worst < 0.5);
    if constexpr (has<residual_monitor>) CHECK(std::isfinite(w.convergence().residual));
  }

  int number_;
  Decompose decompose_;
};

}  // namespace composition
