#pragma once
// Flow through a plane: bodies counted one by one as their centres cross it.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "talus/core/exact_sum.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/shape/plane.hpp"
#include "talus/world/fresh_start.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// The flow through a plane: `forward` along its normal. Masses by density and volume.
struct flow {
  /// mass that has passed along the normal, and against it
  double mass_forward = 0, mass_backward = 0;
  std::uint64_t forward = 0, backward = 0;  ///< bodies; one that turns back counts in both

  /// Mass that has passed, forward minus backward.
  [[nodiscard]] double mass() const { return mass_forward - mass_backward; }
  /// Bodies that have passed, forward minus backward.
  [[nodiscard]] std::int64_t bodies() const {
    return static_cast<std::int64_t>(forward) - static_cast<std::int64_t>(backward);
  }
};

namespace detail {

/// The side of a plane on which each body known to this rank was after the last step.
template <class Scenario>
class crossing_counter {
 public:
  crossing_counter(const world_state<Scenario>& s, const plane& where) : s_(s), where_(where) {}

  void note() {
    before_.clear();
    s_.each_finite_shape([&](const auto& b) {
      for (std::size_t i = 0; i < b.movable.size(); ++i)
        before_.push_back(side_of(b.movable.id[i], b.movable.position[i]));
    });
    indexed_ = false;
  }
  void count() {
    std::size_t n = 0;
    s_.each_finite_shape([&](const auto& b) {
      const auto& store = b.movable;
      for (std::size_t i = 0; i < store.size(); ++i, ++n) {
        if (i >= store.locals || store.fixed(i)) continue;
        const side* last = find(n, store.id[i]);
        if (last == nullptr || last->ahead == ahead(as_seen_before(*last, store.position[i])))
          continue;
        const double mass = mass_of(store, i, s_.materials);
        const std::size_t way = last->ahead ? 1 : 0;
        ++numbers_[way], masses_[way] += mass;
      }
    });
    note();
  }
  /// Forward and backward.
  [[nodiscard]] std::array<exact_sum, 2>& masses() { return masses_; }
  [[nodiscard]] std::array<std::uint64_t, 2>& numbers() { return numbers_; }

 private:
  static constexpr bool periodic = world_state<Scenario>::periodic;
  struct nowhere {};
  struct side {
    system_id id = no_id;
    bool ahead = false;
    [[no_unique_address]] std::conditional_t<periodic, vec3, nowhere> position{};
  };
  [[nodiscard]] side side_of(system_id id, const vec3& p) const {
    if constexpr (periodic) {  // a copy may be an image
      const vec3 home = s_.own.box().wrapped(p);
      return {id, ahead(home), home};
    }
    return {id, ahead(p), {}};
  }
  /// The image nearest to the last position of the body: a body that leaves a periodic box on one
  /// side and enters on the other has not crossed the space in between.
  [[nodiscard]] vec3 as_seen_before(const side& before, const vec3& now) const {
    if constexpr (periodic) return s_.own.box().nearest(now, before.position);
    return (void)before, now;
  }
  [[nodiscard]] bool ahead(const vec3& p) const { return where_.distance(p) >= 0; }
  /// Mostly the bodies are in their last places.
  [[nodiscard]] const side* find(std::size_t guess, system_id id) {
    if (guess < before_.size() && before_[guess].id == id) return &before_[guess];
    if (!indexed_) {
      places_.reset(before_.size());
      for (const side& b : before_) places_.add(b.id);
      indexed_ = true;
    }
    const std::uint32_t at = places_.find(id);
    return at == id_table::unknown ? nullptr : &before_[at];
  }

  const world_state<Scenario>& s_;
  plane where_;
  plain_vector<side> before_;
  id_table places_;
  bool indexed_ = false;
  std::array<exact_sum, 2> masses_;
  std::array<std::uint64_t, 2> numbers_{};
};

}  // namespace detail

/// Counts from now on, after each step of simulate(), the bodies whose centres cross a plane:
/// `flow_meter outflow(world, plane{.normal = {0, 0, -1}, .offset = 2})`. Each crossing counts
/// once, on the rank that owns the body after it: a rank knows its neighbours' bodies before they
/// migrate. A body that was unknown in the step before, such as a new one, counts from then on.
/// Nothing is sent until total() is called. Costs one pass over the bodies that a rank knows in
/// each step. Checkpoints hold the counts of each plane. A meter takes them if it is made before
/// the file is read (in run(), before the simulate() that goes on); one that the first run did not
/// have starts at the restart.
template <class Scenario>
class flow_meter {
 public:
  /// On all ranks alike. Throws invalid_argument for an invalid plane. The world must outlive the
  /// meter; counting continues after the meter is destroyed.
  flow_meter(world<Scenario>& w, const plane& where) : w_(w) {
    where.validate();
    counter_ = std::make_shared<detail::crossing_counter<Scenario>>(detail::view_of(w), where);
    if constexpr (Scenario::template has_feature<checkpoints>) {
      std::string name = "flow through a plane";
      for (const real x : {where.normal.x(), where.normal.y(), where.normal.z(), where.offset})
        name += ' ' + detail::text(x, 17);
      auto& keeper = detail::checkpoint_access::keeper(w);
      for (const std::size_t way : {0, 1}) {
        const std::string side = name + (way == 0 ? ", forward" : ", backward");
        keeper.add_meter(side + ", mass", counter_->masses()[way]);
        keeper.add_meter(side + ", bodies", counter_->numbers()[way]);
      }
    }
    w.before_simulating("flow meters", [counter = counter_] { counter->note(); });
    w.monitor_each_step("flow meters", [counter = counter_] { counter->count(); });
  }
  /// Collective: sums over all ranks, since the meter was made.
  [[nodiscard]] flow total() const {
    w_.require_all_ranks("flow_meter::total");
    auto masses = counter_->masses();
    auto numbers = counter_->numbers();
    detail::sum_exactly(w_.link(), masses);
    w_.link().reduce(reduction::sum, std::span<std::uint64_t>(numbers));
    return {masses[0].value(), masses[1].value(), numbers[0], numbers[1]};
  }

 private:
  world<Scenario>& w_;
  std::shared_ptr<detail::crossing_counter<Scenario>> counter_;
};

}  // namespace talus
