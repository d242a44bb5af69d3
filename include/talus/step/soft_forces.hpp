#pragma once
// The forces of the soft contacts of one pair of shapes. Each rank computes every contact of a body
// it owns, from the same data as the other rank that sees it and in the same order of the two
// bodies: no forces travel, and momentum is conserved to round-off.
#include <algorithm>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

#include "talus/features/driven/servo.hpp"
#include "talus/features/energy_ledger/soft_ledger.hpp"
#include "talus/interaction/composed_law.hpp"
#include "talus/interaction/local_curvature.hpp"
#include "talus/interaction/pair_kinematics.hpp"
#include "talus/pairs/flush_corners.hpp"
#include "talus/pairs/flush_surface.hpp"
#include "talus/pairs/neighbour_list.hpp"
#include "talus/pairs/shape_pairs.hpp"
#include "talus/state/state.hpp"
#include "talus/step/passing_contacts.hpp"

namespace talus::detail {

/// The forces of the contact points of one pair of shapes: added up, with the springs advanced by a
/// step; or, with an observer, only passed to it, for the present state.
template <class Scenario, class ShapeA, class ShapeB, partner Partner, class Observer>
class force_adder : shape_pairs<Scenario, ShapeA, ShapeB, Partner> {
  using base = shape_pairs<Scenario, ShapeA, ShapeB, Partner>;
  using base::paired;
  using base::position_a, base::position_b, base::pose_a, base::pose_b, base::body_b;
  using base::s_, base::a_, base::b_, base::first_a_, base::first_b_;
  using typename base::body_pair, typename base::state_type;
  using law = typename state_type::law::law;
  static constexpr bool observed = !std::is_null_pointer_v<Observer>;
  /// An observer of energies only.
  static constexpr bool surveyed = std::is_same_v<Observer, spring_energies>;
  /// An observer that takes the geometry of the contact.
  static constexpr bool watches_geometry =
      requires(Observer & o, const contact_key& k, const contact_geometry& g, const vec3& f) {
    o(k, g, f, true);
  };
  /// An observer that takes the point of the force, and both centres as seen from body a.
  static constexpr bool watches_loads =
      requires(Observer & o, const contact_key& k, const vec3& p, const pair_force& f) {
    o(k, p, p, p, f, true);
  };
  static constexpr bool remembers = state_type::law::remembers;
  /// Whether contacts may pass from triangle to triangle.
  static constexpr bool passing =
      remembers && ShapeB::finite && is_triangulated<ShapeA> != is_triangulated<ShapeB>;
  /// Whether contacts may pass from one fixed body to another, flush beside it.
  static constexpr bool crossing =
      remembers && may_be_on_flush_surface<Scenario, ShapeA, ShapeB, paired>;
  /// Whether fixed bodies may lie flush beside each other under a body.
  static constexpr bool seams = may_cross_seams<Scenario, ShapeB, ShapeA> ||
                                (paired && may_cross_seams<Scenario, ShapeA, ShapeB>);
  /// Whether the force rotates a body of this shape.
  template <class Shape>
  static constexpr bool turns = !law::central || !Shape::isotropic;
  static constexpr bool booked = !observed && monitored<Scenario, energy_ledger>;
  static constexpr bool balanced = !observed && monitored<Scenario, momentum_balance>;
  static constexpr bool residual = !observed && monitored<Scenario, residual_monitor>;

 public:
  static constexpr bool only_reads_places = surveyed;

  force_adder(state_type& s, Observer& observer) : base(s), observer_(observer) {}

  void operator()(std::size_t i, std::size_t j, real, real) {
    history_place last = history_place::unknown;
    meet(i, j, last);
  }
  /// Adds the forces of a candidate pair that is kept from step to step; `last` is its place in the
  /// history.
  void operator()(std::size_t i, std::size_t j, real, real, history_place& last) {
    history_place read = last;
    if constexpr (surveyed)
      meet(i, j, read);
    else if constexpr (observed)
      (*this)(i, j, 0, 0);
    else
      meet(i, j, last);
  }
  /// Loads what a pair that follows soon needs.
  [[gnu::always_inline]] inline void prefetch(const close_pair& pair) const {
    const auto load = [](const soft_body& body) {
      const char* const line = reinterpret_cast<const char*>(&body);
      __builtin_prefetch(line, 1), __builtin_prefetch(line + 64, 1);
    };
    load(s_.soft.bodies[first_a_ + pair.i]);
    if constexpr (paired) load(s_.soft.bodies[first_b_ + pair.j]);
    if constexpr (remembers) s_.history.prefetch(pair.last);
  }

 private:
  using memory_type = typename law::memory;
  using kept = typename state_type::history_type::memory;
  struct none_pass {};

  /// `last` is the place of the memories of the last step, and becomes the place of the new ones.
  [[gnu::always_inline]] inline void meet(std::size_t i, std::size_t j, history_place& last) {
    this->order(i, j);
    // A pair that another rank alone computes is looked up by its key when it acts here.
    const history_place before = std::exchange(last, history_place::unknown);
    body_pair x;
    x.i = i, x.j = j;
    if (!this->find(x)) return;
    if constexpr (paired && !state_type::link_type::alone)
      if (s_.strangers && !x.own_a && !x.own_b)
        require_acquainted<Scenario, ShapeA, ShapeB>(s_, i, j);
    if (!x.acts_here()) return;
    const bool boundary = x.crosses_ranks();
    const real range = range_of(x);
    last = history_place::none;
    const auto key_of = [&](const contact_geometry& g) {
      return contact_key{a_.id[i], b_.id[j], g.feature};
    };
    const auto take = [&](const contact_geometry& g, const auto& old)
        __attribute__((always_inline)) {
      const contact_key key = key_of(g);
      const bool counts = x.own_a || !boundary;
      const pair_force f = add(x, g, key, counts, old, last);
      if constexpr (surveyed) {
      } else if constexpr (watches_geometry) {
        observer_(key, g, f.force, counts);
      } else if constexpr (watches_loads) {
        const real inwards = depth_of_point(x, g);
        observer_(key, vec3(g.point + inwards * g.normal), position_a(x), position_b(x), f, counts);
      } else if constexpr (observed) {
        observer_(key, f.force, x.own_a || !x.moves_a, x.own_b || !x.moves_b);
      } else {
        if (law::reaches && g.gap >= 0 && is_zero(f)) return;
        if constexpr (residual) {
          if (counts) s_.soft.squares_of_forces += f.force.squaredNorm();
          s_.soft.bodies[first_a_ + x.i].contacts += 1;
          if constexpr (paired) s_.soft.bodies[first_b_ + body_b(x)].contacts += 1;
        }
        auto& count = std::get<soft_contacts>(s_.contacts);
        ++(counts ? count.here : count.doubled);
        if constexpr (monitored<Scenario, penetration_monitor>)
          if (counts) s_.monitors.overlaps.add(g.gap);
      }
    };
    const auto accept = [&](const contact_geometry& g, const auto& add_force)
        __attribute__((always_inline)) {
      const auto former = [&]() -> const kept* {
        const kept* old = nullptr;
        if constexpr (remembers) old = s_.history.former(before, key_of(g));
        if constexpr (crossing)
          if (old == nullptr && s_.flush.any() && (!passing || before == history_place::none))
              [[unlikely]]
            return of_body_beside(x, g);
        return old;
      };
      if constexpr (passing) {
        const kept* const old = former();
        if (passing_.stays(g, old != nullptr || before == history_place::none))
          add_force(g, [=] { return old; });
      } else {
        add_force(g, former);
      }
    };
    if constexpr (passing) passing_.begin();
    collide_pair(
        a_.shape[i], pose_a(x), this->shape_b(i, j), pose_b(x),
        range, [&](const contact_geometry& g) __attribute__((always_inline)) {
          if (!(g.gap < range)) return;
          if (is_hidden<ShapeA, ShapeB, paired>(s_, a_, i, position_a(x), b_, j, position_b(x), g))
            return;
          if (boundary && !this->known_to_both(x)) {
            last = history_place::unknown;
            return;
          }
          if constexpr (seams)
            if (s_.flush.any()) [[unlikely]]
              return add_to_area(g);
          accept(g, take);
        });
    // Not compiled into the loop over contacts.
    const auto take_later = [&](const contact_geometry& g, const auto& old)
        __attribute__((noinline)) {
      take(g, old);
    };
    if constexpr (seams)
      if (!area_.empty()) [[unlikely]] {
        leave_corners<ShapeA, ShapeB, paired>(s_, a_, i, pose_a(x), b_, j, pose_b(x), range, area_);
        for (const contact_geometry& g : area_) accept(g, take_later);
        area_.clear();
      }
    if constexpr (passing)
      for (const contact_geometry& g : passing_.others()) {
        const auto former = [&](const auto& mesh, const pose& at, real side, const auto& other) {
          return passing_.former(s_.history, before, key_of(g), mesh.tree(),
                                 at.to_body(g.point + side * g.gap * g.normal),
                                 other.bounding_radius());
        };
        take_later(g, [&] {
          const kept* old = nullptr;
          if constexpr (is_triangulated<ShapeA>)
            old = former(a_.shape[i], pose_a(x), 0.5, b_.shape[j]);
          else
            old = former(b_.shape[j], pose_b(x), -0.5, a_.shape[i]);
          if constexpr (crossing)
            if (old == nullptr && s_.flush.any()) return of_body_beside(x, g);
          return old;
        });
      }
  }
  static constexpr std::uint64_t part_of_union = 0x0000ffff00000000;
  /// The bits of features that name the part of body a, or of body b.
  [[nodiscard]] static constexpr std::uint64_t parts_of(bool a) {
    if constexpr (is_block<ShapeA> && is_block<ShapeB>)
      return a ? 0x3f : 0xfc0;
    else if constexpr (is_triangulated<ShapeA> || is_triangulated<ShapeB>)
      return 0xffff0000;
    else  // (The first shape of the pair function comes first in the feature.)
      return a == collides_in_order<ShapeA, ShapeB> ? 0xffff : 0xffff0000;
  }
  /// How far beside a body the contact of a sphere may go on, as a part of the radius of the
  /// sphere.
  static constexpr real beside_part = 0.1;
  [[nodiscard]] real bounding_radius_b(const body_pair& x) const {
    if constexpr (paired)
      return b_.shape[x.j].bounding_radius();
    else
      return (void)x, 0;
  }
  /// At most how fast the contact of a body moves over a fixed one: of the body, whose corners are
  /// within `radius`, and of the fixed one if that is driven.
  [[nodiscard]] real speed_beside(const body_pair& x, const contact_geometry& g, bool on_b,
                                  real radius) const {
    vec3 v(0, 0, 0), w = v;
    if constexpr (paired) {
      if (!on_b) v = b_.velocity[body_b(x)], w = b_.angular_velocity[body_b(x)];
    }
    if (on_b) v = a_.velocity[x.i], w = a_.angular_velocity[x.i];
    if constexpr (state_type::drives && !paired)
      v -= surface_velocity_of(x.j, vec3(g.point - b_.position[x.j]));
    return (void)g, v.norm() + radius * w.norm();
  }
  /// The springs of the contact of the last step that goes on here, with a fixed body beside the
  /// one it was with; null for a new contact.
  [[nodiscard, gnu::noinline]] const kept* of_body_beside(const body_pair& x,
                                                          const contact_geometry& g) {
    const bool on_b = !paired || b_.inverse_mass[x.j] == 0;
    const system_id own = on_b ? a_.id[x.i] : b_.id[x.j];
    const bool round = on_b ? ShapeA::isotropic : ShapeB::isotropic;
    const real radius = on_b ? a_.shape[x.i].bounding_radius() : bounding_radius_b(x);
    const real way = s_.dt * speed_beside(x, g, on_b, round ? 0 : radius);
    // The only contact of a sphere with a surface, however far the bodies have moved since.
    const real reach = round ? std::max(way, beside_part * radius) : way;
    const auto of_own = parts_of(on_b);
    using entry = typename state_type::history_type::entry;
    const entry* found = nullptr;
    bool found_same = false;
    system_id found_at = no_id;
    const auto look = [&](auto& surface, std::uint32_t number) {
      surface.each_beside(number, way, reach, [&](system_id beside) {
        const entry* one = nullptr;
        int count = 0;
        bool same = false;
        const auto take = [&](const auto& e) {
          const auto differ = e.key.feature ^ g.feature;
          if ((differ & part_of_union) != 0) return;
          if (++count == 1 || (!same && (differ & of_own) == 0)) one = &e;
          same = same || (differ & of_own) == 0;
        };
        s_.history.each_of_pair({own, beside, 0}, take);
        s_.history.each_of_pair({beside, own, 0}, take);
        if (count == 0 || (round && count > 1) || law::is_intact(one->memory)) return;
        // (Ranks hold the bodies in different orders.)
        if (found == nullptr || same > found_same || (same == found_same && beside < found_at))
          found = one, found_same = same, found_at = beside;
      });
    };
    on_flush_surface<ShapeA, ShapeB, paired>(s_, a_, x.i, position_a(x), b_, x.j, position_b(x), g,
                                             look);
    if (found == nullptr) return nullptr;
    crossed_ = kept{};
    static_cast<memory_type&>(crossed_) =
        law::of_resistances(found->memory, (found->key.a == own) != on_b);
    return &crossed_;
  }
  [[gnu::noinline]] void add_to_area(const contact_geometry& g) { area_.push_back(g); }
  /// The range beyond touch of the law for this pair: for shapes with curvatures, where they are
  /// flattest; the law itself ends where it should.
  [[nodiscard]] real range_of(const body_pair& x) const {
    const std::size_t i = x.i, j = x.j;
    if constexpr (!law::reaches) {
      return (void)i, (void)j, 0;
    } else {
      real curvature = s_.soft.bodies[first_a_ + i].curvature;
      if constexpr (has_curvatures<ShapeA>) curvature = 1 / widest_radius(a_.shape[i]);
      if constexpr (has_curvatures<ShapeB>)
        curvature += 1 / widest_radius(b_.shape[j]);
      else if constexpr (paired)
        curvature += s_.soft.bodies[first_b_ + body_b(x)].curvature;
      else if constexpr (ShapeB::finite)
        curvature += wall_curvature(b_.shape[j]);
      const auto& pair = s_.soft.pairs.pair(a_.material[i], b_.material[j]);
      return pair.known ? law::range(pair, 1 / curvature) : 0;
    }
  }
  /// How far along the normal the point of the force is from the middle of the overlap. Two bodies
  /// that move share that point; beside an immovable one each has a point on its own surface.
  [[nodiscard, gnu::always_inline]] inline real depth_of_point(const body_pair& x,
                                                               const contact_geometry& g) const {
    const real half = real(0.5) * g.gap;
    return !paired || b_.inverse_mass[x.j] == 0 ? half : a_.inverse_mass[x.i] == 0 ? -half : 0;
  }
  [[gnu::always_inline]] inline pair_force add(const body_pair& x, const contact_geometry& g,
                                               const contact_key& key, bool counts,
                                               const auto& former, history_place& last) {
    const std::size_t i = x.i, j = x.j;
    soft_body& A = s_.soft.bodies[first_a_ + i];
    vec3 arm_a = g.point - position_a(x), arm_b{0, 0, 0};
    contact_kinematics t;
    soft_body* B = nullptr;
    if constexpr (paired) {
      B = &s_.soft.bodies[first_b_ + body_b(x)];
      arm_b = g.point - position_b(x);
      if (A.inverse_mass == 0 || B->inverse_mass == 0) [[unlikely]] {
        const vec3 half = (real(0.5) * g.gap) * g.normal;
        arm_a += half, arm_b -= half;
      }
      t = kinematics_of_pair<real>(
          g.normal, g.gap, {A.v, A.w, A.inverse_mass, A.radius, A.curvature, arm_a},
          {B->v, B->w, B->inverse_mass, B->radius, B->curvature, arm_b}, s_.dt);
    } else {
      arm_a += (real(0.5) * g.gap) * g.normal;
      t.normal = g.normal;
      t.gap = g.gap;
      t.velocity = A.v + A.w.cross(arm_a);
      t.spin = A.w;
      t.mean_spin = 0.5 * g.normal.dot(A.w);
      real curvature = A.curvature;
      const real rolling = A.inverse_mass * curvature * curvature;
      if constexpr (ShapeB::finite) curvature += wall_curvature(b_.shape[j]);
      if constexpr (state_type::drives) {
        arm_b = g.point - (0.5 * g.gap) * g.normal - b_.position[j];
        t.velocity -= surface_velocity_of(j, arm_b);
        t.spin -= b_.angular_velocity[j];
        t.mean_spin += 0.5 * g.normal.dot(b_.angular_velocity[j]);
      }
      t.mass = 1 / A.inverse_mass;
      t.radius = 1 / curvature;
      t.step = s_.dt;
      t.rolling_inertia = 1.4 / rolling;  // of solid spheres about the point of contact
    }

    if constexpr (has_curvatures<ShapeA> || has_curvatures<ShapeB>) {
      contact_curvature bent(g.normal);
      bent.add(a_.shape[i], pose_a(x), -1, A.curvature);
      real other = 0;
      if constexpr (paired)
        other = B->curvature;
      else if constexpr (ShapeB::finite)
        other = wall_curvature(b_.shape[j]);
      bent.add(b_.shape[j], pose_b(x), 1, other);
      t.radius = bent.radius();
    }

    memory_type memory;
    if constexpr (remembers)
      if (const kept* old = former()) memory = *old;
    const auto& pair = s_.soft.pairs.pair(a_.material[i], b_.material[j]);
    s_.soft.pairs.require_known(pair, a_.material[i], b_.material[j]);
    if constexpr (surveyed) {
      const stored_energy e = law::stored(t, pair, memory);
      if (counts) observer_.normal += e.normal, observer_.across += e.kept;
      return {};
    }
    std::conditional_t<booked, booked_contact, not_booked> books;
    const pair_force f = law::force(t, pair, observed ? 0 : s_.dt, memory, books);
    if constexpr (observed) return f;
    (void)counts, (void)former, (void)last;
    if (!law::reaches || g.gap < 0)
      s_.soft.fastest_approach = std::max(s_.soft.fastest_approach, -t.normal.dot(t.velocity));
    if constexpr (remembers) {
      if (last == history_place::none) last = s_.recorded.next_place();
      if constexpr (requires { state_type::history_type::memory::acts; })
        s_.recorded.add(key, {memory, g.gap < 0 || !is_zero(f) || law::is_intact(memory)});
      else
        s_.recorded.add(key, memory);
    }

    A.force += f.force;
    if constexpr (turns<ShapeA>) A.torque += arm_a.cross(f.force);
    if constexpr (law::exerts_moment) A.torque += f.moment;
    if constexpr (paired) {
      B->force -= f.force;
      if constexpr (turns<ShapeB>) B->torque -= arm_b.cross(f.force);
      if constexpr (law::exerts_moment) B->torque -= f.moment;
    }
    if constexpr (state_type::drives && !paired) press<ShapeB>(s_, j, f.force, A.inverse_mass);
    if constexpr (booked) book(x, books, f, t, arm_a, arm_b, counts);
    if constexpr (balanced) {
      vec3& ground = s_.monitors.momentum.ground_force;
      if (B == nullptr || B->inverse_mass == 0)
        ground += f.force;
      else if (A.inverse_mass == 0)
        ground -= f.force;
    }
    return f;
  }
  void book(const body_pair& x, const booked_contact& c, const pair_force& f,
            const contact_kinematics& t, const vec3& arm_a, const vec3& arm_b, bool counts) {
    spring_record& r = s_.monitors.springs;
    real here = 0;
    if (counts) {
      r.normal += c.stored, r.released += c.released, r.across_before += c.across_before;
      r.across += c.across, r.yielded += c.yielded;
      const auto p = contact_powers<real>::template of<law::central>(c, f, t);
      r.spring_power += p.spring, r.dashpot_power += p.dashpot, r.friction_power += p.friction;
      r.exchanged_power += std::abs(p.spring) + std::abs(p.dashpot) + std::abs(p.friction);
      here = p.spring + p.dashpot + p.friction;
    }
    const soft_body& A = s_.soft.bodies[first_a_ + x.i];
    const auto wall = [&](real sign, const vec3& v, const vec3& w, const vec3& arm) {
      r.wall_power += power_on_body(sign, f.force, f.moment, v, w, arm);
    };
    if constexpr (paired) {
      const soft_body& B = s_.soft.bodies[first_b_ + body_b(x)];
      if (B.inverse_mass == 0)
        wall(1, B.v, B.w, arm_b);
      else if (A.inverse_mass == 0)
        wall(-1, A.v, A.w, arm_a);
      if (x.crosses_ranks())
        r.power_elsewhere +=
            here - (x.own_a ? power_on_body(1, f.force, f.moment, A.v, A.w, arm_a)
                            : power_on_body(-1, f.force, f.moment, B.v, B.w, arm_b));
    } else if constexpr (state_type::drives) {
      r.wall_power +=
          f.force.dot(surface_velocity_of(x.j, arm_b)) + f.moment.dot(b_.angular_velocity[x.j]);
    }
    (void)A, (void)arm_b, (void)here, (void)wall;
  }

  [[nodiscard]] static bool is_zero(const pair_force& f) {
    const vec3 zero(0, 0, 0);
    return f.force == zero && f.moment == zero;
  }
  [[nodiscard]] vec3 surface_velocity_of(std::size_t j, const vec3& arm) const {
    return b_.velocity[j] + b_.angular_velocity[j].cross(arm);
  }

  Observer& observer_;
  [[no_unique_address]] std::conditional_t<passing, passing_contacts<law, kept>, none_pass>
      passing_{};
  kept crossed_;                         ///< the springs that a contact takes from a body beside
  plain_vector<contact_geometry> area_;  ///< the contacts of a pair, if bodies are flush
};

}  // namespace talus::detail
