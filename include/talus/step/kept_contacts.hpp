#pragma once
// Contacts of pairs of spheres that are kept from step to step while the same pairs touch: they
// stay in their places in the solver's list, with their impulses, and get new geometry. All numbers
// are those of contacts made anew, to the bit.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "talus/core/plain_vector.hpp"
#include "talus/detect/sphere_batch.hpp"
#include "talus/pairs/shape_pairs.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/solver/contact_list.hpp"
#include "talus/state/solved_velocity.hpp"
#include "talus/state/state.hpp"
#include "talus/step/contact_conditions.hpp"
#include "talus/step/pair_motion.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

template <class Scenario>
using contact_of_spheres =
    moving_contact<law_of<Scenario>, sphere, sphere, solved_scalar<Scenario>>;

/// Whether contacts of pairs of these bodies are kept: on a single rank, of spheres that no other
/// rule concerns. Their list has contacts of no other pairs of shapes.
template <class Scenario, class ShapeA, class ShapeB, partner Partner>
[[nodiscard]] constexpr bool keeps_contacts_of() {
  using state = world_state<Scenario>;
  if constexpr (Partner == partner::moving && std::is_same_v<ShapeA, sphere> &&
                std::is_same_v<ShapeB, sphere> && !state::law::soft) {
    constexpr bool single = []<class... Shapes>(type_list<Shapes...>) {
      return ((Shapes::finite && Shapes::isotropic) + ... + 0) == 1;
    }(typename Scenario::shapes{});
    using list = typename state::template list_of<contact_of_spheres<Scenario>>;
    return single && state::link_type::alone && !state::periodic && !state::continuous &&
           !state::midpoint && !state::has_joints && !state::sleeps && !state::drives &&
           !is_cohesive<typename state::law> && !monitored<Scenario, penetration_monitor> &&
           std::is_same_v<list, contact_list<contact_of_spheres<Scenario>>>;
  } else {
    return false;
  }
}
/// The same of a list of contacts.
template <class Scenario, class List>
[[nodiscard]] constexpr bool keeps_contacts_in() {
  if constexpr (contains_type<typename Scenario::shapes, sphere>)
    if constexpr (keeps_contacts_of<Scenario, sphere, sphere, partner::moving>())
      return std::is_same_v<List, contact_list<contact_of_spheres<Scenario>>>;
  return false;
}

template <class Scenario>
class contact_keeper : shape_pairs<Scenario, sphere, sphere, partner::moving> {
  using base = shape_pairs<Scenario, sphere, sphere, partner::moving>;
  using base::s_, base::a_, base::first_a_;
  using typename base::state_type, typename base::store_a;
  using law = typename state_type::law;
  using contact_type = contact_of_spheres<Scenario>;
  using wide = wide_pack<real>;
  static constexpr unsigned lanes = sphere_batch::capacity;

 public:
  explicit contact_keeper(state_type& s)
      : base(s),
        list_(std::get<contact_list<contact_type>>(s.contacts)),
        kept_(s.found.kept),
        motion_(s, a_, a_) {}

  /// Makes the contacts of this step from all candidate pairs.
  void make_all(plain_vector<close_pair>& pairs) {
    const bool known = kept_.search == s_.found.searches &&
                       kept_.materials == s_.materials.revision() && list_.held() &&
                       s_.history.unchanged();
    const bool moved_before = note_bodies();
    if (known && moved_before && still_apart() && renew(true)) return;
    kept_.search = s_.found.searches, kept_.materials = s_.materials.revision();
    list_.clear();
    find(pairs);
    if (!renew(false)) fail<std::logic_error>("a contact of spheres was found and lost again");
  }

 private:
  /// Writes the spheres for the batches. Returns whether those that can move are the same as
  /// before.
  bool note_bodies() {
    auto& spheres = s_.template of<sphere>().places;
    const auto& reach = s_.template of<sphere>().reach;
    spheres.resize(a_.size());
    bool same = kept_.moves.size() == a_.size();
    kept_.moves.resize(a_.size());
    for (std::size_t i = 0; i < a_.size(); ++i) {
      spheres[i] = {a_.position[i],         reach[i], a_.velocity[i], a_.shape[i].radius,
                    a_.angular_velocity[i], a_.id[i]};
      const char moves = a_.moves(i);
      same = same && kept_.moves[i] == moves;
      kept_.moves[i] = moves;
    }
    spheres_ = spheres.data();
    return same;
  }
  [[nodiscard]] [[gnu::always_inline]] inline unsigned collide(unsigned count) {
    return batch_.collide_in_reach(count, motion_.gravity(), s_.dt, contact_slack);
  }

  /// Whether the pairs without a contact have none now.
  [[nodiscard]] bool still_apart() {
    const auto& apart = kept_.apart;
    for (std::size_t first = 0; first < apart.size(); first += lanes) {
      const auto count = static_cast<unsigned>(std::min<std::size_t>(apart.size() - first, lanes));
      for (unsigned k = 0; k < count; ++k)
        batch_.set(k, spheres_[apart[first + k].first], spheres_[apart[first + k].second]);
      if (collide(count) != 0) return false;
    }
    return true;
  }
  /// Adds the pairs that have a contact to the list.
  void find(plain_vector<close_pair>& pairs) {
    kept_.apart.clear();
    kept_.rebounds = kept_.slides = false;
    plain_pair<std::uint32_t, std::uint32_t> of_lane[lanes];
    for (std::size_t first = 0; first < pairs.size(); first += lanes) {
      const auto count = static_cast<unsigned>(std::min<std::size_t>(pairs.size() - first, lanes));
      for (unsigned k = 0; k < count; ++k) {
        std::size_t i = pairs[first + k].i, j = pairs[first + k].j;
        this->order(i, j);
        of_lane[k] = {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)};
        batch_.set(k, spheres_[i], spheres_[j]);
      }
      const unsigned met = collide(count);
      for (unsigned k = 0; k < count; ++k) {
        const auto [i, j] = of_lane[k];
        history_place& last = pairs[first + k].last;
        const bool moves_a = kept_.moves[i], moves_b = kept_.moves[j];
        if ((met >> k & 1u) != 0 && (moves_a || moves_b)) {
          add(i, j, moves_a, moves_b, last);
        } else {
          last = history_place::none;
          if (moves_a || moves_b) kept_.apart.push_back(of_lane[k]);
        }
      }
    }
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
    list_.add_pair(c, {spheres_[i].id, spheres_[j].id, 0}, moves_a, moves_b, &last);
  }
  /// Sets the data of all contacts, or returns false if one of their pairs has none now.
  [[nodiscard]] bool renew(bool kept) {
    return list_.renew(
        kept, presses(s_),
        [this](const std::int32_t* a, const std::int32_t* b, int count, renewed_contacts& next)
            __attribute__((always_inline)) {
              const auto size = static_cast<unsigned>(count);
              for (unsigned k = 0; k < size; ++k)
                batch_.set(k, spheres_[sphere_of(a[k])], spheres_[sphere_of(b[k])]);
              if (collide(size) != (1u << size) - 1) return false;
              wide pull = every_lane<wide>(motion_.gravity());
              if constexpr (store_a::forced)
                for (unsigned k = 0; k < size; ++k)
                  pull[k] = motion_.pull(sphere_of(a[k]), sphere_of(b[k]));
              const auto conditions = conditions_of_gap<law, wide>(
                  batch_.gap, held_gap<law, wide>(pull, s_.dt), s_.dt, s_.settings.correction);
              next.normal = batch_.normal, next.arm_a = batch_.arm_a, next.arm_b = batch_.arm_b;
              next.target_velocity = conditions.target_velocity;
              next.correction_rate = conditions.correction_rate;
              if (kept_.rebounds || kept_.slides) set_conditions(a, b, size, pull, next);
              return true;
            });
  }
  /// Conditions that depend on the velocities.
  void set_conditions(const std::int32_t* a, const std::int32_t* b, unsigned count,
                      const wide& pull, renewed_contacts& next) {
    next.slides = kept_.slides;
    for (unsigned k = 0; k < count; ++k) {
      const std::size_t i = sphere_of(a[k]), j = sphere_of(b[k]);
      const pair_material& between = materials_of(i, j);
      const bool rebounds = between.restitution > 0 && batch_.approach[k] < -2 * pull[k] * s_.dt;
      next.friction[k] = between.friction;
      if (!rebounds && !(between.dynamic_friction < between.friction)) continue;
      const vec3 normal = lane(batch_.normal, k);
      const auto want = conditions_of<law, uses_substeps<typename Scenario::solver>>(
          between, normal, lane(batch_.velocity, k), batch_.gap[k], s_.dt, pull[k],
          [&] { return motion_.fall(i, j, normal); }, creep(a_.shape[i].radius, s_.dt),
          s_.settings.correction);
      next.target_velocity[k] = want.target_velocity;
      next.correction_rate[k] = want.correction_rate;
      next.friction[k] = want.friction;
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

  contact_list<contact_type>& list_;
  kept_contacts& kept_;
  pair_motion<Scenario, sphere, sphere, true> motion_;
  const moving_sphere* spheres_ = nullptr;
  sphere_batch batch_;
  bool between_known_ = false;  ///< the properties of the last pair of materials
  material_id material_a_{}, material_b_{};
  pair_material between_{};
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
