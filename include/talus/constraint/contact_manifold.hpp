#pragma once
// The contacts of one pair of bodies with one normal, swept together: the coupling of the bodies is
// computed once, in the frame of the contacts, and their velocities are read and written once.
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "talus/constraint/frame_around.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"

namespace talus::detail {

// Without AVX-512 such a value takes several registers, and compilers warn about how such arguments
// are passed; all functions here are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// A velocity and an angular velocity, or an impulse and its moment, and two unused numbers.
using twist = pack<real, 8>;

/// A contact that can be solved in the frame of its manifold; see general_contact.
template <class Contact>
concept swept_in_manifolds = requires {
  requires Contact::swept_in_manifolds;
};

// Written out, because a sweep consists of them alone.
[[nodiscard]] [[gnu::always_inline]] inline vec3 seen_in(const mat3& f, const vec3& v) {
  return {f(0, 0) * v[0] + f(0, 1) * v[1] + f(0, 2) * v[2],
          f(1, 0) * v[0] + f(1, 1) * v[1] + f(1, 2) * v[2],
          f(2, 0) * v[0] + f(2, 1) * v[1] + f(2, 2) * v[2]};
}
[[nodiscard]] [[gnu::always_inline]] inline vec3 seen_from(const mat3& f, const vec3& v) {
  return {f(0, 0) * v[0] + f(1, 0) * v[1] + f(2, 0) * v[2],
          f(0, 1) * v[0] + f(1, 1) * v[1] + f(2, 1) * v[2],
          f(0, 2) * v[0] + f(1, 2) * v[1] + f(2, 2) * v[2]};
}
[[nodiscard]] [[gnu::always_inline]] inline vec3 crossed(const vec3& a, const vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Contacts [first, last) of a list. The motion of body a relative to b, at the centre of a and in
/// the frame of the contacts, is (V, W) with V = v_a - v_b - w_b x offset; for a contact with
/// impulse r at arm from the centre of a, its velocity is V + W x arm, and (V, W) changes by
/// mobility (r, arm x r).
struct contact_manifold {
  real columns[6][6];    ///< of the mobility, which is symmetric; first, for mobility()
  mat3 frame;            ///< rows: normal, tangent, tangent
  vec3 offset{0, 0, 0};  ///< from the centre of b to that of a
  std::uint32_t first = 0, last = 0;
  std::int32_t a = 0, b = -1;

  [[nodiscard]] [[gnu::always_inline]] twist mobility(int k) const {
    twist column;  // and two numbers of the next column or member
    std::memcpy(&column, reinterpret_cast<const char*>(this) + k * sizeof columns[0],
                sizeof column);
    return column;
  }
};

/// Changes the velocities of two bodies by an impulse on a, with its moment about the centre of a.
template <bool Paired, class State>
void give_pair(State& s, std::int32_t of_a, std::int32_t of_b, const vec3& offset,
               const vec3& impulse, const vec3& moment) {
  const auto i = static_cast<std::size_t>(of_a);
  using number = typename State::number;
  auto& a = s.bodies[i];
  a.v += in_scalar<number>(vec3(a.inverse_mass * impulse));
  a.w += in_scalar<number>(seen_in(s.tensor(i), moment));
  if constexpr (Paired) {
    const auto j = static_cast<std::size_t>(of_b);
    auto& b = s.bodies[j];
    b.v -= in_scalar<number>(vec3(b.inverse_mass * impulse));
    b.w -= in_scalar<number>(seen_in(s.tensor(j), moment + crossed(offset, impulse)));
  }
}

/// The motion of a manifold's bodies while its contacts are solved.
template <bool Paired>
class manifold_motion {
 public:
  template <class State>
  manifold_motion(const contact_manifold& p, const State& s) : p_(p) {
    const auto& a = s.bodies[static_cast<std::size_t>(p.a)];
    vec3 v = v_of(a), w = w_of(a);
    if constexpr (Paired) {
      const auto& b = s.bodies[static_cast<std::size_t>(p.b)];
      v -= v_of(b) + crossed(w_of(b), p.offset);
      w -= w_of(b);
    }
    v = seen_in(p.frame, v), w = seen_in(p.frame, w);
    motion_ = twist{v[0], v[1], v[2], w[0], w[1], w[2]};
  }
  [[nodiscard]] vec3 at(const vec3& arm) const {
    const real x = motion_[3], y = motion_[4], z = motion_[5];
    return {motion_[0] + (y * arm[2] - z * arm[1]), motion_[1] + (z * arm[0] - x * arm[2]),
            motion_[2] + (x * arm[1] - y * arm[0])};
  }
  void apply_impulse(const vec3& arm, const vec3& r) {
    const real x = arm[1] * r[2] - arm[2] * r[1], y = arm[2] * r[0] - arm[0] * r[2],
               z = arm[0] * r[1] - arm[1] * r[0];
    motion_ += (p_.mobility(0) * r[0] + p_.mobility(1) * r[1]) +
               (p_.mobility(2) * r[2] + p_.mobility(3) * x) +
               (p_.mobility(4) * y + p_.mobility(5) * z);
    total_ += twist{r[0], r[1], r[2], x, y, z};
  }
  /// Applies the accumulated impulses to the bodies.
  template <class State>
  void apply(State& s) const {
    give(p_, s, {total_[0], total_[1], total_[2]}, {total_[3], total_[4], total_[5]});
  }
  /// The impulse `r`, with the moment `m` about the centre of a, both in the frame of the manifold.
  template <class State>
  static void give(const contact_manifold& p, State& s, const vec3& r, const vec3& m) {
    give_pair<Paired>(s, p.a, p.b, p.offset, seen_from(p.frame, r), seen_from(p.frame, m));
  }

 private:
  const contact_manifold& p_;
  twist motion_{}, total_{};
};

/// The same for the position correction, which acts along the normal alone: the rate of approach at
/// an arm needs three numbers of (V, W).
template <bool Paired>
class patch_shift {
 public:
  template <class State>
  patch_shift(const contact_manifold& p, const State& s) : p_(p) {
    const auto a = static_cast<std::size_t>(p.a);
    vec3 v = in_scalar<real>(s.shift[a].v), w = s.turn[a - s.first_tensor].w;
    if constexpr (Paired) {
      const auto b = static_cast<std::size_t>(p.b);
      const vec3& turn = s.turn[b - s.first_tensor].w;
      v -= in_scalar<real>(s.shift[b].v) + crossed(turn, p.offset);
      w -= turn;
    }
    const mat3& f = p.frame;
    n_ = f(0, 0) * v[0] + f(0, 1) * v[1] + f(0, 2) * v[2];
    y_ = f(1, 0) * w[0] + f(1, 1) * w[1] + f(1, 2) * w[2];
    z_ = f(2, 0) * w[0] + f(2, 1) * w[1] + f(2, 2) * w[2];
  }
  [[nodiscard]] real at(const vec3& arm) const { return n_ + (y_ * arm[2] - z_ * arm[1]); }
  void correct(const vec3& arm, real d) {
    const real y = d * arm[2], z = -d * arm[1];
    const auto& m = p_.columns;
    n_ += m[0][0] * d + m[0][4] * y + m[0][5] * z;
    y_ += m[0][4] * d + m[4][4] * y + m[4][5] * z;
    z_ += m[0][5] * d + m[4][5] * y + m[5][5] * z;
    total_ += d, moment_y_ += y, moment_z_ += z;
  }
  template <class State>
  void apply(State& s) const {
    if (total_ == 0 && moment_y_ == 0 && moment_z_ == 0) return;
    using number = typename State::number;
    const mat3& f = p_.frame;
    const vec3 impulse{total_ * f(0, 0), total_ * f(0, 1), total_ * f(0, 2)};
    const vec3 moment{moment_y_ * f(1, 0) + moment_z_ * f(2, 0),
                      moment_y_ * f(1, 1) + moment_z_ * f(2, 1),
                      moment_y_ * f(1, 2) + moment_z_ * f(2, 2)};
    const auto a = static_cast<std::size_t>(p_.a);
    s.shift[a].v += in_scalar<number>(vec3(s.bodies[a].inverse_mass * impulse));
    s.turn[a - s.first_tensor].w += seen_in(s.tensor(a), moment);
    if constexpr (Paired) {
      const auto b = static_cast<std::size_t>(p_.b);
      s.shift[b].v -= in_scalar<number>(vec3(s.bodies[b].inverse_mass * impulse));
      s.turn[b - s.first_tensor].w -= seen_in(s.tensor(b), moment + crossed(p_.offset, impulse));
    }
  }

 private:
  const contact_manifold& p_;
  real n_, y_, z_;
  real total_ = 0, moment_y_ = 0, moment_z_ = 0;
};

/// The columns of f m f^T with a symmetric m.
struct turned_tensor {
  vec3 x, y, z;
  turned_tensor(const mat3& f, const mat3& m) {
    const auto row = [&](int i) { return vec3{f(i, 0), f(i, 1), f(i, 2)}; };
    x = seen_in(f, seen_in(m, row(0)));
    y = seen_in(f, seen_in(m, row(1)));
    z = seen_in(f, seen_in(m, row(2)));
  }
};

/// Computes the coupling of the bodies of a manifold.
template <bool Paired, class State>
void prepare_manifold(contact_manifold& p, const State& s) {
  const auto a = static_cast<std::size_t>(p.a);
  real mass = s.bodies[a].inverse_mass;
  turned_tensor turning(p.frame, s.tensor(a));
  const auto set = [&](int k, const vec3& v, const vec3& w) {
    for (int i = 0; i < 3; ++i) p.columns[k][i] = v[i], p.columns[k][3 + i] = w[i];
  };
  if constexpr (Paired) {
    const auto b = static_cast<std::size_t>(p.b);
    mass += s.bodies[b].inverse_mass;
    const turned_tensor of_b(p.frame, s.tensor(b));
    turning.x += of_b.x, turning.y += of_b.y, turning.z += of_b.z;
    const vec3 c = seen_in(p.frame, p.offset);
    // The rotation by an impulse, seen from a; and the motion of the centre of a by it.
    const vec3 x = c[2] * of_b.y - c[1] * of_b.z, y = c[0] * of_b.z - c[2] * of_b.x,
               z = c[1] * of_b.x - c[0] * of_b.y;
    const vec3 mx = crossed(c, x), my = crossed(c, y), mz = crossed(c, z);
    const vec3 e[3] = {{mass, 0, 0}, {0, mass, 0}, {0, 0, mass}};
    set(0, e[0] - mx, x), set(1, e[1] - my, y), set(2, e[2] - mz, z);
    set(3, {x[0], y[0], z[0]}, turning.x);
    set(4, {x[1], y[1], z[1]}, turning.y);
    set(5, {x[2], y[2], z[2]}, turning.z);
  } else {
    set(0, {mass, 0, 0}, {0, 0, 0}), set(1, {0, mass, 0}, {0, 0, 0});
    set(2, {0, 0, mass}, {0, 0, 0}), set(3, {0, 0, 0}, turning.x);
    set(4, {0, 0, 0}, turning.y), set(5, {0, 0, 0}, turning.z);
  }
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
