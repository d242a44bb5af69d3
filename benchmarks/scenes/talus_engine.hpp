#pragma once
// talus on a benchmark scene: one rank, double precision, only the shapes that the scene has.
#include <algorithm>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>
#include <utility>
#include <vector>

#include "checker.hpp"
#include "report.hpp"
#include "scene.hpp"

namespace bench {

template <class... Shapes>
class talus_engine {
  using scenario = talus::scenario<talus::bodies<Shapes...>, talus::transport<talus::serial>>;

 public:
  talus_engine(const scene& s, int iterations) : scene_(s), world_(link_) {
    if (iterations > 0) world_.solver().iterations = iterations;
    const auto loose = world_.material({.density = s.density,
                                        .restitution = s.between_balls.restitution,
                                        .friction = s.between_balls.friction});
    const auto firm = world_.material({.density = s.density});
    world_.material_pair(loose, firm,
                         {.restitution = s.against_fixed.restitution,
                          .friction = s.against_fixed.friction,
                          .dynamic_friction = s.against_fixed.friction});
    world_.gravity({0, 0, s.gravity});
    world_.global([&](auto& scope) {
      for (const wall& w : s.walls)
        scope.add(talus::plane{.normal = vector(w.normal), .offset = w.offset}, firm);
    });
    if constexpr ((std::is_same_v<Shapes, talus::box> || ...))
      for (const block& b : s.blocks)
        world_.add(talus::body{
            .shape = talus::box{.size = vector(b.size)},
            .position = vector(b.centre),
            .material = firm,
            .orientation = {b.orientation[0], b.orientation[1], b.orientation[2], b.orientation[3]},
            .fixed = true});
    for (const ball& b : s.balls)
      world_.add(talus::body{.shape = talus::sphere{b.radius},
                             .position = vector(b.position),
                             .material = loose,
                             .velocity = vector(b.velocity),
                             .angular_velocity = vector(b.spin)});
  }

  static std::string name() { return "talus"; }
  void step() { world_.step(scene_.dt); }
  [[nodiscard]] int iterations() const { return world_.solver().iterations; }
  void watch_loads() {}

  /// Bodies of one rank keep their order.
  [[nodiscard]] std::vector<ball> balls() const {
    const auto& store = world_.state().template of<talus::sphere>().movable;
    std::vector<ball> all;
    for (std::size_t i = 0; i < store.locals; ++i)
      all.push_back({array(store.position[i]), store.shape[i].radius, array(store.velocity[i]),
                     array(store.angular_velocity[i])});
    return all;
  }
  [[nodiscard]] std::size_t contacts() const {
    std::size_t n = 0;
    world_.state().each_contact_list([&](const auto& list) { n += list.size(); });
    return n;
  }
  [[nodiscard]] std::vector<loaded_pair> loaded() const {
    using entry = std::pair<talus::system_id, loaded_pair>;  // of the latter, kind and number only
    std::vector<entry> bodies;
    const auto add = [&](const auto& store, partner kind) {
      for (std::size_t i = 0; i < store.size(); ++i)
        bodies.push_back({store.id[i], {.kind = kind, .other = i}});
    };
    add(world_.state().template of<talus::sphere>().movable, partner::ball);
    add(world_.state().template of<talus::plane>().global, partner::wall);
    if constexpr ((std::is_same_v<Shapes, talus::box> || ...))
      add(world_.state().template of<talus::box>().movable, partner::block);
    const auto by_id = [](const entry& x, const entry& y) { return x.first < y.first; };
    std::sort(bodies.begin(), bodies.end(), by_id);
    const auto find = [&](talus::system_id id) {
      return std::lower_bound(bodies.begin(), bodies.end(), entry{id, {}}, by_id)->second;
    };
    std::vector<loaded_pair> pairs;
    for (const auto& c : world_.state().history.entries()) {
      if (c.impulse.squaredNorm() == 0) continue;
      auto a = find(c.key.a), b = find(c.key.b);
      if (a.kind != partner::ball) std::swap(a, b);
      pairs.push_back({a.other, b.kind, b.other});
    }
    return pairs;
  }
  void describe(record& out) const {
    const auto& t = world_.state().seconds;
    const double steps = static_cast<double>(world_.steps());
    out.add("detect_ms_per_step", 1e3 * t.detect / steps);
    out.add("respond_ms_per_step", 1e3 * t.respond / steps);
    out.add("integrate_ms_per_step", 1e3 * t.integrate / steps);
    out.add("correction_iterations", world_.solver().correction_iterations);
  }

 private:
  static talus::vec3 vector(const vec& v) { return {v[0], v[1], v[2]}; }
  static vec array(const talus::vec3& v) { return {v[0], v[1], v[2]}; }

  scene scene_;
  talus::serial::link link_;
  talus::world<scenario> world_;
};

}  // namespace bench
