#pragma once
// From candidate pairs of bodies to the contacts of the solver.
#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "talus/core/plain_vector.hpp"
#include "talus/detect/box_batch.hpp"
#include "talus/detect/sphere_batch.hpp"
#include "talus/detect/usual_pairs.hpp"
#include "talus/features/sleeping/sleeping_islands.hpp"
#include "talus/ghosts/migrate_and_refresh.hpp"
#include "talus/pairs/close_pairs.hpp"
#include "talus/pairs/flush_surface.hpp"
#include "talus/pairs/shape_pairs.hpp"
#include "talus/state/kinematic_bodies.hpp"
#include "talus/state/state.hpp"
#include "talus/step/contact_conditions.hpp"
#include "talus/step/pair_motion.hpp"
#include "talus/step/velocity_bias.hpp"

namespace talus::detail {

/// Whether this rank also searches for the contacts between bodies of other ranks.
template <class Scenario>
[[nodiscard]] bool shares_islands(const world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::islands_across_ranks)
    return s.islands.wants_foreign_contacts() && sees_single_images(s);
  else
    return (void)s, false;
}

/// Converts the contact points of one pair of shapes to contacts of the solver.
template <class Scenario, class ShapeA, class ShapeB, partner Partner>
class contact_maker : shape_pairs<Scenario, ShapeA, ShapeB, Partner> {
  using base = shape_pairs<Scenario, ShapeA, ShapeB, Partner>;
  using base::paired, base::driven, base::imaged;
  using base::position_a, base::position_b, base::pose_a, base::pose_b, base::body_b;
  using base::s_, base::a_, base::b_, base::first_a_, base::first_b_;
  using typename base::body_pair, typename base::state_type;
  using typename base::store_a, typename base::store_b;
  using law = typename state_type::law;
  using number = solved_scalar<Scenario>;
  using wide = wide_pack<real>;
  static constexpr bool batched =
      paired && std::is_same_v<ShapeA, ShapeB> && computed_in_batches<ShapeA>;
  static constexpr bool strikes =
      law::restitution && law::correction && !uses_substeps<typename Scenario::solver>;
  /// Contacts of spheres are computed several at a time, where only their motion counts.
  static constexpr bool packed = paired && std::is_same_v<ShapeA, sphere> &&
                                 std::is_same_v<ShapeB, sphere> && !imaged &&
                                 !state_type::continuous && !is_cohesive<law>;
  template <class A, class B>
  static auto kind() {
    if constexpr (paired)
      return moving_contact<law, A, B, number>{};
    else if constexpr (driven)
      return driven_contact<law, A, number>{};
    else
      return anchored_contact<law, A, number>{};
  }
  using contact_type = decltype(kind<ShapeA, ShapeB>());
  using list_type = typename state_type::template list_of<contact_type>;

 public:
  explicit contact_maker(state_type& s)
      : base(s), list_(std::get<list_type>(s.contacts)), motion_(s, a_, b_) {
    if constexpr (batched) {
      const auto& reach = s.template of<ShapeA>().reach;
      waiting_.places = &s.template of<ShapeA>().places;
      waiting_.places->resize(a_.size());
      for (std::size_t i = 0; i < a_.size(); ++i)
        (*waiting_.places)[i] = place_of<real>(a_.shape[i], a_.pose(i), reach[i]);
    } else if constexpr (packed) {
      const auto& reach = s.template of<ShapeA>().reach;
      waiting_.places = &s.template of<ShapeA>().places;
      waiting_.places->resize(a_.size());
      for (std::size_t i = 0; i < a_.size(); ++i)
        (*waiting_.places)[i] = {a_.position[i],         reach[i],
                                 a_.velocity[i],         a_.shape[i].radius,
                                 a_.angular_velocity[i], a_.id[i]};
    }
  }

  /// The pair (i, j); bodies of one shape in the order of their ids, so that every rank that sees
  /// the pair computes the same.
  void operator()(std::size_t i, std::size_t j, real margin_a, real margin_b) {
    make(i, j, margin_a, margin_b, nullptr);
  }
  /// Adds the contacts of a candidate pair that is kept from step to step; `last` is its place in
  /// the history.
  void operator()(std::size_t i, std::size_t j, real margin_a, real margin_b, history_place& last) {
    make(i, j, margin_a, margin_b, &last);
  }
  /// Adds the contacts of a kept candidate pair, with the reach that the places of the bodies hold.
  void operator()(std::size_t i, std::size_t j, history_place& last) requires(batched) {
    const auto margin = [&](std::size_t k) {
      const auto& at = (*waiting_.places)[k];
      return at.reach - at.radius;
    };
    make(i, j, margin(i), margin(j), &last);
  }
  /// Finds those of `size` kept pairs that are within reach; see pairs/close_pairs.hpp.
  [[nodiscard]] std::size_t find_close(close_pair* pairs, std::size_t size,
                                       std::uint32_t* close) const requires(packed || batched) {
    const auto* const places = waiting_.places->data();
    return detail::find_close(pairs, size, places, places, close);
  }
  /// To be called after the last pair: some pairs wait until a batch is full.
  void finish() requires(packed) {
    const unsigned count = waiting_.count;
    waiting_.count = 0;
    if (count == 0) return;
    const unsigned met = waiting_.batch.collide(count, motion_.gravity(), s_.dt);
    for (unsigned k = 0; k < waiting_.batch.capacity; ++k) {
      const pair_at_hand& x = waiting_.pairs[k < count ? k : 0];
      waiting_.pull[k] = motion_.pull(x.i, x.j);
    }
    waiting_.conditions =
        conditions_of_gap<law, wide>(waiting_.batch.gap, held_gap<law, wide>(waiting_.pull, s_.dt),
                                     s_.dt, s_.settings.correction);
    if constexpr (state_type::midpoint)
      waiting_.bias = biases_of<law::friction>(waiting_.batch, waiting_.pull, s_.dt);
    for (unsigned k = 0; k < count; ++k) {
      pair_at_hand& x = waiting_.pairs[k];
      if (met >> k & 1u) add_lane(x, k);
      drop_unless_made(x);
    }
  }
  void finish() requires(batched) {
    const unsigned count = waiting_.count;
    waiting_.count = 0;
    if (count == 0) return;
    const unsigned near = waiting_.batch.search(count), single = waiting_.batch.uncertain();
    for (unsigned k = 0; k < count; ++k) {
      pair_at_hand& x = waiting_.pairs[k];
      const auto add_point = [&](const contact_geometry& g) { add(x, g); };
      if (single >> k & 1u)
        collide_pair(a_.shape[x.i], pose_a(x), b_.shape[x.j], pose_b(x), x.margin, add_point);
      else if (near >> k & 1u)
        collide_lane(place_a(x), place_b(x), waiting_.batch, k, x.margin, contact_sink(add_point));
      drop_unless_made(x);
    }
  }

 private:
  /// A global body in the solver's arrays, for contacts with this normal.
  struct met_body {
    std::int32_t number = -1;
    vec3 normal{0, 0, 0};
  };
  struct nothing_met {};
  struct pair_at_hand : body_pair {
    real margin = 0;
    real radius = 0;  ///< of a
    real slack = 0;   ///< a contact with a larger gap must be about to close
    history_place* last = nullptr;
    bool boundary = false, foreign = false;
    bool made = false;  ///< a contact that may get an impulse
    path paths = path::unknown;
    [[no_unique_address]] std::conditional_t<driven, met_body, nothing_met> met{};
  };
  template <class Batch>
  struct waiting_pairs {
    using place = typename Batch::place;
    plain_vector<place>* places = nullptr;  ///< of all bodies of this shape
    Batch batch;
    std::array<pair_at_hand, Batch::capacity> pairs;
    unsigned count = 0;
    /// The two bodies of each pair, where they are for this pair.
    [[no_unique_address]] std::conditional_t<
        imaged, std::array<std::array<place, 2>, Batch::capacity>, nothing_met>
        images;
  };
  /// Pairs of spheres, and the properties of the last pair of materials.
  struct waiting_spheres {
    plain_vector<moving_sphere>* places = nullptr;  ///< of all spheres
    sphere_batch batch;
    std::array<pair_at_hand, sphere_batch::capacity> pairs;
    unsigned count = 0;
    wide pull;
    pack_vector<wide> bias;  ///< with the midpoint
    gap_conditions<wide> conditions;
    bool known = false;
    material_id material_a{}, material_b{};
    pair_material between{};
  };
  struct none_wait {};
  struct earlier_pair {
    std::size_t i = ~std::size_t{0}, j = 0;
    earlier_contacts points;
  };
  struct no_earlier_pair {};

  static void drop_unless_made(const pair_at_hand& x) {
    if (!x.made && x.last != nullptr) *x.last = history_place::none;
  }

  /// A pair that waits is written to its lane at once: copies of it would wait for the stores of
  /// its parts.
  [[nodiscard]] pair_at_hand& place_of_next([[maybe_unused]] pair_at_hand& local) {
    if constexpr (packed || batched)
      return waiting_.pairs[waiting_.count];
    else
      return local;
  }

  void make(std::size_t i, std::size_t j, real margin_a, real margin_b, history_place* last) {
    if (this->order(i, j)) std::swap(margin_a, margin_b);
    [[maybe_unused]] pair_at_hand local;
    pair_at_hand& x = place_of_next(local);
    x.i = i, x.j = j, x.last = last, x.made = false, x.paths = path::unknown;
    if constexpr (state_type::has_joints)
      if (s_.joints.joined(a_.id[i], b_.id[j])) return drop_unless_made(x);
    if (!this->find(x)) return drop_unless_made(x);
    if constexpr (store_a::sleeps)
      if (meet_sleeper(s_, a_, i, b_, j)) return drop_unless_made(x);
    if constexpr (paired && !state_type::link_type::alone)
      if (s_.strangers && !x.own_a && !x.own_b)
        require_acquainted<Scenario, ShapeA, ShapeB>(s_, i, j,
                                                     s_.by_colours() ? margin_a + margin_b : 0);
    x.foreign = !x.acts_here();
    if (x.foreign && !(shares_islands(s_) && (x.moves_a || x.moves_b))) return drop_unless_made(x);
    x.boundary = x.crosses_ranks();
    if (x.boundary && !this->known_to_both(x)) return drop_unless_made(x);

    x.radius = radius_of(a_, i);
    x.slack = contact_slack * x.radius;
    x.margin = margin_a + margin_b;
    // Ranks know different sleepers ahead, but agree on contacts.
    if constexpr (store_a::sleeps && !state_type::continuous)
      x.margin = motion_.margin_in_step(i, j);
    if constexpr (ShapeB::finite) {
      // For a large body beside a small one, both use the slack of the small one.
      const real other = radius_of(b_, j);
      const real excess = contact_slack * std::abs(x.radius - other);
      x.slack += contact_slack * other - excess;
      x.margin -= excess;
    } else if constexpr (driven) {
      x.margin += way_of_plane(b_, j, a_.position[i], s_.dt);
    }
    if constexpr (batched) {
      const unsigned lane = waiting_.count++;
      if constexpr (imaged) {
        auto& [at_a, at_b] = waiting_.images[lane];
        at_a = place_a(x), at_b = place_b(x);
        waiting_.batch.set(lane, at_a, at_b, x.margin);
      } else {
        waiting_.batch.set(lane, place_a(x), place_b(x), x.margin);
      }
      if (waiting_.count == waiting_.batch.capacity) finish();
      return;
    } else if constexpr (packed) {
      const unsigned lane = waiting_.count++;
      const auto& spheres = *waiting_.places;
      waiting_.batch.set(lane, spheres[i], spheres[j], x.margin, x.slack);
      if (waiting_.count == waiting_.batch.capacity) finish();
      return;
    } else if constexpr (ShapeA::isotropic && ShapeB::isotropic &&
                         !(driven && state_type::continuous)) {  // a single point
      collide_pair(
          a_.shape[i], pose_a(x), b_.shape[j], pose_b(x),
          x.margin, [&](const contact_geometry& g) __attribute__((always_inline)) { add(x, g); });
    } else {
      if constexpr (driven && state_type::continuous)
        if (const real t = time_to_meeting(x); t != 0) {
          const auto& [shape, place] = global_before<ShapeB>(b_, j, -t);
          collide_pair(a_.shape[i], pose_a(x), shape, place, x.margin,
                       [&](const contact_geometry& g) { add(x, g); });
          return drop_unless_made(x);
        }
      collide_pair(a_.shape[i], pose_a(x), this->shape_b(i, j), pose_b(x), x.margin,
                   [&](const contact_geometry& g) { add(x, g); });
    }
    drop_unless_made(x);
  }

  /// If bodies are followed: the time from the present poses until a body at its impact meets a
  /// driven one, which moves on until then; 0 for all others.
  [[nodiscard]] real time_to_meeting(const pair_at_hand& x) const {
    if constexpr (driven && state_type::continuous)
      if (const real t = s_.impacts.time[first_a_ + x.i];
          t != never && going_body<ShapeB>(s_, x.j) != nullptr)
        return t - time_of_poses(s_);
    return (void)x, 0;
  }
  /// The reference point of a global body for a contact with it.
  [[nodiscard]] vec3 reference_of(const pair_at_hand& x) const {
    if constexpr (driven && state_type::continuous)
      return b_.position[x.j] + time_to_meeting(x) * b_.velocity[x.j];
    else
      return b_.position[x.j];
  }

  /// One of their contact points.
  [[gnu::always_inline]] void add(pair_at_hand& x, const contact_geometry& g) {
    const std::size_t i = x.i, j = x.j;
    if (is_hidden<ShapeA, ShapeB, paired>(s_, a_, i, position_a(x), b_, j, position_b(x), g))
      return;
    vec3 arm_a = g.point - position_a(x);
    // The forces must share a line only if both bodies move; for something immovable the contact
    // point is on its surface.
    if constexpr (!paired) arm_a += (0.5 * g.gap) * g.normal;
    vec3 arm_b{0, 0, 0}, v_b{0, 0, 0};
    vec3 u = a_.velocity[i] + a_.angular_velocity[i].cross(arm_a);
    if constexpr (paired) {
      arm_b = g.point - position_b(x);
      u -= b_.velocity[j] + b_.angular_velocity[j].cross(arm_b);
    } else if constexpr (driven) {
      const vec3 at = reference_of(x);
      arm_b = g.point - (0.5 * g.gap) * g.normal - at;
      v_b = b_.velocity[j];
      if constexpr (!state_type::midpoint)
        v_b += along_chord(b_.angular_velocity[j], a_.position[i] - at, g.normal, s_.dt);
      u -= v_b + b_.angular_velocity[j].cross(arm_b);
    }
    const auto material = [&] { return s_.materials.pair(a_.material[i], b_.material[j]); };
    if constexpr (state_type::continuous) {
      if (motion_.not_met(i, j, g.gap, material())) return;
      motion_.add_flight(u, i, j);
    }
    if (motion_.parts_before_touching(i, j, x.radius, x.slack, g, u)) return;
    real pulled = motion_.pull(i, j);
    const bool passing = passes(x, g, g.normal.dot(u), pulled);
    if constexpr (monitored<Scenario, penetration_monitor>)
      if (!x.foreign && (!x.boundary || x.own_a)) s_.monitors.overlaps.add(g.gap);
    contact_type c;
    c.a = static_cast<std::int32_t>(first_a_ + i);
    if constexpr (paired) {
      c.b = static_cast<std::int32_t>(first_b_ + body_b(x));
    } else if constexpr (driven) {
      pulled += change_of_global<ShapeB>(s_, j, arm_b).norm() / s_.dt;
      meet_global(c, x, g.normal, v_b, arm_b);
    }
    if constexpr (!paired && !driven)
      arm_b = g.point - b_.position[j];  // see grounded_contacts.hpp
    place(c, g, arm_a, arm_b);
    if constexpr (state_type::midpoint) {
      c.bias = motion_.strikes(i, j) ? vec3(0, 0, 0) : bias_of(x, g, u, pulled);
      u += g.normal.dot(c.bias) * g.normal;  // the rest may be an impact
    }
    auto want = conditions_of<law, uses_substeps<typename Scenario::solver>>(
        material(), g.normal, u, g.gap, s_.dt, pulled, [&] { return motion_.fall(i, j, g.normal); },
        creep(x.radius, s_.dt), s_.settings.correction);
    if constexpr (strikes)
      if (s_.solver.finishes) let_part(want, g.normal.dot(u));
    if (passing) let_pass(want, g.gap, g.normal.dot(u), pulled);
    const real rebound = want.target_velocity;
    if constexpr (state_type::continuous) {
      motion_.add_flight_after(want.target_velocity, i, j, g.normal);
      if (want.target_velocity != rebound) want.restitution = 0;  // one at its impact
    }
    s_.solver.impacts = s_.solver.impacts || rebound > 0;
    if constexpr (state_type::midpoint)
      if (!motion_.strikes(i, j)) end_bias(x, c, want, g.normal);
    set_conditions(c, want);
    const contact_key key{a_.id[i], b_.id[j], g.feature};
    if constexpr (is_cohesive<law>)
      if (!x.foreign && g.gap <= std::max(x.slack, pulled * s_.dt * s_.dt))
        if (const real force = material().cohesion; force > 0) {
          std::int32_t b = -1;
          if constexpr (contact_type::paired) b = c.b;
          s_.attraction.add({key, c.a, b, force, g.normal, arm_a, arm_b});
        }
    add_to_list(x, c, key);
  }
  /// Whether the surfaces of a contact with such a gap pass each other in this step.
  [[nodiscard]] bool passes(pair_at_hand& x, const contact_geometry& g, real un, real pull) const {
    const vec3 &at_a = position_a(x), &at_b = position_b(x);
    if (!motion_.may_pass(x.i, x.j, at_a, at_b, x.slack, g.normal, g.gap, un, pull)) return false;
    if (x.paths == path::unknown)
      x.paths = motion_.path_by_contact(x.i, x.j, at_a, at_b, x.slack, g);
    if (x.paths == path::unknown)
      x.paths = motion_.meet_on_paths(x.i, x.j, at_a, at_b, x.slack) ? path::meet : path::pass;
    return x.paths == path::pass;
  }
  void let_pass(contact_conditions& want, real gap, real un, real pull) const {
    want.target_velocity = want.limit = passing_velocity(gap, un, pull, s_.dt);
    want.slowest = slowest_impact(want.limit, want.restitution, pull, s_.dt);
  }
  /// What moves at the end of the step has no bias, but half of the fall.
  void end_bias(const pair_at_hand& x, contact_type& c, contact_conditions& want,
                const vec3& normal) const {
    if (want.target_velocity != 0) c.bias = {0, 0, 0};
    if constexpr (strikes)
      if (want.restitution > 0)
        c.bias -= reflect_in_the_middle(want, motion_.fall(x.i, x.j, normal), s_.dt) * normal;
  }
  static void set_conditions(contact_type& c, const contact_conditions& want) {
    c.target_velocity = static_cast<decltype(c.target_velocity)>(want.target_velocity);
    c.correction_rate = static_cast<decltype(c.correction_rate)>(want.correction_rate);
    if constexpr (law::restitution) {
      c.restitution = static_cast<decltype(c.restitution)>(want.restitution);
      c.limit = static_cast<decltype(c.limit)>(want.limit);
      c.slowest = static_cast<decltype(c.slowest)>(want.slowest);
    }
    if constexpr (law::friction) c.friction = static_cast<decltype(c.friction)>(want.friction);
  }
  [[gnu::always_inline]] void add_to_list(pair_at_hand& x, const contact_type& c,
                                          const contact_key& key) {
    if constexpr (state_type::islands_across_ranks)
      if (x.foreign) return list_.add_foreign(c, key);
    x.made = true;
    if (x.boundary)
      list_.add_boundary(c, key, x.own_a, x.last);
    else
      list_.add(c, key, x.moves_a, x.moves_b || moves_too(c.b), x.last, at_border(x));
  }

  /// The contact of a pair of spheres that has been computed in lane k.
  [[gnu::always_inline]] void add_lane(pair_at_hand& x, unsigned k) requires(packed) {
    const sphere_batch& of = waiting_.batch;
    const real gap = of.gap[k];
    if constexpr (monitored<Scenario, penetration_monitor>)
      if (!x.foreign && (!x.boundary || x.own_a)) s_.monitors.overlaps.add(gap);
    contact_type c;
    c.a = static_cast<std::int32_t>(first_a_ + x.i);
    c.b = static_cast<std::int32_t>(first_b_ + x.j);
    const vec3 normal = lane(of.normal, k);
    c.normal = in_scalar<number>(normal);
    if constexpr (law::friction) {
      c.arm_a = static_cast<number>(of.arm_a[k]);
      c.arm_b = static_cast<number>(of.arm_b[k]);
    }
    const pair_material& between = materials_of(x);
    const real pull = waiting_.pull[k];
    vec3 u = lane(of.velocity, k);
    real un = of.approach[k];
    const bool passing = (of.apart >> k & 1u) && passes(x, {normal, {}, gap, 0}, un, pull);
    if constexpr (state_type::midpoint) {
      c.bias = lane(waiting_.bias, k);
      u += normal.dot(c.bias) * normal;  // the rest may be an impact
      un = normal.dot(u);
    }
    const bool fast = between.restitution > 0 && (un < -2 * pull * s_.dt || s_.solver.finishes);
    contact_conditions want;
    if (fast || passing || between.dynamic_friction < between.friction) [[unlikely]] {
      want = conditions_of<law, uses_substeps<typename Scenario::solver>>(
          between, normal, u, gap, s_.dt, pull, [&] { return motion_.fall(x.i, x.j, normal); },
          creep(x.radius, s_.dt), s_.settings.correction);
      if (strikes && s_.solver.finishes) let_part(want, un);
      if (passing) let_pass(want, gap, un, pull);
      s_.solver.impacts = s_.solver.impacts || want.target_velocity > 0;
    } else {
      const real limit = waiting_.conditions.target_velocity[k];
      want = {.target_velocity = limit,
              .correction_rate = waiting_.conditions.correction_rate[k],
              .friction = between.friction,
              .restitution = strikes ? between.restitution : 0,
              .limit = limit,
              .slowest = slowest_impact(limit, between.restitution, pull, s_.dt)};
    }
    if constexpr (state_type::midpoint) end_bias(x, c, want, normal);
    set_conditions(c, want);
    add_to_list(x, c, {(*waiting_.places)[x.i].id, (*waiting_.places)[x.j].id, 0});
  }
  [[nodiscard]] const pair_material& materials_of(const pair_at_hand& x) requires(packed) {
    const material_id a = a_.material[x.i], b = b_.material[x.j];
    if (!waiting_.known || a != waiting_.material_a || b != waiting_.material_b) {
      waiting_.known = true, waiting_.material_a = a, waiting_.material_b = b;
      waiting_.between = s_.materials.pair(a, b);
    }
    return waiting_.between;
  }

  /// The relative velocity of a lasting contact at the end of the step; see velocity_bias.hpp.
  vec3 bias_of(const pair_at_hand& x, const contact_geometry& g, const vec3& u, real pulled) {
    const real held = std::max(pulled * s_.dt * s_.dt, x.slack);
    if (g.gap > held || turns_slowly(x, pulled)) return {0, 0, 0};
    if (earlier_.i != x.i || earlier_.j != x.j) find_earlier(x);
    const contact_geometry* last = earlier_.points.find(g.feature);
    if (last == nullptr || last->gap > held) return {0, 0, 0};
    const auto& [position_a, v_a, w_a] = earlier_.points.a;
    const auto& [position_b, v_b, w_b] = earlier_.points.b;
    vec3 arm = last->point - position_a;
    if constexpr (!paired) arm += (0.5 * last->gap) * last->normal;
    vec3 before = v_a + w_a.cross(arm);
    if constexpr (paired)
      before -= v_b + w_b.cross(last->point - position_b);
    else if constexpr (driven)
      before -= v_b + w_b.cross(last->point - (0.5 * last->gap) * last->normal - position_b);
    vec3 bias = midpoint_bias<real>(g.normal, u, last->normal, before);
    if constexpr (!law::friction) bias = g.normal.dot(bias) * g.normal;
    return bias;
  }
  /// Whether a bias would compensate too little to matter.
  [[nodiscard]] bool turns_slowly(const pair_at_hand& x, real pulled) const {
    vec3 v = a_.velocity[x.i];
    real speed = x.radius * a_.angular_velocity[x.i].norm(), radius = x.radius;
    if constexpr (paired) {
      const real other = b_.shape[x.j].bounding_radius();
      v -= b_.velocity[x.j];
      speed += other * b_.angular_velocity[x.j].norm();
      radius = std::min(radius, other);
    } else if constexpr (driven) {
      if (driven_at<ShapeB>(s_, x.j) != nullptr) return false;
    }
    speed += v.norm();
    return speed * speed < slow_turn<real>(pulled, radius);
  }
  /// Finds the contact points in the middle of the last step.
  void find_earlier(const pair_at_hand& x) {
    earlier_.i = x.i, earlier_.j = x.j;
    auto& points = earlier_.points;
    points.clear();
    auto& s = s_;
    const auto before = [&]<class Shape>(const auto& store, std::size_t i, const vec3& at,
                                         earlier_contacts::side& side, const Shape&) {
      side = {at - s.dt * store.velocity[i], store.velocity[i], store.angular_velocity[i]};
      pose p{side.position, store.pose(i).orientation};
      if constexpr (std::remove_cvref_t<decltype(store)>::tensor) {
        earlier_turn& last =
            s.midpoints.earlier[index_of<typename state_type::finite_shapes, Shape>][i];
        if (!last.known) find_earlier_turn(last, store, i, s.dt);
        p.orientation = last.orientation, side.w = last.spin;
      }
      return p;
    };
    const auto add = [&](const contact_geometry& g) { points.add(g); };
    const pose a = before(a_, x.i, position_a(x), points.a, a_.shape[x.i]);
    if constexpr (paired) {
      const pose b = before(b_, x.j, position_b(x), points.b, b_.shape[x.j]);
      collide_pair(a_.shape[x.i], a, b_.shape[x.j], b, x.margin, add);
    } else {
      points.b = {b_.position[x.j], {0, 0, 0}, {0, 0, 0}};
      if constexpr (driven)
        if (const driven_body* one = driven_at<ShapeB>(s_, x.j); one != nullptr) {
          const bool goes = !(one->next.end == one->state.at);
          const auto& [shape, b] = global_before<ShapeB>(b_, x.j, goes ? s_.dt : real(0));
          points.b = {b.position, b_.velocity[x.j] - one->dv, b_.angular_velocity[x.j] - one->dw};
          return collide_pair(a_.shape[x.i], a, shape, b, x.margin, add);
        }
      collide_pair(a_.shape[x.i], a, b_.shape[x.j], b_.pose(x.j), x.margin, add);
    }
  }

  template <class Store>
  [[nodiscard]] real radius_of(const Store& store, std::size_t i) const {
    if constexpr (batched)
      return (void)store, (*waiting_.places)[i].radius;
    else
      return store.shape[i].bounding_radius();
  }
  [[nodiscard]] decltype(auto) place_a(const pair_at_hand& x) const {
    return place_at(x.i, position_a(x));
  }
  [[nodiscard]] decltype(auto) place_b(const pair_at_hand& x) const {
    return place_at(x.j, position_b(x));
  }
  /// A body of the two, there.
  [[nodiscard]] decltype(auto) place_at(std::size_t i, const vec3& there) const {
    if constexpr (imaged) {
      auto place = (*waiting_.places)[i];
      place.position = there;
      return place;
    } else {
      return (void)there, ((*waiting_.places)[i]);
    }
  }
  /// Whether the second body of a contact is a part of a servo.
  [[nodiscard]] bool moves_too(std::int32_t b) const {
    if constexpr (driven)
      return s_.solver.bodies[static_cast<std::size_t>(b)].inverse_mass != 0;
    else
      return (void)b, false;
  }
  /// Sets the second body of a contact with a global body that may move. For isotropic bodies its
  /// surface does not rotate.
  void meet_global(contact_type& c, pair_at_hand& x, const vec3& normal, const vec3& v_b,
                   vec3& arm_b) {
    vec3 v = v_b, w = b_.angular_velocity[x.j];
    if constexpr (ShapeA::isotropic) {
      v += w.cross(arm_b);
      w = arm_b = {0, 0, 0};
      x.met.number = -1;
    } else if (!(normal == x.met.normal)) {
      x.met = {-1, normal};
    }
    c.b = x.met.number =
        number_of_global<ShapeB>(s_, x.j, v, w, x.met.number, a_.inverse_mass[x.i]);
  }

  /// Whether other ranks get the velocity of one of them that this contact changes.
  bool at_border(const pair_at_hand& x) const {
    if constexpr (state_type::link_type::alone)
      return (void)x, false;
    else
      return !s_.at_border.empty() && ((x.moves_a && s_.at_border[first_a_ + x.i]) ||
                                       (x.moves_b && s_.at_border[first_b_ + body_b(x)]));
  }
  static void place(contact_type& c, const contact_geometry& g, const vec3& arm_a,
                    const vec3& arm_b) {
    if constexpr (requires { c.r; }) {  // a general contact
      c.normal = g.normal;
      c.arm_a = arm_a;
      c.arm_b = arm_b;
    } else {
      c.normal = in_scalar<number>(g.normal);
      if constexpr (law::friction) {
        c.arm_a = static_cast<number>(-g.normal.dot(arm_a));
        c.arm_b = static_cast<number>(g.normal.dot(arm_b));
      }
    }
  }

  list_type& list_;
  pair_motion<Scenario, ShapeA, ShapeB, paired> motion_;
  static auto waiting() {
    if constexpr (batched)
      return std::type_identity<waiting_pairs<typename batch_of<ShapeA>::type>>{};
    else
      return std::type_identity<std::conditional_t<packed, waiting_spheres, none_wait>>{};
  }
  [[no_unique_address]] typename decltype(waiting())::type waiting_;
  [[no_unique_address]] std::conditional_t<state_type::midpoint, earlier_pair, no_earlier_pair>
      earlier_;
};

}  // namespace talus::detail
