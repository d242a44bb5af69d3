// The cases of ./dev bench validation that take seconds: the tests of Chung and Ooi (2011), single
// contacts of Dosta and others (2024), closed forms, adhesion, drag; and the array that it writes.
#include <doctest/doctest.h>

#include "../../benchmarks/validation_bonds.hpp"
#include "../../benchmarks/validation_chung_ooi.hpp"
#include "../../benchmarks/validation_closed_forms.hpp"
#include "../../benchmarks/validation_cohesion.hpp"
#include "../../benchmarks/validation_fluid.hpp"
#include "../../benchmarks/validation_hard_cohesion.hpp"
#include "record.hpp"

namespace {

void check(const validation::report& results) {
  for (const validation::result& r : results)
    talus::validation::check_absolute(r.name, r.quantity, r.expected, r.found, r.tolerance);
}

}  // namespace

TEST_CASE("the eight tests of Chung and Ooi (2011)") {
  validation::report results;
  validation::chung_ooi(results, {.quick = true});
  CHECK(results.size() > 60);
  check(results);
}

TEST_CASE("the integration of an oblique impact has the closed form of sliding as its limit") {
  using namespace validation::chung_ooi_cases;
  const impact i{.of = {"steel", 208e9, 0.3, 7850},
                 .radius = 1e-5,
                 .speed = 5,
                 .rigid_plane = false,
                 .friction = 0.3,
                 .tangential_speed = 20};
  REQUIRE(slides(i));
  const outcome integrated = oblique_hertz(i), closed = sliding_impulse(i);
  CHECK(integrated.tangential_speed == doctest::Approx(closed.tangential_speed).epsilon(1e-4));
  CHECK(integrated.spin == doctest::Approx(closed.spin).epsilon(1e-4));
  CHECK(integrated.restitution == doctest::Approx(1).epsilon(1e-6));
}

TEST_CASE("closed forms of rigid bodies with hard contacts") {
  validation::report results;
  validation::closed_forms(results, {.quick = true});
  check(results);
}

TEST_CASE("pull-off forces and impacts of the laws of adhesion") {
  validation::report results;
  validation::cohesion(results, {.quick = true});
  check(results);
}

TEST_CASE("bonds stretch, twist, break and swing as beams do") {
  validation::report results;
  validation::bonds(results, {.quick = true});
  check(results);
}

TEST_CASE("hard contacts that stick bear their cohesion and the friction of it") {
  validation::report results;
  validation::hard_cohesion(results, {.quick = true});
  check(results);
}

TEST_CASE("terminal velocities of the laws of drag") {
  validation::report results;
  validation::fluid(results, {.quick = true});
  check(results);
}

TEST_CASE("the array of validation cases is JSON; a case is met within its tolerance only") {
  const validation::result near{"a \"case\"", "q", "1", 1, 1.25, 0.5, "s"};
  validation::result far = near;
  far.found = 2;
  CHECK(near.met());
  CHECK(!far.met());
  far.found = std::nan("");
  CHECK(!far.met());
  CHECK(validation::json({near, far}) ==
        "[\n {\"case\": \"a \\\"case\\\"\", \"engine\": \"talus\", \"quantity\": \"q\", \"unit\": "
        "\"1\", \"expected\": 1, \"found\": 1.25, \"tolerance\": 0.5, \"met\": true, \"source\": "
        "\"s\"},\n {\"case\": \"a \\\"case\\\"\", \"engine\": \"talus\", \"quantity\": \"q\", "
        "\"unit\": \"1\", \"expected\": 1, \"found\": null, \"tolerance\": 0.5, \"met\": false, "
        "\"source\": \"s\"}\n]\n");
}
