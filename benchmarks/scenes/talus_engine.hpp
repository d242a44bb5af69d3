#pragma once
// talus on a benchmark scene: one rank, double precision, only the shapes that the scene has.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <talus/observe/memory.hpp>
#include <talus/observe/residual.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>
#include <utility>
#include <vector>

#include "checker.hpp"
#include "report.hpp"
#include "scene.hpp"

namespace bench {

template <class Shapes, class... Policies>
class talus_engine_with {
  using scenario = talus::scenario<Shapes, talus::transport<talus::serial>, Policies...>;
  static constexpr bool boxes = scenario::template has_shape<talus::box>;

 public:
  explicit talus_engine_with(const scene& s, int iterations = 0) : scene_(s), world_(link_) {
    if constexpr (!scenario::contact_law::soft)
      if (iterations > 0) world_.solver().iterations = iterations;
    const auto loose = world_.material({.density = s.density,
                                        .restitution = s.between_balls.restitution,
                                        .friction = s.between_balls.friction,
                                        .stiffness = stiffness(s)});
    const auto firm = world_.material({.density = s.density, .stiffness = stiffness(s)});
    world_.material_pair(loose, firm,
                         {.restitution = s.against_fixed.restitution,
                          .friction = s.against_fixed.friction,
                          .dynamic_friction = s.against_fixed.friction});
    world_.gravity({0, 0, s.gravity});
    world_.global([&](auto& scope) {
      for (const wall& w : s.walls)
        scope.add(talus::plane{.normal = vector(w.normal), .offset = w.offset}, firm);
    });
    if constexpr (boxes) {
      for (const block& b : s.blocks)
        world_.add(talus::body{.shape = talus::box{.size = vector(b.size)},
                               .position = vector(b.centre),
                               .material = firm,
                               .orientation = turn(b.orientation),
                               .fixed = true});
      for (const crate& c : s.crates)
        crates_.push_back(world_.add(talus::body{.shape = talus::box{.size = vector(c.size)},
                                                 .position = vector(c.centre),
                                                 .material = of_density(c.density, loose, firm),
                                                 .velocity = vector(c.velocity),
                                                 .angular_velocity = vector(c.spin),
                                                 .orientation = turn(c.orientation)}));
    }
    for (const ball& b : s.balls)
      world_.add(talus::body{.shape = talus::sphere{b.radius},
                             .position = vector(b.position),
                             .material = loose,
                             .velocity = vector(b.velocity),
                             .angular_velocity = vector(b.spin)});
    for (const ball& b : s.boulders)
      world_.add(talus::body{.shape = talus::sphere{b.radius},
                             .position = vector(b.position),
                             .material = firm,
                             .fixed = true});
  }

  static std::string name() { return "talus"; }
  void step() { world_.step(scene_.dt); }
  /// A force on a crate in the next step, with features<forces>.
  void push(std::size_t crate, const vec& force) requires boxes {
    world_[crates_[crate]].add_force(vector(force));
  }
  /// Contact residual of the last step.
  [[nodiscard]] double residual() { return talus::measure_residual(world_).value; }
  [[nodiscard]] int iterations() const {
    if constexpr (scenario::contact_law::soft)
      return 0;
    else
      return world_.solver().iterations;
  }
  void iterate(int iterations) {
    if constexpr (!scenario::contact_law::soft) world_.solver().iterations = iterations;
  }
  void start_measuring() { before_ = world_.stage_times(), steps_before_ = world_.steps(); }
  void watch_loads() {}

  [[nodiscard]] std::vector<ball> balls() const {
    const auto& store = talus::detail::state_of(world_).template of<talus::sphere>().movable;
    std::vector<ball> all;
    for (const std::size_t i : in_order(store, 0, scene_.balls.size()))
      all.push_back({array(store.position[i]), store.shape[i].radius, array(store.velocity[i]),
                     array(store.angular_velocity[i])});
    return all;
  }
  /// After the blocks, which are boxes too.
  [[nodiscard]] std::vector<crate> crates() const {
    std::vector<crate> all = scene_.crates;
    if constexpr (boxes) {
      const auto& store = talus::detail::state_of(world_).template of<talus::box>().movable;
      const auto order = in_order(store, scene_.blocks.size(), all.size());
      for (std::size_t i = 0; i < all.size(); ++i) {
        const std::size_t at = order[i];
        const talus::quat& q = store.orientation_of[at];
        all[i].centre = array(store.position[at]);
        all[i].orientation = {q.w(), q.x(), q.y(), q.z()};
        all[i].velocity = array(store.velocity[at]);
        all[i].spin = array(store.angular_velocity[at]);
      }
    }
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
    // Of the bodies of a store in the order of their creation, those from `first` on.
    const auto add = [&](const auto& store, partner kind, std::size_t first, std::size_t count) {
      const auto order = in_order(store, first, count);
      for (std::size_t i = 0; i < count; ++i)
        bodies.push_back({store.id[order[i]], {.kind = kind, .other = i}});
    };
    const auto& spheres = talus::detail::state_of(world_).template of<talus::sphere>().movable;
    add(spheres, partner::ball, 0, scene_.balls.size());
    add(spheres, partner::boulder, scene_.balls.size(), scene_.boulders.size());
    const auto& walls = talus::detail::state_of(world_).template of<talus::plane>().global;
    add(walls, partner::wall, 0, walls.size());
    if constexpr (boxes) {
      const auto& all = talus::detail::state_of(world_).template of<talus::box>().movable;
      add(all, partner::block, 0, all.size());
    }
    const auto by_id = [](const entry& x, const entry& y) { return x.first < y.first; };
    std::sort(bodies.begin(), bodies.end(), by_id);
    const auto find = [&](talus::system_id id) {
      return std::lower_bound(bodies.begin(), bodies.end(), entry{id, {}}, by_id)->second;
    };
    std::vector<loaded_pair> pairs;
    for (const auto& c : talus::detail::state_of(world_).history.entries()) {
      if (c.memory.squaredNorm() == 0) continue;
      auto a = find(c.key.a), b = find(c.key.b);
      if (a.kind != partner::ball) std::swap(a, b);
      pairs.push_back({a.other, b.kind, b.other});
    }
    return pairs;
  }
  void describe(record& out) const {
    const auto t = world_.stage_times();
    const double steps = static_cast<double>(world_.steps() - steps_before_);
    out.add("detect_ms_per_step", 1e3 * (t.detect - before_.detect) / steps);
    out.add("respond_ms_per_step", 1e3 * (t.respond - before_.respond) / steps);
    out.add("integrate_ms_per_step", 1e3 * (t.integrate - before_.integrate) / steps);
    if constexpr (!scenario::contact_law::soft)
      out.add("correction_iterations", world_.solver().correction_iterations);
    // Storage of the spheres alone; and with everything held for them: contacts, grid, solver.
    const auto& store = talus::detail::state_of(world_).template of<talus::sphere>().movable;
    out.add("bytes_stored_per_body", store.bytes_per_body());
    const double bodies = std::max(1.0, static_cast<double>(world_.local_bodies()));
    out.add("bytes_in_use_per_body", static_cast<double>(talus::bytes_in_use(world_)) / bodies);
    std::size_t contacts = 0, bytes = 0;
    talus::detail::state_of(world_).each_contact_list([&](const auto& list) {
      contacts += list.size();
      if constexpr (requires { list.bytes(); }) bytes += list.bytes();
    });
    out.add("bytes_of_contacts_per_body", static_cast<double>(bytes) / bodies);
    out.add("bytes_of_history_per_body",
            static_cast<double>(talus::detail::state_of(world_).history.bytes()) / bodies);
  }

  /// The scene as it was at the start.
  [[nodiscard]] const scene& start() const { return scene_; }
  static constexpr bool takes_boulders = true;
  /// The world, for measurements that are talus' own.
  [[nodiscard]] talus::world<scenario>& world() { return world_; }

 private:
  /// Where the bodies of a store are that were added as number `first` and the next: their ids
  /// count up, however they are sorted.
  template <class Store>
  static std::vector<std::size_t> in_order(const Store& store, std::size_t first,
                                           std::size_t count) {
    std::vector<std::size_t> all(store.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    const auto earlier = [&](std::size_t i, std::size_t j) { return store.id[i] < store.id[j]; };
    if (!std::is_sorted(all.begin(), all.end(), earlier))
      std::sort(all.begin(), all.end(), earlier);
    all.erase(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(first));
    all.resize(count);
    return all;
  }
  /// Soft contacts are as stiff as the time step allows: it is a fifth of the critical one, about.
  static double stiffness(const scene& s) {
    if (!scenario::contact_law::soft) return 0;
    double smallest = INFINITY;
    for (const ball& b : s.balls) smallest = std::min(smallest, b.radius);
    const double mass = s.density * 4 / 3 * talus::pi * smallest * smallest * smallest;
    return 0.5 * mass * (0.15 / s.dt) * (0.15 / s.dt);
  }
  /// A material for each density of crates, else alike.
  talus::material_id of_density(double density, talus::material_id loose, talus::material_id firm) {
    if (density == scene_.density) return loose;
    for (const auto& [known, id] : densities_)
      if (known == density) return id;
    const auto id = world_.material({.density = density});
    const auto law = [](const pair_law& p) {
      return talus::pair_material{p.restitution, p.friction, p.friction};
    };
    world_.material_pair(id, loose, law(scene_.between_balls));
    world_.material_pair(id, firm, law(scene_.against_fixed));
    for (const auto& [known, other] : densities_)
      world_.material_pair(id, other, law(scene_.between_balls));
    world_.material_pair(id, id, law(scene_.between_balls));
    densities_.emplace_back(density, id);
    return id;
  }
  static talus::quat turn(const std::array<double, 4>& q) { return {q[0], q[1], q[2], q[3]}; }
  static talus::vec3 vector(const vec& v) { return {v[0], v[1], v[2]}; }
  static vec array(const talus::vec3& v) { return {v[0], v[1], v[2]}; }

  scene scene_;
  talus::serial::link link_;
  talus::world<scenario> world_;
  std::vector<std::pair<double, talus::material_id>> densities_;
  std::vector<talus::handle<talus::box>> crates_;
  talus::stage_seconds before_;
  std::uint64_t steps_before_ = 0;
};

/// With the default solver.
template <class... Shapes>
using talus_engine = talus_engine_with<talus::bodies<Shapes...>>;

}  // namespace bench
