#pragma once
// All manifolds of a list of contacts: eight at a time, or one by one if they have many contacts;
// those of a body on what cannot move together if they are many.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "talus/constraint/contact_manifold.hpp"
#include "talus/constraint/grounded_contacts.hpp"
#include "talus/constraint/manifold_blocks.hpp"
#include "talus/constraint/ordered_planner.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// The manifolds of a list of contacts. Sweeps visit contacts in the order of the list, as if each
/// were solved alone: of two that share a body the first is in an earlier block, because stacks
/// converge much faster if the impulses propagate along them. Bodies on many contacts with what
/// cannot move come first, and manifolds with more contacts than fit a block last.
template <class Contact, class Planner = ordered_planner>
class contact_manifolds {
  static constexpr bool paired = Contact::paired;

 public:
  /// Whether sweeps over groups of islands are possible.
  static constexpr bool grouped = requires(Planner p) { p.begin_group(); };

  /// Finds the manifolds and prepares their contacts. `contacts` of one pair are adjacent, and stay
  /// in place until they are prepared again. The blocks of each group of islands are consecutive.
  void prepare(plain_vector<Contact>& contacts, const solver_state& s) {
    large_.clear(), blocks_.clear(), grounded_.clear();
    plan_.clear();
    groups_.clear();
    impulses_change();
    find_manifolds(contacts, s);
    const std::size_t groups = grouped ? s.groups.size() : 0;
    if (groups > 0) sort_by_group(s);
    for (const manifold& m : manifolds_)
      if (m.b < 0) grounded_.meet(m.a, m.first, m.last);
    grounded_.choose(contacts);
    std::size_t k = 0, met = 0;
    const auto add_until = [&](std::size_t end) {
      for (; k < end; ++k)
        if (const manifold& m = manifolds_[k]; m.b >= 0 || !grounded_.holds(met++)) add(m);
    };
    if constexpr (grouped)
      for (std::uint32_t g = 0; g < groups; ++g) {
        plan_.begin_group();
        add_until(ends_[g]);
        std::size_t grounded = g == 0 ? 0 : groups_.back().grounded;
        while (grounded < grounded_.size() && s.groups.of(grounded_.body(grounded)) == g)
          ++grounded;
        groups_.push_back({grounded, blocks_.size(), large_.size()});
      }
    add_until(manifolds_.size());
    grounded_.prepare(contacts, s);
    blocks_.prepare(contacts, spare_, s);
    large_.prepare(contacts, spare_, s);
  }
  /// Calls f(first, last) for each manifold: the contacts [first, last).
  template <class F>
  static void each_manifold(const plain_vector<Contact>& contacts, F&& f) {
    for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
      const Contact& c = contacts[first];
      while (last < contacts.size() && contacts[last].same_manifold(c)) ++last;
      f(first, last);
    }
  }
  /// Prepares the same contacts, after tensors of inertia or rates of the correction have changed.
  void prepare_again(plain_vector<Contact>& contacts, const solver_state& s) {
    impulses_change();
    grounded_.prepare(contacts, s);
    blocks_.prepare_again(s), large_.prepare_again(s);
  }
  /// Applies all impulses of the contacts, which need not be prepared, to the bodies.
  static void apply_all(const plain_vector<Contact>& contacts, solver_state& s) {
    for (std::size_t first = 0, i = 0; first < contacts.size(); first = i) {
      const Contact& c = contacts[first];
      const mat3 frame = c.axes();
      vec3 impulse{0, 0, 0}, moment{0, 0, 0};
      for (; i < contacts.size() && contacts[i].same_manifold(c); ++i) {
        const vec3 p = seen_from(frame, contacts[i].r);
        impulse += p, moment += crossed(contacts[i].arm_a, p);
      }
      if (impulse == vec3(0, 0, 0) && moment == vec3(0, 0, 0)) continue;
      vec3 offset{0, 0, 0};
      if constexpr (paired) offset = c.arm_b - c.arm_a;
      give_pair<paired>(s, c.a, c.b, offset, impulse, moment);
    }
  }
  void sweep_forward(plain_vector<Contact>& contacts, solver_state& s) {
    impulses_change();
    sweep_range<true>({}, end_of_all(), contacts, s);
  }
  /// A sweep over one of the groups of islands.
  void sweep_group(std::size_t group, bool forward, plain_vector<Contact>& contacts,
                   solver_state& s) requires grouped {
    impulses_change();
    const auto [from, to] = range(group);
    forward ? sweep_range<true>(from, to, contacts, s) : sweep_range<false>(from, to, contacts, s);
  }
  /// A sweep of the position correction over one of them, the `first` since the impulses changed.
  void correct_group(std::size_t group, bool first, plain_vector<Contact>& contacts,
                     solver_state& s) requires grouped {
    const auto [from, to] = range(group);
    first ? correct_range<true>(from, to, contacts, s)
          : correct_range<false>(from, to, contacts, s);
  }
  void sweep_backward(plain_vector<Contact>& contacts, solver_state& s) {
    impulses_change();
    sweep_range<false>({}, end_of_all(), contacts, s);
  }
  /// note(index, change) with the change of velocity that each contact's own impulse causes.
  template <class Note>
  void sweep_watched(plain_vector<Contact>& contacts, solver_state& s, Note&& note) {
    const auto note_contact = [&](const Contact* c, real change) {
      if (c != &spare_) note(static_cast<std::size_t>(c - contacts.data()), change);
    };
    impulses_change();
    large_.template sweep_backward<true>(0, large_.size(), s, note_contact);
    blocks_.template sweep_backward<true>(0, blocks_.size(), s, note_contact);
    grounded_.sweep_watched(contacts, s, note);
  }
  void sweep_correction(plain_vector<Contact>& contacts, solver_state& s) {
    corrects_ ? correct_range<false>({}, end_of_all(), contacts, s)
              : correct_range<true>({}, end_of_all(), contacts, s);
    corrects_ = true;
  }
  /// To be called with each change of the impulses from outside.
  void impulses_change() { corrects_ = false; }
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.bytes() + large_.bytes() + grounded_.bytes() + plan_.bytes() +
           groups_.capacity() * sizeof(end) +
           (manifolds_.capacity() + sorted_.capacity()) * sizeof(manifold) +
           ends_.capacity() * sizeof(std::size_t);
  }

 private:
  using eight = pack<real, 8>;
  static_assert(Planner::lanes == lanes_of<eight>);
  struct manifold {
    std::uint32_t first, last;  ///< its contacts
    std::int32_t a, b;          ///< its movable bodies, the second -1 if there is one
  };
  /// The end of a group among the bodies that are solved together, and the blocks of either kind.
  struct end {
    std::size_t grounded = 0, blocks = 0, large = 0;
  };

  [[nodiscard]] end end_of_all() const { return {grounded_.size(), blocks_.size(), large_.size()}; }
  [[nodiscard]] std::pair<end, end> range(std::size_t group) const {
    return {group == 0 ? end{} : groups_[group - 1], groups_[group]};
  }
  void find_manifolds(const plain_vector<Contact>& contacts, const solver_state& s) {
    const auto moves = [&](std::int32_t i) {
      return s.bodies[static_cast<std::size_t>(i)].inverse_mass != 0;
    };
    manifolds_.clear();
    each_manifold(contacts, [&](std::size_t first, std::size_t last) {
      const Contact& c = contacts[first];
      const bool b_moves = paired && moves(c.b), a_moves = moves(c.a);
      manifolds_.push_back({static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last),
                            a_moves ? c.a : c.b, a_moves && b_moves ? c.b : -1});
    });
  }
  /// Puts the manifolds in the order of their groups, of which ends_ are the ends.
  void sort_by_group(const solver_state& s) {
    ends_.assign(s.groups.size(), 0);
    for (const manifold& m : manifolds_) ++ends_[s.groups.of(m.a)];
    std::size_t begin = 0;
    for (std::size_t& next : ends_) begin += std::exchange(next, begin);
    sorted_.resize(manifolds_.size());
    for (const manifold& m : manifolds_) sorted_[ends_[s.groups.of(m.a)]++] = m;
    std::swap(manifolds_, sorted_);
  }
  void add(const manifold& m) {
    if (m.last - m.first > most_layers)
      large_.add(large_.size(), m.first, m.last);
    else
      blocks_.add(static_cast<std::size_t>(plan_.place(m.a, m.b)), m.first, m.last);
  }
  template <bool Forward>
  void sweep_range(const end& from, const end& to, plain_vector<Contact>& contacts,
                   solver_state& s) {
    if constexpr (Forward) {
      grounded_.template sweep<true>(from.grounded, to.grounded, contacts, s);
      blocks_.sweep_forward(from.blocks, to.blocks, s);
      large_.sweep_forward(from.large, to.large, s);
    } else {
      const auto silent = [](auto&&...) {};
      large_.template sweep_backward<false>(from.large, to.large, s, silent);
      blocks_.template sweep_backward<false>(from.blocks, to.blocks, s, silent);
      grounded_.template sweep<false>(from.grounded, to.grounded, contacts, s);
    }
  }
  template <bool First>
  void correct_range(const end& from, const end& to, plain_vector<Contact>& contacts,
                     solver_state& s) {
    grounded_.correct(from.grounded, to.grounded, contacts, s);
    blocks_.template correct<First>(from.blocks, to.blocks, s);
    large_.template correct<First>(from.large, to.large, s);
  }

  Planner plan_;
  grounded_contacts<Contact> grounded_;
  manifold_blocks<Contact, eight> blocks_;
  manifold_blocks<Contact, real> large_;  ///< with more contacts than fit a block, one by one
  plain_vector<end> groups_;              ///< empty without groups
  plain_vector<manifold> manifolds_, sorted_;
  plain_vector<std::size_t> ends_;  ///< of the groups in manifolds_
  bool corrects_ = false;           ///< the last sweep was one of the position correction
  Contact spare_;                   ///< for empty places; its impulse stays zero
};

}  // namespace talus::detail
