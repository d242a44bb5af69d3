#pragma once
// The forces between spheres, eight contacts at once: what force_adder (soft_forces.hpp) computes
// one by one, with the same bits. Forces are added to bodies in the order of the pairs.
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "talus/core/exact_batch.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_fields.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/detect/pairs/sphere_sphere.hpp"
#include "talus/features/energy_ledger/soft_ledger.hpp"
#include "talus/interaction/composed_law.hpp"
#include "talus/interaction/pair_kinematics.hpp"
#include "talus/interaction/soft_state.hpp"
#include "talus/pairs/found_pairs.hpp"
#include "talus/pairs/shape_pairs.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Whether the pairs of these shapes are evaluated several at once.
template <class Scenario, class ShapeA, class ShapeB, partner Partner>
inline constexpr bool forces_in_packs =
    std::is_same_v<ShapeA, sphere>&& std::is_same_v<ShapeB, sphere>&& Partner ==
        partner::moving&& world_state<Scenario>::law::law::in_packs &&
    !world_state<Scenario>::sleeps &&
    (!monitored<Scenario, energy_ledger> || world_state<Scenario>::law::law::stores_in_packs);

/// The sums over contacts of a survey of energies, or of the ledger if there is one.
template <class Scenario, class Observer>
struct books_of_step {
  explicit books_of_step(const world_state<Scenario>&, const Observer&) {}
};
template <class Scenario>
struct books_of_step<Scenario, spring_energies> {
  exact_batch<signed_sum> normal, across;
  books_of_step(const world_state<Scenario>&, spring_energies& e)
      : normal(e.normal), across(e.across) {}
};
template <class Scenario>
requires monitored<Scenario, energy_ledger>
struct books_of_step<Scenario, std::nullptr_t> {
  exact_batch<signed_sum> normal, across_before, across, yielded, spring, dashpot, friction;
  exact_batch<exact_sum> exchanged;
  books_of_step(world_state<Scenario>& s, std::nullptr_t)
      : normal(s.monitors.springs.normal),
        across_before(s.monitors.springs.across_before),
        across(s.monitors.springs.across),
        yielded(s.monitors.springs.yielded),
        spring(s.monitors.springs.spring_power),
        dashpot(s.monitors.springs.dashpot_power),
        friction(s.monitors.springs.friction_power),
        exchanged(s.monitors.springs.exchanged_power) {}
};

/// Adds up the forces, with the springs advanced by a step; or, with spring_energies as observer,
/// the energies of the springs in the present state.
template <class Scenario, class Observer>
class sphere_forces : shape_pairs<Scenario, sphere, sphere, partner::moving> {
  using base = shape_pairs<Scenario, sphere, sphere, partner::moving>;
  using base::s_, base::a_, base::first_a_;
  using typename base::body_pair, typename base::state_type;
  using law = typename state_type::law::law;
  using number = wide_pack<real>;
  using vectors = vectors_of<number>;
  using entry = typename state_type::history_type::entry;
  static constexpr std::size_t lanes = lanes_of<number>;
  static constexpr bool remembers = state_type::law::remembers;
  static constexpr bool alone = state_type::link_type::alone;
  static constexpr bool imaged = base::imaged;
  static constexpr bool surveyed = std::is_same_v<Observer, spring_energies>;
  static constexpr bool booked = !surveyed && monitored<Scenario, energy_ledger>;
  static constexpr bool balanced = !surveyed && monitored<Scenario, momentum_balance>;
  static constexpr bool residual = !surveyed && monitored<Scenario, residual_monitor>;

 public:
  static constexpr bool only_reads_places = surveyed;

  sphere_forces(state_type& s, Observer& observer)
      : base(s),
        books_(s, observer),
        places_hold_(s.history.places_hold()),
        bodies_(s.soft.bodies.data()),
        places_(s.soft.places.data()) {
    const auto& material = a_.material;
    one_material_ = s.soft.pairs.holds_all();
    for (std::size_t i = 0; i < a_.size(); ++i)
      one_material_ = one_material_ && material[i] == material[0];
    if (a_.size() == 0 || !one_material_) return;
    const auto& all = s.soft.pairs.pair(material[0], material[0]);
    one_material_ = all.known;
    spread(all);
  }

  /// Adds the forces of `count` candidate pairs at most as far apart as they reach, by their
  /// numbers.
  void operator()(close_pair* pairs, const std::uint32_t* close, std::size_t count) {
    std::size_t chosen = 0;
    for (std::size_t k = 0; k < count; ++k) chosen += choose_pair(pairs[close[k]], chosen);
    if (chosen == 0) return;
    const std::size_t full = chosen / lanes * lanes, last = chosen - 1;
    // The lanes beyond the last pair repeat it, and nothing of them is used.
    for (std::size_t k = chosen; k < full + lanes; ++k) {
      pair_[k] = pair_[last], body_a_[k] = body_a_[last], body_b_[k] = body_b_[last];
      place_a_[k] = place_a_[last], place_b_[k] = place_b_[last];
    }
    for (std::size_t k = 0; k < chosen && k < 2 * lanes; ++k) prefetch(k);
    for (std::size_t k = 0; k < full; k += lanes) {
      for (std::size_t l = k + 2 * lanes; l < k + 3 * lanes; ++l)
        if (l < chosen) prefetch(l);
      add(k, lanes);
    }
    if (full < chosen) add(full, chosen - full);
  }
  void finish() {
    for (std::size_t l = 0; l < lanes; ++l)
      s_.soft.fastest_approach = std::max(s_.soft.fastest_approach, lane(fastest_, l));
  }

 private:
  /// Writes down a pair as number k if it acts here.
  [[gnu::always_inline]] inline bool choose_pair(close_pair& pair, std::size_t k) {
    pair_[k] = &pair;
    if constexpr (!alone || imaged) {
      counts_[k] = true, crosses_[k] = false;
      if (imaged || pair.i >= a_.locals || pair.j >= a_.locals) {
        body_pair x;
        x.i = pair.i, x.j = pair.j;
        // A pair that another rank alone computes is looked up by its key when it acts here.
        const history_place before = pair.last;
        if constexpr (!surveyed) pair.last = history_place::unknown;
        if (!this->find(x)) return false;
        if constexpr (!alone)
          if (s_.strangers && !x.own_a && !x.own_b)
            require_acquainted<Scenario, sphere, sphere>(s_, x.i, x.j);
        if (!x.acts_here()) return false;
        if (x.crosses_ranks()) {
          if (!this->known_to_both(x)) return false;
          counts_[k] = x.own_a, crosses_[k] = true;
        }
        if constexpr (!surveyed) pair.last = before;
        if constexpr (imaged) {
          images_[2 * k] = {this->position_a(x), a_.shape[x.i].radius};
          images_[2 * k + 1] = {this->position_b(x), a_.shape[x.j].radius};
          place_a_[k] = &images_[2 * k], place_b_[k] = &images_[2 * k + 1];
          body_a_[k] = &s_.soft.bodies[first_a_ + x.i];
          body_b_[k] = &s_.soft.bodies[first_a_ + this->body_b(x)];
        }
      }
    }
    if constexpr (!imaged) {
      const std::size_t i = first_a_ + pair.i, j = first_a_ + pair.j;
      body_a_[k] = bodies_ + i, body_b_[k] = bodies_ + j;
      place_a_[k] = places_ + i, place_b_[k] = places_ + j;
    }
    return true;
  }
  /// Loads what a pair that follows soon needs.
  [[gnu::always_inline]] inline void prefetch(std::size_t k) const {
    const auto load = [](const void* line) { __builtin_prefetch(line, 1); };
    const auto after = [](const soft_body* body) {
      return reinterpret_cast<const char*>(body) + 64;
    };
    load(body_a_[k]), load(after(body_a_[k]));
    load(body_b_[k]), load(after(body_b_[k]));
    if constexpr (remembers) s_.history.prefetch(pair_[k]->last);
  }

  /// The contacts of the pairs written down from `first` on.
  [[gnu::always_inline]] inline void add(std::size_t first, std::size_t count) {
    soft_body *const *const body_a = &body_a_[first], *const *const body_b = &body_b_[first];
    const soft_place *const *const place_a = &place_a_[first], *const *const place_b =
                                                                   &place_b_[first];
    const auto rows = [](auto&& row) __attribute__((always_inline)) { return gather<number>(row); };
    const auto pa = rows([&](int l) { return row_of(*place_a[l], place_a[l]->position); });
    const auto pb = rows([&](int l) { return row_of(*place_b[l], place_b[l]->position); });
    const auto va = rows([&](int l) { return row_of(*body_a[l], body_a[l]->v); });
    const auto vb = rows([&](int l) { return row_of(*body_b[l], body_b[l]->v); });
    const auto wa = rows([&](int l) { return row_of(*body_a[l], body_a[l]->w); });
    const auto wb = rows([&](int l) { return row_of(*body_b[l], body_b[l]->w); });

    const vectors centre_a = vectors_in(pa), centre_b = vectors_in(pb);
    touch_of_spheres<number> g(centre_a, wa.w, centre_b, wb.w);
    g.find_point(centre_b, wb.w);
    body_at_contact<number> a{vectors_in(va), vectors_in(wa), va.w,
                              wa.w,           real(1) / wa.w, vectors(g.point - centre_a)},
        b{vectors_in(vb), vectors_in(wb), vb.w, wb.w, real(1) / wb.w, vectors(g.point - centre_b)};
    if (!all_lanes(both(a.inverse_mass > real(0), b.inverse_mass > real(0)))) [[unlikely]] {
      // Beside an immovable sphere each has its point on its own surface.
      const auto fixed = inverted(both(a.inverse_mass > real(0), b.inverse_mass > real(0)));
      const vectors half = choose(fixed, number(real(0.5) * g.gap), number{}) * g.normal;
      a.arm += half, b.arm -= half;
    }
    const auto t = kinematics_of_pair<number>(g.normal, g.gap, a, b, s_.dt);

    const auto moves = inverted(both(a.inverse_mass == real(0), b.inverse_mass == real(0)));
    const auto touch = both(g.squared <= g.touch * g.touch, g.gap < real(0));
    const unsigned moving = bits_of(moves) & ((1u << count) - 1), live = bits_of(touch) & moving;
    if (live == 0) {
      if constexpr (!surveyed) leave(first, count, moving);
      return;
    }

    read_parameters(first, live);
    typename law::template memory_of<number> memory;
    const entry* old[lanes];  // null for a new contact
    if constexpr (remembers) read_memory(first, live, old, memory);
    if constexpr (surveyed) {
      const auto e = law::template stored<number>(t, parameters_, memory);
      const auto counting = counting_lanes(first, count, both(moves, touch));
      books_.normal += choose(counting, e.normal, number{});
      books_.across += choose(counting, e.kept, number{});
      return;
    }
    std::conditional_t<booked, booked_contact_of<number>, not_booked> books;
    const pair_force_of<number> f =
        law::template force<number>(t, parameters_, s_.dt, memory, books);

    const number approach = -dot(t.normal, t.velocity);
    fastest_ = choose(both(moves, both(touch, approach > fastest_)), approach, fastest_);
    leave(first, count, moving);
    if constexpr (remembers) write_memory(first, live, old, memory);
    count_contacts(first, live, g.gap);
    if constexpr (residual) add_square(first, live, dot(f.force, f.force));
    if constexpr (booked)
      book(counting_lanes(first, count, both(moves, touch)), books, f, t),
          book_across_ranks(first, live, books, f, t, a, b);
    if constexpr (booked || balanced) book_fixed(live, f, a, b);

    row_pack<real> force[lanes], torque_a[lanes], torque_b[lanes];
    vectors turn_a = every_lane_of<number>(0, 0, 0), turn_b = turn_a;
    if constexpr (!law::central) turn_a = crossed(a.arm, f.force), turn_b = crossed(b.arm, f.force);
    rows_of_lanes<number>(f.force, force);
    rows_of_lanes<number>(turn_a, torque_a);
    rows_of_lanes<number>(turn_b, torque_b);
    row_pack<real> moment[lanes];
    if constexpr (law::exerts_moment) rows_of_lanes<number>(f.moment, moment);
    const auto add_to_bodies = [&](std::size_t l) __attribute__((always_inline)) {
      const auto row = [](soft_body * body, const vec3& part) __attribute__((always_inline)) {
        return row_of(*body, part);
      };
      soft_body *const A = body_a[l], *const B = body_b[l];
      const auto change = [&](auto&& at_row, auto&& f_of) __attribute__((always_inline)) {
        store(at_row, f_of(load(at_row)));
      };
      change(row(A, A->force), [&](const auto& x) { return x + force[l]; });
      if constexpr (!law::central || law::exerts_moment || residual)
        change(row(A, A->torque), [&](auto x) {
          if constexpr (!law::central) x = x + torque_a[l];
          if constexpr (law::exerts_moment) x = x + moment[l];
          if constexpr (residual) x = x + row_pack<real>{0, 0, 0, 1};
          return x;
        });
      change(row(B, B->force), [&](const auto& x) { return x - force[l]; });
      if constexpr (!law::central || law::exerts_moment || residual)
        change(row(B, B->torque), [&](auto x) {
          if constexpr (!law::central) x = x - torque_b[l];
          if constexpr (law::exerts_moment) x = x - moment[l];
          if constexpr (residual) x = x + row_pack<real>{0, 0, 0, 1};
          return x;
        });
    };
    for_lanes(live, add_to_bodies);
  }

  using booked_type = std::conditional_t<booked, booked_contact_of<number>, not_booked>;
  using kinematics = contact_kinematics_of<number>;
  using powers = contact_powers<number>;
  /// The lanes of contacts that count on this rank.
  [[nodiscard, gnu::always_inline]] inline mask_of<number> counting_lanes(
      std::size_t first, std::size_t count, mask_of<number> touch) const {
    constexpr number places{0, 1, 2, 3, 4, 5, 6, 7};
    touch = both(touch, places < every_lane<number>(static_cast<real>(count)));
    if constexpr (!alone || imaged) {
      number counts{};
      for (std::size_t l = 0; l < lanes; ++l) counts[l] = counts_[first + l] ? 1 : 0;
      touch = both(touch, counts > number{});
    }
    return (void)first, touch;
  }
  /// The entries of contacts in the energy ledger.
  [[gnu::always_inline]] inline void book(const mask_of<number>& counting, const booked_type& c,
                                          const pair_force_of<number>& f, const kinematics& t) {
    const auto add = [&](auto& sum, const number& x) __attribute__((always_inline)) {
      sum += choose(counting, x, number{});
    };
    const powers p = powers::template of<law::central>(c, f, t);
    add(books_.normal, c.stored), add(books_.across_before, c.across_before);
    add(books_.across, c.across), add(books_.yielded, c.yielded);
    add(books_.spring, p.spring), add(books_.dashpot, p.dashpot), add(books_.friction, p.friction);
    add(books_.exchanged,
        size_of_lanes(p.spring) + size_of_lanes(p.dashpot) + size_of_lanes(p.friction));
  }
  /// The power on bodies of other ranks of the contacts that count here, and the reverse.
  [[gnu::always_inline]] inline void book_across_ranks(
      std::size_t first, unsigned live, const booked_type& c, const pair_force_of<number>& f,
      const kinematics& t, const body_at_contact<number>& a, const body_at_contact<number>& b) {
    if constexpr (alone) return;
    powers p;
    bool known = false;
    for_lanes(live, [&](std::size_t l) {
      if (!crosses_here(first + l)) return;
      if (!std::exchange(known, true)) p = powers::template of<law::central>(c, f, t);
      const bool of_a = counts_here(first + l);
      const auto& own = of_a ? a : b;
      const real here =
          of_a ? lane(p.spring, l) + lane(p.dashpot, l) + lane(p.friction, l) : real(0);
      s_.monitors.springs.power_elsewhere +=
          here - power_on_body(of_a ? 1 : -1, lane(f.force, l), lane(f.moment, l), lane(own.v, l),
                               lane(own.w, l), lane(own.arm, l));
    });
  }
  /// Contacts with fixed spheres: their work and momentum.
  [[gnu::always_inline]] inline void book_fixed(unsigned live, const pair_force_of<number>& f,
                                                const body_at_contact<number>& a,
                                                const body_at_contact<number>& b) {
    const unsigned fixed_a = bits_of(a.inverse_mass == real(0)),
                   fixed_b = bits_of(b.inverse_mass == real(0));
    if (((fixed_a | fixed_b) & live) == 0) [[likely]]
      return;
    for_lanes((fixed_a | fixed_b) & live, [&](std::size_t l) {
      const bool of_b = (fixed_b >> l & 1) != 0;
      const real sign = of_b ? 1 : -1;
      const auto& fixed = of_b ? b : a;
      if constexpr (booked)
        s_.monitors.springs.wall_power +=
            power_on_body(sign, lane(f.force, l), lane(f.moment, l), lane(fixed.v, l),
                          lane(fixed.w, l), lane(fixed.arm, l));
      if constexpr (balanced) s_.monitors.momentum.ground_force += sign * lane(f.force, l);
    });
  }

  /// Pairs without contact keep no place; one of two immovable bodies is looked up by its key.
  [[gnu::always_inline]] inline void leave(std::size_t first, std::size_t count, unsigned moving) {
    for (std::size_t l = 0; l < count; ++l)
      pair_[first + l]->last =
          (moving >> l & 1) != 0 ? history_place::none : history_place::unknown;
  }
  /// Calls f(l) for the lanes of the mask, in their order.
  template <class F>
  [[gnu::always_inline]] static inline void for_lanes(unsigned live, F&& f) {
    if (live == (1u << lanes) - 1) {
      for (std::size_t l = 0; l < lanes; ++l) f(l);
    } else {
      for (std::size_t l = 0; l < lanes; ++l)
        if ((live >> l & 1) != 0) f(l);
    }
  }

  [[gnu::always_inline]] inline void read_parameters(std::size_t first, unsigned live) {
    if (one_material_) return;
    auto& pairs = s_.soft.pairs;
    const typename law::parameters* of_lane[lanes];
    typename law::parameters copy[lanes];
    for (std::size_t l = 0; l < lanes; ++l) {
      const close_pair& pair = *pair_[first + l];
      const material_id a = a_.material[pair.i], b = a_.material[pair.j];
      of_lane[l] = &pairs.pair(a, b);
      if ((live >> l & 1) != 0) pairs.require_known(*of_lane[l], a, b);
      if (!pairs.holds_all()) [[unlikely]]
        copy[l] = *of_lane[l], of_lane[l] = &copy[l];
    }
    law::each_part([&]<class Part>() __attribute__((always_inline)) {
      auto& packs = law::template of<Part>(parameters_);
      gather_fields<number>(
          packs, [&](int l) __attribute__((always_inline))->const auto& {
            return law::template of<Part>(*of_lane[l]);
          });
    });
  }

  void spread(const typename law::parameters& all) {
    law::each_part([&]<class Part>() __attribute__((always_inline)) {
      spread_fields<number>(law::template of<Part>(parameters_), law::template of<Part>(all));
    });
  }
  [[nodiscard]] contact_key key_of(const close_pair& pair) const {
    return {a_.id[pair.i], a_.id[pair.j], 0};
  }
  template <class Memory>
  [[gnu::always_inline]] inline void read_memory(std::size_t first, unsigned live,
                                                 const entry* (&old)[lanes], Memory& memory) {
    for (std::size_t l = 0; l < lanes; ++l) {
      const history_place place = pair_[first + l]->last;
      old[l] = places_hold_ ? s_.history.at(place) : nullptr;
      if (old[l] == nullptr && place != history_place::none && (live >> l & 1) != 0) [[unlikely]]
        old[l] = s_.history.former_entry(place, key_of(*pair_[first + l]));
    }
    law::each_part([&]<class Part>() __attribute__((always_inline)) {
      gather_fields<number>(
          law::template of<Part>(memory), [&](int l) __attribute__((always_inline))->const auto& {
            const entry* const e = old[l] != nullptr ? old[l] : &fresh_;
            return law::template of<Part>(e->memory);
          });
    });
  }
  template <class Memory>
  [[gnu::always_inline]] inline void write_memory(std::size_t first, unsigned live,
                                                  const entry* const (&old)[lanes],
                                                  const Memory& memory) {
    const auto place = static_cast<std::uint32_t>(s_.recorded.next_place());
    entry* const entries = s_.recorded.add_some(lanes);
    entry* at[lanes];
    entry unused;
    std::uint32_t next = 0;
    if (live == (1u << lanes) - 1) {
      for (std::uint32_t l = 0; l < lanes; ++l) {
        pair_[first + l]->last = static_cast<history_place>(place + l);
        at[l] = entries + l;
      }
      next = lanes;
    } else {
      for (std::size_t l = 0; l < lanes; ++l) {
        if ((live >> l & 1) == 0) {
          at[l] = &unused;
          continue;
        }
        pair_[first + l]->last = static_cast<history_place>(place + next);
        at[l] = entries + next++;
      }
      s_.recorded.drop_last(lanes - next);
    }
    for (std::size_t l = 0; l < lanes; ++l)
      if (old[l] != nullptr) [[likely]]
        at[l]->key = old[l]->key;
      else
        at[l]->key = key_of(*pair_[first + l]);
    law::each_part([&]<class Part>() __attribute__((always_inline)) {
      scatter_fields<number>(
          law::template of<Part>(memory), [&](int l) __attribute__((always_inline))->auto& {
            return law::template of<Part>(at[l]->memory);
          });
    });
  }
  /// Whether the pair of this number counts on this rank.
  [[nodiscard, gnu::always_inline]] inline bool counts_here(std::size_t k) const {
    if constexpr (!alone || imaged)
      return counts_[k];
    else
      return (void)k, true;
  }
  /// Whether two ranks compute it.
  [[nodiscard, gnu::always_inline]] inline bool crosses_here(std::size_t k) const {
    if constexpr (!alone || imaged)
      return crosses_[k];
    else
      return (void)k, false;
  }
  [[gnu::always_inline]] inline void count_contacts(std::size_t first, unsigned live,
                                                    const number& gap) {
    auto& count = std::get<soft_contacts>(s_.contacts);
    if constexpr ((alone && !imaged) && !monitored<Scenario, penetration_monitor>) {
      count.here += static_cast<std::size_t>(__builtin_popcount(live));
    } else {
      for_lanes(live, [&](std::size_t l) {
        const bool counts = counts_here(first + l);
        ++(counts ? count.here : count.doubled);
        if constexpr (monitored<Scenario, penetration_monitor>)
          if (counts) s_.monitors.overlaps.add(lane(gap, l));
      });
    }
    (void)first, (void)gap;
  }

  /// Adds up the squares of the forces of those contacts that count on this rank.
  [[gnu::always_inline]] inline void add_square(std::size_t first, unsigned live,
                                                const number& square) {
    for_lanes(live, [&](std::size_t l) {
      if (counts_here(first + l)) s_.soft.squares_of_forces += lane(square, l);
    });
  }

  static constexpr std::size_t most = pairs_of_block + lanes;
  struct nothing {};
  template <bool Needed, class T>
  using if_needed = std::conditional_t<Needed, T, nothing>;

  [[no_unique_address]] books_of_step<Scenario, Observer> books_;
  entry fresh_{};
  const bool places_hold_;
  number fastest_{};
  typename law::template parameters_of<number> parameters_;
  bool one_material_ = false;  ///< so that all contacts have the same parameters
  soft_body* const bodies_;
  const soft_place* const places_;
  // The pairs of the block that act here.
  std::array<close_pair*, most> pair_;
  std::array<soft_body*, most> body_a_, body_b_;
  std::array<const soft_place*, most> place_a_, place_b_;
  [[no_unique_address]] if_needed<!alone || imaged, std::array<bool, most>>
      counts_,   ///< on this rank
      crosses_;  ///< two ranks compute it
  [[no_unique_address]] if_needed<imaged, std::array<soft_place, 2 * most>> images_;
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
