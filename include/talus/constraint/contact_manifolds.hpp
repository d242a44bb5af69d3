#pragma once
// All manifolds of a list of contacts: eight at a time, or one by one if they have many contacts;
// those of a body on several bodies that cannot move together.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/contact_manifold.hpp"
#include "talus/constraint/grounded_contacts.hpp"
#include "talus/constraint/manifold_block.hpp"
#include "talus/constraint/ordered_planner.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Blocks of manifolds, as many manifolds in each as a pack has lanes. The contacts hold the
/// impulses; the prepared data are stored here.
template <class Contact, class Pack>
class manifold_blocks {
  using work = manifold_work<Contact, Pack>;
  using block = manifold_block<Contact, Pack>;
  using layer = manifold_layer<Contact, Pack>;

 public:
  static constexpr std::size_t lanes = lanes_of<Pack>;

  void clear() { runs_.clear(), used_ = 0; }
  [[nodiscard]] std::size_t size() const { return used_; }
  /// Contacts [first, last) are a manifold, for that lane of all blocks.
  void add(std::size_t slot, std::size_t first, std::size_t last) {
    const auto at = slot / lanes;
    for (; used_ <= at; ++used_) {
      if (used_ == blocks_.size()) blocks_.emplace_back();
      blocks_[used_].depth = blocks_[used_].filled = 0;
    }
    block& b = blocks_[at];
    b.depth = std::max(b.depth, static_cast<std::uint32_t>(last - first));
    ++b.filled;
    runs_.push_back({static_cast<std::uint32_t>(slot), static_cast<std::uint32_t>(first),
                     static_cast<std::uint32_t>(last)});
  }
  /// `spare` is the contact of empty places.
  void prepare(plain_vector<Contact>& contacts, Contact& spare, const solver_state& s) {
    fill(contacts, spare);
    each([&](block& b) { work::prepare(b, layers_of(b), s); });
  }
  /// After tensors of inertia have changed.
  void prepare_again(const solver_state& s) {
    each([&](block& b) { work::prepare(b, layers_of(b), s); });
  }
  void sweep_forward(solver_state& s) {
    const auto silent = [](auto&&...) {};
    each([&](block& b) { work::template sweep<true, false>(b, layers_of(b), s, silent); });
  }
  template <bool Watched, class Note>
  void sweep_backward(solver_state& s, Note& note) {
    for (std::size_t k = used_; k-- > 0;)
      if (blocks_[k].filled > 0)
        work::template sweep<false, Watched>(blocks_[k], layers_of(blocks_[k]), s, note);
  }
  template <bool First>
  void correct(solver_state& s) {
    each([&](block& b) { work::template correct<First>(b, layers_of(b), s); });
  }
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.capacity() * sizeof(block) + layers_.capacity() * sizeof(layer) +
           runs_.capacity() * sizeof(run);
  }

 private:
  struct run {
    std::uint32_t slot, first, last;
  };

  template <class F>
  void each(F&& f) {
    for (std::size_t k = 0; k < used_; ++k)
      if (blocks_[k].filled > 0) f(blocks_[k]);
  }
  layer* layers_of(const block& b) { return layers_.data() + b.first; }
  /// Records in the blocks which contacts are theirs.
  void fill(plain_vector<Contact>& contacts, Contact& spare) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < used_; ++k) {
      blocks_[k].first = static_cast<std::uint32_t>(count);
      count += blocks_[k].depth;
    }
    if (layers_.size() < count) layers_.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
      layers_[k].present = mask_of<Pack>{};
      for (Contact*& c : layers_[k].at) c = &spare;
    }
    for (const run& r : runs_) {
      block& b = blocks_[r.slot / lanes];
      const std::size_t lane = r.slot % lanes;
      const Contact& c = contacts[r.first];
      for (std::size_t l = lane; l < (lane == 0 ? lanes : lane + 1); ++l)
        b.a[l] = c.a, b.b[l] = c.b;
      for (std::uint32_t i = r.first; i < r.last; ++i) {
        layer& x = layers_of(b)[i - r.first];
        x.at[lane] = &contacts[i];
        include_lane(x.present, lane);
      }
    }
  }

  plain_vector<block> blocks_;  ///< of which only the first are in use
  std::size_t used_ = 0;
  plain_vector<layer> layers_;  ///< of all blocks
  plain_vector<run> runs_;
};

/// The manifolds of a list of contacts. Sweeps visit contacts in the order of the list, as if each
/// were solved alone: of two that share a body the first is in an earlier block, because stacks
/// converge much faster if the impulses propagate along them. Bodies on many contacts with what
/// cannot move come first, and manifolds with more contacts than fit a block last.
template <class Contact, class Planner = ordered_planner>
class contact_manifolds {
  static constexpr bool paired = Contact::paired;
  static constexpr std::size_t most_layers = 4;  ///< contacts of a manifold in a block

 public:
  /// Finds the manifolds and prepares their contacts. `contacts` of one pair are adjacent, and stay
  /// in place until they are prepared again.
  void prepare(plain_vector<Contact>& contacts, const solver_state& s) {
    large_.clear(), blocks_.clear(), grounded_.clear(), runs_.clear();
    plan_.clear();
    impulses_change();
    const auto moves = [&](std::int32_t i) {
      return s.bodies[static_cast<std::size_t>(i)].inverse_mass != 0;
    };
    for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
      const Contact& c = contacts[first];
      while (last < contacts.size() && contacts[last].same_manifold(c)) ++last;
      const bool b_moves = paired && moves(c.b), a_moves = moves(c.a);
      runs_.push_back(
          {static_cast<std::uint32_t>(last), a_moves ? c.a : c.b, a_moves && b_moves ? c.b : -1});
      if (!a_moves || !b_moves) grounded_.meet(runs_.back().a, first, last);
    }
    grounded_.choose(contacts);
    std::size_t first = 0, met = 0;
    for (const run& r : runs_) {
      if (r.b >= 0 || !grounded_.holds(met++)) {
        if (r.last - first > most_layers)
          large_.add(large_.size(), first, r.last);
        else
          blocks_.add(static_cast<std::size_t>(plan_.place(r.a, r.b)), first, r.last);
      }
      first = r.last;
    }
    grounded_.prepare(contacts, s);
    blocks_.prepare(contacts, spare_, s);
    large_.prepare(contacts, spare_, s);
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
    grounded_.template sweep<true>(contacts, s);
    blocks_.sweep_forward(s), large_.sweep_forward(s);
  }
  void sweep_backward(plain_vector<Contact>& contacts, solver_state& s) {
    const auto silent = [](auto&&...) {};
    backward<false>(s, silent);
    grounded_.template sweep<false>(contacts, s);
  }
  /// note(index, change) with the change of velocity that each contact's own impulse causes.
  template <class Note>
  void sweep_watched(plain_vector<Contact>& contacts, solver_state& s, Note&& note) {
    const auto note_contact = [&](const Contact* c, real change) {
      if (c != &spare_) note(static_cast<std::size_t>(c - contacts.data()), change);
    };
    backward<true>(s, note_contact);
    grounded_.sweep_watched(contacts, s, note);
  }
  void sweep_correction(plain_vector<Contact>& contacts, solver_state& s) {
    grounded_.correct(contacts, s);
    if (corrects_)
      blocks_.template correct<false>(s), large_.template correct<false>(s);
    else
      blocks_.template correct<true>(s), large_.template correct<true>(s);
    corrects_ = true;
  }
  /// To be called with each change of the impulses from outside.
  void impulses_change() { corrects_ = false; }
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.bytes() + large_.bytes() + grounded_.bytes() + plan_.bytes() +
           runs_.capacity() * sizeof(run);
  }

 private:
  using eight = pack<real, 8>;
  static_assert(Planner::lanes == lanes_of<eight>);
  struct run {
    std::uint32_t last;  ///< the end of its contacts
    std::int32_t a, b;   ///< its movable bodies, the second -1 if there is one
  };

  template <bool Watched, class Note>
  void backward(solver_state& s, Note& note) {
    impulses_change();
    large_.template sweep_backward<Watched>(s, note);
    blocks_.template sweep_backward<Watched>(s, note);
  }

  Planner plan_;
  plain_vector<run> runs_;  ///< the manifolds in the order of the list
  grounded_contacts<Contact> grounded_;
  manifold_blocks<Contact, eight> blocks_;
  manifold_blocks<Contact, real> large_;  ///< with more contacts than fit a block, one by one
  bool corrects_ = false;                 ///< the last sweep was one of the position correction
  Contact spare_;                         ///< for empty places; its impulse stays zero
};

}  // namespace talus::detail
