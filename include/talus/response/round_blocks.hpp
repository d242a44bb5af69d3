#pragma once
// Interior contacts of round bodies in blocks of eight that share no body that can move, so that
// eight are solved at once.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/core/octet.hpp"
#include "talus/response/solver_state.hpp"

namespace talus::detail {

/// Finds for each contact the first block that has room and none of its bodies. Blocks are open
/// for a while only, so that they hold neighbours in the list, which are neighbours in space.
class block_planner {
 public:
  static constexpr int lanes = 8;

  void start(std::size_t bodies) {
    used_.assign(bodies, {});
    filled_.clear();
    first_ = 0;
    full_ = 0;
  }
  /// Slot (block * lanes + lane) for a contact of a and b, -1 where b cannot move; or -1 if all
  /// open blocks hold one of its bodies.
  [[nodiscard]] std::int64_t place(std::int32_t a, std::int32_t b) {
    std::uint64_t taken = full_ | near(a);
    if (b >= 0) taken |= near(b);
    const int at = std::countr_one(taken);
    if (at == open) return -1;
    const std::size_t block = first_ + static_cast<std::size_t>(at);
    if (block >= filled_.size()) filled_.resize(block + 1, 0);
    const int lane = filled_[block]++;
    mark(a, at);
    if (b >= 0) mark(b, at);
    if (lane + 1 == lanes) {
      full_ |= std::uint64_t{1} << at;
      const int done = std::countr_one(full_);
      first_ += static_cast<std::size_t>(done);
      full_ = done == open ? 0 : full_ >> done;
    }
    return static_cast<std::int64_t>(block) * lanes + lane;
  }
  [[nodiscard]] std::size_t blocks() const { return filled_.size(); }
  [[nodiscard]] int filled(std::size_t block) const { return filled_[block]; }

 private:
  static constexpr int open = 64;
  /// In which of the open blocks a body is, as it was when block `first` was the first of these.
  struct use {
    std::size_t first = 0;
    std::uint64_t blocks = 0;
  };

  [[nodiscard]] std::uint64_t near(std::int32_t body) const {
    const use& u = used_[static_cast<std::size_t>(body)];
    const std::size_t passed = first_ - u.first;
    const std::uint64_t in = passed < open ? u.blocks >> passed : 0;
    return in | in << 1;  // blocks that follow each other share no body, or one would wait
  }
  void mark(std::int32_t body, int at) {
    use& u = used_[static_cast<std::size_t>(body)];
    const std::size_t passed = first_ - u.first;
    u.blocks = (passed < open ? u.blocks >> passed : 0) | std::uint64_t{1} << at;
    u.first = first_;
  }

  std::vector<use> used_;
  std::vector<std::uint8_t> filled_;
  std::size_t first_ = 0;
  std::uint64_t full_ = 0;
};

template <bool Friction>
struct round_block_friction {
  octet tx, ty, tz, inverse_wt, arm_a, arm_b, friction;
};
template <>
struct round_block_friction<false> {};

/// Eight contacts. Lanes that are not filled repeat the bodies of the first and do nothing.
template <class Contact>
struct round_block : round_block_friction<(Contact::rows > 1)> {
  octet nx, ny, nz, inverse_wn, target, rn;
  std::int32_t a[8], b[8];
};
/// What the correction of overlaps needs besides.
struct round_block_push {
  octet push, least, pushed;
};

template <class Contact>
class round_blocks {
  static constexpr bool paired = Contact::paired;
  static constexpr bool friction = Contact::rows > 1;
  static constexpr int lanes = block_planner::lanes;
  using block = round_block<Contact>;

 public:
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.capacity() * sizeof(block) + pushes_.capacity() * sizeof(round_block_push) +
           (slots_.capacity() + rest_.capacity()) * sizeof(std::uint32_t);
  }

  /// Gives contacts their places.
  void arrange(const std::vector<Contact>& contacts, const solver_state& s) {
    plan_.start(s.bodies.size());
    slots_.resize(contacts.size());
    rest_.clear();
    const auto movable = [&](std::int32_t i) { return body(s, i).inverse_mass != 0; };
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const Contact& c = contacts[i];
      std::int32_t x = c.a, y = -1;
      if constexpr (paired) {
        if (movable(c.b)) y = c.b;
        if (!movable(c.a)) std::swap(x, y);
      }
      const std::int64_t slot = plan_.place(x, y);
      slots_[i] = static_cast<std::uint32_t>(slot);
      if (slot < 0) rest_.push_back(static_cast<std::uint32_t>(i));
    }
    blocks_.resize(plan_.blocks());
  }
  /// Takes up the contacts with their impulses.
  void load(const std::vector<Contact>& contacts) {
    for (std::size_t i = 0; i < contacts.size(); ++i)
      if (slots_[i] != nowhere) put(blocks_[slots_[i] / lanes], slots_[i] % lanes, contacts[i]);
    for (std::size_t k = 0; k < blocks_.size(); ++k) fill_up(blocks_[k], plan_.filled(k));
  }
  /// Gives the contacts the impulses that have been found.
  void collect(std::vector<Contact>& contacts) const {
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (slots_[i] == nowhere) continue;
      const block& x = blocks_[slots_[i] / lanes];
      const std::size_t l = slots_[i] % lanes;
      contacts[i].rn = x.rn[l];
      if constexpr (friction) contacts[i].rt = {x.tx[l], x.ty[l], x.tz[l]};
    }
  }
  /// The contacts that found no place.
  [[nodiscard]] const std::vector<std::uint32_t>& rest() const { return rest_; }

  void forward(solver_state& s) {
    for (block& x : blocks_) relax(x, s);
  }
  void backward(solver_state& s) {
    for (std::size_t k = blocks_.size(); k-- > 0;) relax(blocks_[k], s);
  }
  /// As backward; note(contact, change of velocity) for those that changed by more than `speed`.
  template <class Note>
  void backward_watched(solver_state& s, real speed, Note&& note) {
    number_.assign(blocks_.size() * lanes, nowhere);
    for (std::size_t i = 0; i < slots_.size(); ++i)
      if (slots_[i] != nowhere) number_[slots_[i]] = static_cast<std::uint32_t>(i);
    for (std::size_t k = blocks_.size(); k-- > 0;) {
      const octet change = relax(blocks_[k], s);
      const octet_mask over = change > eight(speed * speed);
      for (std::size_t l = lanes; l-- > 0;)
        if (over[l] && number_[k * lanes + l] != nowhere)
          note(number_[k * lanes + l], std::sqrt(change[l]));
    }
  }

  /// Before sweeps of the correction of overlaps; the contacts hold the impulses of the response.
  void start_push(const std::vector<Contact>& contacts) {
    const octet zero = eight(0);
    pushes_.assign(blocks_.size(), {zero, zero, zero});
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (slots_[i] == nowhere) continue;
      round_block_push& x = pushes_[slots_[i] / lanes];
      const std::size_t l = slots_[i] % lanes;
      x.push[l] = contacts[i].push;
      x.least[l] = contacts[i].least_push();
    }
  }
  void push(solver_state& s) {
    for (std::size_t k = 0; k < blocks_.size(); ++k) relax_push(blocks_[k], pushes_[k], s);
  }

 private:
  static constexpr std::uint32_t nowhere = std::uint32_t(-1);

  static const solver_body& body(const solver_state& s, std::int32_t i) {
    return s.bodies[static_cast<std::size_t>(i)];
  }
  static void put(block& x, std::size_t l, const Contact& c) {
    x.nx[l] = c.normal[0], x.ny[l] = c.normal[1], x.nz[l] = c.normal[2];
    x.inverse_wn[l] = c.inverse_wn;
    x.target[l] = c.target;
    x.rn[l] = c.rn;
    x.a[l] = c.a, x.b[l] = c.b;
    if constexpr (friction) {
      x.tx[l] = c.rt[0], x.ty[l] = c.rt[1], x.tz[l] = c.rt[2];
      x.inverse_wt[l] = c.inverse_wt;
      x.arm_a[l] = c.arm_a, x.arm_b[l] = c.arm_b;
      x.friction[l] = c.friction;
    }
  }
  static void fill_up(block& x, int filled) {
    Contact none;
    none.normal = {0, 0, 0};
    none.a = x.a[0], none.b = x.b[0];
    for (int l = filled; l < lanes; ++l) put(x, static_cast<std::size_t>(l), none);
  }

  // The same as round_contact::relax and apply. Returns the squares of the changes of velocity.
  static octet relax(block& x, solver_state& s) {
    const auto va = [&](int i) -> vec3& { return s.bodies[std::size_t(x.a[i])].v; };
    const auto wa = [&](int i) -> vec3& { return s.bodies[std::size_t(x.a[i])].w; };
    const auto vb = [&](int i) -> vec3& { return s.bodies[std::size_t(x.b[i])].v; };
    const auto wb = [&](int i) -> vec3& { return s.bodies[std::size_t(x.b[i])].w; };
    octet_rows v_a = gather(va), v_b;
    octet ux = v_a.x, uy = v_a.y, uz = v_a.z;
    if constexpr (paired) {
      v_b = gather(vb);
      ux -= v_b.x, uy -= v_b.y, uz -= v_b.z;
    }
    const octet nx = x.nx, ny = x.ny, nz = x.nz;
    const octet un = nx * ux + ny * uy + nz * uz;
    const octet rn = larger(x.rn - (un - x.target) * x.inverse_wn, eight(0));
    const octet dn = rn - x.rn;
    x.rn = rn;
    octet dx = dn * nx, dy = dn * ny, dz = dn * nz;
    octet square = dn * dn;
    if constexpr (friction) {
      octet_rows w_a = gather(wa), w_b;
      octet sx = x.arm_a * w_a.x, sy = x.arm_a * w_a.y, sz = x.arm_a * w_a.z;
      if constexpr (paired) {
        w_b = gather(wb);
        sx += x.arm_b * w_b.x, sy += x.arm_b * w_b.y, sz += x.arm_b * w_b.z;
      }
      octet tx = x.tx - x.inverse_wt * (ux - un * nx + (ny * sz - nz * sy));
      octet ty = x.ty - x.inverse_wt * (uy - un * ny + (nz * sx - nx * sz));
      octet tz = x.tz - x.inverse_wt * (uz - un * nz + (nx * sy - ny * sx));
      const octet limit = x.friction * rn;
      const octet length = square_root(tx * tx + ty * ty + tz * tz);
      const octet part = limit / larger(larger(length, limit), eight(Contact::tiny));
      tx *= part, ty *= part, tz *= part;
      const octet ex = tx - x.tx, ey = ty - x.ty, ez = tz - x.tz;
      x.tx = tx, x.ty = ty, x.tz = tz;
      square += ex * ex + ey * ey + ez * ez;
      dx += ex, dy += ey, dz += ez;
      const octet cx = ny * ez - nz * ey, cy = nz * ex - nx * ez, cz = nx * ey - ny * ex;
      const octet spin_a = x.arm_a * w_a.w;
      w_a.x -= spin_a * cx, w_a.y -= spin_a * cy, w_a.z -= spin_a * cz;
      scatter(w_a, wa);
      if constexpr (paired) {
        const octet spin_b = x.arm_b * w_b.w;
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

  // The same as round_contact::relax_push, push_a and push_b.
  static void relax_push(const block& x, round_block_push& p, solver_state& s) {
    const auto at_a = [&](int i) -> vec3& { return s.shift[std::size_t(x.a[i])].v; };
    const auto at_b = [&](int i) -> vec3& { return s.shift[std::size_t(x.b[i])].v; };
    octet_rows a = gather(at_a), b;
    octet rate = x.nx * a.x + x.ny * a.y + x.nz * a.z;
    if constexpr (paired) {
      b = gather(at_b);
      rate -= x.nx * b.x + x.ny * b.y + x.nz * b.z;
    }
    const octet next = larger(p.pushed - (rate - p.push) * x.inverse_wn, p.least);
    const octet d = next - p.pushed;
    p.pushed = next;
    const octet da = d * a.w;
    a.x += da * x.nx, a.y += da * x.ny, a.z += da * x.nz;
    scatter(a, at_a);
    if constexpr (paired) {
      const octet db = d * b.w;
      b.x -= db * x.nx, b.y -= db * x.ny, b.z -= db * x.nz;
      scatter(b, at_b);
    }
  }

  block_planner plan_;
  std::vector<block> blocks_;
  std::vector<round_block_push> pushes_;
  std::vector<std::uint32_t> slots_, rest_;  ///< of each contact; contacts without one
  std::vector<std::uint32_t> number_;        ///< the contact in a slot
};

}  // namespace talus::detail
