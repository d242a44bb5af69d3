#pragma once
// One family of fuzzed runs: a type of scenario, filled and stepped by the numbers of a plan, with
// checks of the invariants of the design (I1 to I7) between steps.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/world.hpp>
#include <tuple>

#include "degenerate.hpp"
#include "plan.hpp"

namespace fuzz {

using namespace talus;

any_decomposition decomposition_of(const plan& p);

[[noreturn]] inline void fail(const std::string& what) { throw broken(what); }

/// The draws of most families: spheres, and boxes, capsules and unions if the scenario has them.
/// Another type that is `degenerate` has an add_shape() and an add_walls() of its own, and half of
/// its bodies lie where faces, edges or centres coincide with those of another body.
struct usual_draws {
  static constexpr bool degenerate = false;
};

/// One rank's part of a run. All ranks draw the same numbers, so that they do the same.
template <class Scenario, class Draws>
class on_rank {
  using world_type = world<Scenario>;
  using link_type = typename Scenario::transport::link;
  using random = random_stream;
  static constexpr bool soft = Scenario::contact_law::soft;
  static constexpr bool around = world_type::domain_type::periodic;
  template <class Shape>
  static constexpr bool has = detail::contains_type<typename Scenario::shapes, Shape>;
  static constexpr bool degenerate = Draws::degenerate;
  using pieces = union_of<sphere, box>;

 public:
  on_rank(const plan& p, link_type& link) : p_(p), r_(p.seed, 2), w_(link) {}

  outcome run() {
    set_up();
    w_.synchronize();
    note_bodies();
    const motion before = measure_motion(w_);
    for (int k = 0; k < p_.steps; ++k) {
      if (p_.what >= subject::disturbed) stir();
      note_velocities();
      w_.step(number(p_.dt));
      count_contacts();
      if (p_.what < (degenerate ? subject::wild : subject::disturbed)) look_at_energy();
      if (k % p_.look_every == 0 || k + 1 == p_.steps) look();
    }
    if (p_.what < subject::disturbed) compare(before, measure_motion(w_));
    (void)w_.audit();
    std::uint64_t sums[2] = {result_.crossed, result_.contacts};
    w_.link().reduce(reduction::sum, std::span(sums));
    result_.crossed = sums[0], result_.contacts = sums[1];
    result_.digest = state_digest(w_);
    return result_;
  }

 private:
  /// In a wild run, occasionally, a number that a user may have got wrong.
  real number(real usual, std::uint64_t rarity = 20) {
    if (p_.what != subject::wild || r_.integer(rarity) != 0) return usual;
    static constexpr real wrong[] = {0,    -1,    1e-300, 1e-100, 1e-15, 1e9,
                                     1e15, 1e100, 1e300,  -1e300, NAN,   INFINITY};
    return wrong[r_.integer(std::size(wrong))];
  }
  vec3 numbers(const vec3& usual, std::uint64_t rarity) {
    const real x = number(usual[0], rarity), y = number(usual[1], rarity);
    return {x, y, number(usual[2], rarity)};
  }

  void set_up() {
    if constexpr (around)
      w_.decompose({{.lower = {-p_.side, -p_.side}, .upper = {p_.side, p_.side}}},
                   {.distance = p_.reach});
    else
      w_.decompose(decomposition_of(p_), {.distance = p_.reach});
    material m{.density = number(p_.density),
               .restitution = number(p_.restitution),
               .friction = number(p_.friction)};
    if constexpr (soft)  // contacts last for 25 steps or more
      m.stiffness =
          number(p_.density * 4 * std::pow(p_.smallest, 3) / 2 * std::pow(pi / (25 * p_.dt), 2));
    stuff_ = w_.material(m);
    w_.gravity(numbers({0, 0, -p_.gravity}, 20));
    if constexpr (!soft) {
      w_.solver().iterations = p_.iterations;
      w_.solver().tolerance = p_.tolerance;
      w_.solver().max_iterations = 200;
      w_.solver().correction_iterations = p_.correction_iterations;
      w_.solver().correction = p_.correction;
    }
    if constexpr (Scenario::template has_feature<sleeping>)
      w_.sleeping({.speed = p_.what == subject::cloud ? 1e-9 : 0.02, .time = 0.01});
    if (p_.what != subject::cloud) add_walls();
    for (int k = 0; k < p_.bodies; ++k)
      add_body(p_.what == subject::disturbed && r_.integer(8) == 0);
  }

  void add_walls() {
    w_.global([&](auto& scope) {
      for (int axis = around ? 2 : 0; axis < 3; ++axis)
        for (const real side : {-1.0, 1.0})
          scope.add(plane{.normal = -side * vec3(vec3::Unit(axis)), .offset = -p_.side}, stuff_);
      if constexpr (has<box>) scope.add(box{{1, 1, 0.3}}, stuff_, vec3(0, 0, -p_.side));
      if constexpr (degenerate) Draws::add_walls(scope, stuff_, -p_.side);
    });
    if constexpr (degenerate) taken_.push_back({{0, 0, -p_.side}, 0, {0.5, 0.5, 0.15}});
  }

  /// A body without contacts to those added before, unless it may lie `anywhere`.
  void add_body(bool anywhere) {
    const real part = r_.uniform();
    const real radius = p_.smallest * std::pow(p_.ratio, degenerate ? part : std::pow(part, 4));
    const real L = p_.side - 1.05 * radius, floor = has<box> ? 0.2 : 0;
    if (L < floor) return;
    const occupied* beside = nullptr;  // whose ball does not count
    const bool overlaps = p_.what >= subject::disturbed;
    const auto free = [&](const vec3& at) {
      if (p_.how == domains::ring && std::hypot(at[0], at[1]) < 0.5 + 1.1 * radius) return false;
      return anywhere || std::none_of(taken_.begin(), taken_.end(), [&](const auto& ball) {
               return &ball != beside && (ball.at - at).norm() < 1.001 * (ball.radius + radius);
             });
    };
    vec3 at(0, 0, 0);
    int attempts = 0;
    do at = r_.uniform(vec3(-L, -L, floor - L), vec3(L, L, L));
    while (!free(at) && ++attempts < 30);
    if (attempts == 30) return;

    vec3 v = p_.speed * r_.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
    if (p_.what == subject::cloud) v -= 0.5 * p_.speed * at;
    vec3 spin = r_.integer(2) ? r_.uniform(vec3(-3, -3, -3), vec3(3, 3, 3)) : vec3(0, 0, 0);
    const bool fixed = p_.what != subject::cloud && r_.integer(degenerate ? 8 : 30) == 0;
    add_shape(number(radius, 100), [&](const auto& shape) {
      std::optional<quat> turned;
      vec3 half(0, 0, 0);
      if constexpr (degenerate) {
        turned = r_.integer(3) ? axis_aligned(r_) : r_.rotation();
        half = shape.half_extents({{0, 0, 0}, *turned});
        if (!taken_.empty() && r_.integer(2) != 0) {
          beside = &taken_[r_.integer(taken_.size())];
          const auto place = degenerate_place(r_, *beside, half, !overlaps);
          const bool straight = r_.integer(2) != 0;
          if (free(place.at) && (overlaps || within_walls(place.at, half))) {
            at = place.at;
            if (straight) v = beside->velocity + 0.2 * p_.speed * place.towards, spin = {0, 0, 0};
          }
        }
      }
      taken_.push_back({at, radius, half, fixed ? vec3(0, 0, 0) : v});
      w_.add_if_local(body{.shape = shape,
                           .position = numbers(at, 300),
                           .material = stuff_,
                           .velocity = numbers(v, 100),
                           .angular_velocity = numbers(spin, 100),
                           .orientation = turned ? *turned : r_.rotation(),
                           .fixed = fixed});
    });
  }
  /// Whether a body lies above the box on the floor, or on it.
  [[nodiscard]] bool within_walls(const vec3& at, const vec3& half) const {
    return (at.cwiseAbs() + half).maxCoeff() <= p_.side && at[2] - half[2] >= 0.15 - 1e-9 - p_.side;
  }
  /// Calls add(shape) for one of the shapes, in a ball of that radius.
  template <class Add>
  void add_shape(real radius, Add&& add) {
    if constexpr (degenerate) return Draws::add_shape(r_, radius, add);
    const auto kind = r_.integer(4);
    if constexpr (has<box>)
      if (kind == 1) return add(box{vec3(1.1, 0.9, r_.uniform(0.1, 1.3)) * radius});
    if constexpr (has<capsule>)
      if (kind == 2) return add(capsule{0.4 * radius, 1.1 * radius});
    if constexpr (has<pieces>)
      if (kind == 3)
        return add(pieces(std::vector<typename pieces::part>{
            {.shape = sphere{0.45 * radius}, .at = {vec3(0.4 * radius, 0, 0), {1, 0, 0, 0}}},
            {.shape = box{vec3(0.5, 0.5, 0.5) * radius},
             .at = {vec3(-0.3 * radius, 0, 0), {1, 0, 0, 0}}}}));
    add(sphere{radius});
  }

  /// Actions of users between steps.
  void stir() {
    if (r_.integer(3) == 0) add_body(r_.integer(3) == 0);
    if (r_.integer(4) == 0) {
      const auto chosen = r_.integer(7);
      w_.destroy_if([&](const auto& b) { return detail::mix(value_of(b.id())) % 23 == chosen; });
    }
    // Actions of one rank by itself, which depend on the ranks.
    if (r_.integer(6) == 0 && !detail::solves_by_colours<typename Scenario::solver>)
      w_.exclusive(static_cast<int>(r_.integer(static_cast<std::uint64_t>(p_.ranks))), [&] {
        random mine(p_.seed, 100 + w_.steps());
        const real L = p_.side - 0.5;
        for (int attempt = 0; attempt < 50; ++attempt) {
          const vec3 at = mine.uniform(vec3(-L, -L, -L), vec3(L, L, L));
          if (!w_.contains(at) || (p_.how == domains::ring && std::hypot(at[0], at[1]) < 1))
            continue;
          w_.add(body{.shape = sphere{0.2}, .position = at, .material = stuff_});
          break;
        }
      });
    if (r_.integer(5) == 0) {
      const auto chosen = r_.integer(11);
      const vec3 v = numbers(p_.speed * r_.unit_vector(), 60);
      const vec3 by = numbers(0.1 * r_.unit_vector(), 60);
      const bool moves = p_.how != domains::ring;
      w_.for_each_local([&](auto& b) {
        const auto hash = detail::mix(value_of(b.id()) + 1) % 11;
        if (hash == chosen && !b.is_fixed()) b.set_velocity(v);
        if (hash == (chosen + 1) % 11 && moves) b.translate(by);
        if (hash == (chosen + 2) % 11) b.fix();
        if (hash == (chosen + 3) % 11 && b.is_fixed()) b.release();
      });
    }
    if (r_.integer(15) == 0) w_.gravity(numbers(10 * r_.uniform() * r_.unit_vector(), 20));
    if (r_.integer(15) == 0) w_.synchronize();
  }

  void note_bodies() {
    mine_.clear();
    w_.for_each_local([&](const auto& b) { mine_.insert(b.id()); });
  }
  void count_contacts() {
    std::set<system_id> now;
    w_.for_each_local([&](const auto& b) { now.insert(b.id()); });
    for (const auto id : now) result_.crossed += !mine_.contains(id);
    mine_.swap(now);
    if constexpr (!soft)
      talus::detail::state_of(w_).each_contact_list([&](const auto& list) {
        list.each([&](const auto& c, bool counts) {
          result_.contacts += counts && c.impulse().squaredNorm() > 0;
        });
      });
  }

  void note_velocities() {
    if constexpr (!degenerate) return;
    before_.clear();
    w_.for_each_local([&](const auto& b) { before_[b.id()] = b.velocity(); });
  }
  /// What contacts may add in a step of one rank where they press bodies down: each island may gain
  /// as much as gravity takes from it, while the energy of others rises with bodies that rebound,
  /// which the sums over all of them do not show.
  real work_against_gravity() {
    real sum = 0;
    if constexpr (degenerate) {
      const vec3 fall = p_.dt * w_.gravity();
      w_.for_each_local([&](const auto& b) {
        if (b.is_fixed()) return;
        const vec3 change = b.velocity() - before_[b.id()];
        if ((change - fall).norm() > 1e-12 * b.velocity().norm())
          sum += std::max(real(0), 0.5 * b.mass() * fall.dot(change));
      });
    }
    return sum;
  }

  /// Contacts add no energy in any step: if gravity brings bodies together in it they may do work,
  /// but the sum of kinetic and potential energy falls. (Across ranks the default solver's sum is
  /// not exact, and bodies that are followed to their impact have other velocities there.)
  void look_at_energy() {
    if constexpr (detail::monitored<Scenario, energy_ledger> && !soft) {
      const energy_balance e = measure_energy(w_);
      const real work = -(e.step.friction + e.step.impact);
      const real gain = std::min(work, e.step.net() - e.step.correction);
      const bool followed = Scenario::template has_feature<continuous_collision> && p_.gravity > 0;
      const bool coloured = detail::solves_by_colours<typename Scenario::solver>;
      const bool exact = p_.tolerance == 0 && (coloured ? p_.gravity == 0 : p_.ranks == 1);
      const real most = exact ? 1e-12 * e.scale + work_against_gravity() : 0.1 * e.scale;
      if (!followed && gain > most)
        fail("contacts added the energy " + detail::text(gain) + " in a step, of " +
             detail::text(e.scale));
    }
  }

  template <class T>
  std::vector<T> of_all_ranks(const std::vector<T>& mine) {
    detail::byte_buffer bytes;
    detail::byte_writer(bytes).put(std::span<const T>(mine));
    std::vector<T> all;
    for (const auto& theirs : w_.link().gather_all(bytes))
      for (const T& value : detail::byte_reader(theirs).template get_all<T>()) all.push_back(value);
    return all;
  }

  void look() {
    // I1: every point has one owner, and every body is with the owner of its centre; no NaN.
    for (int k = 0; k < 4; ++k) {
      vec3 p = r_.uniform(vec3(-9, -9, -9), vec3(9, 9, 9));
      if constexpr (around) p = talus::detail::state_of(w_).own.box().wrapped(p);
      std::uint64_t owners = w_.contains(p);
      w_.link().reduce(reduction::sum, std::span(&owners, 1));
      if (owners != 1)
        fail("the point " + detail::text(p) + " has " + std::to_string(owners) + " owners");
    }
    std::vector<std::uint64_t> ids;
    const bool on_the_way = p_.what >= subject::disturbed;  // translations may have moved it far
    w_.for_each_local([&](const auto& b) {
      ids.push_back(value_of(b.id()));
      if (!detail::finite(b.position()) || !detail::finite(b.velocity()) ||
          !detail::finite(b.angular_velocity()) || !(std::abs(b.orientation().norm() - 1) < 1e-6))
        fail("the motion of body " + detail::text(b.id()) + " is not finite");
      if (!on_the_way && !w_.contains(b.position()))
        fail("body " + detail::text(b.id()) + " is not with its owner");
    });
    // I6: no body twice, none lost.
    auto all = of_all_ranks(ids);
    std::sort(all.begin(), all.end());
    if (std::adjacent_find(all.begin(), all.end()) != all.end()) fail("a body has two owners");
    if (w_.audit().bodies != all.size()) fail("the audit counts wrong");
    // I2: each contact acts once on each of its bodies, and with the same impulse.
    if constexpr (!soft && !detail::solves_by_colours<typename Scenario::solver>) {
      std::vector<action> actions;
      talus::detail::state_of(w_).each_contact_list([&](const auto& list) {
        using detail::contact_part;
        const std::size_t inner = list.size(contact_part::interior);
        std::size_t n = 0;
        list.each_acting([&](const auto& c, bool on_a, bool on_b) {
          const auto& key = n < inner ? list.key(contact_part::interior, n)
                                      : list.key(contact_part::boundary, n - inner);
          ++n;
          const vec3 q = c.impulse();
          for (const int side : {1, 2})
            if (side == 1 ? on_a : on_b)
              actions.push_back({value_of(key.a), value_of(key.b), key.feature, side, q});
        });
      });
      auto acting = of_all_ranks(actions);
      std::sort(acting.begin(), acting.end());
      for (std::size_t k = 0; k < acting.size(); k += 2) {
        const bool whole = k + 1 < acting.size() && acting[k].side == 1 &&
                           acting[k + 1].side == 2 && acting[k].same_contact(acting[k + 1]);
        if (!whole || (k > 0 && acting[k].same_contact(acting[k - 1])))
          fail("the contact of " + detail::text(system_id{acting[k].a}) + " and " +
               detail::text(system_id{acting[k].b}) + " does not act once on each of them");
        if (acting[k].impulse != acting[k + 1].impulse)
          fail("the contact of " + detail::text(system_id{acting[k].a}) + " and " +
               detail::text(system_id{acting[k].b}) + " acts differently on its two bodies");
      }
    }
  }
  struct action {
    std::uint64_t a = 0, b = 0, feature = 0;
    int side = 0;
    vec3 impulse{0, 0, 0};

    [[nodiscard]] bool same_contact(const action& o) const {
      return std::tie(a, b, feature) == std::tie(o.a, o.b, o.feature);
    }
    bool operator<(const action& o) const {
      return std::tie(a, b, feature, side) < std::tie(o.a, o.b, o.feature, o.side);
    }
  };

  void compare(const motion& before, const motion& after) {
    if (after.bodies != before.bodies) fail("there are other bodies than before");
    if (p_.what == subject::cloud) {
      const real scale = std::sqrt(2 * before.mass * before.kinetic_energy) + 1e-300;
      result_.momentum_error = (after.momentum - before.momentum).norm() / scale;
      if (result_.momentum_error > 1e-12)
        fail("momentum changed by " + detail::text(result_.momentum_error, 3));
    }
    // With gravity, the position correction works against it, and falling bodies gain speed first.
    const real lowest = -p_.gravity * before.mass * p_.side;  // potential energy on the floor
    const real start = before.kinetic_energy + before.potential_energy - lowest;
    const real end = after.kinetic_energy + after.potential_energy - lowest;
    result_.energy_gain = start > 0 ? end / start - 1 : 0;
    if (result_.energy_gain > allowed_gain())
      fail("energy grew by " + detail::text(result_.energy_gain, 3) + " of itself");
  }
  [[nodiscard]] real allowed_gain() const {
    const bool exact = p_.ranks == 1 || detail::solves_by_colours<typename Scenario::solver>;
    if (!soft && exact && p_.tolerance == 0 && p_.what == subject::cloud) return 1e-10;
    return p_.restitution > 0 ? 0.05 : 0.01;
  }

  const plan& p_;
  random r_;
  world_type w_;
  material_id stuff_{};
  std::vector<occupied> taken_;
  std::set<system_id> mine_;
  std::map<system_id, vec3> before_;
  outcome result_;
};

/// Runs a plan; throws `broken` if an invariant does not hold.
template <class Scenario, class Draws = usual_draws>
outcome run_family(const plan& p) {
  outcome result;
  try {
    threads::launch({.ranks = p.ranks}, [&](typename Scenario::transport::link& link) {
      outcome mine = on_rank<Scenario, Draws>(p, link).run();
      if (link.rank() == 0) result = std::move(mine);
    });
  } catch (const broken&) {
    throw;
  } catch (const std::exception& e) {
    result.refused = e.what();
    const auto says = [&](const char* words) {
      return result.refused.find(words) != std::string::npos;
    };
    if (result.refused.size() < 20) fail("a message that says too little: " + result.refused);
    const bool of_domains = says("closed face") || says("not connected") ||
                            says("decompose with a reach") || says("no space of its own") ||
                            says("at most a quarter of it");
    if (p.what != subject::wild && !of_domains) fail("refused: " + result.refused);
  }
  return result;
}

/// The same for a solver that promises the bits of one rank.
template <class Scenario>
outcome run_on_one_too(const plan& p) {
  const outcome many = run_family<Scenario>(p);
  plan single = p;
  single.ranks = 1;
  const outcome one = run_family<Scenario>(single);
  if (many.refused.empty() && one.refused.empty() && many.digest != one.digest)
    fail("one rank ends with " + one.digest + ", these with " + many.digest);
  return many;
}

}  // namespace fuzz
