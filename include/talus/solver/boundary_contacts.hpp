#pragma once
// The contacts of one kind between a body owned here and a movable body owned elsewhere.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/boundary_manifold.hpp"
#include "talus/constraint/impact_terms.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/constraint/stored_impulses.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Each of these contacts is computed alike on both ranks, from the same velocities, and changes
/// only the body owned here.
template <class Contact>
class boundary_contacts {
 public:
  using state = typename Contact::state;

  void clear() { contacts_.clear(), keys_.clear(), places_.clear(), owns_a_.clear(); }
  void add(const Contact& contact, const contact_key& key, bool owns_a, history_place* last) {
    contacts_.push_back(contact);
    keys_.push_back(key);
    places_.push_back(last);
    owns_a_.push_back(owns_a);
  }
  [[nodiscard]] std::size_t size() const { return contacts_.size(); }
  [[nodiscard]] std::size_t bytes() const {
    return contacts_.capacity() * sizeof(Contact) + keys_.capacity() * sizeof(contact_key) +
           places_.capacity() * sizeof(history_place*);
  }
  [[nodiscard]] Contact& operator[](std::size_t i) { return contacts_[i]; }
  [[nodiscard]] const Contact& operator[](std::size_t i) const { return contacts_[i]; }
  [[nodiscard]] const contact_key& key(std::size_t i) const { return keys_[i]; }
  /// Whether its body a is owned here, else b.
  [[nodiscard]] bool owns_a(std::size_t i) const { return owns_a_[i]; }

  void load_impulses(const contact_history& history) {
    detail::load_impulses(history, keys_, places_, contacts_);
  }
  void store_impulses(contact_history& history) const {
    detail::store_impulses(history, keys_, places_, contacts_);
  }
  /// The number of parts into which the mass of each body owned here is divided: one for each pair
  /// it is in.
  void count(state& s) const {
    each_manifold(keys_, [&](std::size_t first, std::size_t) {
      ++s.boundary_contacts[owns_a_[first] ? contacts_[first].a : contacts_[first].b];
    });
  }
  void prepare(const state& s) {
    for (Contact& c : contacts_) c.prepare(s, parts_of(s, c.a), parts_of(s, c.b));
  }
  void warm_start(state& s) const {
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      apply_to_owned(s, i, contacts_[i].impulse_in_frame());
  }
  /// Sets an impulse on a; the change is applied to the body owned here.
  void set(std::size_t i, const vec3& impulse, state& s) {
    Contact& c = contacts_[i];
    const auto before = c.impulse_in_frame();
    c.load_impulse(impulse);
    apply_to_owned(s, i, c.since(before));
  }
  void apply_to_owned(state& s, std::size_t i, const typename Contact::change& d) const {
    if (owns_a_[i])
      contacts_[i].apply_to_a(s, d);
    else if constexpr (Contact::paired)
      contacts_[i].apply_to_b(s, d);
  }

  /// Adds the impulses that are held to the others.
  void end_impacts() {
    if constexpr (may_rebound<Contact>)
      for (Contact& c : contacts_) c.set(c.impulse_in_frame() + c.held);
  }
  /// Solves all contacts from one and the same state, those of a pair together; the changes are
  /// applied later.
  void relax(state& s) {
    for (Contact& c : contacts_) meet_impacts<true>(c, s);
    solve_from_snapshot(
        s, changes_, [&](Contact& c) { return c.relax(s); },
        [&](Contact& c, const auto& d) { c.apply(s, d); });
  }
  void apply(state& s) const {
    for (std::size_t i = 0; i < contacts_.size(); ++i) apply_to_owned(s, i, changes_[i]);
  }
  void relax_correction(state& s) {
    solve_from_snapshot(
        s, corrections_, [&](Contact& c) { return c.relax_correction(s); },
        [&](Contact& c, const auto& d) { c.correct_a(s, d), c.correct_b(s, d); });
  }
  void apply_correction(state& s) const {
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      owns_a_[i] ? contacts_[i].correct_a(s, corrections_[i])
                 : contacts_[i].correct_b(s, corrections_[i]);
  }

 private:
  static typename state::number parts_of(const state& s, std::int32_t body) {
    return static_cast<typename state::number>(
        std::max(1u, s.boundary_contacts[static_cast<std::size_t>(body)]));
  }
  /// Changes of all contacts, where the bodies are those of `s`. The contacts of one pair are swept
  /// forward and backward, isolated from all others; the pair's bodies are restored afterwards.
  template <class Change, class Relax, class Apply>
  void solve_from_snapshot(state& s, plain_vector<Change>& changes, Relax&& relax, Apply&& apply) {
    changes.resize(contacts_.size());
    each_manifold(keys_, [&](std::size_t first, std::size_t last) {
      changes[first] = relax(contacts_[first]);
      if constexpr (comes_in_manifolds<Contact>) {
        const std::size_t n = last - first;
        if (n == 1) return;
        const Contact& c = contacts_[first];
        const split_pair<typename state::number> alone(s, c.a, c.b, parts_of(s, c.a),
                                                       parts_of(s, c.b));
        for (std::size_t k = 0; k < 2 * n - 1; ++k) {
          const bool again = k >= n;
          const std::size_t i = again ? first + 2 * n - 2 - k : first + k;
          const Change d = again || i > first ? relax(contacts_[i]) : changes[i];
          changes[i] = again ? changes[i] + d : d;
          apply(contacts_[i], d);
        }
      }
    });
  }

  plain_vector<Contact> contacts_;
  plain_vector<contact_key> keys_;
  plain_vector<history_place*> places_;
  plain_vector<char> owns_a_;
  plain_vector<typename Contact::change> changes_;
  plain_vector<decltype(Contact::correction_impulse)> corrections_;
};

}  // namespace talus::detail
