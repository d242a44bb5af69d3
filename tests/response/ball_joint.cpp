// The laws of ball joints.
#include "joint_laws.hpp"

#include <talus/constraint/ball_joint.hpp>

using namespace talus;

TEST_CASE("ball_joint obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<ball_joint>(
      [](random_stream& random) { return ball_joint{.at = laws::any_vector(random, 2)}; });
}
