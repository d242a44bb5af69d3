// Random mechanisms: how they are drawn, and what they are in words.
#include "mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fuzz {
namespace {

using random = talus::random_stream;
using role = mechanism_body::role;
using joint_kind = mechanism_joint::kind;
using event_kind = mechanism_event::kind;

[[nodiscard]] bool chance(random& r, real p) { return r.uniform() < p; }
[[nodiscard]] int up_to(random& r, int n) {
  return static_cast<int>(r.integer(static_cast<std::uint64_t>(n)));
}
[[nodiscard]] vec3 across(random& r, const vec3& axis) {
  vec3 x = axis.cross(r.unit_vector());
  while (x.norm() < 0.1) x = axis.cross(r.unit_vector());
  return x / x.norm();
}
[[nodiscard]] real radius_of(const mechanism_body& b) {
  return b.is_box ? 0.5 * b.size.norm() : b.size[0];
}
[[nodiscard]] real mass_of(const mechanism_body& b) {
  return b.is_box ? b.size[0] * b.size[1] * b.size[2]
                  : 4.0 / 3 * std::numbers::pi * std::pow(b.size[0], 3);
}

struct drawing {
  mechanism m;
  random r;
  bool drives = false;   ///< a driven body alone holds the mechanism
  bool passive = false;  ///< no motors

  drawing(std::uint64_t seed, bool around) : r(seed, 4) { m.seed = seed, m.around = around; }

  void add_bodies() {
    const int count = 2 + up_to(r, 11);
    drives = chance(r, 0.12);
    const bool held = !drives && chance(r, 0.8);
    const bool moves = chance(r, 0.6);
    vec3 middle = 0.3 * r.in_ball();
    if (m.around && chance(r, 0.5)) middle[up_to(r, 2)] += m.side;  // across the edge of the box
    for (int k = 0; k < count; ++k) {
      mechanism_body b;
      b.is_box = chance(r, 0.6);
      const real radius = r.uniform(0.06, 0.14);
      b.size = b.is_box
                   ? vec3(r.uniform(0.4, 1.6), r.uniform(0.4, 1.6), r.uniform(0.4, 1.6)) * radius
                   : vec3(radius, radius, radius);
      b.turn = r.rotation();
      if (drives && k == 0)
        b.how = role::driven;
      else if (held && k > 0 && chance(r, 0.15))
        b.how = chance(r, 0.6) ? role::fixed : role::global;
      else if (held && k == 0 && chance(r, 0.5))
        b.how = chance(r, 0.6) ? role::fixed : role::global;
      else if (m.wild && chance(r, 0.1))
        b.how = role::driven;
      if (b.how == role::driven) {
        if (chance(r, 0.5))
          b.stroke = 0.2 * r.in_ball(), b.speed = r.uniform(0.2, 2);
        else
          b.axis = r.unit_vector(), b.speed = r.uniform(-6, 6);
      }
      if (b.how == role::movable && moves)
        b.velocity = r.uniform(0, 3) * r.in_ball(), b.spin = r.uniform(0, 5) * r.in_ball();
      // Near one of those before, without an overlap.
      for (int attempt = 0;; ++attempt) {
        b.at = middle;
        if (k > 0) {
          const mechanism_body& last =
              m.bodies[static_cast<std::size_t>(chance(r, 0.6) ? k - 1 : up_to(r, k))];
          b.at =
              last.at + (radius_of(last) + radius_of(b) + r.uniform(0.02, 0.3)) * r.unit_vector();
        }
        const bool free = std::none_of(m.bodies.begin(), m.bodies.end(), [&](const auto& o) {
          return (o.at - b.at).norm() < radius_of(o) + radius_of(b) + 0.01;
        });
        if (free || attempt == 100) break;
      }
      m.bodies.push_back(b);
    }
    if (m.floor) {
      real lowest = 0;
      for (const auto& b : m.bodies) lowest = std::min(lowest, b.at[2] - radius_of(b));
      if (!m.around) m.side = 1;
      floor_below = lowest - r.uniform(0.01, 0.5);
      for (auto& b : m.bodies) b.at[2] -= floor_below;  // onto z = 0
    }
  }
  real floor_below = 0;

  [[nodiscard]] bool immovable(int k) const {
    return k < 0 || m.bodies[static_cast<std::size_t>(k)].how != role::movable;
  }
  void draw_axis(mechanism_axis& x, real torque, real length) {
    // `torque` is that of gravity, about; `length` 1 for angles
    if (chance(r, 0.35)) {
      x.lower = -length * r.uniform(0.05, 2), x.upper = length * r.uniform(0.05, 2);
      if (chance(r, 0.5)) x.restitution = r.uniform();
    }
    if (!passive && chance(r, 0.3)) {
      x.largest = torque * std::exp(r.uniform(-1, 3));
      if (chance(r, 0.5)) {
        x.motor_velocity = r.uniform(-8, 8) * length;
      } else {
        x.position = length * r.uniform(-2, 2);
        x.stiffness = torque / length * std::exp(r.uniform(-1, 5));
        if (chance(r, 0.7)) x.damping = x.stiffness * r.uniform(0, 0.2);
      }
    }
    if (chance(r, 0.25)) {
      x.spring = torque / length * std::exp(r.uniform(-1, 4));
      if (chance(r, 0.5)) x.spring_damping = x.spring * r.uniform(0, 0.1);
      x.rest = length * r.uniform(-1, 1);
    }
    if (chance(r, 0.25)) x.friction = torque * r.uniform(0, 0.6);
  }
  [[nodiscard]] mechanism_joint draw_joint(int a, int b) {
    mechanism_joint j;
    if (b < 0) std::swap(a, b);
    if (a >= 0 && chance(r, 0.5)) std::swap(a, b);
    j.a = a, j.b = b;
    static constexpr joint_kind kinds[] = {
        joint_kind::ball,          joint_kind::ball,      joint_kind::ball,
        joint_kind::hinge,         joint_kind::hinge,     joint_kind::hinge,
        joint_kind::hinge,         joint_kind::fixed,     joint_kind::weld,
        joint_kind::slider,        joint_kind::slider,    joint_kind::cylindrical,
        joint_kind::universal,     joint_kind::universal, joint_kind::rod,
        joint_kind::rod,           joint_kind::rope,      joint_kind::strut,
        joint_kind::point_on_plane};
    j.what = kinds[up_to(r, std::size(kinds))];
    j.fraction = chance(r, 0.7) ? r.uniform(0.2, 0.8) : r.integer(2);
    j.off = a < 0 ? vec3(r.uniform(0.05, 0.5) * r.unit_vector()) : vec3(0.05 * r.in_ball());
    j.axis = chance(r, 0.5) ? vec3(vec3::Unit(up_to(r, 3))) : r.unit_vector();
    j.second_axis = across(r, j.axis);
    real mass = 1e9;
    for (const int k : {a, b})
      if (k >= 0) mass = std::min(mass, mass_of(m.bodies[static_cast<std::size_t>(k)]));
    const bool slides = j.what == joint_kind::slider || j.what == joint_kind::strut;
    const real force = 10 * mass, length = 0.2;
    draw_axis(j.first, slides ? force : force * length, slides ? length : 1);
    const bool second_slides = j.what == joint_kind::cylindrical;
    draw_axis(j.second, second_slides ? force : force * length, second_slides ? length : 1);
    // What slides freely leaves the scene.
    for (auto [x, moves] : {std::pair(&j.first, slides), std::pair(&j.second, second_slides)})
      if (moves && !(x->upper < 9) && chance(r, 0.8))
        x->lower = -r.uniform(0.02, 0.3), x->upper = r.uniform(0.02, 0.3);
    j.strength = force * std::exp(r.uniform(-1, 4));
    j.restitution = chance(r, 0.5) ? r.uniform() : 0;
    return j;
  }
  void add_joints() {
    const int count = static_cast<int>(m.bodies.size());
    // A tree.
    for (int k = 1; k < count; ++k) {
      int parent = chance(r, 0.7) ? k - 1 : up_to(r, k);
      for (int attempt = 0; attempt < 10 && immovable(parent) && immovable(k); ++attempt)
        parent = up_to(r, k);
      if (immovable(parent) && immovable(k)) continue;
      if (chance(r, 0.93)) m.joints.push_back(draw_joint(parent, k));
    }
    // More of them: to the world, in loops, and on one pair.
    const bool fast = !drives || m.wild;
    for (int k = 0; k < count; ++k)
      if (fast && !immovable(k) && chance(r, k == 0 ? 0.3 : 0.05))
        m.joints.push_back(draw_joint(mechanism_joint::world, k));
    for (int extra = up_to(r, 4); extra > 1; --extra) {
      const int a = up_to(r, count), b = chance(r, 0.3) && a > 0 ? a - 1 : up_to(r, count);
      if (a == b || (immovable(a) && immovable(b))) continue;
      m.joints.push_back(draw_joint(a, b));
    }
    // Two wheels on the world, and gears between them.
    if (fast && chance(r, 0.25)) {
      std::vector<int> free;
      for (int k = 0; k < count; ++k) {
        const auto mine = [&](const auto& j) { return j.a == k || j.b == k; };
        if (!immovable(k) && std::none_of(m.joints.begin(), m.joints.end(), mine))
          free.push_back(k);
      }
      for (int k = 0; k < 2 && free.size() < 2; ++k) {
        mechanism_body wheel;
        wheel.size = vec3(0.1, 0.1, 0.1);
        wheel.at = vec3(1.1 + 0.3 * k, r.uniform(-0.2, 0.2), r.uniform(0.3, 0.6));
        wheel.spin = 5 * r.in_ball();
        free.push_back(static_cast<int>(m.bodies.size()));
        m.bodies.push_back(wheel);
      }
      for (int k = 0; k < 2; ++k) {
        mechanism_joint pin = draw_joint(mechanism_joint::world, free[static_cast<std::size_t>(k)]);
        pin.what = joint_kind::hinge, pin.off = vec3(0, 0, 0);
        m.joints.push_back(pin);
      }
      mechanism_joint teeth = m.joints.back();
      teeth.what = joint_kind::gear;
      teeth.a = free[0], teeth.b = free[1];
      teeth.axis = m.joints[m.joints.size() - 2].axis;
      teeth.second_axis = m.joints.back().axis;
      teeth.ratio = (chance(r, 0.5) ? 1 : -1) * std::exp(r.uniform(-1, 1));
      m.joints.push_back(teeth);
    }
  }
  void add_events() {
    const int bodies = static_cast<int>(m.bodies.size()),
              joints = static_cast<int>(m.joints.size());
    if (joints == 0) return;
    const auto later = [&] { return 1 + up_to(r, m.steps - 1); };
    for (int left = chance(r, 0.5) ? 0 : 1 + up_to(r, 6); left > 0; --left) {
      mechanism_event e;
      e.step = later();
      const int which = up_to(r, 12);
      e.target = up_to(r, bodies);
      e.value = r.uniform(0, 2) * r.in_ball();
      e.number = r.uniform();
      switch (which) {
        case 0:
        case 1:
          if (drives && !m.wild) continue;  // a second one that holds it
          e.what = event_kind::fix;
          break;
        case 2:
        case 3:
          e.what = event_kind::release;
          break;
        case 4:
          e.what = event_kind::destroy;
          break;
        case 5:
          e.what = event_kind::part, e.target = up_to(r, joints);
          break;
        case 6:
          if (passive) continue;
          e.what = event_kind::motor, e.target = up_to(r, joints);
          break;
        case 7:
          e.what = event_kind::push;
          break;
        case 8:
          e.what = m.wild ? event_kind::shift : event_kind::push;
          e.value *= 0.05;
          break;
        case 9:
          e.what = event_kind::gravity, e.value *= 5;
          break;
        case 10:
          e.what = event_kind::synchronize;
          break;
        default: {
          const int a = up_to(r, bodies), b = up_to(r, bodies);
          if (a == b || (immovable(a) && immovable(b)) || (drives && !m.wild && immovable(b)))
            continue;
          mechanism_joint j = draw_joint(a, chance(r, 0.2) && !drives ? mechanism_joint::world : b);
          if (immovable(j.a) && immovable(j.b)) continue;
          j.step = e.step;
          m.joints.push_back(j);
          continue;
        }
      }
      m.events.push_back(e);
    }
    if (chance(r, 0.25)) {
      static constexpr int counts[] = {1, 2, 4, 7};
      m.events.push_back(
          {.what = event_kind::restart, .step = later(), .target = counts[up_to(r, 4)]});
    }
    if (!m.around && !m.balances && chance(r, 0.15))
      m.events.push_back({.what = event_kind::divide, .step = later(), .number = r.uniform()});
    std::stable_sort(m.events.begin(), m.events.end(),
                     [](const auto& x, const auto& y) { return x.step < y.step; });
  }
};

std::string say(const vec3& v) { return talus::detail::text(v); }
std::string say(real x) { return talus::detail::text(x, 3); }

void say_axis(std::string& s, const char* name, const mechanism_axis& x) {
  std::string t;
  if (x.upper < 1e9)
    t += " limits " + say(x.lower) + " to " + say(x.upper) +
         (x.restitution > 0 ? " of restitution " + say(x.restitution) : "");
  if (x.largest > 0 && x.stiffness == 0)
    t += " motor of velocity " + say(x.motor_velocity) + " with at most " + say(x.largest);
  if (x.largest > 0 && x.stiffness > 0)
    t += " motor to " + say(x.position) + " of stiffness " + say(x.stiffness) + ", damping " +
         say(x.damping) + ", with at most " + say(x.largest);
  if (x.spring > 0)
    t +=
        " spring " + say(x.spring) + ", damping " + say(x.spring_damping) + ", rest " + say(x.rest);
  if (x.friction > 0) t += " friction " + say(x.friction);
  if (!t.empty()) s += std::string("; ") + name + ":" + t;
}

}  // namespace

mechanism draw_mechanism(std::uint64_t seed, bool around) {
  drawing d(seed, around);
  mechanism& m = d.m;
  random& r = d.r;
  m.reproducible = chance(r, 0.6);
  m.wild = chance(r, 0.05);
  d.passive = chance(r, 0.4);
  m.floor = chance(r, 0.25);
  m.sleeps = chance(r, 0.3);
  m.how = static_cast<mechanism::domains>(up_to(r, 5));
  static constexpr int counts[] = {2, 4, 7};
  m.ranks = counts[up_to(r, 3)];
  if (m.how == mechanism::domains::hexagonal) m.ranks = 7;
  if (around) m.how = mechanism::domains::grid;
  m.balances = m.how == mechanism::domains::bisection && chance(r, 0.6);
  m.dt = r.integer(2) ? 0.005 : r.uniform(0.001, 0.01);
  m.steps = 100 + up_to(r, m.ranks == 2 ? 301 : m.ranks == 4 ? 101 : 51);
  m.reach = chance(r, 0.2) ? (around ? 3 : 9) : 1.5;
  m.iterations = 2 + up_to(r, 5);
  if (chance(r, 0.75)) m.gravity = chance(r, 0.8) ? vec3(0, 0, -9.81) : vec3(9.81 * r.in_ball());
  m.friction = chance(r, 0.5) ? r.uniform() : 0;
  m.restitution = chance(r, 0.5) ? r.uniform() : 0;
  m.side = around ? 6 : r.uniform(0.3, 1.2);
  d.add_bodies();
  d.add_joints();
  d.add_events();
  return m;
}

std::string text(const mechanism& m) {
  static const char* const roles[] = {"movable", "fixed", "global", "driven"};
  static const char* const kinds[] = {"ball",   "fixed joint", "weld",           "hinge",
                                      "slider", "cylindrical", "universal",      "rod",
                                      "rope",   "strut",       "point on plane", "gear"};
  static const char* const events[] = {"fix body",
                                       "release body",
                                       "destroy body",
                                       "release joint",
                                       "other motor of joint",
                                       "push body",
                                       "shift body",
                                       "gravity",
                                       "synchronize",
                                       "checkpoint and restart on ranks",
                                       "divide again"};
  static const char* const ways[] = {"grid", "slabs", "bisection", "cells", "hexagonal"};
  std::string s = std::string(m.reproducible ? "reproducible" : "default solver") +
                  (m.wild ? ", perhaps inconsistent" : "") + ", " + std::to_string(m.steps) +
                  " steps of " + talus::detail::text(m.dt) + ", " + std::to_string(m.ranks) +
                  " ranks, " + (m.around ? "periodic " : "") + ways[int(m.how)] + " of half side " +
                  say(m.side) + (m.balances ? " that balances" : "") + ", gravity " +
                  say(m.gravity) + (m.sleeps ? ", sleeping" : "") +
                  (m.floor ? ", a floor at z = 0 of friction " + say(m.friction) +
                                 " and restitution " + say(m.restitution)
                           : "");
  int item = 0;
  for (std::size_t k = 0; k < m.bodies.size(); ++k, ++item) {
    if (!m.has_body(item)) continue;
    const auto& b = m.bodies[k];
    s += "\n  " + std::to_string(item) + ": body " + std::to_string(k) + ", a " +
         roles[int(b.how)] +
         (b.is_box ? " box of " + say(b.size) : " sphere of radius " + say(b.size[0])) + " at " +
         say(b.at);
    if (b.velocity.norm() > 0) s += ", velocity " + say(b.velocity) + ", spin " + say(b.spin);
    if (b.how == role::driven)
      s += b.stroke.norm() > 0 ? ", oscillates by " + say(b.stroke) + " at " + say(b.speed) + " Hz"
                               : ", turns about " + say(b.axis) + " at " + say(b.speed) + " rad/s";
  }
  for (std::size_t k = 0; k < m.joints.size(); ++k, ++item) {
    if (!m.has_joint(static_cast<int>(k))) continue;
    const auto& j = m.joints[k];
    const auto name = [](int body) {
      return body < 0 ? std::string("the world") : "body " + std::to_string(body);
    };
    s += "\n  " + std::to_string(item) + ": joint " + std::to_string(k) + ", " +
         kinds[int(j.what)] + " of " + name(j.a) + " and " + name(j.b);
    if (j.step > 0) s += ", made before step " + std::to_string(j.step);
    if (j.what == joint_kind::weld) s += ", breaks at " + say(j.strength);
    if (j.what == joint_kind::gear) s += ", ratio " + say(j.ratio);
    if (j.what == joint_kind::rope) s += ", restitution " + say(j.restitution);
    const bool one =
        j.what == joint_kind::hinge || j.what == joint_kind::slider || j.what == joint_kind::strut;
    const bool two = j.what == joint_kind::cylindrical || j.what == joint_kind::universal;
    if (one || two) say_axis(s, two ? "first" : "axis", j.first);
    if (two) say_axis(s, "second", j.second);
  }
  for (std::size_t k = 0; k < m.events.size(); ++k, ++item) {
    if (!m.has_event(static_cast<int>(k))) continue;
    const auto& e = m.events[k];
    s += "\n  " + std::to_string(item) + ": before step " + std::to_string(e.step) + " " +
         events[int(e.what)];
    if (e.what != event_kind::gravity && e.what != event_kind::synchronize &&
        e.what != event_kind::divide)
      s += " " + std::to_string(e.target);
    if (e.what == event_kind::push || e.what == event_kind::gravity || e.what == event_kind::shift)
      s += " " + say(e.value);
  }
  return s;
}

}  // namespace fuzz
