#pragma once
// Pairs of bodies that a feature keeps apart: its hook may_touch(pair). A pair that may not touch
// is no candidate pair, so that nothing else in a step has to exclude it.
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "talus/body/column.hpp"
#include "talus/body/features.hpp"
#include "talus/core/id.hpp"
#include "talus/core/type_list.hpp"
#include "talus/state/feature_states.hpp"
#include "talus/state/state.hpp"

namespace talus {

/// One of the two bodies that the hook may_touch of a feature compares.
template <class Store>
class pair_body {
 public:
  using shape_type = typename Store::shape_type;

  pair_body(const Store& store, std::size_t i) : store_(store), i_(i) {}

  /// Number of the body, the same on all ranks.
  [[nodiscard]] system_id id() const { return store_.id[i_]; }
  /// Material of the body.
  [[nodiscard]] material_id material() const { return store_.material[i_]; }
  /// Form and size.
  [[nodiscard]] const shape_type& shape() const { return store_.shape[i_]; }
  /// Whether it cannot move, as fixed and global bodies.
  [[nodiscard]] bool is_fixed() const { return store_.fixed(i_); }
  /// The value of a column; its default if this shape does not carry it.
  template <class Column>
  [[nodiscard]] typename Column::value_type get() const {
    static_assert(detail::travel_of<Column>() == travels::when_changed,
                  "may_touch reads a column that does not travel when it is changed, so that ranks "
                  "would differ: give the column `travel = talus::travels::when_changed`");
    if constexpr (Store::template has<Column>)
      return store_.template column<Column>()[i_];
    else
      return detail::initial_of<Column>();
  }

 private:
  const Store& store_;
  std::size_t i_;
};

/// What the hook may_touch of a feature takes: two bodies near each other, of which the first has
/// the lesser id.
template <class State, class StoreA, class StoreB>
class body_pair {
 public:
  body_pair(const State& state, const pair_body<StoreA>& a, const pair_body<StoreB>& b)
      : state_(state), a_(a), b_(b) {}

  [[nodiscard]] const pair_body<StoreA>& a() const { return a_; }
  [[nodiscard]] const pair_body<StoreB>& b() const { return b_; }
  /// The state of the feature, which is alike on all ranks.
  [[nodiscard]] const State& state() const { return state_; }

 private:
  const State& state_;
  pair_body<StoreA> a_;
  pair_body<StoreB> b_;
};

namespace detail {

struct no_filter_state {};

/// Calls f.template operator()<Feature>() for the features with a hook may_touch.
template <class Features, class F>
void each_filter(F&& f) {
  [&]<class... Listed>(type_list<Listed...>) {
    [[maybe_unused]] const auto one = [&]<class Feature>() {
      if constexpr (filters_pairs<Feature>) f.template operator()<Feature>();
    };
    (one.template operator()<Listed>(), ...);
  }(Features{});
}

/// Whether the features of the scenario let two bodies touch.
template <class Scenario, class StoreA, class StoreB>
[[nodiscard]] bool may_touch(const world_state<Scenario>& s, const StoreA& a, std::size_t i,
                             const StoreB& b, std::size_t j) {
  if (b.id[j] < a.id[i]) return may_touch(s, b, j, a, i);
  const pair_body<StoreA> one(a, i);
  const pair_body<StoreB> other(b, j);
  bool may = true;
  each_filter<typename Scenario::features>([&]<class Feature>() {
    if constexpr (has_own_state<Feature, Scenario>)
      may = may && Feature::hooks::may_touch(body_pair(own_state<Feature>(s), one, other));
    else
      may = may && Feature::hooks::may_touch(body_pair(no_filter_state{}, one, other));
  });
  return may;
}

/// At the start of a step, and before a checkpoint: candidate pairs are searched anew if the state
/// of a filter has another `revision()`, and sleeping bodies wake. (Changes of bodies are noted in
/// note_filtered_change().)
template <class Scenario>
void note_filters(world_state<Scenario>& s) {
  std::uint64_t revision = 0;
  each_filter<typename Scenario::features>([&]<class Feature>() {
    if constexpr (has_own_state<Feature, Scenario>) {
      if constexpr (requires { own_state<Feature>(s).revision(); })
        revision += own_state<Feature>(s).revision();
      if constexpr (requires { own_state<Feature>(s).require_materials(s.materials.size()); })
        own_state<Feature>(s).require_materials(s.materials.size());
    }
  });
  if (s.filtered.known && s.filtered.revision == revision) return;
  s.found.known = false;
  if constexpr (world_state<Scenario>::sleeps) s.sleep.all = s.sleep.all || s.filtered.known;
  s.filtered = {true, revision};
}

/// Between the last exchange before the contacts of a step are found and that moment, hooks change
/// nothing that filters read: the copies on neighbours would differ.
template <class Scenario>
void note_copies_sent([[maybe_unused]] world_state<Scenario>& s, [[maybe_unused]] bool sent) {
  if constexpr (world_state<Scenario>::filters) s.filtered.sent = sent;
}

}  // namespace detail
}  // namespace talus
