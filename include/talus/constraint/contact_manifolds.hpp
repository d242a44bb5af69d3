#pragma once
// All manifolds of a list of contacts: eight at a time if they share no movable body, and one by
// one if they do.
#include <cstddef>
#include <cstdint>

#include "talus/constraint/contact_manifold.hpp"
#include "talus/constraint/manifold_block.hpp"
#include "talus/constraint/ordered_planner.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// The manifolds of a list of contacts. Sweeps visit contacts in the order of the list, as if each
/// were solved alone: of two that share a body the first is in an earlier block, because stacks
/// converge much faster if the impulses propagate along them. (Manifolds with more contacts than
/// fit a block come last.) The contacts hold the impulses; the prepared data are stored here.
template <class Contact, class Planner = ordered_planner>
class contact_manifolds {
  static constexpr bool paired = Contact::paired;
  static constexpr std::size_t most_layers = 4;  ///< contacts of a manifold in a block
  using work = patch_block_work<Contact>;
  using block = manifold_block<Contact>;
  using layer = patch_layer<Contact>;

 public:
  /// Finds the manifolds and prepares their contacts. `contacts` of one pair are adjacent, and stay
  /// in place until they are prepared again.
  void prepare(plain_vector<Contact>& contacts, const solver_state& s) {
    manifolds_.clear(), runs_.clear();
    plan_.clear();
    used_ = 0;
    const auto moves = [&](std::int32_t i) {
      return s.bodies[static_cast<std::size_t>(i)].inverse_mass != 0;
    };
    for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
      const Contact& c = contacts[first];
      while (last < contacts.size() && contacts[last].same_manifold(c)) ++last;
      if (last - first > most_layers) {
        prepare_overflow(contacts, first, last, s);
        continue;
      }
      const bool b_moves = paired && moves(c.b);
      const auto slot = static_cast<std::size_t>(moves(c.a) ? plan_.place(c.a, b_moves ? c.b : -1)
                                                            : plan_.place(c.b, -1));
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
    fill(contacts);
    for (std::size_t k = 0; k < used_; ++k)
      if (blocks_[k].filled > 0) work::prepare(blocks_[k], layers_of(blocks_[k]), s);
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
    const auto silent = [](auto&&...) {};
    for (std::size_t k = 0; k < used_; ++k)
      if (blocks_[k].filled > 0)
        work::template sweep<true, false>(blocks_[k], layers_of(blocks_[k]), s, silent);
    for (const contact_manifold& p : manifolds_) {
      manifold_motion<paired> motion(p, s);
      bool changed = false;
      for (std::size_t i = p.first; i < p.last; ++i) changed |= solve(contacts[i], motion);
      if (changed) motion.apply(s);
    }
  }
  void sweep_backward(plain_vector<Contact>& contacts, solver_state& s) {
    backward<false>(contacts, s, [](auto&&...) {});
  }
  /// note(index, change) with the change of velocity that each contact's own impulse causes.
  template <class Note>
  void sweep_watched(plain_vector<Contact>& contacts, solver_state& s, Note&& note) {
    backward<true>(contacts, s, note);
  }
  void sweep_correction(plain_vector<Contact>& contacts, solver_state& s) {
    for (std::size_t k = 0; k < used_; ++k)
      if (blocks_[k].filled > 0) work::correct(blocks_[k], layers_of(blocks_[k]), s);
    for (const contact_manifold& p : manifolds_) {
      patch_shift<paired> motion(p, s);
      for (std::size_t i = p.first; i < p.last; ++i) {
        Contact& c = contacts[i];
        const real d = c.correction_at(motion.at(c.arm));
        if (d != 0) motion.correct(c.arm, d);
      }
      motion.apply(s);
    }
  }
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.capacity() * sizeof(block) + layers_.capacity() * sizeof(layer) +
           manifolds_.capacity() * sizeof(contact_manifold) + runs_.capacity() * sizeof(run) +
           plan_.bytes();
  }

 private:
  static constexpr std::size_t lanes = Planner::lanes;
  struct run {
    std::uint32_t slot, first, last;
  };

  layer* layers_of(const block& b) { return layers_.data() + b.first; }

  void prepare_overflow(plain_vector<Contact>& contacts, std::size_t first, std::size_t last,
                        const solver_state& s) {
    const Contact& c = contacts[first];
    contact_manifold& p = manifolds_.emplace_back();
    p.first = static_cast<std::uint32_t>(first), p.last = static_cast<std::uint32_t>(last);
    p.a = c.a, p.b = c.b;
    p.frame = frame_around<real>(c.normal);
    if constexpr (paired) p.offset = c.arm_b - c.arm_a;
    prepare_manifold<paired>(p, s);
    for (std::size_t i = first; i < last; ++i) contacts[i].prepare(p);
  }
  /// Records in the blocks which contacts are theirs.
  void fill(plain_vector<Contact>& contacts) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < used_; ++k) {
      blocks_[k].first = static_cast<std::uint32_t>(count);
      count += blocks_[k].depth;
    }
    if (layers_.size() < count) layers_.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
      layers_[k].present = mask_of<eight>{};
      for (Contact*& c : layers_[k].at) c = &spare_;
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
        x.present[lane] = -1;
      }
    }
  }
  template <bool Watched, class Note>
  void backward(plain_vector<Contact>& contacts, solver_state& s, Note&& note) {
    for (std::size_t k = manifolds_.size(); k-- > 0;) {
      const contact_manifold& p = manifolds_[k];
      manifold_motion<paired> motion(p, s);
      bool changed = false;
      for (std::size_t i = p.last; i-- > p.first;) {
        const vec3 before = contacts[i].r;
        if (!solve(contacts[i], motion)) continue;
        changed = true;
        if constexpr (Watched) note(i, contacts[i].speed_of(contacts[i].r - before));
      }
      if (changed) motion.apply(s);
    }
    const auto note_contact = [&](const Contact* c, real change) {
      if (c != &spare_) note(static_cast<std::size_t>(c - contacts.data()), change);
    };
    for (std::size_t k = used_; k-- > 0;)
      if (blocks_[k].filled > 0)
        work::template sweep<false, Watched>(blocks_[k], layers_of(blocks_[k]), s, note_contact);
  }
  static bool solve(Contact& c, manifold_motion<paired>& motion) {
    const vec3 before = c.r;
    vec3 u = motion.at(c.arm);
    if constexpr (Contact::biased) u -= c.bias_in_frame;
    u[0] -= c.target_velocity;
    c.r = c.block.solve(before, u, c.friction);
    const vec3 d = c.r - before;
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) return false;  // for contacts that stay open
    motion.apply_impulse(c.arm, d);
    return true;
  }

  Planner plan_;
  plain_vector<block> blocks_;  ///< of which only the first are in use
  std::size_t used_ = 0;
  plain_vector<layer> layers_;  ///< of all blocks
  plain_vector<run> runs_;
  plain_vector<contact_manifold> manifolds_;  ///< with more contacts than fit a block
  Contact spare_;                             ///< for empty places; its impulse stays zero
};

}  // namespace talus::detail
