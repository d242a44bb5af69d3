#pragma once
// Experiments with granular media, small or large: a cooling gas, a poured pile, a silo, its
// outlet, and a heap. Lengths in mean diameters or near them, gravity 9.81.
#include <numbers>

#include "grains.hpp"

namespace talus::validation {

inline constexpr real gravity = 9.81;

// --- Haff: a gas of inelastic frictionless spheres ---------------------------------------------

struct cooling {
  real tau = 0;                            ///< from the measured T0
  real worst = 0;                          ///< of T (1 + t/tau)^2 / T0 - 1
  std::vector<std::array<real, 2>> curve;  ///< time over tau, temperature over T0
};

/// n spheres of mass and diameter 1 in a box of elastic walls instead of a periodic box. The volume
/// is that accessible to centres. Beside a wall, spheres have fewer collisions: at a distance z < 1
/// of its centre's reach a part (1 - z) / 2 of the directions lies behind the wall, which equals a
/// layer of a quarter diameter without collisions. So tau is longer than that of an unbounded gas
/// (to first order in the density).
inline cooling cool_gas(std::size_t n, real fraction, real restitution, real until, int ranks = 1,
                        real dt = 0.01) {
  using gas = scenario<bodies<sphere, plane>, hard_contact<newton_restitution>,
                       decomposition<grid<dynamic, dynamic>>, transport<threads>>;
  const real side = std::cbrt(static_cast<real>(n) * pi / 6 / fraction) + 1;
  cooling result;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<gas> w(link, grid<dynamic, dynamic>{.lower = {0, 0}, .upper = {side, side}});
    const auto hard = w.material({.density = 6 / pi, .restitution = restitution});
    const auto elastic = w.material({.density = 1});
    w.material_pair(hard, elastic, {.restitution = 1});
    w.global([&](auto& s) {
      for (int k = 0; k < 3; ++k) {
        vec3 normal(0, 0, 0);
        normal[k] = 1;
        s.add(plane{.normal = normal, .offset = 0}, elastic);
        s.add(plane{.normal = -normal, .offset = -side}, elastic);
      }
    });
    const auto sites = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<real>(n))));
    const real spacing = (side - 1.02) / static_cast<real>(sites - 1);
    w.fill((simple_cubic{.spacing = spacing, .origin = {0.51, 0.51, 0.51}} &
            box_region{{0.5, 0.5, 0.5}, vec3::Constant(side - 0.5)})
               .first(n),
           [&](const site& at, random_stream& random) {
             vec3 v;  // Maxwell's distribution of temperature 1 (Box, Muller 1958)
             for (int k = 0; k < 3; ++k)
               v[k] = std::sqrt(-2 * std::log(1 - random.uniform())) *
                      std::cos(2 * pi * random.uniform());
             return body{.shape = sphere{0.5}, .position = at.position, .velocity = v};
           });
    const auto temperature = [&] {
      return 2 * measure_motion(w).kinetic_energy / (3 * static_cast<real>(n));
    };
    const real start = temperature();
    const real density = 6 * fraction / pi;
    const real chi = (1 - fraction / 2) / std::pow(1 - fraction, 3);
    const real hit = 1 - 6 * 0.25 / (side - 1);
    const real tau = 3 / (hit * 2 * std::sqrt(pi) * (1 - restitution * restitution) * density *
                          chi * std::sqrt(start));
    if (link.rank() == 0) result.tau = tau;
    const int samples = 16;
    const auto steps = static_cast<std::size_t>(until * tau / samples / dt);
    for (int k = 0; k < samples; ++k) {
      w.simulate({.steps = steps, .dt = dt});
      const real now = temperature();
      if (link.rank() != 0) continue;
      const real t = w.time() / tau, error = now / start * (1 + t) * (1 + t) - 1;
      result.curve.push_back({t, now / start});
      if (!(std::abs(error) <= std::abs(result.worst))) result.worst = error;
    }
  });
  return result;
}

// --- A poured pile ------------------------------------------------------------------------------

struct packing {
  real fraction = 0;  ///< in the bulk: three diameters from walls, floor and surface
  coordination contacts;
  real height = 0, kinetic_energy = 0;  ///< the latter per grain, over m g r
};

/// Spheres of radius .4 to .5 fall from a lattice into a box and come to rest.
inline packing pour(std::size_t n, real friction, real seconds, int ranks = 1, real height = 1) {
  using pile = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, split_correction>,
                        decomposition<grid<dynamic, dynamic>>, transport<threads>>;
  const real dt = 1.0 / 240;
  const auto sites = std::ceil(std::cbrt(static_cast<real>(n) / height));
  const real side = 1.05 * sites;
  snapshot grains;
  packing result;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<pile> w(link, grid<dynamic, dynamic>{.lower = {0, 0}, .upper = {side, side}});
    w.material({.density = 1, .friction = friction});
    w.gravity({0, 0, -gravity});
    w.global([&](auto& s) {
      s.add(plane{.normal = {0, 0, 1}}, {});
      s.add(plane{.normal = {1, 0, 0}}, {});
      s.add(plane{.normal = {-1, 0, 0}, .offset = -side}, {});
      s.add(plane{.normal = {0, 1, 0}}, {});
      s.add(plane{.normal = {0, -1, 0}, .offset = -side}, {});
    });
    w.fill((simple_cubic{.spacing = 1.05, .origin = {0.525, 0.525, 0.6}} &
            box_region{{0, 0, 0}, {side, side, 100 * side}})
               .first(n),
           [&](const site& at, random_stream& random) {
             return body{.shape = sphere{random.uniform(0.4, 0.5)},
                         .position = at.position +
                                     random.uniform(vec3::Constant(-0.02), vec3::Constant(0.02))};
           });
    w.simulate({.steps = static_cast<std::size_t>(seconds / dt), .dt = dt});
    const auto m = measure_motion(w);
    if (link.rank() == 0) result.kinetic_energy = m.kinetic_energy / (m.mass * gravity * 0.45);
    grains.gather(w);
  });
  std::vector<real> heights;
  for (const grain& g : grains.all()) heights.push_back(g.position[2]);
  std::sort(heights.begin(), heights.end());
  result.height = heights[heights.size() * 98 / 100];
  const real margin = 3 * 0.9;
  const vec3 lower = vec3::Constant(margin);
  const vec3 upper(side - margin, side - margin, result.height - margin);
  result.fraction = packing_fraction(grains.all(), lower, upper);
  result.contacts = coordination_number(grains.all(), lower, upper);
  return result;
}

// --- Janssen: a silo whose walls creep upwards ---------------------------------------------------

struct silo_stress {
  real lambda = 0;                           ///< of the best fit
  real misfit = 0;                           ///< root mean square over the saturation stress
  real floor_share = 0;                      ///< force on the floor over the weight
  real floor_misfit = 0;                     ///< |floor - fit at the floor| over the fit
  real depth_over_lambda = 0;                ///< depth of the silo over lambda
  real balance = 0;                          ///< |weight - floor - walls| over the weight
  std::vector<std::array<real, 3>> profile;  ///< depth, stress, stress of the fit
};

/// A square silo, filled; then its walls creep upwards, so that wall friction is mobilised
/// everywhere, as in the theory.
inline silo_stress fill_silo(real width, std::size_t n, real seconds, real measured,
                             real creep = 0.1) {
  using silo = scenario<bodies<sphere, box, plane>,
                        hard_contact<coulomb_friction, split_correction>, transport<serial>>;
  const real dt = 1.0 / 240, tall = 2 * static_cast<real>(n) / (width * width), thick = 2;
  serial::link link;
  world<silo> w(link);
  w.material({.density = 1, .friction = 0.5});
  w.gravity({0, 0, -gravity});
  const auto floor = w.add(body{
      .shape = box{{3 * width, 3 * width, thick}}, .position = {0, 0, -thick / 2}, .fixed = true});
  std::vector<handle<box>> walls;
  for (int k = 0; k < 4; ++k) {
    const vec3 out(k == 0 ? 1 : k == 1 ? -1 : 0, k == 2 ? 1 : k == 3 ? -1 : 0, 0);
    const vec3 size(k < 2 ? thick : width + 4, k < 2 ? width + 4 : thick, tall);
    walls.push_back(w.add(body{.shape = box{size},
                               .position = (width + thick) / 2 * out + vec3(0, 0, tall / 2),
                               .fixed = true}));
    w[walls.back()].set_velocity({0, 0, creep});
  }
  const real edge = width / 2 - 0.5;
  w.fill((simple_cubic{.spacing = 1.05, .origin = {-edge, -edge, 0.6}} &
          box_region{{-edge - 0.01, -edge - 0.01, 0}, {edge + 0.01, edge + 0.01, tall}})
             .first(n),
         [&](const site& at, random_stream& random) {
           return body{.shape = sphere{random.uniform(0.4, 0.5)},
                       .position = at.position +
                                   random.uniform(vec3::Constant(-0.02), vec3::Constant(0.02))};
         });
  w.simulate({.steps = static_cast<std::size_t>(seconds / dt), .dt = dt});

  // Vertical forces of walls and floor on grains, by height, as a mean over time.
  const auto bins = static_cast<std::size_t>(tall);
  std::vector<real> weight(bins), lifted(bins);
  real on_floor = 0;
  const auto bin = [&](real z) {
    return std::min(bins - 1, static_cast<std::size_t>(std::max(z, real(0))));
  };
  const auto steps = static_cast<std::size_t>(measured / dt);
  real top = 0;
  for (std::size_t k = 0; k < steps; ++k) {
    w.step(dt);
    std::map<system_id, real> height;
    w.for_each_local([&](const auto& b) {
      if (b.is_fixed()) return;
      height[b.id()] = b.position()[2];
      weight[bin(b.position()[2])] += b.mass() * gravity / static_cast<real>(steps);
    });
    for (const auto& c : talus::detail::state_of(w).history.entries()) {
      const auto of_a = height.find(c.key.a), of_b = height.find(c.key.b);
      const bool a = of_a != height.end(), b = of_b != height.end();
      if (a == b) continue;
      const real force = (a ? 1 : -1) * c.memory[2] / dt / static_cast<real>(steps);
      if (c.key.a == floor.id || c.key.b == floor.id)
        on_floor += force;
      else
        lifted[bin(a ? of_a->second : of_b->second)] += force;
    }
  }
  while (top < static_cast<real>(bins) - 1 && weight[static_cast<std::size_t>(top)] > 0) ++top;

  silo_stress result;
  const real area = width * width;
  real total = 0, walls_lift = 0;
  for (std::size_t z = 0; z < bins; ++z) total += weight[z], walls_lift += lifted[z];
  result.floor_share = on_floor / total;
  result.balance = std::abs(total - on_floor - walls_lift) / total;
  // Weight per volume, without the lowest and the loose topmost layers.
  real bulk = 0;
  const auto high = static_cast<std::size_t>(top);
  for (std::size_t z = 2; z + 4 < high; ++z) bulk += weight[z] / area / static_cast<real>(high - 6);
  const real surface = total / area / bulk;  // as if filled evenly
  std::vector<std::array<real, 2>> points;   // depth and stress at the lower faces of bins
  real above = 0;
  for (std::size_t z = high; z-- > 1;) {
    above += weight[z] - lifted[z];
    const real depth = surface - static_cast<real>(z);
    if (depth > 1) points.push_back({depth, above / area});
  }
  const auto fit = [&](real lambda, real depth) {
    return bulk * lambda * (1 - std::exp(-depth / lambda));
  };
  const auto misfit = [&](real lambda) {
    real sum = 0;
    for (const auto& [depth, stress] : points) sum += std::pow(stress - fit(lambda, depth), 2);
    return std::sqrt(sum / static_cast<real>(points.size()));
  };
  real least = misfit(result.lambda = 0.1 * width);
  for (real lambda = 0.1 * width; lambda < 20 * width; lambda *= 1.005)
    if (const real m = misfit(lambda); m < least) least = m, result.lambda = lambda;
  result.misfit = least / (bulk * result.lambda);
  result.depth_over_lambda = surface / result.lambda;
  const real fitted = fit(result.lambda, surface);
  result.floor_misfit = std::abs(on_floor / area - fitted) / fitted;
  for (const auto& [depth, stress] : points)
    result.profile.push_back({depth, stress, fit(result.lambda, depth)});
  return result;
}

// --- Beverloo: flow through a round orifice ------------------------------------------------------

struct outflow {
  real diameter = 0;  ///< of the circle of the same area, over the mean diameter
  real rate = 0;      ///< mass per time
  real bulk = 0;      ///< bulk density above the orifice
};

/// A square silo with an orifice of 16 edges in its floor. Grains that fall out are put back on
/// top, so that the head stays constant.
inline outflow discharge(real diameter, real fill, real settle, real measured) {
  using silo = scenario<bodies<sphere, box, plane>,
                        hard_contact<coulomb_friction, split_correction>, transport<serial>>;
  const int edges = 16;
  const real dt = 1.0 / 240, width = std::max<real>(2.6 * diameter, diameter + 8), thick = 0.2;
  // Distance of the edges for which the area is that of the circle.
  const real apothem = diameter / 2 * std::sqrt(pi / (edges * std::tan(pi / edges)));
  serial::link link;
  world<silo> w(link);
  w.material({.density = 1, .friction = 0.3});
  w.gravity({0, 0, -gravity});
  w.global([&](auto& s) {
    s.add(plane{.normal = {1, 0, 0}, .offset = -width / 2}, {});
    s.add(plane{.normal = {-1, 0, 0}, .offset = -width / 2}, {});
    s.add(plane{.normal = {0, 1, 0}, .offset = -width / 2}, {});
    s.add(plane{.normal = {0, -1, 0}, .offset = -width / 2}, {});
  });
  // A box beyond each edge, wide enough to leave no gap between; the hole is the area inside all
  // edges.
  const real reach = width * std::sqrt(real(0.5)) + 1 - apothem;
  const real wide = 2 * (apothem + reach) * std::tan(pi / edges);
  for (int k = 0; k < edges; ++k) {
    const real angle = 2 * pi * k / edges;
    const vec3 out(std::cos(angle), std::sin(angle), 0);
    w.add(body{.shape = box{{reach, wide, thick}},
               .position = (apothem + reach / 2) * out + vec3(0, 0, -thick / 2),
               .orientation = quat(std::cos(angle / 2), 0, 0, std::sin(angle / 2)),
               .fixed = true});
  }
  const auto per_layer =
      static_cast<std::size_t>(std::pow(std::floor((width - 1.2) / 1.12) + 1, 2));
  const real layers = std::ceil(fill / 0.9);
  const real edge = 1.12 * std::floor((width - 1.2) / 1.12) / 2;
  w.fill((simple_cubic{.spacing = 1.12, .origin = {-edge, -edge, 0.6}} &
          box_region{{-edge - 0.01, -edge - 0.01, 0}, {edge + 0.01, edge + 0.01, 1000}})
             .first(per_layer * static_cast<std::uint64_t>(layers)),
         [&](const site& at, random_stream& random) {
           return body{.shape = sphere{random.uniform(0.45, 0.55)},
                       .position = at.position,
                       .velocity = random.uniform(vec3(-0.1, -0.1, 0), vec3(0.1, 0.1, 0))};
         });

  outflow result{.diameter = diameter};
  std::uint64_t returned = 0;
  const auto rows = static_cast<std::uint64_t>(std::llround(2 * edge / 1.12)) + 1;
  real mass = 0;
  const auto run = [&](real seconds) {
    for (int k = 0, n = static_cast<int>(std::lround(seconds / dt)); k < n; ++k) {
      w.step(dt);
      if (k % 8 != 0) continue;
      w.for_each_local([&](auto& b) {
        if (b.is_fixed() || b.position()[2] > -4) return;
        mass += b.mass();
        // Sites of a lattice in turn, scattered by a coprime stride.
        const auto place = (returned++ * 7919) % (rows * rows);
        const real x = -edge + 1.12 * static_cast<real>(place % rows);
        const real y = -edge + 1.12 * static_cast<real>(place / rows);
        const real z = fill * 1.25 + 4 + 1.2 * static_cast<real>(returned % 4);
        b.translate(vec3(x, y, z) - b.position());
        b.set_velocity({0, 0, -3});
        b.set_angular_velocity({0, 0, 0});
      });
    }
  };
  run(settle);
  mass = 0;
  snapshot grains;
  run(measured);
  result.rate = mass / measured;
  grains.gather(w);
  const vec3 lower(-width / 2 + 2, -width / 2 + 2, 2),
      upper(width / 2 - 2, width / 2 - 2, fill / 2);
  result.bulk = packing_fraction(grains.all(), lower, upper);
  return result;
}

// --- Angle of repose -----------------------------------------------------------------------------

/// Degrees: the slope of a heap that is poured slowly at a wall, between smooth walls, on a floor
/// of fixed grains that ends at `length`, where grains that roll so far fall off.
template <class... Policies>
real repose(real friction, real length, real depth, real seconds) {
  using heap = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, split_correction>,
                        transport<serial>, Policies...>;
  const real dt = 1.0 / 240;
  serial::link link;
  world<heap> w(link);
  const auto rough = w.material({.density = 1, .friction = friction});
  const auto smooth = w.material({.density = 1});
  w.material_pair(rough, smooth, {});
  w.gravity({0, 0, -gravity});
  w.global([&](auto& s) {
    s.add(plane{.normal = {1, 0, 0}}, smooth);
    s.add(plane{.normal = {0, 1, 0}}, smooth);
    s.add(plane{.normal = {0, -1, 0}, .offset = -depth}, smooth);
  });
  w.fill(simple_cubic{.spacing = 0.9, .origin = {0.5, 0.5, 0}} &
             box_region{{0.4, 0.4, -0.1}, {length, depth - 0.4, 0.1}},
         [&](const site& at, random_stream& random) {
           return body{.shape = sphere{random.uniform(0.4, 0.5)},
                       .position = at.position + vec3(0, 0, random.uniform(-0.2, 0.2)),
                       .material = rough,
                       .fixed = true};
         });
  random_stream random(1, 1);
  for (int k = 0, n = static_cast<int>(std::lround((seconds + 3) / dt)); k < n; ++k) {
    w.step(dt);
    if (k % 12 != 0 || k * dt > seconds) continue;
    w.destroy_if([](const auto& b) { return !b.is_fixed() && b.position()[2] < -3; });
    real top = 0;
    w.for_each_local([&](const auto& b) {
      if (b.position()[0] < 3) top = std::max(top, b.position()[2]);
    });
    const real x = random.uniform(0.6, 2);
    for (real y = 0.6; y < depth - 0.5; y += 1.1)
      w.add(body{.shape = sphere{random.uniform(0.4, 0.5)},
                 .position = {x, y + random.uniform(-0.05, 0.05), top + 1.1},
                 .material = rough,
                 .velocity = {0, 0, -1}});
  }
  // Height by volume in slices two diameters wide, without the ends.
  const real slice = 2;
  std::map<int, real> volume;
  w.for_each_local([&](const auto& b) {
    if (!b.is_fixed()) volume[static_cast<int>(b.position()[0] / slice)] += b.shape().volume();
  });
  std::vector<std::array<real, 2>> surface;
  for (const auto& [k, v] : volume) {
    const real x = (k + 0.5) * slice, z = v / (0.58 * slice * depth);
    if (x > 4 && x < length - 4) surface.push_back({x, z});
  }
  if (surface.size() < 3) return 0;
  return -std::atan(line_through(surface)[1]) * 180 / pi;
}

}  // namespace talus::validation
