#pragma once
/// \file
/// Data of M. Dosta and others, "Comparing open-source DEM frameworks for simulations of common
/// bulk processes", Computer Physics Communications 296 (2024) 109066: materials, and readers of
/// the files of spheres and of triangles that the authors publish. SI units.
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <talus/body/material.hpp>
#include <talus/core/math.hpp>
#include <vector>

namespace dosta {

inline constexpr double gravity = 9.8;

/// The three materials of a world.
struct materials {
  talus::material_id m1, m2, steel;
};

/// Adds the materials and their pairs. `softness` divides Young's moduli of the spheres: 1 as
/// published, 500 in the cheap variant of the drum. `softness_of_steel` divides that of steel.
template <class World>
materials add_materials(World& world, double softness = 1, double softness_of_steel = 1) {
  const auto add = [&](double modulus, double density, double restitution, double friction) {
    return world.material({.density = density,
                           .restitution = restitution,
                           .friction = friction,
                           .youngs_modulus = modulus,
                           .poisson_ratio = 0.2});
  };
  const materials m{add(1e9 / softness, 2500, 0.5, 0.3), add(0.5e9 / softness, 2000, 0.4, 0.4),
                    add(210e9 / softness_of_steel, 7200, 0.6, 0.5)};
  world.material_pair(m.m1, m.m2, {.restitution = 0.45, .friction = 0.2});
  world.material_pair(m.m1, m.steel, {.restitution = 0.4, .friction = 0.2});
  world.material_pair(m.m2, m.steel, {.restitution = 0.4, .friction = 0.2});
  return m;
}

/// A sphere of a file.
struct grain {
  double radius;
  talus::vec3 position;
};

/// The lines of a file after its first one, each as `Count` numbers; lines with another number of
/// entries are skipped (the file of the penetration ends with such a line). Throws runtime_error if
/// the file cannot be read or has no line of numbers.
template <std::size_t Count>
std::vector<std::array<double, Count>> read_table(const std::string& file) {
  std::ifstream in(file);
  std::vector<std::array<double, Count>> rows;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::array<double, Count> row;
    std::size_t count = 0;
    for (double x; words >> x; ++count)
      if (count < Count) row[count] = x;
    if (count == Count) rows.push_back(row);
  }
  if (rows.empty())
    throw std::runtime_error("cannot read " + file + ": there is no line of " +
                             std::to_string(Count) + " numbers");
  return rows;
}

/// The spheres of a file with the columns radius, x, y, z.
inline std::vector<grain> read_spheres(const std::string& file) {
  std::vector<grain> grains;
  for (const auto& row : read_table<4>(file))
    grains.push_back({row[0], talus::vec3(row[1], row[2], row[3])});
  return grains;
}

/// The triangles of a file with the coordinates of three corners in each line.
inline std::vector<std::array<talus::vec3, 3>> read_triangles(const std::string& file) {
  std::vector<std::array<talus::vec3, 3>> triangles;
  for (const auto& t : read_table<9>(file))
    triangles.push_back({talus::vec3(t[0], t[1], t[2]), talus::vec3(t[3], t[4], t[5]),
                         talus::vec3(t[6], t[7], t[8])});
  return triangles;
}

}  // namespace dosta
