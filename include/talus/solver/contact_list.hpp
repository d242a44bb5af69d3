#pragma once
// The contacts of one kind on this rank, and the operations on them.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/approach.hpp"
#include "talus/constraint/boundary_manifold.hpp"
#include "talus/constraint/contact_row.hpp"
#include "talus/constraint/manifold_row.hpp"
#include "talus/constraint/residual.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/constraint/stored_impulses.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/boundary_contacts.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/contact_sums.hpp"
#include "talus/solver/renewable.hpp"

namespace talus::detail {

/// Whether bodies of a contact may have a tensor of inertia.
template <class Contact>
concept turns_bodies = !requires {
  typename Contact::blocks;
};

template <class Contact>
struct interior_contacts {
  using type = contact_row<Contact>;
};
template <swept_in_manifolds Contact>
struct interior_contacts<Contact> {
  using type = manifold_row<Contact>;
};
/// Some kinds of contacts have a container of their own.
template <class Contact>
requires requires { typename Contact::blocks; }
struct interior_contacts<Contact> {
  using type = typename Contact::blocks;
};

/// Contacts whose sweeps can go through groups of islands one after the other.
template <class Contact>
concept grouped = swept_in_manifolds<Contact>;

/// Whether a contact has an impulse; its norm is the same in any frame.
template <class Contact>
[[nodiscard]] bool carries_load(const Contact& c) {
  if constexpr (framed<Contact>)
    return c.impulse_in_frame().dot(c.impulse_in_frame()) > 0;
  else
    return c.impulse().squaredNorm() > 0;
}

/// Interior contacts, with the search for their last impulses.
template <class Contact>
struct keyed_contacts {
  typename interior_contacts<Contact>::type row;
  plain_vector<contact_key> keys;
  plain_vector<history_place*> places;

  void clear() { row.clear(), keys.clear(), places.clear(); }
  [[nodiscard]] std::size_t bytes() const {
    return row.bytes() + keys.capacity() * sizeof(contact_key) +
           places.capacity() * sizeof(history_place*);
  }
};

/// Contacts between bodies that this rank alone can move (interior), and contacts between a body
/// owned here and a movable body owned elsewhere (boundary): each of those is computed alike on
/// both ranks, from the same velocities, and changes only the body owned here. Interior contacts of
/// bodies that other ranks have copies of (the border) are separate from the others: after their
/// sweep, these velocities are sent while the others are swept. Loops over the list are compiled
/// once for a kind of contact: inlined into solvers they would be compiled many times.
template <class Contact>
class contact_list : public contact_sums<contact_list<Contact>, Contact> {
 public:
  using state = typename Contact::state;

  contact_list();
  ~contact_list();

  void clear() {
    inner_.clear(), border_.clear(), boundary_.clear(), foreign_.clear();
    foreign_keys_.clear();
    renewed_ = held_ = false;
  }
  /// `last` is the position in the history of the contacts of its pair, unknown if null. It is kept
  /// up to date. `at_border`: whether other ranks need the velocity of one of the bodies.
  void add(const Contact& contact, const contact_key& key, bool a_moves, bool b_moves,
           history_place* last, bool at_border = false) {
    auto& p = at_border ? border_ : inner_;
    p.row.add(contact, a_moves, b_moves);
    p.keys.push_back(key);
    p.places.push_back(last);
  }
  /// Adds a contact that is kept for more than one step; renew() sets its data.
  void add_pair(const Contact& contact, const contact_key& key, bool a_moves, bool b_moves,
                history_place* last) requires(renewable<Contact>) {
    inner_.row.add_pair(contact, a_moves, b_moves);
    inner_.keys.push_back(key);
    inner_.places.push_back(last);
  }
  /// New data for all contacts between the same bodies; see isotropic_blocks. If they are `kept`
  /// since the last step, they keep its impulses, or lose them unless `loads`.
  template <class F>
  [[nodiscard]] bool renew(bool kept, bool loads, F&& renewed) requires(renewable<Contact>) {
    renewed_ = kept, held_ = false;
    return inner_.row.renew(kept && loads, renewed);
  }
  /// Whether contacts were kept in this step.
  [[nodiscard]] bool renewed() const { return renewed_; }
  /// Whether the contacts have the impulses that were stored in the last step.
  [[nodiscard]] bool held() const { return held_; }
  void hold() { held_ = true; }
  /// Stores the impulses of contacts that were kept, of which these are the entries.
  void store_in_place(stored_contact* entries) requires(renewable<Contact>) {
    inner_.row.each_impulse(
        [entries](std::size_t i, const vec3& impulse) { entries[i].memory = impulse; });
  }
  void add_boundary(const Contact& contact, const contact_key& key, bool owns_a,
                    history_place* last) {
    boundary_.add(contact, key, owns_a, last);
  }
  /// A contact of bodies of other ranks, without effect here; see shared_islands.hpp.
  void add_foreign(const Contact& contact, const contact_key& key) {
    foreign_.push_back(contact);
    foreign_keys_.push_back(key);
  }
  [[nodiscard]] std::size_t size() const { return interior() + boundary_.size(); }
  [[nodiscard]] std::size_t bytes() const {
    return inner_.bytes() + border_.bytes() + boundary_.bytes();
  }

  /// Calls f(contact, counts_here): a boundary contact counts on the rank that owns its body a.
  template <class F>
  void each(F&& f) const {
    each_interior([&](const auto& c) { f(c, true); });
    for (std::size_t i = 0; i < boundary_.size(); ++i) f(boundary_[i], boundary_.owns_a(i));
  }

  /// Calls f(contact, acts_on_a, acts_on_b): on which of its bodies it acts on this rank. Over all
  /// ranks each contact acts on each body once.
  template <class F>
  void each_acting(F&& f) const {
    each_interior([&](const auto& c) { f(c, true, true); });
    for (std::size_t i = 0; i < boundary_.size(); ++i)
      f(boundary_[i], boundary_.owns_a(i), !boundary_.owns_a(i));
  }

  /// Loads the impulses of the last step.
  void load_impulses(const contact_history& history);
  void store_impulses(contact_history& history) const;

  /// The number of parts into which the mass of each body owned here is divided: one for each pair
  /// it is in.
  void count_boundary(state& s) const;
  void prepare_interior(const state& s);
  void prepare_boundary(const state& s);
  void warm_start(state& s) const;

  /// Adds the impulses that are held to the others.
  void end_impacts() {
    inner_.row.end_impacts(), border_.row.end_impacts(), boundary_.end_impacts();
  }

  /// Sweeps over the interior contacts. The border comes first in either direction.
  void sweep_border(state& s, bool forward);
  void sweep_inner(state& s, bool forward);
  /// Sweeps over the interior contacts of one group of islands, and sweeps of the position
  /// correction; see island_groups.hpp.
  void sweep_group(std::size_t group, bool forward, state& s) requires grouped<Contact>;
  void correct_group(std::size_t group, bool first, state& s) requires grouped<Contact>;
  /// Calls f(contact) with one contact of each interior manifold of a single rank.
  template <class F>
  void each_manifold(F&& f) const requires grouped<Contact> {
    inner_.row.each_manifold(f);
  }
  /// A backward sweep that records the interior contacts that still change by more than `speed`:
  /// (index, change).
  const plain_vector<plain_pair<std::size_t, real>>& sweep_watched(state& s, real speed);

  /// For contact_access.
  static const contact_calls<state>* calls();
  [[nodiscard]] std::size_t size(contact_part p) const {
    return p == contact_part::interior   ? interior()
           : p == contact_part::boundary ? boundary_.size()
                                         : foreign_.size();
  }
  [[nodiscard]] Contact contact(contact_part p, std::size_t i) const {
    return p == contact_part::interior   ? interior(i)
           : p == contact_part::boundary ? boundary_[i]
                                         : foreign_[i];
  }
  /// The bodies of a contact: a, and b, or -1 if that is a global one.
  [[nodiscard]] plain_pair<std::int32_t, std::int32_t> bodies(contact_part p, std::size_t i) const {
    const auto of = [](const Contact& c) -> plain_pair<std::int32_t, std::int32_t> {
      return {c.a, Contact::paired ? c.b : -1};
    };
    if (p != contact_part::interior)
      return of(p == contact_part::boundary ? boundary_[i] : foreign_[i]);
    const std::size_t inner = inner_.row.size();
    const auto& row = i < inner ? inner_.row : border_.row;
    if constexpr (requires { row.bodies(i); })
      return row.bodies(i < inner ? i : i - inner);
    else
      return of(row[i < inner ? i : i - inner]);
  }
  template <class F>
  void edit(contact_part p, std::size_t i, F&& f) {
    if (p == contact_part::interior)
      edit_interior(i, f);
    else
      f(p == contact_part::boundary ? boundary_[i] : foreign_[i]);
  }
  [[nodiscard]] const contact_key& key(contact_part p, std::size_t i) const {
    if (p != contact_part::interior)
      return p == contact_part::boundary ? boundary_.key(i) : foreign_keys_[i];
    const std::size_t inner = inner_.keys.size();
    return i < inner ? inner_.keys[i] : border_.keys[i - inner];
  }
  /// Solves all boundary contacts from one and the same state, those of a pair together; the
  /// changes are applied later.
  void relax_boundary(state& s);
  void apply_boundary(state& s) const;

  /// Sets an impulse on a of a boundary contact; the change is applied to the body owned here.
  void set_at_boundary(std::size_t i, const vec3& impulse, state& s) {
    boundary_.set(i, impulse, s);
  }

  // For the test that impulses add no energy; see step/passivity.hpp.

  template <class F>
  void each_interior_contact(F&& f) const {
    each_interior(f);
  }
  /// Calls f(a, b) for the bodies of interior contacts that have an impulse, in no particular
  /// order.
  template <class F>
  void each_loaded_pair(F&& f) const requires(Contact::paired && !is_joint<Contact>) {
    for (const part* p : {&inner_, &border_})
      if constexpr (requires { p->row.each_loaded_pair(f); })
        p->row.each_loaded_pair(f);
      else
        for (std::size_t i = 0, n = p->row.size(), last = n; i < n; ++i) {
          const auto& c = p->row[i];
          // Once for consecutive contacts of a pair.
          if (last != n && p->row[last].a == c.a && p->row[last].b == c.b) continue;
          if (carries_load(c)) f(c.a, c.b), last = i;
        }
  }
  template <class F>
  void edit_interior_contacts(F&& f) {
    for (std::size_t i = 0, n = interior(); i < n; ++i) edit_interior(i, f);
  }
  /// Calls f for the interior contacts whose bodies `chosen(a, b)` selects; it may change them.
  template <class Chosen, class F>
  void edit_interior_contacts(Chosen&& chosen, F&& f) {
    for (std::size_t i = 0, n = interior(); i < n; ++i)
      if (const auto [a, b] = bodies(contact_part::interior, i); chosen(a, b)) edit_interior(i, f);
  }
  /// Calls f(contact, key) for the interior contacts, which edit_keyed() may change.
  template <class F>
  void each_keyed(F&& f) const {
    for (const part* p : {&inner_, &border_})
      for (std::size_t i = 0; i < p->row.size(); ++i) f(p->row[i], p->keys[i]);
  }
  template <class F>
  void edit_keyed(F&& f) {
    for (part* p : {&inner_, &border_})
      for (std::size_t i = 0; i < p->row.size(); ++i)
        p->row.edit(i, [&](Contact& c) { f(c, p->keys[i]); });
  }
  [[nodiscard]] bool has_boundary() const { return boundary_.size() > 0; }
  /// Calls f(contact, whether its body a is owned here).
  template <class F>
  void edit_boundary_contacts(F&& f) {
    for (std::size_t i = 0; i < boundary_.size(); ++i) f(boundary_[i], boundary_.owns_a(i));
  }

  // For solvers other than Gauss-Seidel. Functions that a solver does not call are not compiled.

  /// Calls f(contact, number) for all contacts, numbered from 0.
  template <class F>
  void each_numbered(F&& f) {
    std::size_t i = 0;
    for (; i < interior(); ++i) edit_interior(i, [&](Contact& c) { f(c, i); });
    for (std::size_t k = 0; k < boundary_.size(); ++k) f(boundary_[k], i++);
  }
  /// After tensors of inertia or rates of the correction have changed.
  void prepare_again(const state& s) requires turns_bodies<Contact> {
    for (part* p : {&inner_, &border_}) p->row.prepare_again(s);
    boundary_.prepare(s);
  }

  // For solvers that treat all contacts simultaneously.

  void count_all(state& s) const {
    each_acting([&](const Contact& c, bool on_a, bool on_b) {
      if (on_a) ++s.boundary_contacts[c.a];
      if constexpr (Contact::paired)
        if (on_b) ++s.boundary_contacts[c.b];
    });
  }
  void prepare_all(const state& s);
  void start_ahead() {
    before_.clear();
    each([&](const Contact& c, bool) { before_.push_back(c.impulse_in_frame()); });
  }
  /// Solves each contact from one and the same state. Its impulse is extrapolated by `part` of its
  /// last change, unless that leads back; the changes are applied later.
  void relax_ahead(const state& s, real part);
  void apply_all(state& s) const;

  void correct_border(state& s);
  void correct_inner(state& s);
  void relax_boundary_correction(state& s);
  void apply_boundary_correction(state& s) const;

 private:
  using part = keyed_contacts<Contact>;

  [[nodiscard]] std::size_t interior() const { return inner_.row.size() + border_.row.size(); }
  [[nodiscard]] Contact interior(std::size_t i) const {
    const std::size_t inner = inner_.row.size();
    return i < inner ? inner_.row[i] : border_.row[i - inner];
  }
  template <class F>
  void edit_interior(std::size_t i, F&& f) {
    const std::size_t inner = inner_.row.size();
    i < inner ? inner_.row.edit(i, f) : border_.row.edit(i - inner, f);
  }
  template <class F>
  void each_interior(F&& f) const {
    for (const part* p : {&inner_, &border_})
      for (std::size_t i = 0; i < p->row.size(); ++i) f(p->row[i]);
  }
  static void sweep(part& p, state& s, bool forward) {
    forward ? p.row.forward(s) : p.row.backward(s);
  }

  part inner_, border_;
  bool renewed_ = false, held_ = false;  ///< see renewed() and held()
  boundary_contacts<Contact> boundary_;
  plain_vector<Contact> foreign_;
  plain_vector<contact_key> foreign_keys_;
  plain_vector<typename Contact::change> changes_, before_;  ///< of all, for relax_ahead()
  plain_vector<plain_pair<std::size_t, real>> stalled_;
};

template <class Contact>
contact_list<Contact>::contact_list() = default;
template <class Contact>
contact_list<Contact>::~contact_list() = default;

template <class Contact>
void contact_list<Contact>::load_impulses(const contact_history& history) {
  if constexpr (renewable<Contact>)
    if (renewed_) return;  // they are loaded
  for (part* p : {&inner_, &border_}) p->row.load_impulses(history, p->keys, p->places);
  boundary_.load_impulses(history);
}

template <class Contact>
void contact_list<Contact>::store_impulses(contact_history& history) const {
  for (const part* p : {&inner_, &border_})
    detail::store_impulses(history, p->keys, p->places, p->row);
  boundary_.store_impulses(history);
}

template <class Contact>
void contact_list<Contact>::count_boundary(state& s) const {
  boundary_.count(s);
}

template <class Contact>
void contact_list<Contact>::prepare_interior(const state& s) {
  for (part* p : {&inner_, &border_}) p->row.prepare(s);
}

template <class Contact>
void contact_list<Contact>::prepare_boundary(const state& s) {
  boundary_.prepare(s);
}

template <class Contact>
void contact_list<Contact>::warm_start(state& s) const {
  for (const part* p : {&inner_, &border_}) p->row.apply(s);
  boundary_.warm_start(s);
}

template <class Contact>
void contact_list<Contact>::sweep_border(state& s, bool forward) {
  sweep(border_, s, forward);
}

template <class Contact>
void contact_list<Contact>::sweep_inner(state& s, bool forward) {
  sweep(inner_, s, forward);
}

template <class Contact>
void contact_list<Contact>::sweep_group(std::size_t group, bool forward,
                                        state& s) requires grouped<Contact> {
  inner_.row.sweep_group(group, forward, s);
}

template <class Contact>
void contact_list<Contact>::correct_group(std::size_t group, bool first,
                                          state& s) requires grouped<Contact> {
  inner_.row.correct_group(group, first, s);
}

template <class Contact>
const plain_vector<plain_pair<std::size_t, real>>& contact_list<Contact>::sweep_watched(
    state& s, real speed) {
  stalled_.clear();
  const auto watch = [&](auto& row, std::size_t first) {
    row.backward_watched(s, speed, [&](std::size_t i, real change) {
      stalled_.push_back({first + i, change});
    });
  };
  if (border_.row.size() > 0) watch(border_.row, inner_.row.size());
  watch(inner_.row, 0);
  return stalled_;
}

template <class Contact>
void contact_list<Contact>::relax_boundary(state& s) {
  boundary_.relax(s);
}

template <class Contact>
void contact_list<Contact>::apply_boundary(state& s) const {
  boundary_.apply(s);
}

template <class Contact>
void contact_list<Contact>::prepare_all(const state& s) {
  const auto prepare = [&](Contact& c) {
    real parts_of_b = 1;
    if constexpr (Contact::paired) parts_of_b = std::max(1u, s.boundary_contacts[c.b]);
    c.prepare(s, std::max(1u, s.boundary_contacts[c.a]), parts_of_b);
  };
  each_numbered([&](Contact& c, std::size_t) { prepare(c); });
}

template <class Contact>
void contact_list<Contact>::relax_ahead(const state& s, real part) {
  changes_.resize(size());
  each_numbered([&](Contact& c, std::size_t i) {
    auto& before = before_[i];
    auto& change = changes_[i];
    change = c.relax(s);
    const auto now = c.impulse_in_frame();
    const typename Contact::change step = now - before;
    before = now;
    if (part == 0 || change.dot(step) < 0) return;
    const typename Contact::change more = part * step;
    c.set(now + more);
    change = change + more;
  });
}

template <class Contact>
void contact_list<Contact>::apply_all(state& s) const {
  const std::size_t first = interior();
  for (std::size_t i = 0; i < first; ++i) interior(i).apply(s, changes_[i]);
  for (std::size_t i = 0; i < boundary_.size(); ++i)
    boundary_.apply_to_owned(s, i, changes_[first + i]);
}

template <class Contact>
void contact_list<Contact>::correct_border(state& s) {
  border_.row.correct(s);
}

template <class Contact>
void contact_list<Contact>::correct_inner(state& s) {
  inner_.row.correct(s);
}

template <class Contact>
void contact_list<Contact>::relax_boundary_correction(state& s) {
  boundary_.relax_correction(s);
}

template <class Contact>
void contact_list<Contact>::apply_boundary_correction(state& s) const {
  boundary_.apply_correction(s);
}

template <class Contact>
const contact_calls<typename Contact::state>* contact_list<Contact>::calls() {
  return &calls_for<contact_list>;
}

}  // namespace talus::detail
