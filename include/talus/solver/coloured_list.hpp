#pragma once
// The contacts of one kind on this rank, solved colour by colour.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/constraint/approach.hpp"
#include "talus/constraint/contact_row.hpp"
#include "talus/constraint/grounded_contacts.hpp"
#include "talus/constraint/in_sequence.hpp"
#include "talus/constraint/isotropic_blocks.hpp"
#include "talus/constraint/joint_in_list.hpp"
#include "talus/constraint/manifold_row.hpp"
#include "talus/constraint/passive_rebound.hpp"
#include "talus/constraint/residual.hpp"
#include "talus/constraint/stored_impulses.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/colouring.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/contact_sums.hpp"
#include "talus/solver/renewable.hpp"

namespace talus::detail {

template <class Contact>
struct row_of_colour {
  using type = contact_row<Contact>;
};
template <swept_in_manifolds Contact>
struct row_of_colour<Contact> {
  using type = manifold_row<Contact, in_sequence<8>>;
};
template <class Contact>
requires requires { typename Contact::blocks; }
struct row_of_colour<Contact> {
  using type =
      isotropic_blocks<Contact, in_sequence<lanes_of<wide_pack<typename Contact::number>>>>;
};

/// The constraint list of solvers by colours; contact_list is that of other solvers. No two pairs
/// of one colour share a movable body, so that their order has no effect. Contacts with a body of
/// another rank (shared ones) are computed alike on both ranks. They, and the contacts of other
/// ranks that are computed here too (foreign ones), are kept apart from the others: they wait for
/// velocities from other ranks.
template <class Contact>
class coloured_list : public contact_sums<coloured_list<Contact>, Contact> {
 public:
  using state = typename Contact::state;

  coloured_list();
  ~coloured_list();

  void clear() {
    waiting_.clear();
    for (std::size_t k = 0; k < used_; ++k)
      for (part& p : colours_[k].parts) p.clear();
    used_ = 0;
    count_ = 0;
    pairs_alone_ = renewed_ = held_ = false;
  }
  void add(const Contact& contact, const contact_key& key, bool a_moves, bool b_moves,
           history_place* last, bool = false) {
    waiting_.add(contact, key, last, {a_moves, b_moves, false, true, -1});
  }
  void add_boundary(const Contact& contact, const contact_key& key, bool owns_a,
                    history_place* last) {
    waiting_.add(contact, key, last, {true, true, true, owns_a, -1});
  }

  // Contacts that are kept for more than one step, as in contact_list.

  /// All contacts of the list are added by this function, or none.
  void add_pair(const Contact& contact, const contact_key& key, bool a_moves, bool b_moves,
                history_place* last) requires(renewable<Contact>) {
    pairs_alone_ = true;
    waiting_.add(contact, key, last, {a_moves, b_moves, false, true, -1});
  }
  /// Whether contacts were added by add_pair() since renew() was called.
  [[nodiscard]] bool lacks_data() const { return pairs_alone_ && !renewed_ && !held_; }
  /// After arrange().
  template <class F>
  [[nodiscard]] bool renew(bool kept, bool loads, F&& renewed) requires(renewable<Contact>) {
    renewed_ = kept, held_ = false;
    for (std::size_t k = 0; k < used_; ++k)
      if (!colours_[k].parts[0].row.renew(kept && loads, renewed)) return false;
    return true;
  }
  [[nodiscard]] bool renewed() const { return renewed_; }
  [[nodiscard]] bool held() const { return held_; }
  void hold() { held_ = true; }
  void store_in_place(stored_contact* entries) requires(renewable<Contact>) {
    for (std::size_t k = 0; k < used_; ++k) {
      auto& row = colours_[k].parts[0].row;
      row.each_impulse(
          [entries](std::size_t i, const vec3& impulse) { entries[i].memory = impulse; });
      entries += row.size();
    }
  }
  /// Moves contacts of own bodies, one for each unit, from the colours `before` to those of now.
  /// They load their impulses again.
  template <class Colour>
  void rearrange(std::span<const std::uint32_t> before, Colour&& colour_of, std::uint32_t colours);

  /// Calls f(unit, shared) for each pair of bodies, and each body with all that holds it where that
  /// is solved together (see grounded_contacts.hpp); the caller sets the unit's list.
  template <class F>
  void each_unit(F&& f) {
    join_grounded();
    const auto& w = waiting_;
    for (std::size_t i = 0; i < w.contacts.size(); ++i) {
      if (!w.begins_unit(i)) continue;
      const ends_of_contact& e = w.ends[i];
      std::int32_t a = e.a_moves ? w.contacts[i].a : -1, b = -1;
      if constexpr (Contact::paired) b = e.b_moves ? w.contacts[i].b : -1;
      const bool swapped = a < 0 || (e.shared && !e.owns_a);
      if (swapped) std::swap(a, b);
      f(contact_unit{.priority = w.keys[i].hash(),
                     .id_a = w.keys[i].a,
                     .id_b = w.keys[i].b,
                     .a = a,
                     .b = b,
                     .first = static_cast<std::uint32_t>(i),
                     .swapped = swapped},
        e.shared);
    }
  }
  /// The colour of the unit whose first contact is `first`.
  void set_colour(std::uint32_t first, std::uint32_t colour) { waiting_.colour[first] = colour; }
  /// Called when all units have a colour below `colours`: from then on contacts are stored by
  /// colour. With `find_units`, place_of_unit() knows where.
  void arrange(std::uint32_t colours, bool find_units);
  /// Where the contacts of a unit are; units in the order of each_unit().
  struct unit_place {
    std::uint32_t part = 0, first = 0, count = 0;
  };
  [[nodiscard]] const unit_place& place_of_unit(std::size_t n) const { return places_[n]; }
  [[nodiscard]] Contact contact(std::uint32_t colour, std::uint32_t part, std::uint32_t i) const {
    return colours_[colour].parts[part].row[i];
  }
  [[nodiscard]] const contact_key& key(std::uint32_t colour, std::uint32_t part,
                                       std::uint32_t i) const {
    return colours_[colour].parts[part].keys[i];
  }
  /// Adds a contact between bodies of other ranks, with its impulse. It is solved, but neither
  /// counted nor stored. Returns its place.
  std::uint32_t add_foreign(const Contact& contact, const contact_key& key, std::uint32_t colour,
                            bool a_moves, bool b_moves) {
    part& p = colours_[colour].parts[foreign];
    p.row.add(contact, a_moves, b_moves);
    p.keys.push_back(key);
    return static_cast<std::uint32_t>(p.row.size() - 1);
  }
  /// Calls f(index) for the body of another rank of each shared contact; f returns the index that
  /// replaces it.
  template <class F>
  void renumber_shared(F&& f) requires(Contact::paired) {
    auto& w = waiting_;
    for (std::size_t i = 0; i < w.contacts.size(); ++i)
      if (w.ends[i].shared) {
        auto& other = w.ends[i].owns_a ? w.contacts[i].b : w.contacts[i].a;
        other = f(other);
      }
  }
  static constexpr std::uint32_t foreign = 2;  ///< the part of foreign contacts

  [[nodiscard]] std::size_t size() const { return count_ + waiting_.contacts.size(); }
  [[nodiscard]] std::size_t bytes() const {
    std::size_t sum = waiting_.bytes() + places_.capacity() * sizeof(unit_place);
    for (const all_parts& c : colours_)
      for (const part& p : c.parts) sum += p.bytes();
    return sum;
  }
  /// Calls f(contact, counts_here): a shared contact counts on the rank that owns its body a.
  template <class F>
  void each(F&& f) const {
    each_part([&](const part& p, bool shared) {
      for (std::size_t i = 0; i < p.row.size(); ++i) f(p.row[i], !shared || p.owns_a[i]);
    });
  }
  /// Calls f(contact, acts_on_a, acts_on_b): on which of its bodies it acts on this rank. Over all
  /// ranks each contact acts on each body once.
  template <class F>
  void each_acting(F&& f) const {
    each_part([&](const part& p, bool shared) {
      for (std::size_t i = 0; i < p.row.size(); ++i)
        f(p.row[i], !shared || p.owns_a[i], !shared || !p.owns_a[i]);
    });
  }

  /// Loads the impulses of the last step.
  void load_impulses(const contact_history& history);
  void store_impulses(contact_history& history) const;
  /// Calls f(contact), which may change it, for all contacts.
  template <class F>
  void edit_all(F&& f) {
    each_part([&](part& p, bool) {
      for (std::size_t i = 0; i < p.row.size(); ++i) p.row.edit(i, f);
    });
  }
  /// Calls f(contact, key) for all contacts but foreign ones, which edit_keyed() may change.
  template <class F>
  void each_keyed(F&& f) const {
    each_part([&](const part& p, bool) {
      for (std::size_t i = 0; i < p.keys.size(); ++i) f(p.row[i], p.keys[i]);
    });
  }
  template <class F>
  void edit_keyed(F&& f) {
    each_part([&](part& p, bool) {
      for (std::size_t i = 0; i < p.keys.size(); ++i)
        p.row.edit(i, [&](Contact& c) { f(c, p.keys[i]); });
    });
  }

  // For contact_access: own contacts are interior, shared ones at the boundary, by their colours.

  static const contact_calls<state>* calls() { return &calls_for<coloured_list>; }
  [[nodiscard]] std::size_t size(contact_part p) const {
    std::size_t sum = 0;
    for (std::size_t k = 0; k < used_; ++k) sum += colours_[k].parts[number(p)].row.size();
    return sum;
  }
  /// Calls f(a, b) for the bodies of each contact, in this order.
  template <class F>
  void each_ends(contact_part p, F&& f) const {
    for (std::size_t k = 0; k < used_; ++k) {
      const auto& row = colours_[k].parts[number(p)].row;
      for (std::size_t i = 0; i < row.size(); ++i)
        if constexpr (requires { row.bodies(i); }) {
          const auto [a, b] = row.bodies(i);
          f(a, b);
        } else {
          const Contact c = row[i];
          f(c.a, Contact::paired ? c.b : -1);
        }
    }
  }
  /// Calls f(row, place) for the contacts of these numbers, which ascend.
  template <class F>
  void each_numbered(contact_part p, std::span<const std::uint32_t> numbers, F&& f) const {
    std::size_t before = 0, n = 0;
    for (std::size_t k = 0; k < used_ && n < numbers.size(); ++k) {
      const auto& row = colours_[k].parts[number(p)].row;
      for (; n < numbers.size() && numbers[n] - before < row.size(); ++n)
        f(row, numbers[n] - before);
      before += row.size();
    }
  }
  [[nodiscard]] const contact_key& key(contact_part p, std::size_t i) const {
    const auto [of, k] = place(p, i);
    return of->keys[k];
  }
  [[nodiscard]] Contact contact(contact_part p, std::size_t i) const {
    const auto [of, k] = place(p, i);
    return of->row[k];
  }
  template <class F>
  void edit(contact_part p, std::size_t i, F&& f) {
    const auto [of, k] = place(p, i);
    const_cast<part*>(of)->row.edit(k, f);
  }

  /// Limits the restitution of impacts with friction of pairs that would add energy.
  void limit_rebounds(state& s);
  void prepare(const state& s);
  /// In the order of the colours, so that the impulses on each body have the same order on any
  /// ranks.
  void warm_start(state& s, std::uint32_t colour) const;
  void warm_start(state& s) const {
    for (std::uint32_t k = 0; k < used_; ++k) warm_start(s, k);
  }
  /// Sweeps over the contacts of one colour: either those that wait for velocities from other
  /// ranks, or the others.
  void sweep(state& s, std::uint32_t colour, bool waits);
  /// Adds the impulses that are held to the others.
  void end_impacts() {
    for (std::uint32_t k = 0; k < used_; ++k)
      for (part& p : colours_[k].parts) p.row.end_impacts();
  }
  void correct(state& s, std::uint32_t colour, bool waits);

 private:
  struct ends_of_contact {
    bool a_moves, b_moves, shared, owns_a;
    std::int32_t grounded = -1;  ///< the body that is solved with all that holds it

    [[nodiscard]] bool moves_one() const { return !shared && a_moves != b_moves; }
  };
  /// Contacts in the order in which they were found.
  struct waiting {
    plain_vector<Contact> contacts;
    plain_vector<contact_key> keys;
    plain_vector<history_place*> places;
    plain_vector<ends_of_contact> ends;
    plain_vector<std::uint32_t> colour;

    void add(const Contact& c, const contact_key& key, history_place* place,
             const ends_of_contact& e) {
      contacts.push_back(c), keys.push_back(key), places.push_back(place), ends.push_back(e);
      colour.push_back(0);
    }
    void clear() { contacts.clear(), keys.clear(), places.clear(), ends.clear(), colour.clear(); }
    [[nodiscard]] bool begins_unit(std::size_t i) const {
      return i == 0 || (!keys[i].same_pair(keys[i - 1]) &&
                        (ends[i].grounded < 0 || ends[i].grounded != ends[i - 1].grounded));
    }
    /// Contacts in another order: the i-th is the order[i]-th of now.
    void reorder(const plain_vector<std::uint32_t>& order) {
      waiting next;
      for (const std::uint32_t i : order) next.add(contacts[i], keys[i], places[i], ends[i]);
      *this = std::move(next);
    }
    [[nodiscard]] std::size_t bytes() const {
      return contacts.capacity() * (sizeof(Contact) + sizeof(contact_key) + sizeof(history_place*) +
                                    sizeof(ends_of_contact) + 4);
    }
  };
  struct part {
    typename row_of_colour<Contact>::type row;
    plain_vector<contact_key> keys;
    plain_vector<history_place*> places;
    plain_vector<char> owns_a;  ///< of shared contacts: whether body a is owned here, else b

    void clear() { row.clear(), keys.clear(), places.clear(), owns_a.clear(); }
    [[nodiscard]] std::size_t bytes() const {
      return row.bytes() + keys.capacity() * sizeof(contact_key) +
             places.capacity() * sizeof(history_place*) + owns_a.capacity();
    }
  };
  struct all_parts {
    part parts[3];  ///< own, shared, foreign
  };

  static constexpr std::size_t number(contact_part p) {
    return p == contact_part::interior ? 0 : p == contact_part::boundary ? 1 : foreign;
  }
  /// The part with a contact, and its number there.
  [[nodiscard]] plain_pair<const part*, std::size_t> place(contact_part p, std::size_t i) const {
    std::size_t k = 0;
    while (i >= colours_[k].parts[number(p)].row.size())
      i -= colours_[k++].parts[number(p)].row.size();
    return {&colours_[k].parts[number(p)], i};
  }

  /// Moves the contacts that are solved together next to each other, behind all others, in an order
  /// that depends on ids alone.
  void join_grounded() {
    if constexpr (swept_in_manifolds<Contact>) {
      auto& w = waiting_;
      grounded_contacts<Contact> grounded;
      const auto each_run = [&](auto&& f) {
        for (std::size_t first = 0, last = 0; first < w.contacts.size(); first = last) {
          while (last < w.contacts.size() && w.keys[last].same_pair(w.keys[first]) &&
                 w.contacts[last].same_manifold(w.contacts[first]))
            ++last;
          if (w.ends[first].moves_one()) f(first, last);
        }
      };
      const auto body_of = [&](std::size_t i) {
        return w.ends[i].a_moves ? w.contacts[i].a : w.contacts[i].b;
      };
      each_run(
          [&](std::size_t first, std::size_t last) { grounded.meet(body_of(first), first, last); });
      grounded.choose(w.contacts);
      if (grounded.size() == 0) return;
      std::size_t run = 0;
      each_run([&](std::size_t first, std::size_t last) {
        if (grounded.holds(run++))
          for (std::size_t i = first; i < last; ++i) w.ends[i].grounded = body_of(i);
      });
      plain_vector<std::uint32_t> order;
      for (std::uint32_t i = 0; i < w.contacts.size(); ++i) order.push_back(i);
      std::stable_sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
        const std::int32_t x = w.ends[i].grounded, y = w.ends[j].grounded;
        if (x != y) return x < y;
        const contact_key &k = w.keys[i], &l = w.keys[j];
        if (x < 0 || k.same_pair(l)) return false;
        return k.a != l.a ? value_of(k.a) < value_of(l.a) : value_of(k.b) < value_of(l.b);
      });
      w.reorder(order);
    }
  }
  template <class F>
  void each_part(F&& f) {
    for (std::size_t k = 0; k < used_; ++k)
      f(colours_[k].parts[0], false), f(colours_[k].parts[1], true);
  }
  template <class F>
  void each_part(F&& f) const {
    for (std::size_t k = 0; k < used_; ++k)
      f(colours_[k].parts[0], false), f(colours_[k].parts[1], true);
  }

  waiting waiting_;
  std::vector<all_parts> colours_;
  plain_vector<unit_place> places_;
  std::size_t used_ = 0, count_ = 0;
  bool pairs_alone_ = false;  ///< all contacts were added by add_pair()
  bool renewed_ = false, held_ = false;
};

template <class Contact>
coloured_list<Contact>::coloured_list() = default;
template <class Contact>
coloured_list<Contact>::~coloured_list() = default;

template <class Contact>
void coloured_list<Contact>::arrange(std::uint32_t colours, bool find_units) {
  if (colours_.size() < colours) colours_.resize(colours);
  used_ = colours;
  auto& w = waiting_;
  std::uint32_t colour = 0;
  places_.clear();
  for (std::size_t i = 0; i < w.contacts.size(); ++i) {
    const ends_of_contact& e = w.ends[i];
    const bool next = w.begins_unit(i);
    if (next) colour = w.colour[i];
    part& p = colours_[colour].parts[e.shared];
    if (find_units) {
      if (next) places_.push_back({e.shared, static_cast<std::uint32_t>(p.row.size()), 0});
      ++places_.back().count;
    }
    if constexpr (renewable<Contact>)
      pairs_alone_ ? p.row.add_pair(w.contacts[i], e.a_moves, e.b_moves)
                   : p.row.add(w.contacts[i], e.a_moves, e.b_moves);
    else
      p.row.add(w.contacts[i], e.a_moves, e.b_moves);
    p.keys.push_back(w.keys[i]);
    p.places.push_back(w.places[i]);
    if (e.shared) p.owns_a.push_back(e.owns_a);
  }
  count_ = w.contacts.size();
  w.clear();
}

template <class Contact>
template <class Colour>
void coloured_list<Contact>::rearrange(std::span<const std::uint32_t> before, Colour&& colour_of,
                                       std::uint32_t colours) {
  std::vector<all_parts> from(std::max<std::size_t>(colours_.size(), colours));
  std::swap(colours_, from);
  used_ = colours;
  renewed_ = false;
  plain_vector<std::size_t> next(from.size(), 0);
  for (std::size_t n = 0; n < before.size(); ++n) {
    const part& old = from[before[n]].parts[0];
    const std::size_t i = next[before[n]]++;
    part& p = colours_[colour_of(n)].parts[0];
    p.row.add(old.row[i], true, true);
    p.keys.push_back(old.keys[i]);
    p.places.push_back(old.places[i]);
  }
}

template <class Contact>
void coloured_list<Contact>::load_impulses(const contact_history& history) {
  if constexpr (renewable<Contact>)
    if (renewed_) return;  // they are loaded
  each_part([&](part& p, bool) { p.row.load_impulses(history, p.keys, p.places); });
}

template <class Contact>
void coloured_list<Contact>::store_impulses(contact_history& history) const {
  each_part([&](const part& p, bool) { detail::store_impulses(history, p.keys, p.places, p.row); });
}

template <class Contact>
void coloured_list<Contact>::limit_rebounds(state& s) {
  if constexpr (!is_joint<Contact> && Contact::rows == 3 && comes_in_manifolds<Contact>) {
    passive_rebound<Contact> impact;
    plain_vector<Contact> pair;
    each_part([&](part& p, bool) {
      for (std::size_t first = 0, last = 0; first < p.row.size(); first = last) {
        pair.clear();
        for (; last < p.row.size() && p.keys[last].same_pair(p.keys[first]); ++last)
          pair.push_back(p.row[last]);
        if (!impact.limit({pair.data(), pair.size()}, s)) continue;
        for (std::size_t i = first; i < last; ++i)
          p.row.edit(i, [&](Contact& c) { c.target_velocity = pair[i - first].target_velocity; });
      }
    });
  }
}

template <class Contact>
void coloured_list<Contact>::prepare(const state& s) {
  for (std::size_t k = 0; k < used_; ++k)
    for (part& p : colours_[k].parts) p.row.prepare(s);
}

template <class Contact>
void coloured_list<Contact>::warm_start(state& s, std::uint32_t colour) const {
  if (colour < used_)
    for (const std::uint32_t k : {0u, 1u}) colours_[colour].parts[k].row.apply(s);
}

template <class Contact>
void coloured_list<Contact>::sweep(state& s, std::uint32_t colour, bool waits) {
  if (colour >= used_) return;
  auto& parts = colours_[colour].parts;
  if (!waits) return parts[0].row.forward(s);
  parts[1].row.forward(s), parts[foreign].row.forward(s);
}

template <class Contact>
void coloured_list<Contact>::correct(state& s, std::uint32_t colour, bool waits) {
  if (colour >= used_) return;
  auto& parts = colours_[colour].parts;
  if (!waits) return parts[0].row.correct(s);
  parts[1].row.correct(s), parts[foreign].row.correct(s);
}

}  // namespace talus::detail
