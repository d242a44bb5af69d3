#pragma once
// The world of three of the scenes: all shapes, and checkpoints. It takes longest to compile: its
// steps, and its checkpoints, are compiled apart from the scenes.
#include <talus/checkpoint.hpp>
#include <talus/mesh.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/triangle_mesh.hpp>
#include <talus/shape/union_of.hpp>

#include "digest_of.hpp"

using dumbbell = union_of<sphere, capsule>;

using rubble = scenario<
    bodies<sphere, box, capsule, cylinder, convex_polyhedron, dumbbell, triangle_mesh, plane>,
    hard_contact<coulomb_friction, newton_restitution>, solver<reproducible>,
    decomposition<squares>, transport<threads>, features<driven, checkpoints>>;

// Empty in the one file that compiles them, else extern.
#ifndef RUBBLE_STEPS
#define RUBBLE_STEPS extern
#endif
#ifndef RUBBLE_FILES
#define RUBBLE_FILES extern
#endif
RUBBLE_STEPS template void world<rubble>::step(real);
RUBBLE_FILES template void talus::write_checkpoint(world<rubble>&, const std::string&);
RUBBLE_FILES template std::string talus::read_checkpoint(world<rubble>&, const std::string&);
