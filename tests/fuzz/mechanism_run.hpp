#pragma once
// Runs a random mechanism on any ranks, checks it between steps, and compares runs.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <talus/body/motion.hpp>
#include <talus/checkpoint.hpp>
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/cylindrical_joint.hpp>
#include <talus/constraint/fixed_joint.hpp>
#include <talus/constraint/gear.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/point_on_plane.hpp>
#include <talus/constraint/rod.hpp>
#include <talus/constraint/slider.hpp>
#include <talus/constraint/strut.hpp>
#include <talus/constraint/universal_joint.hpp>
#include <talus/constraint/weld.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/joints.hpp>
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

#include "mechanism.hpp"

namespace fuzz {

using namespace talus;

any_decomposition decomposition_of(const mechanism& m, int ranks, std::uint64_t variant);

/// What all ranks remember of a run, over restarts.
struct mechanism_progress {
  std::vector<system_id> ids;
  std::vector<char> there, fixed;                      ///< of bodies
  std::vector<std::optional<detail::joint_key>> keys;  ///< of joints that were not released
};

/// One rank's part of a run from one step to another.
template <class Scenario>
class mechanism_on_rank {
  using world_type = world<Scenario>;
  using link_type = typename Scenario::transport::link;
  using role = mechanism_body::role;
  using kind = mechanism_joint::kind;
  static constexpr bool around = world_type::domain_type::periodic;
  static constexpr bool balances = Scenario::template has_feature<balancing>;

 public:
  mechanism_on_rank(const mechanism& m, const mechanism_options& how, link_type& link,
                    mechanism_progress& progress, mechanism_end& end)
      : m_(m), how_(how), now_(progress), end_(end), w_(link) {}

  void run(int from, int to, const std::string& file, bool last) {
    set_up();
    if (from == 0)
      add_everything();
    else
      read_checkpoint(w_, file);
    w_.synchronize();
    note_bodies();
    for (int k = from; k < to; ++k) {
      if (k > 0)
        for (std::size_t n = 0; n < m_.joints.size(); ++n)
          if (m_.joints[n].step == k && m_.has_joint(static_cast<int>(n))) join(n);
      for (std::size_t n = 0; n < m_.events.size(); ++n)
        if (m_.events[n].step == k && m_.has_event(static_cast<int>(n))) act(m_.events[n]);
      w_.step(m_.dt);
      count_contacts();
      check_ledger();
      if (w_.ranks() == 1 || k % 8 == 7 || k + 1 == m_.steps) look(k);
      if (how_.trace) end_.digests.push_back(state_digest(w_));
    }
    if (!last) {
      write_checkpoint(w_, file);
      return sum_up();
    }
    (void)w_.audit();
    end_.digest = state_digest(w_);
    read_joints();
    read_bodies();
    sum_up();
  }

 private:
  static std::size_t index(int k) { return static_cast<std::size_t>(k); }

  void set_up() {
    if (m_.reproducible) w_.use_solver_on_request();
    if constexpr (around) {
      w_.decompose({{.lower = {-m_.side, -m_.side}, .upper = {m_.side, m_.side}}},
                   {.distance = m_.reach});
    } else {
      w_.decompose(decomposition_of(m_, w_.ranks(), 0), {.distance = m_.reach});
    }
    if constexpr (balances)
      if (m_.balances) w_.balance({.every = 5, .above = 1.01, .by = balance_by::count});
    stuff_ = w_.material({.density = 1, .restitution = m_.restitution, .friction = m_.friction});
    w_.gravity(m_.gravity);
    w_.solver().iterations = m_.iterations;
    if (m_.sleeps)
      w_.sleeping({.speed = 0.05, .time = 0.05});
    else
      w_.sleeping({.speed = 1e-12, .time = 1e9});
    now_.ids.resize(m_.bodies.size());
    w_.global([&](auto& scope) {
      if (m_.floor) scope.add(plane{.normal = {0, 0, 1}}, stuff_);
      for (std::size_t k = 0; k < m_.bodies.size(); ++k) {
        const mechanism_body& b = m_.bodies[k];
        if (!m_.has_body(static_cast<int>(k)) || (b.how != role::global && b.how != role::driven))
          continue;
        with_shape(b, [&](const auto& shape) {
          const auto h = scope.add(shape, stuff_, wrapped(b.at), b.turn);
          now_.ids[k] = h.id;
        });
      }
    });
    for (std::size_t k = 0; k < m_.bodies.size(); ++k) {
      const mechanism_body& b = m_.bodies[k];
      if (!m_.has_body(static_cast<int>(k)) || b.how != role::driven) continue;
      with_handle(k, [&](auto h) {
        if (b.stroke.norm() > 0)
          w_.drive(h, oscillation{.amplitude = b.stroke, .frequency = b.speed});
        else
          w_.drive(h, turning{.about = wrapped(b.at), .axis = b.axis, .speed = b.speed});
      });
    }
  }
  void add_everything() {
    random_stream noise(m_.seed, 9);
    now_.there.assign(m_.bodies.size(), 0), now_.fixed.assign(m_.bodies.size(), 1);
    now_.keys.assign(m_.joints.size(), std::nullopt);
    for (std::size_t k = 0; k < m_.bodies.size(); ++k) {
      const mechanism_body& b = m_.bodies[k];
      if (!m_.has_body(static_cast<int>(k))) continue;
      now_.there[k] = 1;
      if (b.how == role::global || b.how == role::driven) continue;
      now_.fixed[k] = b.how == role::fixed;
      std::uint64_t id = 0;
      const vec3 by = how_.perturbation * noise.in_ball();
      with_shape(b, [&](const auto& shape) {
        const auto h = w_.add_if_local(body{.shape = shape,
                                            .position = wrapped(b.at) + by,
                                            .material = stuff_,
                                            .velocity = b.velocity,
                                            .angular_velocity = b.spin,
                                            .orientation = b.turn,
                                            .fixed = b.how == role::fixed});
        if (h) id = value_of(h->id);
      });
      w_.link().reduce(reduction::max, std::span(&id, 1));
      now_.ids[k] = system_id{id};
    }
    for (std::size_t n = 0; n < m_.joints.size(); ++n)
      if (m_.joints[n].step == 0 && m_.has_joint(static_cast<int>(n))) join(n);
  }
  [[nodiscard]] vec3 wrapped(const vec3& p) const {
    if constexpr (around) return w_.periodic_space().wrapped(p);
    return p;
  }
  template <class F>
  static void with_shape(const mechanism_body& b, F&& f) {
    if (b.is_box)
      f(box{b.size});
    else
      f(sphere{b.size[0]});
  }
  template <class F>
  void with_handle(std::size_t k, F&& f) {
    if (m_.bodies[k].is_box)
      f(handle<box>{now_.ids[k]});
    else
      f(handle<sphere>{now_.ids[k]});
  }
  /// Calls f(body) on its owner; on all ranks if it is global.
  template <class F>
  void at_owner(std::size_t k, F&& f) {
    with_handle(k, [&](auto h) {
      if (auto b = w_.find(h); b && !b->is_remote()) f(*b);
    });
  }
  /// On all ranks.
  [[nodiscard]] vec3 place(int k) {
    if (k < 0) return {0, 0, 0};
    std::array<double, 3> p{};
    at_owner(index(k), [&](auto& b) {
      if (!b.is_global() || w_.rank() == 0) p = {b.position()[0], b.position()[1], b.position()[2]};
    });
    w_.link().reduce(reduction::sum, std::span(p));
    return {p[0] + 0.0, p[1] + 0.0, p[2] + 0.0};
  }

  void join(std::size_t n) {
    const mechanism_joint& j = m_.joints[n];
    const auto usable = [&](int k) { return k < 0 || now_.there[index(k)]; };
    const auto still = [&](int k) { return k < 0 || now_.fixed[index(k)]; };
    if (!usable(j.a) || !usable(j.b) || (still(j.a) && still(j.b))) return;
    vec3 b = place(j.b);
    const vec3 a = j.a < 0 ? vec3(b + j.off) : place(j.a);
    if constexpr (around)
      if (j.a >= 0) b = detail::seen_from(detail::state_of(w_), a, b);
    const vec3 at = j.a < 0 ? a : vec3(a + j.fraction * (b - a) + j.off);
    const vec3 from = a, to = j.a < 0 ? b : vec3(b + j.off);
    const auto limits = [](const mechanism_axis& x) {
      return joint_limits{.lower = x.lower, .upper = x.upper, .restitution = x.restitution};
    };
    const auto spring = [](const mechanism_axis& x) {
      return joint_spring{.stiffness = x.spring, .damping = x.spring_damping, .rest = x.rest};
    };
    const mechanism_axis &x = j.first, &y = j.second;
    switch (j.what) {
      case kind::ball:
        return make(n, ball_joint{.at = at});
      case kind::fixed:
        return make(n, fixed_joint{.at = at});
      case kind::weld:
        return make(n, weld{.at = at, .largest_force = j.strength, .largest_torque = j.strength});
      case kind::hinge:
        return make(n, hinge{.at = at,
                             .axis = j.axis,
                             .limits = limits(x),
                             .motor = torque_of(x),
                             .spring = spring(x),
                             .friction = x.friction});
      case kind::slider:
        return make(n, slider{.at = at,
                              .axis = j.axis,
                              .limits = limits(x),
                              .motor = force_of(x),
                              .spring = spring(x),
                              .friction = x.friction});
      case kind::cylindrical:
        return make(n, cylindrical_joint{.at = at,
                                         .axis = j.axis,
                                         .turn_limits = limits(x),
                                         .turn_motor = torque_of(x),
                                         .turn_spring = spring(x),
                                         .turn_friction = x.friction,
                                         .travel_limits = limits(y),
                                         .travel_motor = force_of(y),
                                         .travel_spring = spring(y),
                                         .travel_friction = y.friction});
      case kind::universal:
        return make(n, universal_joint{.at = at,
                                       .first_axis = j.axis,
                                       .second_axis = j.second_axis,
                                       .first_limits = limits(x),
                                       .first_spring = spring(x),
                                       .first_friction = x.friction,
                                       .second_limits = limits(y),
                                       .second_spring = spring(y),
                                       .second_friction = y.friction});
      case kind::rod:
        return make(n, rod{.from = from, .to = to});
      case kind::rope:
        return make(n, rope{.from = from, .to = to, .restitution = j.restitution});
      case kind::strut:
        return make(n, strut{.from = from,
                             .to = to,
                             .limits = limits(x),
                             .motor = force_of(x),
                             .spring = spring(x),
                             .friction = x.friction});
      case kind::point_on_plane:
        return make(n, point_on_plane{.at = at, .normal = j.axis});
      case kind::gear:
        return make(n, gear{.first_axis = j.axis, .second_axis = j.second_axis, .ratio = j.ratio});
    }
  }
  static torque_motor torque_of(const mechanism_axis& x) {
    return {.velocity = x.motor_velocity,
            .largest_torque = x.largest,
            .position = x.position,
            .stiffness = x.stiffness,
            .damping = x.damping};
  }
  static force_motor force_of(const mechanism_axis& x) {
    return {.velocity = x.motor_velocity,
            .largest_force = x.largest,
            .position = x.position,
            .stiffness = x.stiffness,
            .damping = x.damping};
  }
  template <class Kind>
  void make(std::size_t n, const Kind& how) {
    const mechanism_joint& j = m_.joints[n];
    with_handle(index(j.b), [&](auto b) {
      if (j.a < 0)
        now_.keys[n] = w_.join(world_frame, b, how).key();
      else
        with_handle(index(j.a), [&](auto a) { now_.keys[n] = w_.join(a, b, how).key(); });
    });
  }
  /// Calls f(handle) of a joint that was not released.
  template <class F>
  void with_joint(std::size_t n, F&& f) {
    if (!now_.keys[n]) return;
    const auto call = [&]<class Kind>(const Kind*) {
      f(joint_handle<Scenario, Kind>(w_, *now_.keys[n]));
    };
    switch (m_.joints[n].what) {
      case kind::ball:
        return call(static_cast<ball_joint*>(nullptr));
      case kind::fixed:
        return call(static_cast<fixed_joint*>(nullptr));
      case kind::weld:
        return call(static_cast<weld*>(nullptr));
      case kind::hinge:
        return call(static_cast<hinge*>(nullptr));
      case kind::slider:
        return call(static_cast<slider*>(nullptr));
      case kind::cylindrical:
        return call(static_cast<cylindrical_joint*>(nullptr));
      case kind::universal:
        return call(static_cast<universal_joint*>(nullptr));
      case kind::rod:
        return call(static_cast<rod*>(nullptr));
      case kind::rope:
        return call(static_cast<rope*>(nullptr));
      case kind::strut:
        return call(static_cast<strut*>(nullptr));
      case kind::point_on_plane:
        return call(static_cast<point_on_plane*>(nullptr));
      case kind::gear:
        return call(static_cast<gear*>(nullptr));
    }
  }
  void part(std::size_t n) {
    with_joint(n, [](auto joint) { joint.release(); });
    now_.keys[n].reset();
  }

  void act(const mechanism_event& e) {
    using what = mechanism_event::kind;
    const bool of_body = e.what == what::fix || e.what == what::release ||
                         e.what == what::destroy || e.what == what::push || e.what == what::shift;
    const std::size_t k = index(e.target);
    const bool global =
        of_body && (m_.bodies[k].how == role::global || m_.bodies[k].how == role::driven);
    if (of_body && (!m_.has_body(e.target) || !now_.there[k] || global)) return;
    switch (e.what) {
      case what::fix:
        at_owner(k, [](auto& b) { b.fix(); });
        now_.fixed[k] = 1;
        return;
      case what::release:
        at_owner(k, [](auto& b) { b.release(); });
        now_.fixed[k] = 0;
        return;
      case what::destroy:
        for (std::size_t n = 0; n < m_.joints.size(); ++n)
          if (m_.joints[n].a == e.target || m_.joints[n].b == e.target) part(n);
        with_handle(k, [&](auto h) {
          if (auto b = w_.find(h); b && !b->is_remote()) w_.destroy(h);
        });
        now_.there[k] = 0;
        return;
      case what::part:
        return part(k);
      case what::motor: {
        mechanism_axis x = m_.joints[k].first;
        x.largest = 0.05 * e.number, x.motor_velocity = 5 * e.value[0], x.stiffness = x.damping = 0;
        return with_joint(k, [&](auto joint) {
          if constexpr (requires { joint.set_motor(torque_of(x)); })
            joint.set_motor(torque_of(x));
          else if constexpr (requires { joint.set_motor(force_of(x)); })
            joint.set_motor(force_of(x));
        });
      }
      case what::push:
        if (now_.fixed[k]) return;
        return at_owner(k, [&](auto& b) { b.set_velocity(e.value); });
      case what::shift:
        return at_owner(k, [&](auto& b) { b.translate(e.value); });
      case what::gravity:
        return w_.gravity(e.value);
      case what::synchronize:
        return w_.synchronize();
      case what::restart:
        return;
      case what::divide:
        if constexpr (!around) {
          w_.decompose(decomposition_of(m_, w_.ranks(), 1), {.distance = m_.reach});
          w_.synchronize();
        }
        return;
    }
  }

  void note_bodies() {
    mine_.clear();
    w_.for_each_local([&](const auto& b) { mine_.insert(b.id()); });
  }
  void count_contacts() {
    std::set<system_id> now;
    w_.for_each_local([&](const auto& b) { now.insert(b.id()); });
    for (const auto id : now) crossed_ += !mine_.contains(id);
    mine_.swap(now);
    talus::detail::state_of(w_).each_contact_list([&](const auto& list) {
      list.each([&](const auto& c, bool counts) {
        contacts_ += counts && c.impulse().squaredNorm() > 0;
      });
    });
  }
  /// What the ledger of the last step leaves, over the energy of all ranks: motion that is
  /// round-off alone, of all of them or of the bodies of one, closes to no part of its own energy.
  void check_ledger() {
    const energy_balance e = measure_energy(w_);
    end_.energy = std::max<real>(end_.energy, e.scale);
    if (const real least = real(1e-12) * end_.energy; e.scale > 0)
      end_.worst_closure =
          std::max<real>(end_.worst_closure, std::abs(e.closure) / std::max<real>(e.scale, least));
  }
  void look(int k) {
    real fastest = 0;
    w_.for_each_local([&](const auto& b) {
      if (!detail::finite(b.position()) || !detail::finite(b.velocity()) ||
          !detail::finite(b.angular_velocity()) || !(std::abs(b.orientation().norm() - 1) < 1e-6))
        throw broken("the motion of body " + detail::text(b.id()) + " is not finite in step " +
                     std::to_string(k));
      fastest = std::max(fastest, b.velocity().norm());
    });
    w_.link().reduce(reduction::max, std::span(&fastest, 1));
    end_.fastest = std::max(end_.fastest, fastest);
    const energy_balance e = measure_energy(w_);
    // Of the bodies, of these with their weight, and of what they have without the impulses:
    // gravity, motors and springs may do work against the other impulses of the step.
    const real taken = e.step.friction + e.step.impact;
    const real gain = std::min<real>({-taken, e.step.scheme - taken, added_to_free_motion()});
    if (gain > end_.gain * end_.energy) end_.gain = gain / end_.energy, end_.step_of_gain = k;
    const joint_errors open = measure_joints(w_);
    if (open.gap > end_.gap) end_.gap = open.gap, end_.step_of_gap = k;
    end_.opened = std::max(end_.opened, talus::detail::state_of(w_).joints.opening.part);
    w_.link().reduce(reduction::max, std::span(&end_.opened, 1));
  }
  /// By how much the kinetic energy is larger than without the impulses of contacts, conditions and
  /// limits.
  [[nodiscard]] real added_to_free_motion() {
    const auto& s = talus::detail::state_of(w_);
    std::vector<wrench> loads(s.solver.bodies.size());
    const auto add = [&](std::int32_t k, const auto& impulse) {
      wrench& sum = loads[static_cast<std::size_t>(k)];
      sum.impulse += impulse.impulse, sum.moment += impulse.moment;
    };
    s.each_contact_list([&](const auto& list) {
      list.each_acting([&](const auto& c, bool on_a, bool on_b) {
        const auto along = [&](auto&& work) {
          wrench x;
          for (int i = 0; i < 3; ++i) {
            x.impulse[i] = work(vec3(vec3::Unit(i)), vec3(0, 0, 0));
            x.moment[i] = work(vec3(0, 0, 0), vec3(vec3::Unit(i)));
          }
          return x;
        };
        if (on_a)
          add(c.a, along([&](const vec3& v, const vec3& w) { return detail::work_on_a(c, v, w); }));
        if constexpr (std::remove_cvref_t<decltype(c)>::paired)
          if (on_b)
            add(c.b,
                along([&](const vec3& v, const vec3& w) { return detail::work_on_b(c, v, w); }));
      });
    });
    s.each_joint_list([&](const auto& list) {
      list.each_acting([&](const auto& c, bool on_a, bool on_b) {
        const auto holds = c.since(c.driven());
        if (on_a) add(c.a, c.wrench_on_a(holds));
        if (on_b) add(c.b, c.wrench_on_b(holds));
      });
    });
    double sum = 0;
    for (std::size_t k = 0; k < loads.size() && k < s.solver.first_global; ++k) {
      const auto& body = s.solver.bodies[k];
      const wrench& x = loads[k];
      if (body.inverse_mass == 0) continue;
      const vec3 turn = s.solver.has_tensor(k) ? vec3(s.solver.tensor(k) * x.moment)
                                               : vec3(real(body.inverse_inertia) * x.moment);
      sum += x.impulse.dot(detail::v_of(body)) + x.moment.dot(detail::w_of(body)) -
             real(0.5) * (real(body.inverse_mass) * x.impulse.squaredNorm() + x.moment.dot(turn));
    }
    w_.link().reduce(reduction::sum, std::span(&sum, 1));
    return sum;
  }
  void read_joints() {
    end_.joints.assign(m_.joints.size(), {});
    for (std::size_t n = 0; n < m_.joints.size(); ++n)
      with_joint(n, [&](auto joint) {
        const joint_reading r = measure_joint(w_, joint);
        end_.joints[n] = {real(r.exists), r.angle, r.travel};
      });
  }
  void read_bodies() {
    std::vector<mechanism_end::body> mine;
    w_.for_each_local([&](const auto& b) {
      const vec3 p = b.position(), v = b.velocity(), w = b.angular_velocity();
      const quat q = b.orientation();
      mine.push_back(
          {value_of(b.id()),
           {p[0], p[1], p[2], q.w(), q.x(), q.y(), q.z(), v[0], v[1], v[2], w[0], w[1], w[2]}});
    });
    detail::byte_buffer bytes;
    detail::byte_writer(bytes).put(std::span<const mechanism_end::body>(mine));
    end_.bodies.clear();
    for (const auto& theirs : w_.link().gather_all(bytes))
      for (const auto& b : detail::byte_reader(theirs).template get_all<mechanism_end::body>())
        end_.bodies.push_back(b);
    std::sort(end_.bodies.begin(), end_.bodies.end());
  }
  void sum_up() {
    std::uint64_t sums[2] = {contacts_, crossed_};
    w_.link().reduce(reduction::sum, std::span(sums));
    end_.contacts += sums[0], end_.crossed += sums[1];
  }

  const mechanism& m_;
  const mechanism_options& how_;
  mechanism_progress& now_;
  mechanism_end& end_;
  world_type w_;
  material_id stuff_{};
  std::set<system_id> mine_;
  std::uint64_t contacts_ = 0, crossed_ = 0;
};

/// A run on so many ranks; with several, a restart on others if the mechanism has one.
template <class Scenario>
mechanism_end run_mechanism(const mechanism& m, int ranks, const mechanism_options& how) {
  struct leg {
    int ranks, from, to;
  };
  std::vector<leg> legs{{ranks, 0, m.steps}};
  if (ranks > 1)
    for (std::size_t n = 0; n < m.events.size(); ++n)
      if (const mechanism_event& e = m.events[n]; e.what == mechanism_event::kind::restart &&
                                                  m.has_event(static_cast<int>(n)) &&
                                                  e.step < m.steps) {
        legs.back().to = e.step;
        legs.push_back({e.target, e.step, m.steps});
      }
  const std::string file = (std::filesystem::temp_directory_path() /
                            ("talus_mechanism_" + std::to_string(getpid()) + ".h5"))
                               .string();
  mechanism_progress progress;
  mechanism_end end;
  try {
    for (const leg& l : legs) {
      mechanism_progress next;
      mechanism_end after;
      threads::launch({.ranks = l.ranks}, [&](typename Scenario::transport::link& link) {
        mechanism_progress mine = progress;
        mechanism_end seen = end;
        mechanism_on_rank<Scenario>(m, how, link, mine, seen)
            .run(l.from, l.to, file, l.to == m.steps);
        if (link.rank() == 0) next = std::move(mine), after = std::move(seen);
      });
      progress = std::move(next), end = std::move(after);
    }
  } catch (const broken&) {
    throw;
  } catch (const std::exception& e) {
    end.refused = e.what();
  }
  std::error_code ignored;
  if (legs.size() > 1) std::filesystem::remove(file, ignored);
  return end;
}

}  // namespace fuzz
