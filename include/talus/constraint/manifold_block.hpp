#pragma once
// Manifolds, the contacts of a pair of bodies with one normal, swept together: the coupling of the
// bodies is computed once, in the frame of the contacts, and their velocities are read and written
// once. One manifold, or as many as a pack has lanes, which share no movable body.
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

/// frame_around() of the normals, to the bit.
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline pack_matrix<Pack> frames_around(
    const pack_vector<Pack>& n) {
  const Pack sign = n.z < every_lane<Pack>(0) ? every_lane<Pack>(-1) : every_lane<Pack>(1);
  const Pack p = -1 / (sign + n.z), q = n.x * n.y * p;
  return {n, {1 + sign * n.x * n.x * p, sign * q, -sign * n.x}, {q, sign + n.y * n.y * p, -n.y}};
}

/// F T F^T.
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline pack_symmetric<Pack> turned_tensors(
    const pack_matrix<Pack>& f, const pack_symmetric<Pack>& t) {
  const pack_vector<Pack> x = t.times(f.x), y = t.times(f.y), z = t.times(f.z);
  return {dot(f.x, x), dot(f.x, y), dot(f.x, z), dot(f.y, y), dot(f.y, z), dot(f.z, z)};
}

template <bool Biased, class Pack>
struct manifold_layer_bias {
  pack_vector<Pack> bias;  ///< in the frame of the manifold
};
template <class Pack>
struct manifold_layer_bias<false, Pack> {};

/// Contacts of a manifold in a block of several; one with more is swept by itself.
inline constexpr std::uint32_t most_layers = 4;

/// One contact of each manifold.
template <class Contact, class Pack>
struct manifold_layer : manifold_layer_bias<Contact::biased, Pack> {
  pack_vector<Pack> arm;  ///< from the centre of a, in the frame of the manifold
  Pack friction;
  coulomb_blocks<Pack> own;  ///< the blocks of the contacts
  Pack correction_rate, correction_impulse;
  mask_of<Pack> present;
  mask_of<Pack> loaded;  ///< at rest and under load, for the position correction
  Contact* at[lanes_of<Pack>] =
      {};  ///< the impulse stays there; a spare one in lanes without a contact
};

/// The motion of body a relative to b, at the centre of a and in the frame of the contacts, is (V,
/// W) with V = v_a - v_b - w_b x offset. For a contact with impulse r at arm from the centre of a,
/// its velocity is V + W x arm, and (V, W) changes by the mobility times (r, arm x r).
template <class Contact, class Pack>
struct manifold_block {
  static constexpr int lanes = lanes_of<Pack>;

  pack_matrix<Pack> frame;   ///< rows: normal, tangent, tangent
  pack_vector<Pack> offset;  ///< from the centre of b to that of a
  pack_symmetric<Pack> tensor_a, tensor_b;
  pack_matrix<Pack> vv, wv;  ///< the mobility: velocity and spin, each row for one of them
  pack_symmetric<Pack> ww;
  std::int32_t a[lanes], b[lanes];
  std::uint32_t first = 0, depth = 0;  ///< its layers
  std::uint32_t filled = 0;            ///< lanes, from the first; the others repeat its bodies
};

/// What a solver does with a block.
template <class Contact, class Pack>
struct manifold_work {
  static constexpr bool paired = Contact::paired;
  static constexpr int lanes = lanes_of<Pack>;
  using block = manifold_block<Contact, Pack>;
  using layer = manifold_layer<Contact, Pack>;
  using bodies = std::int32_t[lanes];
  using vectors = pack_vector<Pack>;
  using matrices = pack_matrix<Pack>;
  using symmetric = pack_symmetric<Pack>;

  static void prepare(block& p, layer* layers, const solver_state& s) {
    const auto& at = layers[0].at;
    const auto vector = [](const pack_rows<Pack>& r) { return vectors{r.x, r.y, r.z}; };
    p.frame =
        frames_around(vector(gather<Pack>([&](int i) { return row_of(*at[i], at[i]->normal); })));
    Pack mass;
    const auto tensors = [&](const bodies& of, symmetric& t) {
      const auto number = [&](int i) {
        return s.tensors.data() + (static_cast<std::size_t>(of[i]) - s.first_tensor);
      };
      // Its nine numbers are xx yx zx xy yy zy xz yz zz.
      const auto from = [&](int first) {
        return gather<Pack>(
            [&](int i) { return row_from<real>(*number(i), number(i)->data()[first]); });
      };
      const pack_rows<Pack> low = from(1), high = from(5);
      for (int i = 0; i < lanes; ++i) put_lane(t.xx, i, (*number(i))(0, 0));
      t.xy = low.x, t.xz = low.y, t.yy = low.w, t.yz = high.x, t.zz = high.w;
    };
    const auto inverse_mass = [&](std::int32_t i) {
      return s.bodies[static_cast<std::size_t>(i)].inverse_mass;
    };
    for (int i = 0; i < lanes; ++i) put_lane(mass, i, inverse_mass(p.a[i]));
    tensors(p.a, p.tensor_a);
    p.ww = turned_tensors(p.frame, p.tensor_a);
    const Pack zero = every_lane<Pack>(0);
    if constexpr (paired) {
      for (int i = 0; i < lanes; ++i) put_lane(mass, i, lane(mass, i) + inverse_mass(p.b[i]));
      p.offset = vector(gather<Pack>([&](int i) { return row_of(*at[i], at[i]->arm_b); })) -
                 vector(gather<Pack>([&](int i) { return row_of(*at[i], at[i]->arm_a); }));
      tensors(p.b, p.tensor_b);
      const symmetric g = turned_tensors(p.frame, p.tensor_b);
      p.ww += g;
      const vectors c = p.frame.times(p.offset);
      // The rotation by an impulse, seen from a; and the motion of the centre of a by it.
      p.wv = {c.z * g.row_y() - c.y * g.row_z(), c.x * g.row_z() - c.z * g.row_x(),
              c.y * g.row_x() - c.x * g.row_y()};
      const vectors mx = crossed(c, p.wv.x), my = crossed(c, p.wv.y), mz = crossed(c, p.wv.z);
      p.vv = {{mass - mx.x, zero - mx.y, zero - mx.z},
              {zero - my.x, mass - my.y, zero - my.z},
              {zero - mz.x, zero - mz.y, mass - mz.z}};
    } else {
      p.vv.x.x = mass;
    }
    for (std::uint32_t k = 0; k < p.depth; ++k) prepare_layer(p, layers[k]);
  }

  /// Solves all contacts, in the order of the layers or the reverse. note(contact, change of the
  /// impulse's norm times own mobility) for those that change. A manifold of many contacts is swept
  /// there and back in a `Watched` sweep, which may be the only one of its step: single sweeps in
  /// one direction, warm started, amplify small errors, by which bodies at rest creep.
  template <bool Forward, bool Watched, class Note>
  static void sweep(const block& p, layer* layers, solver_state& s, Note&& note) {
    const auto v_of = [&](const bodies& of) {
      return [&](int i) {
        auto& body = s.bodies[static_cast<std::size_t>(of[i])];
        return row_of(body, body.v);
      };
    };
    const auto w_of = [&](const bodies& of) {
      return [&](int i) {
        auto& body = s.bodies[static_cast<std::size_t>(of[i])];
        return row_of(body, body.w);
      };
    };
    ends_of_pairs ends;
    auto [v, w] = ends.read(p, v_of, w_of);
    v = p.frame.times(v), w = p.frame.times(w);
    const Pack zero = every_lane<Pack>(0);
    vectors impulse{zero, zero, zero}, moment{zero, zero, zero};
    const bool both_ways = lanes == 1 && Watched && p.depth > most_layers;
    const std::uint32_t last = p.depth - 1, visits = both_ways ? 2 * last : last;
    for (std::uint32_t n = 0; n <= visits; ++n) {
      const std::uint32_t k = n <= last ? n : visits - n;
      layer& c = layers[Forward ? k : last - k];
      const vectors u = v + crossed(w, c.arm);
      const bool notes = Watched && (!both_ways || n >= last);
      const vectors d = notes ? solve<Watched>(c, u, note) : solve<false>(c, u, note);
      const vectors m = crossed(c.arm, d);
      impulse += d, moment += m;
      if (n == visits) break;
      if constexpr (paired) {
        v += p.vv.times(d) + p.wv.times(m);
        w += p.wv.across(d) + p.ww.times(m);
      } else {
        v += p.vv.x.x * d;
        w += p.ww.times(m);
      }
    }
    const vectors r = p.frame.across(impulse), m = p.frame.across(moment);
    ends.give(p, r, m, v_of, w_of);
  }

  /// The position correction, which acts along the normal alone. The `First` sweep after the
  /// impulses have changed reads which contacts are under load.
  template <bool First>
  static void correct(const block& p, layer* layers, solver_state& s) {
    const auto v_of = [&](const bodies& of) {
      return [&](int i) {
        auto& shift = s.shift[static_cast<std::size_t>(of[i])];
        return row_of(shift, shift.v);
      };
    };
    const auto w_of = [&](const bodies& of) {
      return [&](int i) {
        auto& turn = s.turn[static_cast<std::size_t>(of[i]) - s.first_tensor];
        return row_of(turn, turn.w);
      };
    };
    ends_of_pairs ends;
    auto [v, w] = ends.read(p, v_of, w_of);
    const matrices& f = p.frame;
    Pack n = dot(f.x, v), y = dot(f.y, w), z = dot(f.z, w);
    const Pack zero = every_lane<Pack>(0);
    Pack impulse = zero, moment_y = zero, moment_z = zero;
    for (std::uint32_t k = 0; k < p.depth; ++k) {
      layer& c = layers[k];
      if constexpr (First) {
        const pack_rows<Pack> held =
            gather<Pack>([&](int i) { return row_of(*c.at[i], c.at[i]->r); });
        c.loaded = both<mask_of<Pack>>(held.w == zero, held.x > zero);
      }
      const Pack rate = n + (y * c.arm.z - z * c.arm.y);
      const Pack free = c.correction_impulse - (rate - c.correction_rate) * c.own.inverse_nn;
      const mask_of<Pack> kept = c.loaded | (free > zero);
      const Pack next = both(kept, c.present) ? free : zero;
      const Pack d = next - c.correction_impulse;
      c.correction_impulse = next;
      const Pack my = d * c.arm.z, mz = zero - d * c.arm.y;
      impulse += d, moment_y += my, moment_z += mz;
      if (k + 1 == p.depth) break;
      if constexpr (paired) {
        n += p.vv.x.x * d + p.wv.x.y * my + p.wv.x.z * mz;
        y += p.wv.x.y * d + p.ww.yy * my + p.ww.yz * mz;
        z += p.wv.x.z * d + p.ww.yz * my + p.ww.zz * mz;
      } else {
        n += p.vv.x.x * d;
        y += p.ww.yy * my + p.ww.yz * mz;
        z += p.ww.yz * my + p.ww.zz * mz;
      }
    }
    const vectors r = impulse * f.x, m = moment_y * f.y + moment_z * f.z;
    ends.give(p, r, m, v_of, w_of);
  }

 private:
  struct relative_motion {
    vectors v, w;
  };
  /// Velocities of the bodies of a block, or displacements: v_of and w_of are their accessors.
  struct ends_of_pairs {
    pack_rows<Pack> va, wa, vb, wb;

    /// Reads the velocities of both bodies. Returns those of a relative to b, at the centre of a.
    template <class V, class W>
    [[gnu::always_inline]] relative_motion read(const block& p, V& v_of, W& w_of) {
      va = gather<Pack>(v_of(p.a)), wa = gather<Pack>(w_of(p.a));
      const vectors v{va.x, va.y, va.z}, w{wa.x, wa.y, wa.z};
      if constexpr (!paired) return {v, w};
      vb = gather<Pack>(v_of(p.b)), wb = gather<Pack>(w_of(p.b));
      const vectors of_b{wb.x, wb.y, wb.z};
      return {v - (vectors{vb.x, vb.y, vb.z} + crossed(of_b, p.offset)), w - of_b};
    }
    /// Changes them by an impulse on a and its moment about the centre of a, and stores them.
    template <class V, class W>
    [[gnu::always_inline]] void give(const block& p, const vectors& r, const vectors& m, V& v_of,
                                     W& w_of) {
      va.x += va.w * r.x, va.y += va.w * r.y, va.z += va.w * r.z;
      const vectors ta = p.tensor_a.times(m);
      wa.x += ta.x, wa.y += ta.y, wa.z += ta.z;
      if constexpr (paired) {
        vb.x -= vb.w * r.x, vb.y -= vb.w * r.y, vb.z -= vb.w * r.z;
        const vectors tb = p.tensor_b.times(m + crossed(p.offset, r));
        wb.x -= tb.x, wb.y -= tb.y, wb.z -= tb.z;
        scatter(vb, v_of(p.b)), scatter(wb, w_of(p.b));
      }
      scatter(va, v_of(p.a)), scatter(wa, w_of(p.a));
    }
  };
  static void prepare_layer(const block& p, layer& c) {
    const Pack zero = every_lane<Pack>(0);
    const pack_rows<Pack> arm =
        gather<Pack>([&](int i) { return row_of(*c.at[i], c.at[i]->arm_a); });
    const vectors r = c.arm = p.frame.times({arm.x, arm.y, arm.z});
    for (int i = 0; i < lanes; ++i) {
      put_lane(c.friction, i, c.at[i]->friction);
      put_lane(c.correction_rate, i, c.at[i]->correction_rate);
    }
    c.correction_impulse = zero;
    if constexpr (Contact::biased) {
      const pack_rows<Pack> bias =
          gather<Pack>([&](int i) { return row_of(*c.at[i], c.at[i]->bias); });
      c.bias = p.frame.times({bias.x, bias.y, bias.z});
    }
    // The motion that each component of an impulse at the arm causes, and the velocity there.
    const vectors wx = p.ww.row_x(), wy = p.ww.row_y(), wz = p.ww.row_z();
    vectors nw = r.z * wy - r.y * wz, xw = r.x * wz - r.z * wx, yw = r.y * wx - r.x * wy;
    Pack nn, n1, n2, t11, t12, t22;
    if constexpr (paired) {
      // Columns of the velocity that a moment causes.
      const vectors c3{p.wv.x.x, p.wv.y.x, p.wv.z.x}, c4{p.wv.x.y, p.wv.y.y, p.wv.z.y},
          c5{p.wv.x.z, p.wv.y.z, p.wv.z.z};
      const vectors n = p.vv.x + (r.z * c4 - r.y * c5), x = p.vv.y + (r.x * c5 - r.z * c3),
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
    c.own.set(nn, n1, n2, t11, t12, t22);
  }
  /// Solves one contact of each manifold, which has the velocity u; returns the changes.
  template <bool Watched, class Note>
  [[gnu::always_inline]] static vectors solve(layer& c, vectors u, Note& note) {
    const auto impulse = [&](int i) { return row_of(*c.at[i], c.at[i]->r); };
    pack_rows<Pack> r = gather<Pack>(impulse);  // and the target
    u.x -= r.w;
    if constexpr (Contact::biased) u.x -= c.bias.x, u.y -= c.bias.y, u.z -= c.bias.z;
    const vectors next = c.own.solve({r.x, r.y, r.z}, u, c.friction, c.present);
    const vectors d = next - vectors{r.x, r.y, r.z};
    r.x = next.x, r.y = next.y, r.z = next.z;
    scatter(r, impulse);
    if constexpr (Watched) {
      const Pack change = square_root(dot(d, d)) * c.own.nn;
      for (int i = lanes; i-- > 0;) note(c.at[i], lane(change, i));
    }
    return d;
  }
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
