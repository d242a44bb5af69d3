#pragma once
// Interior contacts of isotropic bodies in blocks that share no movable body, so that the contacts
// of a block are solved at once: eight in double, sixteen in float.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/constraint/block_planner.hpp"
#include "talus/constraint/impact_terms.hpp"
#include "talus/constraint/isotropic_rows.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/constraint/stored_impulses.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

// All functions that take packs are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

template <bool Biased, class Wide>
struct isotropic_block_bias {
  pack_vector<Wide> bias;
};
template <class Wide>
struct isotropic_block_bias<false, Wide> {};

/// The contacts of a block. Empty lanes repeat the bodies of the first and have no effect, because
/// their normals are zero.
template <class Contact>
struct isotropic_block
    : isotropic_rows<wide_pack<typename Contact::number>, typename Contact::cone, Contact::paired>,
      isotropic_block_bias<Contact::biased, wide_pack<typename Contact::number>> {
  using wide = wide_pack<typename Contact::number>;
  using state = typename Contact::state;
  static constexpr int lanes = lanes_of<wide>;

  std::int32_t a[lanes] = {}, b[lanes] = {};

  /// With undivided masses.
  void prepare(const state& s) {
    wide mass[2], inertia[2];
    for (int l = 0; l < lanes; ++l) {
      const auto read = [&](int side, std::int32_t i) {
        const auto& body = s.bodies[static_cast<std::size_t>(i)];
        mass[side][l] = body.inverse_mass, inertia[side][l] = body.inverse_inertia;
      };
      read(0, a[l]);
      if constexpr (Contact::paired) read(1, b[l]);
    }
    const wide one = every_lane<wide>(1);
    this->set_effective_mass(one, mass[0], inertia[0], one, mass[1], inertia[1]);
  }
  /// Applies the impulses to the bodies.
  void apply(state& s) const {
    const auto r = this->impulse_in_frame();
    auto spins = spins_of_bodies(s);
    this->read(spins);
    this->turn(r, this->normal, this->distance_a(), this->distance_b(), spins);
    auto velocities = velocities_of_bodies(s);
    velocities.read();
    velocities.push(r.along(this->normal));
    velocities.write();
  }
  /// Solves the contacts and applies the changes. Returns the squares of the changes of velocity.
  wide relax(state& s) {
    auto velocities = velocities_of_bodies(s);
    auto spins = spins_of_bodies(s);
    velocities.read();
    pack_vector<wide> u = velocities.relative();
    if constexpr (Contact::biased) u -= this->bias;
    const auto d = this->solve(u, spins);
    this->turn(d, this->normal, this->distance_a(), this->distance_b(), spins);
    velocities.push(d.along(this->normal));
    velocities.write();
    return d.dot(d) / (this->inverse_wn * this->inverse_wn);
  }
  /// The normal velocities.
  [[nodiscard]] wide approach(state& s) const {
    auto velocities = velocities_of_bodies(s);
    velocities.read();
    return detail::dot(this->normal, velocities.relative());
  }
  void relax_correction(const wide& rate, wide& impulse, state& s) const {
    auto shifts = of_bodies([&s](std::int32_t i) {
      auto& shift = s.shift[static_cast<std::size_t>(i)];
      return row_of(shift, shift.v);
    });
    shifts.read();
    wide separation = detail::dot(this->normal, vectors_in(shifts.a));
    if constexpr (Contact::paired) separation -= detail::dot(this->normal, vectors_in(shifts.b));
    shifts.push(this->correct_at(separation, rate, impulse), this->normal);
    shifts.write();
  }

 private:
  template <class Row>
  [[nodiscard]] [[gnu::always_inline]] auto of_bodies(Row row) const {
    const auto at_a = [this, row](int i) { return row(a[i]); };
    const auto at_b = [this, row](int i) { return row(b[i]); };
    return ends_of_contact<wide, Contact::paired, decltype(at_a), decltype(at_b)>(at_a, at_b);
  }
  [[nodiscard]] [[gnu::always_inline]] auto velocities_of_bodies(state& s) const {
    return of_bodies([&s](std::int32_t i) {
      auto& body = s.bodies[static_cast<std::size_t>(i)];
      return row_of(body, body.v);
    });
  }
  [[nodiscard]] [[gnu::always_inline]] auto spins_of_bodies(state& s) const {
    return of_bodies([&s](std::int32_t i) {
      auto& body = s.bodies[static_cast<std::size_t>(i)];
      return row_of(body, body.w);
    });
  }
};

/// Additional data for the position correction: separate, because the memory traffic limits the
/// speed of the sweeps.
template <class Wide>
struct isotropic_correction {
  Wide rate, impulse;
};

/// Additional data of contacts that may rebound; see impact_terms.hpp.
template <class Wide, class Cone>
struct isotropic_impact {
  Wide restitution{}, limit{}, slowest{};
  isotropic_impulse<Wide, Cone> held;
};

/// New data of up to eight contacts between the same bodies as before, for
/// isotropic_blocks::renew().
struct renewed_contacts {
  using wide = wide_pack<real>;
  pack_vector<wide> normal, bias;  ///< the bias counts where contacts have one
  wide arm_a, arm_b, target_velocity, correction_rate, friction;
  wide restitution, limit, slowest;
  bool rebounds = false;  ///< whether these three are set
  bool slides = false;    ///< whether `friction` has changed
  static constexpr int lanes = lanes_of<wide>;
};

/// The container of these contacts; contact_row is that of others. `Planner` assigns contacts to
/// blocks.
template <class Contact,
          class Planner = block_planner<lanes_of<wide_pack<typename Contact::number>>>>
class isotropic_blocks {
  using number = typename Contact::number;
  using state = typename Contact::state;
  using wide = wide_pack<number>;
  using correction = isotropic_correction<wide>;
  using impact = isotropic_impact<wide, typename Contact::cone>;
  static constexpr bool paired = Contact::paired;
  static constexpr int lanes = lanes_of<wide>;
  using block = isotropic_block<Contact>;

 public:
  void clear() {
    plan_.clear();
    slots_.clear(), overflow_.clear();
    used_ = 0, numbered_ = false;
  }
  void add(const Contact& c, bool a_moves, bool b_moves) {
    const std::int64_t slot = next_slot(c, a_moves, b_moves);
    if (slot >= 0)
      put(static_cast<std::size_t>(slot) / lanes, static_cast<std::size_t>(slot) % lanes, c);
  }
  /// Adds a contact of which only the bodies and the friction are set; renew() sets the others.
  void add_pair(const Contact& c, bool a_moves, bool b_moves) {
    const std::int64_t slot = next_slot(c, a_moves, b_moves);
    if (slot < 0) return;
    const std::size_t l = static_cast<std::size_t>(slot) % lanes;
    block& x = blocks_[static_cast<std::size_t>(slot) / lanes];
    if constexpr (requires { x.friction; }) x.friction[l] = c.friction;
    x.a[l] = c.a, x.b[l] = c.b;
  }
  /// Sets new data of all contacts. renewed(a, b, count, data) computes the data of the contacts
  /// between the bodies a[k] and b[k]. It returns false if a pair has no contact any more. Then
  /// this function returns false, too, and the caller makes all contacts anew. With `loads` the
  /// impulses are those of the last step, projected into the present cones; else they are 0.
  template <class F>
  [[nodiscard]] bool renew(bool loads, F&& renewed) {
    const auto set_impulse = [loads](auto& x) __attribute__((always_inline)) {
      loads ? x.load_kept_impulses() : x.set({});
    };
    constexpr int part = renewed_contacts::lanes;
    renewed_contacts next;
    for (std::size_t at = 0; at < used_; ++at) {
      block& x = blocks_[at];
      const auto filled = static_cast<int>(plan_.filled(at));
      pack_vector<wide> normal{};
      wide arm_a{}, arm_b{};
      correction& c = corrections_[at];
      c = correction{}, x.target_velocity = wide{};
      if (!impacts_.empty()) impacts_[at] = impact{};
      for (int first = 0; first < filled; first += part) {
        const int count = std::min(filled - first, part);
        if (!renewed(x.a + first, x.b + first, count, next)) return false;
        const auto put = [&](wide& all, const renewed_contacts::wide& of_part) {
          put_part(all, first, of_part, count);
        };
        const auto put_vector = [&](auto& all, const auto& of_part) {
          put(all.x, of_part.x), put(all.y, of_part.y), put(all.z, of_part.z);
        };
        put_vector(normal, next.normal);
        if constexpr (Contact::biased) put_vector(x.bias, next.bias);
        put(arm_a, next.arm_a), put(arm_b, next.arm_b);
        put(x.target_velocity, next.target_velocity), put(c.rate, next.correction_rate);
        if (next.rebounds) {
          hold_impacts();
          put(impacts_[at].restitution, next.restitution), put(impacts_[at].limit, next.limit);
          put(impacts_[at].slowest, next.slowest);
        }
        if constexpr (requires { x.friction; })
          if (next.slides) put(x.friction, next.friction);
      }
      x.renew(normal, arm_a, arm_b);
      set_impulse(x);
    }
    for (std::size_t first = 0; first < overflow_.size(); first += part) {
      const auto count = static_cast<int>(std::min(overflow_.size() - first, std::size_t{part}));
      std::int32_t a[part], b[part];
      for (int l = 0; l < count; ++l)
        a[l] = overflow_[first + static_cast<std::size_t>(l)].a,
        b[l] = overflow_[first + static_cast<std::size_t>(l)].b;
      if (!renewed(a, b, count, next)) return false;
      for (int l = 0; l < count; ++l) {
        Contact& c = overflow_[first + static_cast<std::size_t>(l)];
        renew_single(c, next, static_cast<std::size_t>(l));
        set_impulse(c);
      }
    }
    return true;
  }
  [[nodiscard]] std::size_t size() const { return slots_.size(); }
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.capacity() * sizeof(block) + corrections_.capacity() * sizeof(correction) +
           impacts_.capacity() * sizeof(impact) + overflow_.capacity() * sizeof(Contact) +
           (slots_.capacity() + number_.capacity()) * sizeof(std::uint32_t) + plan_.bytes();
  }
  [[nodiscard]] Contact operator[](std::size_t i) const {
    const std::uint32_t slot = slots_[i];
    return slot & overflow ? overflow_[slot & ~overflow] : get(slot / lanes, slot % lanes);
  }
  /// The bodies of a contact, b = -1 if that is a global one: cheaper than all of it.
  [[nodiscard]] plain_pair<std::int32_t, std::int32_t> bodies(std::size_t i) const {
    const std::uint32_t slot = slots_[i];
    const bool single = (slot & overflow) != 0;
    const std::int32_t a =
        single ? overflow_[slot & ~overflow].a : blocks_[slot / lanes].a[slot % lanes];
    if constexpr (!paired) return {a, -1};
    return {a, single ? overflow_[slot & ~overflow].b : blocks_[slot / lanes].b[slot % lanes]};
  }
  [[nodiscard]] vec3 impulse(std::size_t i) const {
    const std::uint32_t slot = slots_[i];
    if (slot & overflow) return overflow_[slot & ~overflow].impulse();
    return in_scalar<real>(blocks_[slot / lanes].impulse_of(slot % lanes));
  }
  /// Calls f(i, impulse) for each contact i, block by block.
  template <class F>
  void each_impulse(F&& f) {
    find_numbers();
    for (std::size_t at = 0; at < used_; ++at) {
      const block& x = blocks_[at];
      const pack_vector<wide> p = x.impulse_in_frame().along(x.normal);
      const std::size_t filled = plan_.filled(at);
      for (std::size_t l = 0; l < filled; ++l)
        f(number_[at * lanes + l], in_scalar<real>(lane(p, l)));
    }
    for (std::size_t k = 0; k < overflow_.size(); ++k)
      f(number_[used_ * lanes + k], overflow_[k].impulse());
  }
  /// Calls f(a, b) for the bodies of contacts that have an impulse, in no particular order.
  template <class F>
  void each_loaded_pair(F&& f) const requires(paired) {
    for (const block& x : used()) {
      const pack_vector<wide> p = x.impulse_in_frame().along(x.normal);
      const wide zero{};
      const auto none = (p.x == zero) & (p.y == zero) & (p.z == zero);
      for (unsigned loaded = bits_of(inverted(none)); loaded != 0; loaded &= loaded - 1) {
        const auto l = static_cast<std::size_t>(std::countr_zero(loaded));
        if (in_scalar<real>(lane(p, l)).squaredNorm() > 0) f(x.a[l], x.b[l]);
      }
    }
    for (const Contact& c : overflow_)
      if (c.impulse().squaredNorm() > 0) f(c.a, c.b);
  }
  template <class F>
  void edit(std::size_t i, F&& f) {
    const std::uint32_t slot = slots_[i];
    if (slot & overflow) return f(overflow_[slot & ~overflow]);
    Contact c = get(slot / lanes, slot % lanes);
    f(c);
    put(slot / lanes, slot % lanes, c);
  }

  void load_impulses(const contact_history& history, const plain_vector<contact_key>& keys,
                     const plain_vector<history_place*>& places) {
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      const vec3* found = places[i] != nullptr ? history.at(*places[i], keys[i]) : nullptr;
      if (found == nullptr) found = kept_pair(history, keys[i], places[i]).find(keys[i]);
      if (found == nullptr) continue;
      const std::uint32_t slot = slots_[i];
      if (slot & overflow) {
        overflow_[slot & ~overflow].load_impulse(*found);
        continue;
      }
      blocks_[slot / lanes].keep_impulse(slot % lanes, in_scalar<number>(*found));
    }
    for (block& x : used()) x.load_kept_impulses();
  }
  void prepare(const state& s) {
    for (block& x : used()) x.prepare(s);
    for (Contact& c : overflow_) c.prepare(s, 1, 1);
  }
  void apply(state& s) const {
    for (const block& x : used()) x.apply(s);
    for (const Contact& c : overflow_) c.apply(s, c.impulse_in_frame());
  }
  /// Adds the impulses that are held to the others.
  void end_impacts() {
    for (std::size_t at = 0; at < used_ && !impacts_.empty(); ++at)
      blocks_[at].set(blocks_[at].impulse_in_frame() + impacts_[at].held);
    if constexpr (may_rebound<Contact>)
      for (Contact& c : overflow_) c.set(c.impulse_in_frame() + c.held);
  }
  void forward(state& s) {
    for (std::size_t k = 0; k < used_; ++k) meet_impacts(k, s), blocks_[k].relax(s);
    for (Contact& c : overflow_) detail::meet_impacts(c, s), c.apply(s, c.relax(s));
  }
  void backward(state& s) {
    for (std::size_t k = overflow_.size(); k-- > 0;)
      detail::meet_impacts(overflow_[k], s), overflow_[k].apply(s, overflow_[k].relax(s));
    for (std::size_t k = used_; k-- > 0;) meet_impacts(k, s), blocks_[k].relax(s);
  }
  template <class Note>
  void backward_watched(state& s, real speed, Note&& note) {
    const std::size_t places = used_ * lanes;
    find_numbers();
    for (std::size_t k = overflow_.size(); k-- > 0;) {
      detail::meet_impacts(overflow_[k], s);
      const auto d = overflow_[k].relax(s);
      overflow_[k].apply(s, d);
      if (const real change = overflow_[k].speed_of(d); change > speed)
        note(number_[places + k], change);
    }
    for (std::size_t k = used_; k-- > 0;) {
      meet_impacts(k, s);
      const wide change = blocks_[k].relax(s);
      for (std::size_t l = lanes; l-- > 0;)
        if (change[l] > speed * speed) note(number_[k * lanes + l], std::sqrt(change[l]));
    }
  }
  void correct(state& s) {
    for (std::size_t k = 0; k < used_; ++k)
      blocks_[k].relax_correction(corrections_[k].rate, corrections_[k].impulse, s);
    for (Contact& c : overflow_)
      if (const number d = c.relax_correction(s); d != 0) c.correct_a(s, d), c.correct_b(s, d);
  }

 private:
  static constexpr std::uint32_t overflow =
      0x80000000u;  ///< of a slot: a contact outside the blocks

  [[nodiscard]] std::span<block> used() { return {blocks_.data(), used_}; }
  [[nodiscard]] std::span<const block> used() const { return {blocks_.data(), used_}; }

  /// The stage of the sweep for the contacts of a block; see impact_terms.hpp.
  [[gnu::always_inline]] void meet_impacts(std::size_t at, state& s) {
    if constexpr (may_rebound<Contact>)
      if (s.stage != impact_stage::none && !impacts_.empty()) meet_impacts_of(at, s);
  }
  void meet_impacts_of(std::size_t at, state& s) {
    const impact& x = impacts_[at];
    const block& c = blocks_[at];
    auto meets = x.restitution > wide{};
    if (bits_of(meets) == 0) return;
    const wide least = x.slowest, approach = c.approach(s);
    if (s.stage == impact_stage::release)
      meets = meets & (x.limit < wide{}) & ((approach - least) * c.inverse_wn < c.rn);
    else
      meets = meets &
              (((approach < least) & (c.rn == wide{})) | inverted(c.target_velocity == x.limit));
    for (unsigned left = bits_of(meets); left != 0; left &= left - 1) {
      const auto l = static_cast<std::size_t>(std::countr_zero(left));
      Contact of_lane = get(at, l);
      detail::meet_impacts(of_lane, s);
      put(at, l, of_lane);
    }
  }

  /// Slot of a contact that is added, in a block that has begun; or -1 if it is added to the
  /// overflow.
  [[nodiscard]] [[gnu::always_inline]] inline std::int64_t next_slot(const Contact& c, bool a_moves,
                                                                     bool b_moves) {
    numbered_ = false;
    const std::int64_t slot =
        a_moves ? plan_.place(c.a, paired && b_moves ? c.b : -1) : plan_.place(c.b, -1);
    if (slot < 0) {
      slots_.push_back(overflow | static_cast<std::uint32_t>(overflow_.size()));
      overflow_.push_back(c);
      return slot;
    }
    slots_.push_back(static_cast<std::uint32_t>(slot));
    const auto at = static_cast<std::size_t>(slot) / lanes;
    for (; used_ <= at; ++used_) {
      if (used_ == blocks_.size()) {
        blocks_.emplace_back(), corrections_.emplace_back();
        if (!impacts_.empty()) impacts_.emplace_back(impact{});
      }
      make_empty(used_, c);
    }
    if (slot % lanes == 0) make_empty(at, c);  // blocks do not begin in their order
    return slot;
  }
  /// The first `count` numbers of a part of the lanes, from `first` on.
  [[gnu::always_inline]] static void put_part(wide& all, int first,
                                              const renewed_contacts::wide& of_part, int count) {
    using part = renewed_contacts::wide;
    if constexpr (std::is_same_v<wide, part>) {
      const part number{0, 1, 2, 3, 4, 5, 6, 7};
      all = choose(number < every_lane<part>(count), of_part, all);
    } else {
      for (int l = 0; l < count; ++l) all[first + l] = static_cast<number>(of_part[l]);
    }
  }
  static void renew_single(Contact& c, const renewed_contacts& next, std::size_t l) {
    const auto of_lane = [l](const auto& part) { return static_cast<number>(part[l]); };
    c.renew(in_scalar<number>(lane(next.normal, l)), of_lane(next.arm_a), of_lane(next.arm_b));
    if constexpr (Contact::biased) c.bias = lane(next.bias, l);
    c.target_velocity = of_lane(next.target_velocity);
    c.correction_rate = of_lane(next.correction_rate), c.correction_impulse = 0;
    if constexpr (may_rebound<Contact>) {
      if (next.rebounds) {
        c.restitution = of_lane(next.restitution), c.limit = of_lane(next.limit);
        c.slowest = of_lane(next.slowest);
      }
      c.held = {};
    }
    if constexpr (requires { c.friction; })
      if (next.slides) c.friction = of_lane(next.friction);
  }
  /// Finds the contact of each slot, once for all steps in which contacts keep their places.
  void find_numbers() {
    if (numbered_) return;
    const std::size_t places = used_ * lanes;
    number_.assign(places + overflow_.size(), 0);
    for (std::size_t i = 0; i < slots_.size(); ++i)
      number_[slots_[i] & overflow ? places + (slots_[i] & ~overflow) : slots_[i]] =
          static_cast<std::uint32_t>(i);
    numbered_ = true;
  }
  void make_empty(std::size_t at, const Contact& first) {
    const wide zero = every_lane<wide>(number(0));
    block& x = blocks_[at];
    x = block{};
    x.normal = {zero, zero, zero};
    corrections_[at] = {zero, zero};
    if (!impacts_.empty()) impacts_[at] = impact{};
    std::fill_n(x.a, lanes, first.a);
    std::fill_n(x.b, lanes, first.b);
  }
  [[gnu::always_inline]] void put(std::size_t at, std::size_t l, const Contact& c) {
    block& x = blocks_[at];
    x.put(l, c);
    x.a[l] = c.a, x.b[l] = c.b;
    if constexpr (Contact::biased) put_lane(x.bias, l, in_scalar<number>(c.bias));
    corrections_[at].rate[l] = c.correction_rate;
    corrections_[at].impulse[l] = c.correction_impulse;
    if constexpr (may_rebound<Contact>) {
      if (c.restitution > 0) hold_impacts();
      if (!impacts_.empty()) {
        impact& y = impacts_[at];
        y.restitution[l] = c.restitution, y.limit[l] = c.limit, y.slowest[l] = c.slowest;
        y.held.n[l] = c.held.n;
        if constexpr (requires { y.held.t; }) put_lane(y.held.t, l, c.held.t);
      }
    }
  }
  /// From the first contact with restitution on.
  void hold_impacts() {
    if (impacts_.empty()) impacts_.resize(blocks_.size(), impact{});
  }
  [[nodiscard]] Contact get(std::size_t at, std::size_t l) const {
    const block& x = blocks_[at];
    Contact c;
    x.get(l, c);
    c.a = x.a[l], c.b = x.b[l];
    if constexpr (Contact::biased) c.bias = in_scalar<real>(lane(x.bias, l));
    c.correction_rate = corrections_[at].rate[l];
    c.correction_impulse = corrections_[at].impulse[l];
    if constexpr (may_rebound<Contact>) {
      if (impacts_.empty()) return c;
      const impact& y = impacts_[at];
      c.restitution = y.restitution[l], c.limit = y.limit[l], c.slowest = y.slowest[l];
      c.held.n = y.held.n[l];
      if constexpr (requires { y.held.t; }) c.held.t = lane(y.held.t, l);
    }
    return c;
  }

  Planner plan_;
  plain_vector<block> blocks_;            ///< of which only the first are in use
  plain_vector<correction> corrections_;  ///< of each block
  plain_vector<impact> impacts_;          ///< likewise, or empty without restitution
  std::size_t used_ = 0;
  plain_vector<std::uint32_t> slots_;   ///< of each contact: block * lanes + lane, or | overflow
  plain_vector<Contact> overflow_;      ///< contacts that found no slot
  plain_vector<std::uint32_t> number_;  ///< the contact in a slot, or in the overflow after them
  bool numbered_ = false;               ///< these are known
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
