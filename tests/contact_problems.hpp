#pragma once
// Random frictional contact problems with an assembled Delassus operator, from bodies and contacts.
#include <Eigen/Core>
#include <cmath>
#include <utility>
#include <vector>

#include "generator.hpp"
#include "talus/constraint/general_contact.hpp"
#include "talus/solver/direct/assembled.hpp"

namespace talus {

/// Bodies and contacts between them; an impulse acts on `a`, its opposite on `b` (-1: the ground).
struct contact_scene {
  struct body {
    real mass;
    vec3 inertia;  ///< principal moments, along the axes of the world
    vec3 position, velocity{0, 0, 0}, spin{0, 0, 0};
  };
  struct contact {
    int a, b;
    vec3 point, normal;  ///< from b to a
    real mu;
    real least = 0;  ///< required separating velocity
  };
  std::vector<body> bodies;
  std::vector<contact> contacts;

  void box(real mass, const vec3& edges, const vec3& position) {
    const vec3 s = edges.cwiseProduct(edges);
    bodies.push_back({mass, mass / 12 * vec3(s[1] + s[2], s[0] + s[2], s[0] + s[1]), position});
  }
  /// Contacts on a grid of k by k points with its corners at +-half.
  void face(int a, int b, const vec3& middle, const vec3& normal, real half, int k, real mu) {
    const mat3 f = detail::frame_around(normal);
    for (int i = 0; i < k; ++i)
      for (int j = 0; j < k; ++j) {
        const real x = half * (2. * i / (k - 1) - 1), y = half * (2. * j / (k - 1) - 1);
        contacts.push_back({a, b, middle + f.transpose() * vec3(0, x, y), normal, mu});
      }
  }

  [[nodiscard]] detail::assembled_problem problem() const {
    const auto n = static_cast<int>(contacts.size());
    // Rows of a contact for one of its bodies: its velocity and spin, in the frame.
    const auto jacobian = [&](const contact& c, int body) {
      Eigen::Matrix<real, 3, 6> h;
      const vec3 arm = c.point - bodies[body].position;
      const mat3 f = detail::frame_around(c.normal);
      h << Eigen::Matrix3d(f), Eigen::Matrix3d(-f * detail::cross_matrix(arm));
      return body == c.a ? h : Eigen::Matrix<real, 3, 6>(-h);
    };
    std::vector<std::vector<int>> of(bodies.size());
    detail::contact_vector q(n);
    detail::plain_vector<real> mu;
    for (int i = 0; i < n; ++i) {
      const contact& c = contacts[i];
      for (const int k : {c.a, c.b}) {
        if (k < 0) continue;
        of[k].push_back(i);
        Eigen::Matrix<real, 6, 1> v;
        v << Eigen::Vector3d(bodies[k].velocity), Eigen::Vector3d(bodies[k].spin);
        q(i) += vec3(Eigen::Vector3d(jacobian(c, k) * v));
      }
      q(i)[0] -= c.least;
      mu.push_back(c.mu);
    }
    detail::plain_vector<detail::delassus_block> blocks;
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      Eigen::Matrix<real, 6, 1> inverse;
      inverse << Eigen::Vector3d::Constant(1 / bodies[k].mass),
          Eigen::Vector3d(bodies[k].inertia.cwiseInverse());
      for (const int i : of[k])
        for (const int j : of[k])
          blocks.push_back(
              {i, j,
               Eigen::Matrix3d(jacobian(contacts[i], static_cast<int>(k)) * inverse.asDiagonal() *
                               jacobian(contacts[j], static_cast<int>(k)).transpose())});
    }
    return detail::assemble(std::move(blocks), std::move(q), std::move(mu));
  }
};

/// Cubes of edge 1 on each other, with k by k contacts on every face; mass ratio^(i / (n - 1)) from
/// below. They start with gravity's velocity and a horizontal velocity.
inline contact_scene stack_of_boxes(int n, real ratio, real mu, int k, const vec3& push) {
  contact_scene s;
  for (int i = 0; i < n; ++i) {
    s.box(n > 1 ? std::pow(ratio, real(i) / (n - 1)) : 1, {1, 1, 1}, {0, 0, i + 0.5});
    s.bodies.back().velocity = push + vec3(0, 0, -0.05);
    s.face(i, i - 1, {0, 0, real(i)}, {0, 0, 1}, 0.5, k, mu);
  }
  return s;
}

/// A wall of bricks, each on two below it.
inline contact_scene wall_of_boxes(int width, int height, real mu, generator& random) {
  contact_scene s;
  for (int row = 0; row < height; ++row)
    for (int i = 0; i < width; ++i) {
      const vec3 place(i + 0.5 * (row % 2), 0, row + 0.5);
      s.box(std::pow(10., random(-1, 1)), {1, 1, 1}, place);
      s.bodies.back().velocity = random.point(0.02) + vec3(0, 0, -0.05);
      const int me = row * width + i;
      for (const int side : {0, 1}) {
        const int below = i + side - (row % 2 == 0 ? 1 : 0);
        const bool ground = row == 0;
        if (!ground && (below < 0 || below >= width)) continue;
        const vec3 middle(place[0] + (side - 0.5) * 0.5, 0, row);
        for (const real x : {-0.25, 0.25})
          for (const real y : {-0.5, 0.5})
            s.contacts.push_back(
                {me, ground ? -1 : me - i - width + below, middle + vec3(x, y, 0), {0, 0, 1}, mu});
      }
    }
  return s;
}

/// Bodies at random places, each touching some others and the ground, at random points.
inline contact_scene random_cluster(int bodies, int contacts, real decades, real most_friction,
                                    generator& random) {
  contact_scene s;
  for (int i = 0; i < bodies; ++i) {
    const real m = std::pow(10., random(0, decades));
    s.bodies.push_back({m, m * vec3{random(0.05, 1), random(0.05, 1), random(0.05, 1)},
                        random.point(0.5 * std::cbrt(bodies)), random.point(1), random.point(1)});
    s.bodies.back().velocity[2] -= 1;
  }
  for (int c = 0; c < contacts; ++c) {
    const int a = static_cast<int>(random(0, bodies));
    int b = static_cast<int>(random(-0.3 * bodies, bodies));
    if (b < 0 || b == a) b = -1;
    const vec3 at = s.bodies[a].position,
               to = b < 0 ? vec3(at + vec3(0, 0, -1) + random.point(0.3)) : s.bodies[b].position;
    const vec3 normal = ((at - to).normalized() + random.point(0.5)).normalized();
    s.contacts.push_back(
        {a, b, 0.5 * (at + to) + random.point(0.2), normal, random(0, most_friction)});
  }
  return s;
}

}  // namespace talus
