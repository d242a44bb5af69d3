// A run that continues from a checkpoint equals the one that wrote it: soft contacts, and the
// midpoint.
// timeout: 300
#include <doctest/doctest.h>

#include <talus/checkpoint.hpp>

#include "restarts.hpp"

using namespace talus::restarts;

TEST_CASE("a restarted heap of soft spheres goes on to the bit, its springs included") {
  check_restarts<soft_pile>(150, 0.002);
}

TEST_CASE("a restarted heap with the midpoint goes on to the bit, on other ranks too") {
  check_restarts<midpoint_pile>(100, 0.01);
}
