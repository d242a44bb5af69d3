#pragma once
// What the states of bodies are judged by: drift of the joints, energy, values of the probes.
#include <algorithm>
#include <cmath>

#include "scene.hpp"

namespace bench::joints {

/// Distance by which a joint is apart, m; wrong angles count by the length of the scene.
inline double gap(const scene& s, const std::vector<state>& now, const joint& j) {
  vec apart = moved_point(s, now, j.b, j.at) - moved_point(s, now, j.a, j.at);
  double twist = 0;
  if (j.type != kind::ball) {
    const vec axis = moved_direction(s, now, j.a, j.axis);
    twist = (axis - moved_direction(s, now, j.b, j.axis)).norm();
    if (j.type == kind::slider) {
      apart -= axis * axis.dot(apart);
      const vec side = j.axis.unitOrthogonal();
      twist = std::max(
          twist, (moved_direction(s, now, j.a, side) - moved_direction(s, now, j.b, side)).norm());
    }
  }
  return std::max(apart.norm(), twist * s.length);
}

inline double largest_gap(const scene& s, const std::vector<state>& now) {
  double most = 0;
  for (const joint& j : s.joints) {
    const double apart = gap(s, now, j);
    if (!(apart <= most)) most = apart;  // also when it is not a number
  }
  return most;
}

/// Kinetic and potential energy of bodies and springs, J.
inline double energy(const scene& s, const std::vector<state>& now) {
  double sum = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const vec spin = now[i].orientation.conjugate() * now[i].spin;
    sum += s.bodies[i].mass * (now[i].velocity.squaredNorm() / 2 - s.gravity.dot(now[i].position)) +
           spin.dot(s.bodies[i].inertia.cwiseProduct(spin)) / 2;
  }
  for (const spring& k : s.springs) {
    const vec span = moved_point(s, now, k.b, k.at_b) - moved_point(s, now, k.a, k.at_a);
    sum += k.stiffness * std::pow(span.norm() - k.rest, 2) / 2;
  }
  return sum;
}

/// Values of all probes, three coordinates each.
inline std::vector<double> values(const scene& s, const std::vector<state>& now) {
  std::vector<double> list;
  for (const probe& p : s.probes) {
    const vec v =
        p.direction ? moved_direction(s, now, p.of, p.at) : moved_point(s, now, p.of, p.at);
    list.insert(list.end(), v.data(), v.data() + 3);
  }
  return list;
}

/// Force on the second point of a spring, from the states.
inline vec spring_force(const scene& s, const std::vector<state>& now, const spring& k) {
  const vec pa = moved_point(s, now, k.a, k.at_a), pb = moved_point(s, now, k.b, k.at_b);
  vec speed = now[k.b].velocity + now[k.b].spin.cross(pb - now[k.b].position);
  if (k.a != ground) speed -= now[k.a].velocity + now[k.a].spin.cross(pa - now[k.a].position);
  const double length = (pb - pa).norm();
  const vec way = (pb - pa) / length;
  return -way * (k.stiffness * (length - k.rest) + k.damping * way.dot(speed));
}

}  // namespace bench::joints
