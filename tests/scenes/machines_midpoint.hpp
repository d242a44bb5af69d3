#pragma once
// Spheres and boxes with joints of all kinds with the midpoint, and the energy ledger.
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/cylindrical_joint.hpp>
#include <talus/constraint/fixed_joint.hpp>
#include <talus/constraint/gear.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/point_on_plane.hpp>
#include <talus/constraint/rod.hpp>
#include <talus/constraint/slider.hpp>
#include <talus/constraint/strut.hpp>
#include <talus/constraint/universal_joint.hpp>
#include <talus/constraint/weld.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/joints.hpp>
#include <talus/parallel/threads.hpp>

#include "shared.hpp"

namespace scenes {
using machines_midpoint = talus::scenario<
    talus::bodies<talus::sphere, talus::box>,
    talus::joints<talus::ball_joint, talus::fixed_joint, talus::hinge, talus::slider,
                  talus::cylindrical_joint, talus::universal_joint, talus::rod, talus::rope,
                  talus::point_on_plane, talus::weld, talus::gear, talus::strut>,
    talus::transport<talus::threads>, talus::features<talus::energy_ledger>,
    talus::integrator<talus::moreau_midpoint>>;
}
TALUS_SHARED_MACHINES(scenes::machines_midpoint);
