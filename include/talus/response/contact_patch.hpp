#pragma once
// The contacts of one pair of bodies with one normal, swept together: what the bodies do to each
// other is written once, in the frame of the contacts, and their velocities are read and written
// once.
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/response/solver_state.hpp"

namespace talus::detail {

// Without AVX-512 such a value is several registers, and compilers remark on how such arguments are
// passed; all functions here are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Two vectors of three, each with one number to spare: a velocity and an angular velocity.
using twist = real __attribute__((vector_size(8 * sizeof(real))));

/// A contact that can be solved in the frame of its patch; see general_contact.
template <class Contact>
concept swept_in_patches = requires {
  requires Contact::swept_in_patches;
};

/// Contacts [first, last) of a list. The motion of body a relative to b, at the centre of a and in
/// the frame of the contacts, is (V, W) with V = v_a - v_b - w_b x offset; where a contact presses
/// with r at arm from the centre of a, its velocity is V + W x arm, and (V, W) changes by
/// mobility (r, arm x r).
struct contact_patch {
  twist mobility[6];     ///< columns of the symmetric matrix
  mat3 frame;            ///< rows: normal, tangent, tangent
  vec3 offset{0, 0, 0};  ///< from the centre of b to that of a
  std::uint32_t first = 0, last = 0;
  std::int32_t a = 0, b = -1;
};

/// Changes the velocities of two bodies by an impulse on a, with its moment about the centre of a.
template <bool Paired>
void give_pair(solver_state& s, std::int32_t of_a, std::int32_t of_b, const vec3& offset,
               const vec3& impulse, const vec3& moment) {
  const auto i = static_cast<std::size_t>(of_a);
  solver_body& a = s.bodies[i];
  a.v += a.inverse_mass * impulse;
  a.w += s.tensor(i) * moment;
  if constexpr (Paired) {
    const auto j = static_cast<std::size_t>(of_b);
    solver_body& b = s.bodies[j];
    b.v -= b.inverse_mass * impulse;
    b.w -= s.tensor(j) * vec3(moment + offset.cross(impulse));
  }
}

/// The motion of a patch's bodies while its contacts are solved.
template <bool Paired>
class patch_motion {
 public:
  patch_motion(const contact_patch& p, const solver_state& s) : p_(p) {
    const solver_body& a = s.bodies[static_cast<std::size_t>(p.a)];
    vec3 v = a.v, w = a.w;
    if constexpr (Paired) {
      const solver_body& b = s.bodies[static_cast<std::size_t>(p.b)];
      v -= b.v + b.w.cross(p.offset);
      w -= b.w;
    }
    v = p.frame * v, w = p.frame * w;
    motion_ = twist{v[0], v[1], v[2], 0, w[0], w[1], w[2], 0};
  }
  [[nodiscard]] vec3 at(const vec3& arm) const {
    const real x = motion_[4], y = motion_[5], z = motion_[6];
    return {motion_[0] + (y * arm[2] - z * arm[1]), motion_[1] + (z * arm[0] - x * arm[2]),
            motion_[2] + (x * arm[1] - y * arm[0])};
  }
  void hit(const vec3& arm, const vec3& r) {
    const real x = arm[1] * r[2] - arm[2] * r[1], y = arm[2] * r[0] - arm[0] * r[2],
               z = arm[0] * r[1] - arm[1] * r[0];
    motion_ += (p_.mobility[0] * r[0] + p_.mobility[1] * r[1]) +
               (p_.mobility[2] * r[2] + p_.mobility[3] * x) +
               (p_.mobility[4] * y + p_.mobility[5] * z);
    total_ += twist{r[0], r[1], r[2], 0, x, y, z, 0};
  }
  /// Gives the bodies the impulses that acted.
  void apply(solver_state& s) const {
    give(p_, s, {total_[0], total_[1], total_[2]}, {total_[4], total_[5], total_[6]});
  }
  /// The impulse `r`, with the moment `m` about the centre of a, both in the frame of the patch.
  static void give(const contact_patch& p, solver_state& s, const vec3& r, const vec3& m) {
    give_pair<Paired>(s, p.a, p.b, p.offset, p.frame.transpose() * r, p.frame.transpose() * m);
  }

 private:
  const contact_patch& p_;
  twist motion_{}, total_{};
};

/// The same for the correction of overlaps, which presses along the normal alone: the rate of
/// approach at an arm needs three numbers of (V, W).
template <bool Paired>
class patch_shift {
 public:
  patch_shift(const contact_patch& p, const solver_state& s) : p_(p) {
    const auto a = static_cast<std::size_t>(p.a);
    vec3 v = s.shift[a].v, w = s.turn[a - s.first_tensor];
    if constexpr (Paired) {
      const auto b = static_cast<std::size_t>(p.b);
      const vec3& turn = s.turn[b - s.first_tensor];
      v -= s.shift[b].v + turn.cross(p.offset);
      w -= turn;
    }
    const mat3& f = p.frame;
    n_ = f(0, 0) * v[0] + f(0, 1) * v[1] + f(0, 2) * v[2];
    y_ = f(1, 0) * w[0] + f(1, 1) * w[1] + f(1, 2) * w[2];
    z_ = f(2, 0) * w[0] + f(2, 1) * w[1] + f(2, 2) * w[2];
  }
  [[nodiscard]] real at(const vec3& arm) const { return n_ + (y_ * arm[2] - z_ * arm[1]); }
  void push(const vec3& arm, real d) {
    const real y = d * arm[2], z = -d * arm[1];
    const twist &n = p_.mobility[0], &my = p_.mobility[4], &mz = p_.mobility[5];
    n_ += n[0] * d + my[0] * y + mz[0] * z;
    y_ += n[5] * d + my[5] * y + mz[5] * z;
    z_ += n[6] * d + my[6] * y + mz[6] * z;
    total_ += d, moment_y_ += y, moment_z_ += z;
  }
  void apply(solver_state& s) const {
    if (total_ == 0 && moment_y_ == 0 && moment_z_ == 0) return;
    const mat3& f = p_.frame;
    const vec3 impulse{total_ * f(0, 0), total_ * f(0, 1), total_ * f(0, 2)};
    const vec3 moment{moment_y_ * f(1, 0) + moment_z_ * f(2, 0),
                      moment_y_ * f(1, 1) + moment_z_ * f(2, 1),
                      moment_y_ * f(1, 2) + moment_z_ * f(2, 2)};
    const auto a = static_cast<std::size_t>(p_.a);
    s.shift[a].v += s.bodies[a].inverse_mass * impulse;
    s.turn[a - s.first_tensor] += s.tensor(a) * moment;
    if constexpr (Paired) {
      const auto b = static_cast<std::size_t>(p_.b);
      s.shift[b].v -= s.bodies[b].inverse_mass * impulse;
      s.turn[b - s.first_tensor] -= s.tensor(b) * vec3(moment + p_.offset.cross(impulse));
    }
  }

 private:
  const contact_patch& p_;
  real n_, y_, z_;
  real total_ = 0, moment_y_ = 0, moment_z_ = 0;
};

/// Fills in what the bodies of a patch do to each other.
template <bool Paired>
void weigh_patch(contact_patch& p, const solver_state& s) {
  const auto a = static_cast<std::size_t>(p.a);
  real inverse_mass = s.bodies[a].inverse_mass;
  mat3 turning = p.frame * s.tensor(a) * p.frame.transpose(), across = diagonal_matrix<real>(0),
       moving;
  if constexpr (Paired) {
    const auto b = static_cast<std::size_t>(p.b);
    inverse_mass += s.bodies[b].inverse_mass;
    const mat3 of_b = p.frame * s.tensor(b) * p.frame.transpose();
    const mat3 x = cross_matrix<vec3>(p.frame * p.offset);
    turning += of_b;
    across = of_b * x;  // what an impulse turns, seen from a
    moving = diagonal_matrix(inverse_mass) - x * across;
  } else {
    moving = diagonal_matrix(inverse_mass);
  }
  for (int k = 0; k < 3; ++k) {
    p.mobility[k] = twist{moving(0, k), moving(1, k), moving(2, k), 0,
                          across(0, k), across(1, k), across(2, k), 0};
    p.mobility[3 + k] = twist{across(k, 0),  across(k, 1),  across(k, 2),  0,
                              turning(0, k), turning(1, k), turning(2, k), 0};
  }
}

/// The patches of a list of contacts, in its order. Sweeps visit contacts in the order of the list,
/// as if each were solved by itself.
template <class Contact>
class contact_patches {
  static constexpr bool paired = Contact::paired;

 public:
  /// Finds the patches and weighs their contacts. `contacts` of one pair lie together.
  void weigh(plain_vector<Contact>& contacts, const solver_state& s) {
    patches_.clear();
    for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
      const Contact& c = contacts[first];
      while (last < contacts.size() && contacts[last].same_patch(c)) ++last;
      contact_patch& p = patches_.emplace_back();
      p.first = static_cast<std::uint32_t>(first), p.last = static_cast<std::uint32_t>(last);
      p.a = c.a, p.b = c.b;
      p.frame = c.frame;
      if constexpr (paired) p.offset = c.arm_b - c.arm_a;
      weigh_patch<paired>(p, s);
      for (std::size_t i = first; i < last; ++i) contacts[i].weigh(p);
    }
  }
  /// Gives the bodies all impulses of the contacts, which need not have been weighed.
  static void apply_all(const plain_vector<Contact>& contacts, solver_state& s) {
    for (std::size_t first = 0, i = 0; first < contacts.size(); first = i) {
      const Contact& c = contacts[first];
      vec3 impulse{0, 0, 0}, moment{0, 0, 0};
      for (; i < contacts.size() && contacts[i].same_patch(c); ++i) {
        const vec3 p = contacts[i].impulse();
        impulse += p, moment += contacts[i].arm_a.cross(p);
      }
      if (impulse == vec3(0, 0, 0) && moment == vec3(0, 0, 0)) continue;
      vec3 offset{0, 0, 0};
      if constexpr (paired) offset = c.arm_b - c.arm_a;
      give_pair<paired>(s, c.a, c.b, offset, impulse, moment);
    }
  }
  void sweep_forward(plain_vector<Contact>& contacts, solver_state& s) const {
    for (const contact_patch& p : patches_) {
      patch_motion<paired> motion(p, s);
      bool changed = false;
      for (std::size_t i = p.first; i < p.last; ++i) changed |= solve(contacts[i], motion);
      if (changed) motion.apply(s);
    }
  }
  /// note(index, change) for each contact that changes.
  template <class Note>
  void sweep_backward(plain_vector<Contact>& contacts, solver_state& s, Note&& note) const {
    for (std::size_t k = patches_.size(); k-- > 0;) {
      const contact_patch& p = patches_[k];
      patch_motion<paired> motion(p, s);
      bool changed = false;
      for (std::size_t i = p.last; i-- > p.first;) {
        const vec3 before = contacts[i].r;
        if (!solve(contacts[i], motion)) continue;
        changed = true;
        note(i, vec3(contacts[i].r - before));
      }
      if (changed) motion.apply(s);
    }
  }
  void sweep_push(plain_vector<Contact>& contacts, solver_state& s) const {
    for (const contact_patch& p : patches_) {
      patch_shift<paired> motion(p, s);
      for (std::size_t i = p.first; i < p.last; ++i) {
        Contact& c = contacts[i];
        const real d = c.push_at(motion.at(c.arm));
        if (d != 0) motion.push(c.arm, d);
      }
      motion.apply(s);
    }
  }

 private:
  static bool solve(Contact& c, patch_motion<paired>& motion) {
    const vec3 before = c.r;
    vec3 u = motion.at(c.arm);
    u[0] -= c.target;
    c.r = c.block.solve(before, u, c.friction);
    const vec3 d = c.r - before;
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) return false;  // as open contacts stay
    motion.hit(c.arm, d);
    return true;
  }

  plain_vector<contact_patch> patches_;
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
