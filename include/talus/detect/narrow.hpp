#pragma once
// The narrow phase computes contact points of two posed shapes of known types. For a new shape, add
// its pair functions to pairs/, in one order of the two shapes; the other order follows.
#include "talus/detect/collide_pair.hpp"
#include "talus/detect/pairs/box_box.hpp"
#include "talus/detect/pairs/box_sphere.hpp"
#include "talus/detect/pairs/capsule_capsule.hpp"
#include "talus/detect/pairs/convex_convex.hpp"
#include "talus/detect/pairs/cylinder_sphere.hpp"
#include "talus/detect/pairs/ellipsoid_any.hpp"
#include "talus/detect/pairs/plane_box.hpp"
#include "talus/detect/pairs/plane_convex.hpp"
#include "talus/detect/pairs/plane_sphere.hpp"
#include "talus/detect/pairs/polyhedron_sphere.hpp"
#include "talus/detect/pairs/sphere_sphere.hpp"
#include "talus/detect/pairs/superellipsoid_any.hpp"
#include "talus/detect/pairs/union_any.hpp"
