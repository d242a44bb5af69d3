#pragma once
// Contacts of pairs of spheres that are kept from step to step while the same pairs touch: they
// stay in their places in the solver's list, with their impulses, and get new geometry. All numbers
// are those of contacts made anew, to the bit.
#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
#include <type_traits>

#include "talus/core/plain_vector.hpp"
#include "talus/detect/sphere_batch.hpp"
#include "talus/pairs/shape_pairs.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/solver/contact_list.hpp"
#include "talus/solver/either_list.hpp"
#include "talus/state/solved_velocity.hpp"
#include "talus/state/state.hpp"
#include "talus/step/contact_conditions.hpp"
#include "talus/step/pair_motion.hpp"
#include "talus/step/velocity_bias.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

template <class Scenario>
using contact_of_spheres =
    moving_contact<law_of<Scenario>, sphere, sphere, solved_scalar<Scenario>>;

template <class Scenario>
using list_of_spheres =
    typename world_state<Scenario>::template list_of<contact_of_spheres<Scenario>>;

/// Whether contacts of pairs of these bodies may be kept: of spheres that no other rule concerns.
/// Their list has contacts of no other pairs of shapes.
template <class Scenario, class ShapeA, class ShapeB, partner Partner>
[[nodiscard]] constexpr bool keeps_contacts_of() {
  using state = world_state<Scenario>;
  if constexpr (Partner == partner::moving && std::is_same_v<ShapeA, sphere> &&
                std::is_same_v<ShapeB, sphere> && !state::law::soft) {
    constexpr bool single = []<class... Shapes>(type_list<Shapes...>) {
      return ((Shapes::finite && Shapes::isotropic) + ... + 0) == 1;
    }(typename Scenario::shapes{});
    return single && !state::periodic && !state::continuous && !state::has_joints &&
           !state::sleeps && !state::drives && !is_cohesive<typename state::law> &&
           !monitored<Scenario, penetration_monitor> && requires(list_of_spheres<Scenario> & list) {
      list.renewed();
    };
  } else {
    return false;
  }
}
/// Whether the contacts of a list are kept from step to step.
template <class Scenario, class List>
[[nodiscard]] constexpr bool keeps_contacts_in() {
  if constexpr (contains_type<typename Scenario::shapes, sphere>)
    if constexpr (keeps_contacts_of<Scenario, sphere, sphere, partner::moving>())
      return std::is_same_v<List, list_of_spheres<Scenario>>;
  return false;
}

/// Whether the contacts that are kept are in the first list. Contacts of other lists do not change
/// their places in the history and among the colours.
template <class Scenario>
[[nodiscard]] constexpr bool keeps_first_contacts() {
  return keeps_contacts_in<Scenario,
                           std::tuple_element_t<0, decltype(world_state<Scenario>::contacts)>>();
}

/// For runs on one rank. `Coloured`: the contacts are solved colour by colour.
template <class Scenario, bool Coloured>
class contact_keeper : shape_pairs<Scenario, sphere, sphere, partner::moving> {
  static constexpr bool strikes = world_state<Scenario>::law::restitution &&
                                  world_state<Scenario>::law::correction &&
                                  !uses_substeps<typename Scenario::solver>;

  using base = shape_pairs<Scenario, sphere, sphere, partner::moving>;
  using base::s_, base::a_, base::first_a_;
  using typename base::state_type, typename base::store_a;
  using law = typename state_type::law;
  using contact_type = contact_of_spheres<Scenario>;
  using wide = wide_pack<real>;
  static constexpr unsigned lanes = sphere_batch::capacity;
  static constexpr bool midpoint = state_type::midpoint;

 public:
  explicit contact_keeper(state_type& s)
      : base(s),
        list_(list_in_use<Coloured>(std::get<list_of_spheres<Scenario>>(s.contacts))),
        kept_(s.found.kept),
        motion_(s, a_, a_) {}

  /// Makes the contacts of this step from all candidate pairs.
  void make_all(plain_vector<close_pair>& pairs) {
    const bool known = kept_.search == s_.found.searches &&
                       kept_.materials == s_.materials.revision() && list_.held() &&
                       s_.history.unchanged();
    const bool moved_before = note_places();
    if (kept_.rebounds || kept_.slides || !turns_slowly_) note_motion();
    if (known && moved_before && still_apart() && renew(true)) return (void)(kept_.failures = 0);
    if (Coloured && known && ++kept_.failures > 1) kept_.pause = std::min(kept_.failures, 8);
    kept_.search = s_.found.searches, kept_.materials = s_.materials.revision();
    list_.clear();
    if (spheres_ == nullptr) note_motion();
    find(pairs);
    if constexpr (!Coloured) set_data();
  }
  /// Sets the data of contacts that were found; after they have their colours.
  void set_data() {
    if constexpr (Coloured) note_places(), note_motion();
    if (!renew(false)) fail<std::logic_error>("a contact of spheres was found and lost again");
  }

 private:
  /// Writes the places of all spheres. Returns whether those that can move are the same as before.
  bool note_places() {
    const auto& reach = s_.template of<sphere>().reach;
    auto& places = s_.template of<sphere>().resting;
    bool same = kept_.moves.size() == a_.size();
    kept_.moves.resize(a_.size()), places.resize(a_.size());
    margin_ = 0;
    real smallest = std::numeric_limits<real>::infinity(), fastest = 0;
    for (std::size_t i = 0; i < a_.size(); ++i) {
      const real radius = a_.shape[i].radius;
      if constexpr (midpoint) {
        smallest = std::min(smallest, radius);
        fastest = std::max(fastest, a_.velocity[i].norm() + radius * a_.angular_velocity[i].norm());
      }
      places[i] = {a_.position[i], radius};
      margin_ = std::max(margin_, reach[i] - radius);
      const char moves = a_.moves(i);
      same = same && kept_.moves[i] == moves;
      kept_.moves[i] = moves;
    }
    places_ = places.data();
    // Twice the fastest is a bound for each pair.
    turns_slowly_ = !midpoint || (!store_a::forced &&
                                  4 * fastest * fastest <
                                      (1 - 1e-9) * slow_turn<real>(motion_.gravity(), smallest));
    return same;
  }
  [[nodiscard]] moving_sphere motion_of(std::size_t i) const {
    return {a_.position[i],         s_.template of<sphere>().reach[i],
            a_.velocity[i],         a_.shape[i].radius,
            a_.angular_velocity[i], a_.id[i]};
  }
  /// Writes the motion of all spheres, for steps in which more than a few contacts need it.
  void note_motion() {
    auto& spheres = s_.template of<sphere>().places;
    spheres.resize(a_.size());
    for (std::size_t i = 0; i < a_.size(); ++i) spheres[i] = motion_of(i);
    spheres_ = spheres.data();
  }
  void set_lane(unsigned k, std::size_t i, std::size_t j) {
    lanes_[k] = {i, j};
    if (spheres_ != nullptr) return batch_.set(k, spheres_[i], spheres_[j]);
    few_[2 * k] = motion_of(i), few_[2 * k + 1] = motion_of(j);
    batch_.set(k, few_[2 * k], few_[2 * k + 1]);
  }
  [[nodiscard]] [[gnu::always_inline]] inline unsigned collide(unsigned count) {
    return batch_.collide_in_reach(count, motion_.gravity(), s_.dt, contact_slack);
  }
  /// Pairs of the batch that pass each other in this step though their gap closes.
  [[gnu::noinline]] void let_pass(const wide& pull, const pack_vector<wide>& u,
                                  renewed_contacts& next) const {
    const wide un = dot(batch_.normal, u);
    for (unsigned left = batch_.apart; left != 0; left &= left - 1) {
      const auto k = static_cast<unsigned>(std::countr_zero(left));
      if (!passes(k, pull[k])) continue;
      const real limit = passing_velocity(batch_.gap[k], un[k], pull[k], s_.dt);
      next.target_velocity[k] = limit;
      if (!next.rebounds) continue;
      next.limit[k] = limit;
      next.slowest[k] = slowest_impact(limit, next.restitution[k], pull[k], s_.dt);
    }
  }
  [[nodiscard]] bool passes(unsigned k, real pull) const {
    const auto [i, j] = lanes_[k];
    const vec3 &at_a = a_.position[i], &at_b = a_.position[j];
    const real slack = slack_of<real>(contact_slack, a_.shape[i].radius, a_.shape[j].radius);
    return motion_.may_pass(i, j, at_a, at_b, slack, lane(batch_.normal, k), batch_.gap[k],
                            batch_.approach[k], pull) &&
           !motion_.meet_on_paths(i, j, at_a, at_b, slack);
  }
  /// The places of bodies, of which the last one fills the empty lanes.
  template <class Body>
  [[nodiscard]] [[gnu::always_inline]] inline pack_rows<wide> places_of(unsigned count,
                                                                        Body&& body) const {
    const int last = static_cast<int>(count) - 1;
    return gather<wide>([&](int k) __attribute__((always_inline)) {
      const placed_sphere& x = places_[body(static_cast<unsigned>(std::min(k, last)))];
      return row_of(x, x.position);
    });
  }

  /// The pairs of a batch that may be in reach, by the largest reach of all spheres. Calls
  /// `pair(k)` for the bodies of pair k.
  template <class Pair>
  [[nodiscard]] [[gnu::always_inline]] inline unsigned near(unsigned count, Pair&& pair) const {
    const auto a = places_of(count, [&](unsigned k) { return pair(k).first; });
    const auto b = places_of(count, [&](unsigned k) { return pair(k).second; });
    const pack_vector<wide> d = vectors_in(a) - vectors_in(b);
    const wide reach =
        (a.w + b.w + every_lane<wide>(2 * margin_)) * every_lane<wide>(1 + 1e-9);  // at least
    return bits_of(dot(d, d) <= reach * reach) & ((1u << count) - 1);
  }
  /// Whether the pairs without a contact have none now.
  [[nodiscard]] bool still_apart() {
    const auto& apart = kept_.apart;
    for (std::size_t first = 0; first < apart.size(); first += lanes) {
      const auto count = static_cast<unsigned>(std::min<std::size_t>(apart.size() - first, lanes));
      if (near(count, [&](unsigned k) { return apart[first + k]; }) == 0) continue;
      for (unsigned k = 0; k < count; ++k) {
        std::size_t i = apart[first + k].first, j = apart[first + k].second;
        this->order(i, j);
        set_lane(k, i, j);
      }
      if (collide(count) != 0) return false;
    }
    return true;
  }
  /// Adds the pairs that have a contact to the list.
  void find(plain_vector<close_pair>& pairs) {
    kept_.apart.clear();
    kept_.rebounds = kept_.slides = false;
    close_pair* in_lane[lanes];
    unsigned filled = 0;
    const auto leave_out = [&](close_pair& pair) {
      pair.last = history_place::none;
      if (kept_.moves[pair.i] || kept_.moves[pair.j])
        kept_.apart.emplace_back(static_cast<std::uint32_t>(pair.i),
                                 static_cast<std::uint32_t>(pair.j));
    };
    const auto add_lanes = [&] {
      for (unsigned k = 0; k < filled; ++k) {
        std::size_t i = in_lane[k]->i, j = in_lane[k]->j;
        this->order(i, j);
        set_lane(k, i, j);
      }
      const unsigned met = filled > 0 ? collide(filled) : 0;
      for (unsigned k = 0; k < filled; ++k) {
        const auto [i, j] = lanes_[k];
        const bool moves_a = kept_.moves[i], moves_b = kept_.moves[j];
        if ((met >> k & 1u) != 0 && (moves_a || moves_b))
          add(i, j, moves_a, moves_b, in_lane[k]->last);
        else
          leave_out(*in_lane[k]);
      }
      filled = 0;
    };
    for (std::size_t first = 0; first < pairs.size(); first += lanes) {
      const auto count = static_cast<unsigned>(std::min<std::size_t>(pairs.size() - first, lanes));
      const unsigned close = near(count, [&](unsigned k) {
        return plain_pair{pairs[first + k].i, pairs[first + k].j};
      });
      for (unsigned k = 0; k < count; ++k) {
        if ((close >> k & 1u) == 0) {
          leave_out(pairs[first + k]);
          continue;
        }
        in_lane[filled++] = &pairs[first + k];
        if (filled == lanes) add_lanes();
      }
    }
    add_lanes();
  }
  void add(std::size_t i, std::size_t j, bool moves_a, bool moves_b, history_place& last) {
    contact_type c;
    c.normal = {0, 0, 0};
    c.a = static_cast<std::int32_t>(first_a_ + i);
    c.b = static_cast<std::int32_t>(first_a_ + j);
    const pair_material& between = materials_of(i, j);
    kept_.rebounds = kept_.rebounds || between.restitution > 0;
    if constexpr (law::friction) {
      c.friction = static_cast<decltype(c.friction)>(between.friction);
      kept_.slides = kept_.slides || between.dynamic_friction < between.friction;
    }
    list_.add_pair(c, {a_.id[i], a_.id[j], 0}, moves_a, moves_b, &last);
  }
  /// Sets the data of all contacts, or returns false if one of their pairs has none now.
  [[nodiscard]] bool renew(bool kept) {
    return list_.renew(
        kept, presses(s_),
        [this](const std::int32_t* a, const std::int32_t* b, int count,
               renewed_contacts& next) __attribute__((always_inline)) {
          const auto size = static_cast<unsigned>(count);
          if (!kept_.rebounds && !kept_.slides && turns_slowly_ && renew_resting(a, b, size, next))
            return true;
          for (unsigned k = 0; k < size; ++k) set_lane(k, sphere_of(a[k]), sphere_of(b[k]));
          if (collide(size) != (1u << size) - 1) return false;
          next.normal = batch_.normal, next.arm_a = batch_.arm_a, next.arm_b = batch_.arm_b;
          const wide pull = set_gap_conditions(a, b, size, batch_.gap, next);
          if constexpr (midpoint) next.bias = biases_of<law::friction>(batch_, pull, s_.dt);
          const auto u = biased_velocity(next);
          if (kept_.rebounds || kept_.slides) set_conditions(a, b, size, pull, u, next);
          if (batch_.apart != 0) let_pass(pull, u, next);
          if constexpr (midpoint) end_biases(size, next);
          return true;
        });
  }
  /// Sets the data of contacts whose gaps are so small that velocities do not matter. Returns false
  /// if one gap is larger.
  [[nodiscard]] [[gnu::always_inline]] inline bool renew_resting(const std::int32_t* a,
                                                                 const std::int32_t* b,
                                                                 unsigned count,
                                                                 renewed_contacts& next) {
    const auto at_a = places_of(count, [&](unsigned k) { return sphere_of(a[k]); });
    const auto at_b = places_of(count, [&](unsigned k) { return sphere_of(b[k]); });
    const sphere_geometry<wide> x(vectors_in(at_a), at_a.w, vectors_in(at_b), at_b.w);
    const wide slack = slack_of(every_lane<wide>(contact_slack), at_a.w, at_b.w);
    if (!all_lanes(x.gap <= every_lane<wide>(touching_part * (1 - 1e-6)) * slack)) return false;
    next.normal = x.normal, next.arm_a = x.arm_a, next.arm_b = x.arm_b;
    if constexpr (midpoint) next.bias = no_bias();
    (void)set_gap_conditions(a, b, count, x.gap, next);
    return true;
  }
  /// Conditions that depend on the gap. Returns the acceleration of the surfaces.
  [[gnu::always_inline]] inline wide set_gap_conditions(const std::int32_t* a,
                                                        const std::int32_t* b, unsigned count,
                                                        const wide& gap, renewed_contacts& next) {
    wide pull = every_lane<wide>(motion_.gravity());
    if constexpr (store_a::forced)
      for (unsigned k = 0; k < count; ++k) pull[k] = motion_.pull(sphere_of(a[k]), sphere_of(b[k]));
    const auto conditions = conditions_of_gap<law, wide>(gap, held_gap<law, wide>(pull, s_.dt),
                                                         s_.dt, s_.settings.correction);
    next.target_velocity = conditions.target_velocity;
    next.correction_rate = conditions.correction_rate;
    return (void)a, (void)b, (void)count, pull;
  }
  /// Conditions that depend on the velocities.
  void set_conditions(const std::int32_t* a, const std::int32_t* b, unsigned count,
                      const wide& pull, const pack_vector<wide>& u, renewed_contacts& next) {
    const wide un = dot(batch_.normal, u);
    next.slides = kept_.slides;
    next.rebounds = kept_.rebounds;
    for (unsigned k = 0; k < count; ++k) {
      const std::size_t i = sphere_of(a[k]), j = sphere_of(b[k]);
      const pair_material& between = materials_of(i, j);
      const bool fast =
          between.restitution > 0 && (un[k] < -2 * pull[k] * s_.dt || s_.solver.finishes);
      next.friction[k] = between.friction;
      next.restitution[k] = strikes ? between.restitution : 0;
      next.limit[k] = next.target_velocity[k];
      next.slowest[k] = slowest_impact(next.limit[k], between.restitution, pull[k], s_.dt);
      if (!fast && !(between.dynamic_friction < between.friction)) continue;
      const vec3 normal = lane(batch_.normal, k);
      auto want = conditions_of<law, uses_substeps<typename Scenario::solver>>(
          between, normal, lane(u, k), batch_.gap[k], s_.dt, pull[k],
          [&] { return motion_.fall(i, j, normal); }, creep(a_.shape[i].radius, s_.dt),
          s_.settings.correction);
      if constexpr (strikes) {
        if (s_.solver.finishes) let_part(want, un[k]);
        next.limit[k] = want.limit;
      }
      const bool strikes_now =
          want.target_velocity > 0 && !((batch_.apart >> k & 1u) && passes(k, pull[k]));
      s_.solver.impacts = s_.solver.impacts || strikes_now;
      next.target_velocity[k] = want.target_velocity;
      next.correction_rate[k] = want.correction_rate;
      next.friction[k] = want.friction;
    }
  }
  [[nodiscard]] static pack_vector<wide> no_bias() {
    return {every_lane<wide>(0), every_lane<wide>(0), every_lane<wide>(0)};
  }
  /// The relative velocities, of which the normal part of a bias is no impact.
  [[nodiscard]] [[gnu::always_inline]] inline pack_vector<wide> biased_velocity(
      const renewed_contacts& next) const {
    if constexpr (!midpoint) return (void)next, batch_.velocity;
    return batch_.velocity + dot(batch_.normal, next.bias) * batch_.normal;
  }
  /// See contact_maker::end_bias().
  void end_biases(unsigned count, renewed_contacts& next) const {
    const wide zero = every_lane<wide>(0);
    next.bias = choose(next.target_velocity == zero, next.bias, no_bias());
    if constexpr (strikes)
      for (unsigned k = 0; next.rebounds && k < count; ++k) {
        if (!(next.restitution[k] > 0)) continue;
        contact_conditions want{.target_velocity = next.target_velocity[k],
                                .limit = next.limit[k],
                                .slowest = next.slowest[k]};
        const vec3 normal = lane(batch_.normal, k);
        const real half = reflect_in_the_middle(
            want, motion_.fall(lanes_[k].first, lanes_[k].second, normal), s_.dt);
        put_lane(next.bias, k, lane(next.bias, k) - half * normal);
        next.target_velocity[k] = want.target_velocity;
        next.limit[k] = want.limit, next.slowest[k] = want.slowest;
      }
  }
  [[nodiscard]] std::size_t sphere_of(std::int32_t body) const {
    return static_cast<std::size_t>(body) - first_a_;
  }
  [[nodiscard]] const pair_material& materials_of(std::size_t i, std::size_t j) {
    const material_id a = a_.material[i], b = a_.material[j];
    if (!between_known_ || a != material_a_ || b != material_b_) {
      between_known_ = true, material_a_ = a, material_b_ = b;
      between_ = s_.materials.pair(a, b);
    }
    return between_;
  }

  std::conditional_t<Coloured, coloured_list<contact_type>, contact_list<contact_type>>& list_;
  kept_contacts& kept_;
  pair_motion<Scenario, sphere, sphere, true> motion_;
  const placed_sphere* places_ = nullptr;
  const moving_sphere* spheres_ = nullptr;  ///< null: of a few only
  std::array<moving_sphere, 2 * lanes> few_;
  bool turns_slowly_ = true;  ///< so that no contact has a bias
  real margin_ = 0;           ///< the largest of a sphere: its reach without its radius
  sphere_batch batch_;
  std::array<plain_pair<std::size_t, std::size_t>, lanes> lanes_;  ///< the bodies of its pairs
  bool between_known_ = false;  ///< the properties of the last pair of materials
  material_id material_a_{}, material_b_{};
  pair_material between_{};
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
