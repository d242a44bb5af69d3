#pragma once
// Interior contacts of isotropic bodies in blocks that share no movable body, so that the contacts
// of a block are solved at once: eight in double, sixteen in float.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/constraint/block_planner.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/constraint/stored_impulses.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

// All functions that take packs are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

template <bool Friction, class Wide>
struct round_block_friction {
  Wide tx, ty, tz, inverse_wt, arm_a, arm_b, friction;
};
template <class Wide>
struct round_block_friction<false, Wide> {};

template <bool Biased, class Wide>
struct round_block_bias {
  Wide bx, by, bz;
};
template <class Wide>
struct round_block_bias<false, Wide> {};

/// The contacts of a block. Empty lanes repeat the bodies of the first and have no effect, because
/// their normals are zero.
template <class Contact>
struct round_block : round_block_friction<(Contact::rows > 1), wide_pack<typename Contact::number>>,
                     round_block_bias<Contact::biased, wide_pack<typename Contact::number>> {
  static constexpr int lanes = lanes_of<wide_pack<typename Contact::number>>;

  wide_pack<typename Contact::number> nx, ny, nz, inverse_wn, target_velocity, rn;
  std::int32_t a[lanes], b[lanes];
};

/// Additional data for the position correction: separate, because the memory traffic limits the
/// speed of the sweeps.
template <class Wide>
struct round_block_push {
  Wide correction_rate, correction_impulse;
};

/// The container of these contacts; contact_row is that of others. `Planner` assigns contacts to
/// blocks.
template <class Contact,
          class Planner = block_planner<lanes_of<wide_pack<typename Contact::number>>>>
class isotropic_blocks {
  using number = typename Contact::number;
  using state = typename Contact::state;
  using wide = wide_pack<number>;
  using rows = pack_rows<wide>;
  using vector = vector3<number>;
  using push_of_block = round_block_push<wide>;
  static constexpr bool paired = Contact::paired;
  static constexpr bool friction = Contact::rows > 1;
  static constexpr int lanes = lanes_of<wide>;
  using block = round_block<Contact>;

 public:
  void clear() {
    plan_.clear();
    slots_.clear(), overflow_.clear();
    used_ = 0;
  }
  void add(const Contact& c, bool a_moves, bool b_moves) {
    const std::int64_t slot =
        a_moves ? plan_.place(c.a, paired && b_moves ? c.b : -1) : plan_.place(c.b, -1);
    if (slot < 0) {
      slots_.push_back(overflow | static_cast<std::uint32_t>(overflow_.size()));
      overflow_.push_back(c);
      return;
    }
    slots_.push_back(static_cast<std::uint32_t>(slot));
    const auto at = static_cast<std::size_t>(slot) / lanes;
    for (; used_ <= at; ++used_) {
      if (used_ == blocks_.size()) blocks_.emplace_back(), corrections_.emplace_back();
      make_empty(used_, c);
    }
    const std::size_t lane = static_cast<std::size_t>(slot) % lanes;
    if (lane == 0) make_empty(at, c);  // blocks do not begin in their order
    put(at, lane, c);
  }
  [[nodiscard]] std::size_t size() const { return slots_.size(); }
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.capacity() * sizeof(block) + corrections_.capacity() * sizeof(push_of_block) +
           overflow_.capacity() * sizeof(Contact) +
           (slots_.capacity() + number_.capacity()) * sizeof(std::uint32_t) + plan_.bytes();
  }
  [[nodiscard]] Contact operator[](std::size_t i) const {
    const std::uint32_t slot = slots_[i];
    return slot & overflow ? overflow_[slot & ~overflow] : get(slot / lanes, slot % lanes);
  }
  /// The same as (*this)[i].impulse().
  [[nodiscard]] vec3 impulse(std::size_t i) const {
    const std::uint32_t slot = slots_[i];
    if (slot & overflow) return overflow_[slot & ~overflow].impulse();
    const block& x = blocks_[slot / lanes];
    const std::size_t l = slot % lanes;
    vector p{x.rn[l] * x.nx[l], x.rn[l] * x.ny[l], x.rn[l] * x.nz[l]};
    if constexpr (friction) p += vector(x.tx[l], x.ty[l], x.tz[l]);
    return in_scalar<real>(p);
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
      const vec3* found = kept_pair(history, keys[i], places[i]).find(keys[i]);
      if (found == nullptr) continue;
      const std::uint32_t slot = slots_[i];
      if (slot & overflow) {
        overflow_[slot & ~overflow].load_impulse(*found);
        continue;
      }
      block& x = blocks_[slot / lanes];
      const std::size_t l = slot % lanes;
      const vector& kept = in_scalar<number>(*found);
      if constexpr (friction)
        x.tx[l] = kept[0], x.ty[l] = kept[1], x.tz[l] = kept[2];
      else
        x.rn[l] = kept.dot(vector(x.nx[l], x.ny[l], x.nz[l]));
    }
    for (block& x : used()) load_impulse(x);
  }
  void prepare(const state& s) {
    for (block& x : used()) prepare(x, s);
    for (Contact& c : overflow_) c.prepare(s, 1, 1);
  }
  void apply(state& s) const {
    for (const block& x : used()) apply(x, s);
    for (const Contact& c : overflow_) c.apply(s, c.impulse_in_frame());
  }
  void forward(state& s) {
    for (block& x : used()) relax(x, s);
    for (Contact& c : overflow_) c.apply(s, c.relax(s));
  }
  void backward(state& s) {
    for (std::size_t k = overflow_.size(); k-- > 0;) overflow_[k].apply(s, overflow_[k].relax(s));
    for (std::size_t k = used_; k-- > 0;) relax(blocks_[k], s);
  }
  template <class Note>
  void backward_watched(state& s, real speed, Note&& note) {
    const std::size_t places = used_ * lanes;
    number_.assign(places + overflow_.size(), 0);
    for (std::size_t i = 0; i < slots_.size(); ++i)
      number_[slots_[i] & overflow ? places + (slots_[i] & ~overflow) : slots_[i]] =
          static_cast<std::uint32_t>(i);
    for (std::size_t k = overflow_.size(); k-- > 0;) {
      const auto d = overflow_[k].relax(s);
      overflow_[k].apply(s, d);
      if (const real change = overflow_[k].speed_of(d); change > speed)
        note(number_[places + k], change);
    }
    for (std::size_t k = used_; k-- > 0;) {
      const wide change = relax(blocks_[k], s);
      for (std::size_t l = lanes; l-- > 0;)
        if (change[l] > speed * speed) note(number_[k * lanes + l], std::sqrt(change[l]));
    }
  }
  void correct(state& s) {
    for (std::size_t k = 0; k < used_; ++k) relax_correction(blocks_[k], corrections_[k], s);
    for (Contact& c : overflow_)
      if (const number d = c.relax_correction(s); d != 0) c.correct_a(s, d), c.correct_b(s, d);
  }

 private:
  static constexpr std::uint32_t overflow =
      0x80000000u;  ///< of a slot: a contact outside the blocks

  [[nodiscard]] std::span<block> used() { return {blocks_.data(), used_}; }
  [[nodiscard]] std::span<const block> used() const { return {blocks_.data(), used_}; }

  void make_empty(std::size_t at, const Contact& first) {
    block& x = blocks_[at];
    x.nx = x.ny = x.nz = x.inverse_wn = x.target_velocity = x.rn = every_lane<wide>(number(0));
    corrections_[at].correction_rate = corrections_[at].correction_impulse =
        every_lane<wide>(number(0));
    if constexpr (friction)
      x.tx = x.ty = x.tz = x.inverse_wt = x.arm_a = x.arm_b = x.friction =
          every_lane<wide>(number(0));
    if constexpr (Contact::biased) x.bx = x.by = x.bz = every_lane<wide>(number(0));
    std::fill_n(x.a, lanes, first.a);
    std::fill_n(x.b, lanes, first.b);
  }
  static void put_impulse(block& x, std::size_t l, const Contact& c) {
    x.rn[l] = c.rn;
    if constexpr (friction) x.tx[l] = c.rt[0], x.ty[l] = c.rt[1], x.tz[l] = c.rt[2];
  }
  void put(std::size_t at, std::size_t l, const Contact& c) {
    block& x = blocks_[at];
    x.nx[l] = c.normal[0], x.ny[l] = c.normal[1], x.nz[l] = c.normal[2];
    x.inverse_wn[l] = c.inverse_wn;
    x.target_velocity[l] = c.target_velocity;
    corrections_[at].correction_rate[l] = c.correction_rate,
    corrections_[at].correction_impulse[l] = c.correction_impulse;
    x.a[l] = c.a, x.b[l] = c.b;
    put_impulse(x, l, c);
    if constexpr (Contact::biased) {
      x.bx[l] = static_cast<number>(c.bias[0]);
      x.by[l] = static_cast<number>(c.bias[1]);
      x.bz[l] = static_cast<number>(c.bias[2]);
    }
    if constexpr (friction) {
      x.inverse_wt[l] = c.inverse_wt;
      x.arm_a[l] = c.arm_a, x.arm_b[l] = c.arm_b;
      x.friction[l] = c.friction;
    }
  }
  [[nodiscard]] Contact get(std::size_t at, std::size_t l) const {
    const block& x = blocks_[at];
    Contact c;
    c.normal = {x.nx[l], x.ny[l], x.nz[l]};
    c.inverse_wn = x.inverse_wn[l];
    c.target_velocity = x.target_velocity[l];
    c.correction_rate = corrections_[at].correction_rate[l],
    c.correction_impulse = corrections_[at].correction_impulse[l];
    c.a = x.a[l], c.b = x.b[l];
    c.rn = x.rn[l];
    if constexpr (Contact::biased) c.bias = vec3(x.bx[l], x.by[l], x.bz[l]);
    if constexpr (friction) {
      c.rt = {x.tx[l], x.ty[l], x.tz[l]};
      c.inverse_wt = x.inverse_wt[l];
      c.arm_a = x.arm_a[l], c.arm_b = x.arm_b[l];
      c.friction = x.friction[l];
    }
    return c;
  }

  // Velocities of a lane's bodies, each followed by its inverse mass or inertia.
  static auto v(state& s, const std::int32_t (&of)[lanes]) {
    return [&](int i) {
      auto& body = s.bodies[static_cast<std::size_t>(of[i])];
      return row_of(body, body.v);
    };
  }
  static auto w(state& s, const std::int32_t (&of)[lanes]) {
    return [&](int i) {
      auto& body = s.bodies[static_cast<std::size_t>(of[i])];
      return row_of(body, body.w);
    };
  }

  // The same as isotropic_contact::load_impulse; the impulse is stored in place of the tangential
  // one.
  static void load_impulse(block& x) {
    if constexpr (friction) {
      const wide n = x.nx * x.tx + x.ny * x.ty + x.nz * x.tz;
      x.rn = larger(n, every_lane<wide>(number(0)));
      x.tx -= n * x.nx, x.ty -= n * x.ny, x.tz -= n * x.nz;
      const wide limit = x.friction * x.rn;
      const wide length = square_root(x.tx * x.tx + x.ty * x.ty + x.tz * x.tz);
      const wide part = limit / larger(larger(length, limit), every_lane<wide>(Contact::tiny));
      x.tx *= part, x.ty *= part, x.tz *= part;
    } else {
      x.rn = larger(x.rn, every_lane<wide>(number(0)));
    }
  }
  // The same as isotropic_contact::prepare, with undivided masses.
  static void prepare(block& x, const state& s) {
    const auto body = [&](std::int32_t i) -> const solver_body_of<number>& {
      return s.bodies[static_cast<std::size_t>(i)];
    };
    wide wn, spin_a, spin_b;
    for (int l = 0; l < lanes; ++l) {
      wn[l] = body(x.a[l]).inverse_mass;
      spin_a[l] = body(x.a[l]).inverse_inertia;
      if constexpr (paired) {
        wn[l] += body(x.b[l]).inverse_mass;
        spin_b[l] = body(x.b[l]).inverse_inertia;
      }
    }
    x.inverse_wn = 1 / wn;
    if constexpr (friction) {
      wide wt = wn + x.arm_a * x.arm_a * spin_a;
      if constexpr (paired) wt += x.arm_b * x.arm_b * spin_b;
      x.inverse_wt = 1 / wt;
    }
  }
  // The same as isotropic_contact::apply of the full impulse.
  static void apply(const block& x, state& s) {
    wide dx = x.rn * x.nx, dy = x.rn * x.ny, dz = x.rn * x.nz;
    if constexpr (friction) {
      hit_spin(x, x.tx, x.ty, x.tz, s);
      dx += x.tx, dy += x.ty, dz += x.tz;
    }
    rows a = gather<wide>(v(s, x.a));
    a.x += a.w * dx, a.y += a.w * dy, a.z += a.w * dz;
    scatter(a, v(s, x.a));
    if constexpr (paired) {
      rows b = gather<wide>(v(s, x.b));
      b.x -= b.w * dx, b.y -= b.w * dy, b.z -= b.w * dz;
      scatter(b, v(s, x.b));
    }
  }
  static void hit_spin(const block& x, const wide& ex, const wide& ey, const wide& ez, state& s) {
    const wide cx = x.ny * ez - x.nz * ey, cy = x.nz * ex - x.nx * ez, cz = x.nx * ey - x.ny * ex;
    rows a = gather<wide>(w(s, x.a));
    const wide spin_a = x.arm_a * a.w;
    a.x -= spin_a * cx, a.y -= spin_a * cy, a.z -= spin_a * cz;
    scatter(a, w(s, x.a));
    if constexpr (paired) {
      rows b = gather<wide>(w(s, x.b));
      const wide spin_b = x.arm_b * b.w;
      b.x -= spin_b * cx, b.y -= spin_b * cy, b.z -= spin_b * cz;
      scatter(b, w(s, x.b));
    }
  }

  // The same as isotropic_contact::relax and apply. Returns the squares of the changes of velocity.
  static wide relax(block& x, state& s) {
    const auto va = v(s, x.a), vb = v(s, x.b);
    const auto wa = w(s, x.a), wb = w(s, x.b);
    rows v_a = gather<wide>(va), v_b;
    wide ux = v_a.x, uy = v_a.y, uz = v_a.z;
    if constexpr (paired) {
      v_b = gather<wide>(vb);
      ux -= v_b.x, uy -= v_b.y, uz -= v_b.z;
    }
    if constexpr (Contact::biased) ux -= x.bx, uy -= x.by, uz -= x.bz;
    const wide nx = x.nx, ny = x.ny, nz = x.nz;
    const wide un = nx * ux + ny * uy + nz * uz;
    const wide rn =
        larger(x.rn - (un - x.target_velocity) * x.inverse_wn, every_lane<wide>(number(0)));
    const wide dn = rn - x.rn;
    x.rn = rn;
    wide dx = dn * nx, dy = dn * ny, dz = dn * nz;
    wide square = dn * dn;
    if constexpr (friction) {
      rows w_a = gather<wide>(wa), w_b;
      wide sx = x.arm_a * w_a.x, sy = x.arm_a * w_a.y, sz = x.arm_a * w_a.z;
      if constexpr (paired) {
        w_b = gather<wide>(wb);
        sx += x.arm_b * w_b.x, sy += x.arm_b * w_b.y, sz += x.arm_b * w_b.z;
      }
      wide tx = x.tx - x.inverse_wt * (ux - un * nx + (ny * sz - nz * sy));
      wide ty = x.ty - x.inverse_wt * (uy - un * ny + (nz * sx - nx * sz));
      wide tz = x.tz - x.inverse_wt * (uz - un * nz + (nx * sy - ny * sx));
      const wide limit = x.friction * rn;
      const wide length = square_root(tx * tx + ty * ty + tz * tz);
      const wide part = limit / larger(larger(length, limit), every_lane<wide>(Contact::tiny));
      tx *= part, ty *= part, tz *= part;
      const wide ex = tx - x.tx, ey = ty - x.ty, ez = tz - x.tz;
      x.tx = tx, x.ty = ty, x.tz = tz;
      square += ex * ex + ey * ey + ez * ez;
      dx += ex, dy += ey, dz += ez;
      const wide cx = ny * ez - nz * ey, cy = nz * ex - nx * ez, cz = nx * ey - ny * ex;
      const wide spin_a = x.arm_a * w_a.w;
      w_a.x -= spin_a * cx, w_a.y -= spin_a * cy, w_a.z -= spin_a * cz;
      scatter(w_a, wa);
      if constexpr (paired) {
        const wide spin_b = x.arm_b * w_b.w;
        w_b.x -= spin_b * cx, w_b.y -= spin_b * cy, w_b.z -= spin_b * cz;
        scatter(w_b, wb);
      }
    }
    v_a.x += v_a.w * dx, v_a.y += v_a.w * dy, v_a.z += v_a.w * dz;
    scatter(v_a, va);
    if constexpr (paired) {
      v_b.x -= v_b.w * dx, v_b.y -= v_b.w * dy, v_b.z -= v_b.w * dz;
      scatter(v_b, vb);
    }
    return square / (x.inverse_wn * x.inverse_wn);
  }

  // The same as isotropic_contact::relax_correction, correct_a and correct_b.
  static void relax_correction(const block& x, push_of_block& p, state& s) {
    const auto at_a = [&](int i) {
      auto& shift = s.shift[static_cast<std::size_t>(x.a[i])];
      return row_of(shift, shift.v);
    };
    const auto at_b = [&](int i) {
      auto& shift = s.shift[static_cast<std::size_t>(x.b[i])];
      return row_of(shift, shift.v);
    };
    rows a = gather<wide>(at_a), b;
    wide rate = x.nx * a.x + x.ny * a.y + x.nz * a.z;
    if constexpr (paired) {
      b = gather<wide>(at_b);
      rate -= x.nx * b.x + x.ny * b.y + x.nz * b.z;
    }
    const wide free = p.correction_impulse - (rate - p.correction_rate) * x.inverse_wn;
    const auto open = ((x.target_velocity == every_lane<wide>(number(0))) &
                       (x.rn > every_lane<wide>(number(0)))) |
                      (free > every_lane<wide>(number(0)));
    const wide next = open ? free : every_lane<wide>(number(0));
    const wide d = next - p.correction_impulse;
    p.correction_impulse = next;
    const wide da = d * a.w;
    a.x += da * x.nx, a.y += da * x.ny, a.z += da * x.nz;
    scatter(a, at_a);
    if constexpr (paired) {
      const wide db = d * b.w;
      b.x -= db * x.nx, b.y -= db * x.ny, b.z -= db * x.nz;
      scatter(b, at_b);
    }
  }

  Planner plan_;
  plain_vector<block> blocks_;               ///< of which only the first are in use
  plain_vector<push_of_block> corrections_;  ///< of each block
  std::size_t used_ = 0;
  plain_vector<std::uint32_t> slots_;   ///< of each contact: block * lanes + lane, or | overflow
  plain_vector<Contact> overflow_;      ///< contacts that found no slot
  plain_vector<std::uint32_t> number_;  ///< the contact in a slot
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
