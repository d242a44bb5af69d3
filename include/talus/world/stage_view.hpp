#pragma once
// The view of a world that a user-defined feature has at a stage of the step: bodies with their
// columns, the contacts of the step, and its own state. It writes its own columns and its state,
// and nothing else.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/state/feature_states.hpp"
#include "talus/state/hooks.hpp"
#include "talus/state/state.hpp"
#include "talus/world/contact_memories.hpp"
#include "talus/world/each_contact.hpp"

namespace talus {

/// A body at a stage of the step. `Columns` are those that the feature may write.
template <class Scenario, class Store, class Columns>
class stage_body {
  using store_type = std::remove_const_t<Store>;
  using state_type = std::conditional_t<std::is_const_v<Store>, const detail::world_state<Scenario>,
                                        detail::world_state<Scenario>>;

 public:
  using shape_type = typename store_type::shape_type;

  stage_body(state_type& s, Store& store, std::size_t i, bool global, std::size_t number)
      : s_(s), store_(store), i_(i), global_(global), number_(number) {}

  /// Number of the body, the same on all ranks.
  [[nodiscard]] system_id id() const { return store_.id[i_]; }
  /// Its index in a list of all bodies known here, from 0 to stage_view::bodies() - 1.
  [[nodiscard]] std::size_t number() const { return number_; }
  /// Whether this rank owns it.
  [[nodiscard]] bool is_local() const { return !global_ && i_ < store_.locals; }
  /// Whether it is known on all ranks.
  [[nodiscard]] bool is_global() const { return global_; }
  /// Whether it can move.
  [[nodiscard]] bool is_fixed() const { return global_ || store_.fixed(i_); }
  /// Form and size.
  [[nodiscard]] const shape_type& shape() const { return store_.shape[i_]; }
  /// Position of the centre of mass, length.
  [[nodiscard]] const vec3& position() const { return store_.position[i_]; }
  /// Velocity of the centre of mass, length over time.
  [[nodiscard]] const vec3& velocity() const { return store_.velocity[i_]; }
  /// World frame, radians over time.
  [[nodiscard]] const vec3& angular_velocity() const { return store_.angular_velocity[i_]; }
  /// Position and orientation.
  [[nodiscard]] talus::pose pose() const { return store_.pose(i_); }
  /// The material of the body.
  [[nodiscard]] const talus::material& material() const {
    return s_.materials[store_.material[i_]];
  }
  /// Also of a fixed body.
  [[nodiscard]] real mass() const requires(shape_type::finite) {
    return detail::mass_of(store_, i_, s_.materials);
  }
  /// The value of a column; its default if this shape does not carry it.
  template <class Column>
  [[nodiscard]] typename Column::value_type get() const {
    if constexpr (store_type::template has<Column>)
      return store_.template column<Column>()[i_];
    else
      return detail::initial_of<Column>();
  }
  /// Sets the value of a column of the feature, of a body that this rank owns. Shadow copies
  /// receive it at the next exchange, if the column is sent to them.
  template <class Column>
  void set(const typename Column::value_type& value) const requires(!std::is_const_v<Store>) {
    static_assert(detail::contains_type<Columns, Column>,
                  "a hook sets columns of its own feature: add the column to its `columns`");
    store_.template column<Column>()[i_] = value;
    if constexpr (detail::travel_of<Column>() == travels::when_changed) s_.changed = true;
  }

 private:
  state_type& s_;
  Store& store_;
  std::size_t i_;
  bool global_;
  std::size_t number_;
};

/// A contact of the step, with the indices of its bodies in the list of all known here.
struct stage_contact : loaded_contact {
  std::size_t body_a = 0, body_b = 0;
  /// True on one rank for each contact: for sums over contacts.
  bool counts_here = true;
};

template <class Scenario, class Feature>
class stage_view {
  using state_type = detail::world_state<Scenario>;
  using columns = typename detail::columns_of_feature<Feature>::type;

 public:
  using scenario_type = Scenario;

  explicit stage_view(state_type& s) : s_(s) {}

  /// Length of the step.
  [[nodiscard]] real dt() const { return s_.dt; }
  /// Time of the world: until the step is counted, its start, and then its end.
  [[nodiscard]] real time() const { return s_.time; }
  /// Steps counted so far.
  [[nodiscard]] std::uint64_t steps() const { return s_.steps; }
  [[nodiscard]] int rank() const { return s_.link->rank(); }
  [[nodiscard]] int ranks() const { return s_.link->size(); }
  /// The state of the feature on this rank.
  [[nodiscard]] auto& state() { return detail::own_state<Feature>(s_); }

  /// Number of bodies that this rank knows: its own, shadow copies and global ones.
  [[nodiscard]] std::size_t bodies() const {
    std::size_t n = 0;
    s_.each_shape([&](const auto& b) { n += b.movable.size() + b.global.size(); });
    return n;
  }
  /// Calls f(body) for each body that this rank owns; body.set<Column>(value) changes a column.
  template <class F>
  void for_each_local(F&& f) {
    std::size_t number = 0;
    s_.each_shape([&](auto& b) {
      using store = std::remove_reference_t<decltype(b.movable)>;
      if constexpr (store::shape_type::finite)
        for (std::size_t i = 0; i < b.movable.locals; ++i)
          f(stage_body<Scenario, store, columns>(s_, b.movable, i, false, number + i));
      number += b.movable.size() + b.global.size();
    });
  }
  /// Calls f(body) for each body that this rank knows, to read.
  template <class F>
  void for_each_known(F&& f) const {
    std::size_t number = 0;
    s_.each_shape([&](const auto& b) {
      using store = std::remove_reference_t<decltype(b.movable)>;
      const auto each = [&](store& bodies, bool global) {
        for (std::size_t i = 0; i < bodies.size(); ++i)
          f(stage_body<Scenario, store, columns>(s_, bodies, i, global, number++));
      };
      each(b.movable, false), each(b.global, true);
    });
  }
  /// Calls f(body) for each contact of the step that carries a force and touches a body that this
  /// rank owns, in an order that depends on the ids of the bodies: sums over the contacts of a body
  /// have the same bits on any ranks. Both ranks see a contact across ranks. At after_solve the
  /// contacts are those that were solved, at the positions where they were found.
  template <class F>
  void for_each_contact(F&& f) {
    find_contacts();
    for (const stage_contact& c : contacts_) f(c);
  }
  /// Calls f(contact_memory) for the memories that `Law` has of contacts that act on a movable body
  /// owned here and for which select(memory) holds, in an order that depends on the ids of the
  /// bodies. f may change them: the next step starts from that. Both ranks see the memory of a
  /// contact across ranks, and must make the same of it. From after_solve on these are the memories
  /// that the forces of the step left; before, those of the last step.
  template <class Law, class Select, class F>
  void for_each_memory(Select&& select, F&& f) {
    using law = typename Scenario::contact_law::law;
    std::vector<entry_type*> chosen;
    for (entry_type& e : s_.history.entries())
      if (select(std::as_const(law::template of<Law>(e.memory)))) chosen.push_back(&e);
    visit_memories<Law>(chosen, f);
  }
  /// At after_solve the same for the memories before the forces of the step, to read: for those for
  /// which select(memory before, pointer to the one after) holds. That pointer is null if the
  /// contact has ended.
  template <class Law, class Select, class F>
  void for_each_former_memory(Select&& select, F&& f) {
    using law = typename Scenario::contact_law::law;
    const auto after = std::as_const(s_.history).entries();
    std::vector<const entry_type*> chosen;
    std::size_t next = 0;  // contacts mostly keep their order
    for (const entry_type& e : std::as_const(s_.recorded).entries()) {
      const typename law::memory* now = nullptr;
      if (next < after.size() && after[next].key == e.key)
        now = &after[next++].memory;
      else if (now = s_.history.find(e.key); now != nullptr)
        next = place_of(after, now) + 1;
      if (select(law::template of<Law>(e.memory),
                 now == nullptr ? nullptr : &law::template of<Law>(*now)))
        chosen.push_back(&e);
    }
    visit_memories<Law>(chosen, f);
  }
  /// Calls f(body) for a body of a contact that this rank owns; body.set<Column>(value) changes a
  /// column. Nothing happens for other bodies.
  template <class F>
  void with_local(std::size_t number, F&& f) {
    std::size_t first = 0;
    s_.each_shape([&](auto& b) {
      using store = std::remove_reference_t<decltype(b.movable)>;
      if constexpr (store::shape_type::finite)
        if (number >= first && number - first < b.movable.locals)
          f(stage_body<Scenario, store, columns>(s_, b.movable, number - first, false, number));
      first += b.movable.size() + b.global.size();
    });
  }
  /// Calls f(body) for a body of a contact, to read.
  template <class F>
  void with_body(std::size_t number, F&& f) const {
    const auto& places = *places_;
    places.visit_number(number, [&](const auto& store, std::size_t i, bool global) {
      using type = std::remove_reference_t<decltype(store)>;
      f(stage_body<Scenario, type, columns>(s_, store, i, global, number));
    });
  }

 private:
  using entry_type = typename state_type::history_type::entry;

  /// The index of the entry with this memory.
  [[nodiscard]] static std::size_t place_of(std::span<const entry_type> entries,
                                            const void* memory) {
    const auto* first = reinterpret_cast<const std::byte*>(&entries.front().memory);
    return static_cast<std::size_t>(static_cast<const std::byte*>(memory) - first) /
           sizeof(entry_type);
  }
  template <class Law, class Entry, class F>
  void visit_memories(std::vector<Entry*>& chosen, F&& f) {
    if (chosen.empty()) return;
    detail::sort_by_key(chosen);
    if (!places_) places_.emplace(s_);
    detail::each_memory_of<Law>(*places_, chosen, f);
  }
  void find_contacts() {
    if (found_) return;
    found_ = true;
    if (!places_) places_.emplace(s_);
    const auto note = [&](const loaded_contact& c, bool counts) {
      contacts_.push_back({c, places_->number_of(c.a), places_->number_of(c.b), counts});
    };
    if constexpr (Scenario::contact_law::soft) {
      const auto forces = s_.soft.bodies;  // of the step under way
      each_loaded_contact(s_, *places_, note);
      s_.soft.bodies = forces;
    } else {
      each_loaded_contact(s_, *places_, note);
    }
    std::sort(contacts_.begin(), contacts_.end(), [](const auto& x, const auto& y) {
      return std::tie(x.a, x.b, x.feature) < std::tie(y.a, y.b, y.feature);
    });
  }

  state_type& s_;
  std::optional<detail::body_places<Scenario>> places_;
  std::vector<stage_contact> contacts_;
  bool found_ = false;  ///< contacts_ are those of the step
};

}  // namespace talus
