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

#include "talus/contact/acting_memory.hpp"
#include "talus/state/feature_states.hpp"
#include "talus/state/hooks.hpp"
#include "talus/state/state.hpp"
#include "talus/world/chosen_contacts.hpp"
#include "talus/world/contact_memories.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/stage_body.hpp"

namespace talus {

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
      using store = const std::remove_reference_t<decltype(b.movable)>;
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
  /// Whether no body that this rank knows can move in this step, so that no contact here begins or
  /// ends. False with features<continuous_collision>, which may wake bodies in the step.
  [[nodiscard]] bool at_rest() const { return !state_type::continuous && detail::all_rest(s_); }
  /// Calls f(contact) at after_solve for the contacts of these pairs that carry a force, in the
  /// order of for_each_contact(). The pairs are in ascending order, each once and with the lesser
  /// id first. Costs the geometry of these pairs; no rank waits for another.
  template <class F>
  void for_each_contact_of(const std::vector<std::pair<system_id, system_id>>& pairs, F&& f) {
    if (!places_) places_.emplace(s_);
    std::vector<stage_contact> contacts;
    detail::each_chosen_contact(s_, *places_, pairs, [&](const loaded_contact& c, bool counts) {
      contacts.push_back({c, places_->number_of(c.a), places_->number_of(c.b), counts});
    });
    sort_contacts(contacts);
    for (const stage_contact& c : contacts) f(c);
  }
  /// Calls f(id of a, id of b, counts here, impulse) for the contacts that the memory of this rank
  /// has of bodies that it owns, once for each point: before after_solve those of the last step,
  /// then those of this one. The impulse is that of the step, 0 for soft contacts. A hard contact
  /// is among them if it carried a force, also while its bodies sleep; a soft one as long as its
  /// law remembers it or, with features<events> and a law that acts at a distance, if it carried a
  /// force. Contacts with a body that this rank no longer knows are left out. Costs no detection.
  /// The memory of a contact migrates with its bodies, and checkpoints hold it.
  template <class F>
  void for_each_touching(F&& f) {
    constexpr bool soft = Scenario::contact_law::soft;
    if constexpr (soft)
      static_assert(
          Scenario::contact_law::remembers,
          "for_each_touching takes what contacts remember, and this soft contact remembers "
          "nothing: add coulomb_friction to soft_contact<...>");
    if (!places_) places_.emplace(s_);
    const auto report = [&](const auto& e) {
      bool known = true, own[2] = {false, false}, moves[2] = {false, false};
      for (const int k : {0, 1})
        known = known && places_->visit(k == 0 ? e.key.a : e.key.b,
                                        [&](const auto& store, std::size_t i, bool global) {
                                          moves[k] = !global && !store.fixed(i);
                                          own[k] = moves[k] && i < store.locals;
                                        });
      if (!known || (!own[0] && !own[1])) return;
      real impulse = 0;
      if constexpr (!soft) impulse = e.memory.norm();
      f(e.key.a, e.key.b, moves[0] ? own[0] : own[1], impulse);
    };
    std::vector<const entry_type*> chosen;
    const auto choose = [&](const entry_type& e) {
      if (detail::has_acted(e.memory)) chosen.push_back(&e);
    };
    for (const entry_type& e : std::as_const(s_.history).entries()) choose(e);
    if constexpr (state_type::sleeps) detail::each_frozen_contact(s_, choose);
    detail::sort_by_key(chosen);
    for (const entry_type* e : chosen) report(*e);
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
    if (!chosen.empty()) detail::close_ledger(s_);  // f may change the energy of springs
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
      each_loaded_contact<true>(s_, *places_, note);
      s_.soft.bodies = forces;
    } else {
      each_loaded_contact<true>(s_, *places_, note);
    }
    sort_contacts(contacts_);
  }
  static void sort_contacts(std::vector<stage_contact>& contacts) {
    std::sort(contacts.begin(), contacts.end(), [](const auto& x, const auto& y) {
      return std::tie(x.a, x.b, x.feature) < std::tie(y.a, y.b, y.feature);
    });
  }

  state_type& s_;
  std::optional<detail::body_places<Scenario>> places_;
  std::vector<stage_contact> contacts_;
  bool found_ = false;  ///< contacts_ are those of the step
};

}  // namespace talus
