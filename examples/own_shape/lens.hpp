#pragma once
// A lens: what two equal balls have in common. All that talus needs of a shape is in this file.
#include <cmath>

#include <talus/talus.hpp>

/// Round about the z axis, with a sharp rim.
struct lens {
  talus::real radius = 1;     ///< of the rim, length
  talus::real thickness = 1;  ///< along the axis, length, up to twice the radius (a ball)

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;  // its orientation matters
  static constexpr bool flat_sides = false;
  static constexpr const char* name = "lens";
  static constexpr const char* numbers[] = {"radius", "thickness"};  // for Python

  /// Throws invalid_argument for a lens without volume, and for one thicker than a ball.
  void validate() const {
    if (!(radius > 0) || !(thickness > 0) || !(thickness <= 2 * radius))
      throw std::invalid_argument("a lens needs a positive radius, and a thickness up to twice it");
  }

  /// Of the two balls.
  [[nodiscard]] talus::real ball() const {
    const talus::real h = thickness / 2;
    return (radius * radius + h * h) / (2 * h);
  }
  [[nodiscard]] talus::real bounding_radius() const { return radius; }
  /// Of two caps of the height h of a ball of radius R: pi h^2 (3 R - h) / 3 each.
  [[nodiscard]] talus::real volume() const {
    const talus::real h = thickness / 2, R = ball();
    return 2 * talus::pi * h * h * (3 * R - h) / 3;
  }
  /// Principal moments per unit of mass, from the integrals of x^2 and z^2 over the discs of one
  /// cap, whose radius at the height z is s(z) with s^2 = R^2 - (R - h + z)^2.
  [[nodiscard]] talus::vec3 inertia() const {
    const talus::real h = thickness / 2, R = ball(), c = R - h, q = radius * radius;
    // s^2 = q - 2 c z - z^2; integrals of s^4 / 4 and of z^2 s^2, over z from 0 to h.
    const talus::real h2 = h * h, h3 = h2 * h, h4 = h3 * h, h5 = h4 * h;
    const talus::real fourth =
        q * q * h - 2 * q * c * h2 + (4 * c * c - 2 * q) * h3 / 3 + c * h4 + h5 / 5;
    const talus::real x2 = talus::pi * fourth / 4;
    const talus::real z2 = talus::pi * (q * h3 / 3 - c * h4 / 2 - h5 / 5);
    const talus::real each = 2 / volume();
    return {each * (x2 + z2), each * (x2 + z2), each * 2 * x2};
  }
  /// A point of the cap that faces the direction, or of the rim.
  [[nodiscard]] talus::vec3 support(const talus::vec3& direction) const {
    const talus::real R = ball(), c = R - thickness / 2;
    const talus::real length = direction.norm();
    if (!(length > 0)) return {0, 0, thickness / 2};
    const talus::vec3 d = direction / length;
    const talus::real across = std::sqrt(d[0] * d[0] + d[1] * d[1]);
    if (R * across <= radius) {
      const talus::real up = d[2] < 0 ? -1 : 1;
      return {R * d[0], R * d[1], R * d[2] - up * c};
    }
    return {radius * d[0] / across, radius * d[1] / across, 0};
  }
  /// Half the edges of the box around it: its reach along each axis of the world.
  [[nodiscard]] talus::vec3 half_extents(const talus::pose& at) const {
    talus::vec3 half;
    const talus::mat3 axes = at.orientation.toRotationMatrix();
    for (int i = 0; i < 3; ++i) {
      const talus::vec3 d(axes(i, 0), axes(i, 1), axes(i, 2));
      half[i] = d.dot(support(d));
    }
    return half;
  }

  friend bool operator==(const lens&, const lens&) = default;
};
