// Texts of messages with their values.
#include <doctest/doctest.h>

#include <string>
#include <talus/core/error.hpp>

using talus::detail::compose;

TEST_CASE("a word that begins with a vowel has the article an") {
  const char *const ellipsoid = "ellipsoid", *const sphere = "sphere";
  CHECK(compose("a {} is given a mass", ellipsoid) == "an ellipsoid is given a mass");
  CHECK(compose("the mass of a {} and of a {}", ellipsoid, sphere) ==
        "the mass of an ellipsoid and of a sphere");
  CHECK(compose("in a {}", "universal_joint") == "in a universal_joint");
  CHECK(compose("a {1} in a {0}", sphere, ellipsoid) == "an ellipsoid in a sphere");
  // A name or a number is no word.
  CHECK(compose("plasma {}", ellipsoid) == "plasma ellipsoid");
  CHECK(compose("a {}", std::string("axis.csv")) == "a axis.csv");
  CHECK(compose("a {}", 8) == "a 8");
}
