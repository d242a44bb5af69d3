// long
// Granular media at rest: packing fractions, coordination, Janssen's silo, angle of repose.
#include <doctest/doctest.h>

#include <talus/solver/substepping.hpp>

#include "granular_media.hpp"
#include "record.hpp"

using namespace talus;
using namespace talus::validation;

TEST_CASE("poured spheres pack as densely as friction lets them, on 1 and 4 ranks") {
  real before = 1;
  for (const auto& [friction, ranks] :
       {std::pair{0.0, 1}, {0.1, 1}, {0.2, 1}, {0.5, 1}, {0.5, 4}, {1.0, 1}}) {
    const auto p = pour(8000, friction, 5, ranks);
    const auto with = fmt::format(", mu {}, {} ranks", friction, ranks);
    MESSAGE("mu ", friction, ": phi ", p.fraction, ", Z ", p.contacts.mean, ", rattlers ",
            p.contacts.rattlers, ", kinetic energy ", p.kinetic_energy, " of m g r");
    if (friction == 0) {
      check_absolute("packing", "fraction" + with, 0.64, p.fraction, 0.01);
      check_absolute("packing", "coordination" + with, 6, p.contacts.mean, 0.3);
    }
    if (friction == 0.5) {
      check_absolute("packing", "fraction" + with, 0.578, p.fraction, 0.01);
      check_absolute("packing", "coordination" + with, 4.65, p.contacts.mean, 0.3);
    }
    if (ranks > 1) continue;
    check_holds("packing", "less dense than with less friction" + with, true, p.fraction < before);
    before = p.fraction;
  }
}

TEST_CASE("in a silo the stress saturates as Janssen says") {
  const auto s = fill_silo(8, 3500, 14, 2);
  MESSAGE("lambda ", s.lambda, ", depth over lambda ", s.depth_over_lambda, ", floor over weight ",
          s.floor_share);
  check_error("Janssen's law", "misfit of stress over saturation stress", s.misfit, 0.15);
  check_error("Janssen's law", "misfit of the force on the floor", s.floor_misfit, 0.15);
  check_at_least("Janssen's law", "depth of the silo over lambda", 3, s.depth_over_lambda);
  check_error("Janssen's law", "floor and walls carry the weight", s.balance, 1e-2);
}

TEST_CASE("the angle of repose grows with friction and saturates") {
  std::vector<real> angles;
  for (const real friction : {0.05, 0.1, 0.2, 0.4, 0.6, 0.8}) {
    angles.push_back(repose(friction, 30, 6, 14));
    MESSAGE("mu ", friction, ": ", angles.back(), " degrees");
  }
  for (std::size_t k = 1; k < angles.size(); ++k)
    check_at_least("angle of repose", fmt::format("rise no. {}, degrees", k), -2,
                   angles[k] - angles[k - 1]);
  check_at_least("angle of repose", "rise in all, degrees", 5, angles.back() - angles.front());
  check_absolute("angle of repose", "mu 0.8 against 0.6, degrees", angles[4], angles[5], 2);
  check_absolute("angle of repose", "small steps against Gauss-Seidel, mu 0.4, degrees", angles[3],
                 repose<solver<substepping>>(0.4, 30, 6, 14), 2);
}
