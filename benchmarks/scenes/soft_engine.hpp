#pragma once
// talus with soft contacts on a benchmark scene of spheres: one rank, double precision. A step of
// the scene is divided into as many as `iterations` says, so that its cost stays that of the same
// simulated time; the springs are the stiffest that a quarter of the critical time step allows.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <talus/observe/critical_dt.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/memory.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>
#include <utility>
#include <vector>

#include "checker.hpp"
#include "report.hpp"
#include "scene.hpp"

namespace bench {

template <class Law, class Integrator = talus::semi_implicit_euler>
class soft_engine {
  using scenario = talus::scenario<talus::bodies<talus::sphere, talus::plane>, Law,
                                   talus::integrator<Integrator>, talus::transport<talus::serial>>;
  static constexpr double part_of_critical_dt = 0.25;

 public:
  soft_engine(const scene& s, int iterations)
      : scene_(s), parts_(iterations > 0 ? iterations : 20), world_(link_) {
    double least = std::numeric_limits<double>::infinity();
    for (const ball& b : s.balls) least = std::min(least, std::pow(b.radius, 3));
    const double mass = s.density * 4 / 3 * std::numbers::pi * least;
    const double damping = talus::detail::damping_of_restitution(s.between_balls.restitution);
    const double unit = talus::detail::longest_step_of_spring(1, mass, damping);
    stiffness_ = std::pow(part_of_critical_dt * unit / dt(), 2);
    const auto stuff = world_.material({.density = s.density,
                                        .restitution = s.between_balls.restitution,
                                        .friction = s.between_balls.friction,
                                        .stiffness = stiffness_});
    world_.gravity({0, 0, s.gravity});
    world_.global([&](auto& scope) {
      for (const wall& w : s.walls)
        scope.add(
            talus::plane{.normal = {w.normal[0], w.normal[1], w.normal[2]}, .offset = w.offset},
            stuff);
    });
    for (const ball& b : s.balls)
      world_.add(talus::body{.shape = talus::sphere{b.radius},
                             .position = {b.position[0], b.position[1], b.position[2]},
                             .material = stuff,
                             .velocity = {b.velocity[0], b.velocity[1], b.velocity[2]},
                             .angular_velocity = {b.spin[0], b.spin[1], b.spin[2]}});
  }

  static std::string name() { return "talus soft"; }
  void step() {
    for (int k = 0; k < parts_; ++k) world_.step(dt());
  }
  [[nodiscard]] int iterations() const { return parts_; }
  void watch_loads() {}

  /// Bodies of one rank keep their order.
  [[nodiscard]] std::vector<ball> balls() const {
    const auto array = [](const talus::vec3& v) { return vec{v[0], v[1], v[2]}; };
    const auto& store = talus::detail::state_of(world_).template of<talus::sphere>().movable;
    std::vector<ball> all;
    for (std::size_t i = 0; i < store.locals; ++i)
      all.push_back({array(store.position[i]), store.shape[i].radius, array(store.velocity[i]),
                     array(store.angular_velocity[i])});
    return all;
  }
  [[nodiscard]] std::size_t contacts() const {
    std::size_t n = 0;
    talus::detail::state_of(world_).each_contact_list([&](const auto& list) { n += list.size(); });
    return n;
  }
  [[nodiscard]] std::vector<loaded_pair> loaded() const {
    using entry = std::pair<talus::system_id, loaded_pair>;  // of the latter, kind and number only
    std::vector<entry> bodies;
    const auto add = [&](const auto& store, partner kind) {
      for (std::size_t i = 0; i < store.size(); ++i)
        bodies.push_back({store.id[i], {.kind = kind, .other = i}});
    };
    add(talus::detail::state_of(world_).template of<talus::sphere>().movable, partner::ball);
    add(talus::detail::state_of(world_).template of<talus::plane>().global, partner::wall);
    const auto by_id = [](const entry& x, const entry& y) { return x.first < y.first; };
    std::sort(bodies.begin(), bodies.end(), by_id);
    const auto find = [&](talus::system_id id) {
      return std::lower_bound(bodies.begin(), bodies.end(), entry{id, {}}, by_id)->second;
    };
    std::vector<loaded_pair> pairs;
    for (const auto& c : talus::detail::state_of(world_).history.entries()) {
      auto a = find(c.key.a), b = find(c.key.b);
      if (a.kind != partner::ball) std::swap(a, b);
      pairs.push_back({a.other, b.kind, b.other});
    }
    return pairs;
  }
  void describe(record& out) const {
    const auto t = world_.stage_times();
    const double steps = static_cast<double>(world_.steps());
    out.add("steps_per_step", parts_);
    out.add("stiffness", stiffness_);
    out.add("time_step", dt());
    out.add("detect_ms_per_step", 1e3 * parts_ * t.detect / steps);
    out.add("respond_ms_per_step", 1e3 * parts_ * t.respond / steps);
    out.add("integrate_ms_per_step", 1e3 * parts_ * t.integrate / steps);
    out.add("bytes_per_kept_contact",
            sizeof(typename talus::detail::world_state<scenario>::history_type::entry));
    out.add("bytes_in_use_per_body",
            static_cast<double>(talus::bytes_in_use(world_)) /
                static_cast<double>(std::max<std::size_t>(1, scene_.balls.size())));
  }

 private:
  [[nodiscard]] double dt() const { return scene_.dt / parts_; }

  scene scene_;
  int parts_;
  double stiffness_ = 0;
  talus::serial::link link_;
  talus::world<scenario> world_;
};

}  // namespace bench
