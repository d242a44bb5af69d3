#pragma once
// Eight manifolds that share no movable body, solved side by side, with the formulas of
// contact_manifold, which solves one.
#include <bit>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/contact_manifold.hpp"
#include "talus/constraint/coulomb_block.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/core/pack_vector.hpp"

namespace talus::detail {

// All functions that take packs are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

using eight = pack<real, 8>;
using eight_vectors = pack_vector<eight>;
using eight_matrices = pack_matrix<eight>;

/// frame_around() of eight normals, to the bit.
[[nodiscard]] [[gnu::always_inline]] inline eight_matrices frames_around(const eight_vectors& n) {
  const eight sign = n.z < every_lane<eight>(0) ? every_lane<eight>(-1) : every_lane<eight>(1);
  const eight p = -1 / (sign + n.z), q = n.x * n.y * p;
  return {n, {1 + sign * n.x * n.x * p, sign * q, -sign * n.x}, {q, sign + n.y * n.y * p, -n.y}};
}

/// F T F^T, symmetric.
[[nodiscard]] [[gnu::always_inline]] inline eight_matrices turned_tensors(const eight_matrices& f,
                                                                          const eight_matrices& t) {
  const eight_vectors x = t.times(f.x), y = t.times(f.y), z = t.times(f.z);
  const eight xy = dot(f.x, y), xz = dot(f.x, z), yz = dot(f.y, z);
  return {{dot(f.x, x), xy, xz}, {xy, dot(f.y, y), yz}, {xz, yz, dot(f.z, z)}};
}

template <bool Biased>
struct patch_layer_bias {
  eight_vectors bias;  ///< in the frame of the manifold
};
template <>
struct patch_layer_bias<false> {};

/// One contact of each of eight manifolds.
template <class Contact>
struct patch_layer : patch_layer_bias<Contact::biased> {
  eight_vectors arm;  ///< from the centre of a, in the frame of the manifold
  eight friction;
  eight i_nn, i_n1, i_n2, i_11, i_12, i_22;  ///< as in coulomb_block
  eight nn, n1, n2, inverse_nn;
  eight correction_rate, correction_impulse;
  eight t11, t12, t22;
  mask_of<eight> present;
  Contact* at[8] = {};  ///< the impulse stays there; a spare one in lanes without a contact
};

template <class Contact>
struct manifold_block {
  eight_matrices frame;
  eight_vectors offset;  ///< from the centre of b to that of a
  eight_matrices tensor_a, tensor_b;
  eight_matrices vv, wv, ww;  ///< the mobility: velocity and spin, each row for one of them
  std::int32_t a[8], b[8];
  std::uint32_t first = 0, depth = 0;  ///< its layers
  std::uint32_t filled = 0;            ///< lanes, from the first; the others repeat its bodies
};

template <class Contact>
struct patch_block_work {
  static constexpr bool paired = Contact::paired;
  using block = manifold_block<Contact>;
  using layer = patch_layer<Contact>;

  static void prepare(block& p, layer* layers, const solver_state& s) {
    const auto& at = layers[0].at;
    const auto vector = [](const pack_rows<eight>& r) { return eight_vectors{r.x, r.y, r.z}; };
    p.frame =
        frames_around(vector(gather<eight>([&](int i) { return row_of(*at[i], at[i]->normal); })));
    eight mass;
    const auto tensors = [&](const std::int32_t(&of)[8], eight_matrices& t) {
      const auto number = [&](int i) {
        return s.tensors.data() + (static_cast<std::size_t>(of[i]) - s.first_tensor);
      };
      // Its nine numbers are xx yx zx xy yy zy xz yz zz.
      const auto from = [&](int first) {
        return gather<eight>(
            [&](int i) { return row_from<real>(*number(i), number(i)->data()[first]); });
      };
      const pack_rows<eight> low = from(1), high = from(5);
      for (int i = 0; i < 8; ++i) t.x.x[i] = (*number(i))(0, 0);
      t.x.y = t.y.x = low.x, t.x.z = t.z.x = low.y, t.y.y = low.w;
      t.y.z = t.z.y = high.x, t.z.z = high.w;
    };
    for (int i = 0; i < 8; ++i) mass[i] = s.bodies[static_cast<std::size_t>(p.a[i])].inverse_mass;
    tensors(p.a, p.tensor_a);
    p.ww = turned_tensors(p.frame, p.tensor_a);
    const eight zero = every_lane<eight>(0);
    if constexpr (paired) {
      for (int i = 0; i < 8; ++i)
        mass[i] += s.bodies[static_cast<std::size_t>(p.b[i])].inverse_mass;
      p.offset = vector(gather<eight>([&](int i) { return row_of(*at[i], at[i]->arm_b); })) -
                 vector(gather<eight>([&](int i) { return row_of(*at[i], at[i]->arm_a); }));
      tensors(p.b, p.tensor_b);
      const eight_matrices g = turned_tensors(p.frame, p.tensor_b);
      p.ww.x += g.x, p.ww.y += g.y, p.ww.z += g.z;
      const eight_vectors c = p.frame.times(p.offset);
      // The rotation by an impulse, seen from a; and the motion of the centre of a by it.
      p.wv = {c.z * g.y - c.y * g.z, c.x * g.z - c.z * g.x, c.y * g.x - c.x * g.y};
      const eight_vectors mx = crossed(c, p.wv.x), my = crossed(c, p.wv.y), mz = crossed(c, p.wv.z);
      p.vv = {{mass - mx.x, zero - mx.y, zero - mx.z},
              {zero - my.x, mass - my.y, zero - my.z},
              {zero - mz.x, zero - mz.y, mass - mz.z}};
    } else {
      p.vv.x.x = mass;
    }
    for (std::uint32_t k = 0; k < p.depth; ++k) prepare_layer(p, layers[k]);
  }

  /// Solves all contacts, in the order of the layers or the reverse. note(contact, change of the
  /// impulse's norm times own mobility) for those that change.
  template <bool Forward, bool Watched, class Note>
  static void sweep(const block& p, layer* layers, solver_state& s, Note&& note) {
    const auto v_of = [&](const std::int32_t(&of)[8]) {
      return [&](int i) {
        auto& body = s.bodies[static_cast<std::size_t>(of[i])];
        return row_of(body, body.v);
      };
    };
    const auto w_of = [&](const std::int32_t(&of)[8]) {
      return [&](int i) {
        auto& body = s.bodies[static_cast<std::size_t>(of[i])];
        return row_of(body, body.w);
      };
    };
    ends_of_pairs ends;
    auto [v, w] = ends.read(p, v_of, w_of);
    v = p.frame.times(v), w = p.frame.times(w);
    const eight zero = every_lane<eight>(0);
    eight_vectors impulse{zero, zero, zero}, moment{zero, zero, zero};
    for (std::uint32_t n = 0; n < p.depth; ++n) {
      layer& c = layers[Forward ? n : p.depth - 1 - n];
      const eight_vectors d = solve<Watched>(c, v + crossed(w, c.arm), note), m = crossed(c.arm, d);
      impulse += d, moment += m;
      if (n + 1 == p.depth) break;
      if constexpr (paired) {
        v += p.vv.times(d) + p.wv.times(m);
        w += p.wv.across(d) + p.ww.times(m);
      } else {
        v += p.vv.x.x * d;
        w += p.ww.times(m);
      }
    }
    const eight_vectors r = p.frame.across(impulse), m = p.frame.across(moment);
    ends.give(p, r, m, v_of, w_of);
  }

  /// The position correction, which acts along the normal alone.
  static void correct(const block& p, layer* layers, solver_state& s) {
    const auto v_of = [&](const std::int32_t(&of)[8]) {
      return [&](int i) {
        auto& shift = s.shift[static_cast<std::size_t>(of[i])];
        return row_of(shift, shift.v);
      };
    };
    const auto w_of = [&](const std::int32_t(&of)[8]) {
      return [&](int i) {
        auto& turn = s.turn[static_cast<std::size_t>(of[i]) - s.first_tensor];
        return row_of(turn, turn.w);
      };
    };
    ends_of_pairs ends;
    auto [v, w] = ends.read(p, v_of, w_of);
    const eight_matrices& f = p.frame;
    eight n = dot(f.x, v), y = dot(f.y, w), z = dot(f.z, w);
    const eight zero = every_lane<eight>(0);
    eight impulse = zero, moment_y = zero, moment_z = zero;
    for (std::uint32_t k = 0; k < p.depth; ++k) {
      layer& c = layers[k];
      const pack_rows<eight> held =
          gather<eight>([&](int i) { return row_of(*c.at[i], c.at[i]->r); });
      const eight rate = n + (y * c.arm.z - z * c.arm.y);
      const eight free = c.correction_impulse - (rate - c.correction_rate) * c.inverse_nn;
      const eight next =
          (((held.w == zero) & (held.x > zero)) | (free > zero)) & c.present ? free : zero;
      const eight d = next - c.correction_impulse;
      c.correction_impulse = next;
      const eight my = d * c.arm.z, mz = zero - d * c.arm.y;
      impulse += d, moment_y += my, moment_z += mz;
      if constexpr (paired) {
        n += p.vv.x.x * d + p.wv.x.y * my + p.wv.x.z * mz;
        y += p.wv.x.y * d + p.ww.y.y * my + p.ww.y.z * mz;
        z += p.wv.x.z * d + p.ww.y.z * my + p.ww.z.z * mz;
      } else {
        n += p.vv.x.x * d;
        y += p.ww.y.y * my + p.ww.y.z * mz;
        z += p.ww.y.z * my + p.ww.z.z * mz;
      }
    }
    const eight_vectors r = impulse * f.x, m = moment_y * f.y + moment_z * f.z;
    ends.give(p, r, m, v_of, w_of);
  }

 private:
  struct relative_motion {
    eight_vectors v, w;
  };
  /// Velocities of the bodies of a block, or displacements: v_of and w_of are their accessors.
  struct ends_of_pairs {
    pack_rows<eight> va, wa, vb, wb;

    /// Of a against b, at the centre of a.
    template <class V, class W>
    [[gnu::always_inline]] relative_motion read(const block& p, V& v_of, W& w_of) {
      va = gather<eight>(v_of(p.a)), wa = gather<eight>(w_of(p.a));
      const eight_vectors v{va.x, va.y, va.z}, w{wa.x, wa.y, wa.z};
      if constexpr (!paired) return {v, w};
      vb = gather<eight>(v_of(p.b)), wb = gather<eight>(w_of(p.b));
      const eight_vectors of_b{wb.x, wb.y, wb.z};
      return {v - (eight_vectors{vb.x, vb.y, vb.z} + crossed(of_b, p.offset)), w - of_b};
    }
    /// Changes them by an impulse on a and its moment about the centre of a, and stores them.
    template <class V, class W>
    [[gnu::always_inline]] void give(const block& p, const eight_vectors& r, const eight_vectors& m,
                                     V& v_of, W& w_of) {
      va.x += va.w * r.x, va.y += va.w * r.y, va.z += va.w * r.z;
      const eight_vectors ta = p.tensor_a.times(m);
      wa.x += ta.x, wa.y += ta.y, wa.z += ta.z;
      if constexpr (paired) {
        vb.x -= vb.w * r.x, vb.y -= vb.w * r.y, vb.z -= vb.w * r.z;
        const eight_vectors tb = p.tensor_b.times(m + crossed(p.offset, r));
        wb.x -= tb.x, wb.y -= tb.y, wb.z -= tb.z;
        scatter(vb, v_of(p.b)), scatter(wb, w_of(p.b));
      }
      scatter(va, v_of(p.a)), scatter(wa, w_of(p.a));
    }
  };
  /// The same as general_contact::prepare(contact_manifold).
  static void prepare_layer(const block& p, layer& c) {
    const eight zero = every_lane<eight>(0);
    const pack_rows<eight> arm =
        gather<eight>([&](int i) { return row_of(*c.at[i], c.at[i]->arm_a); });
    const eight_vectors r = c.arm = p.frame.times({arm.x, arm.y, arm.z});
    for (int i = 0; i < 8; ++i)
      c.friction[i] = c.at[i]->friction, c.correction_rate[i] = c.at[i]->correction_rate;
    c.correction_impulse = zero;
    if constexpr (Contact::biased) {
      const pack_rows<eight> bias =
          gather<eight>([&](int i) { return row_of(*c.at[i], c.at[i]->bias); });
      c.bias = p.frame.times({bias.x, bias.y, bias.z});
    }
    // The motion that each component of an impulse at the arm causes, and the velocity there.
    eight_vectors nw = r.z * p.ww.y - r.y * p.ww.z, xw = r.x * p.ww.z - r.z * p.ww.x,
                  yw = r.y * p.ww.x - r.x * p.ww.y;
    eight nn, n1, n2, t11, t12, t22;
    if constexpr (paired) {
      // Columns of the velocity that a moment causes.
      const eight_vectors c3{p.wv.x.x, p.wv.y.x, p.wv.z.x}, c4{p.wv.x.y, p.wv.y.y, p.wv.z.y},
          c5{p.wv.x.z, p.wv.y.z, p.wv.z.z};
      const eight_vectors n = p.vv.x + (r.z * c4 - r.y * c5), x = p.vv.y + (r.x * c5 - r.z * c3),
                          y = p.vv.z + (r.y * c3 - r.x * c4);
      nw += p.wv.x, xw += p.wv.y, yw += p.wv.z;
      nn = n.x, n1 = n.y, n2 = n.z, t11 = x.y, t12 = x.z, t22 = y.z;
    } else {
      nn = t11 = t22 = p.vv.x.x;
      n1 = n2 = t12 = zero;
    }
    nn += nw.y * r.z - nw.z * r.y, n1 += nw.z * r.x - nw.x * r.z, n2 += nw.x * r.y - nw.y * r.x;
    t11 += xw.z * r.x - xw.x * r.z, t12 += xw.x * r.y - xw.y * r.x;
    t22 += yw.x * r.y - yw.y * r.x;
    c.nn = nn, c.n1 = n1, c.n2 = n2, c.t11 = t11, c.t12 = t12, c.t22 = t22;
    const eight f = t11 * t22 - t12 * t12, g = n2 * t12 - n1 * t22, h = n1 * t12 - n2 * t11;
    const eight scale = 1 / (nn * f + n1 * g + n2 * h);
    c.i_nn = scale * f, c.i_n1 = scale * g, c.i_n2 = scale * h;
    c.i_11 = scale * (nn * t22 - n2 * n2);
    c.i_12 = scale * (n1 * n2 - nn * t12);
    c.i_22 = scale * (nn * t11 - n1 * n1);
    c.inverse_nn = 1 / nn;
  }
  /// The same as coulomb_block::solve, for the velocity u; returns the changes.
  template <bool Watched, class Note>
  [[gnu::always_inline]] static eight_vectors solve(layer& c, eight_vectors u, Note& note) {
    const auto impulse = [&](int i) { return row_of(*c.at[i], c.at[i]->r); };
    const eight zero = every_lane<eight>(0);
    pack_rows<eight> r = gather<eight>(impulse);  // and the target
    u.x -= r.w;
    if constexpr (Contact::biased) u.x -= c.bias.x, u.y -= c.bias.y, u.z -= c.bias.z;
    const eight n = r.x - (c.i_nn * u.x + c.i_n1 * u.y + c.i_n2 * u.z),
                x = r.y - (c.i_n1 * u.x + c.i_11 * u.y + c.i_12 * u.z),
                y = r.z - (c.i_n2 * u.x + c.i_12 * u.y + c.i_22 * u.z);
    const eight limit = c.friction * n;
    const mask_of<eight> sticks = (n >= zero) & (x * x + y * y <= limit * limit) & c.present;
    const eight un = u.x - (c.nn * r.x + c.n1 * r.y + c.n2 * r.z);
    const mask_of<eight> slides = ~sticks & ~(un >= zero) & c.present;
    eight_vectors next{sticks ? n : zero, sticks ? x : zero, sticks ? y : zero};
    for (unsigned left = bits_of(slides); left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      coulomb_block own;
      own.nn = c.nn[i], own.n1 = c.n1[i], own.n2 = c.n2[i];
      own.t11 = c.t11[i], own.t12 = c.t12[i], own.t22 = c.t22[i];
      own.inverse_nn = c.inverse_nn[i];
      const vec3 found =
          own.slide({r.x[i], r.y[i], r.z[i]}, {u.x[i], u.y[i], u.z[i]}, un[i], c.friction[i]);
      next.x[i] = found[0], next.y[i] = found[1], next.z[i] = found[2];
    }
    const eight_vectors d = next - eight_vectors{r.x, r.y, r.z};
    r.x = next.x, r.y = next.y, r.z = next.z;
    scatter(r, impulse);
    if constexpr (Watched) {
      const eight change = square_root(dot(d, d)) * c.nn;
      for (int i = 8; i-- > 0;) note(c.at[i], change[i]);
    }
    return d;
  }
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
