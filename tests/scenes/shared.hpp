#pragma once
// Worlds that many tests share. A test that is not about its scenario includes scenes/NAME.hpp and
// takes its type: the functions of that world are compiled once, for all programs (share_scenes in
// CMakeLists.txt), and the test compiles what it says itself.
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>

// Empty in the one unit that compiles the world, else extern.
#ifndef TALUS_SHARED_SCENE_LINKAGE
#define TALUS_SHARED_SCENE_LINKAGE extern
#endif

/// The functions of a world that take long to compile.
#define TALUS_SHARED_WORLD(name)                                                            \
  TALUS_SHARED_SCENE_LINKAGE template void talus::world<name>::step(talus::real);           \
  TALUS_SHARED_SCENE_LINKAGE template void talus::detail::detect(                           \
      talus::detail::world_state<name>&);                                                   \
  TALUS_SHARED_SCENE_LINKAGE template void talus::world<name>::synchronize();               \
  TALUS_SHARED_SCENE_LINKAGE template void talus::world<name>::check_connections();         \
  TALUS_SHARED_SCENE_LINKAGE template talus::body_count talus::world<name>::audit();        \
  TALUS_SHARED_SCENE_LINKAGE template std::string talus::state_digest(talus::world<name>&); \
  TALUS_SHARED_SCENE_LINKAGE template talus::motion talus::measure_motion(talus::world<name>&)
#define TALUS_SHARED_SHAPE(name, shape)                                                    \
  TALUS_SHARED_SCENE_LINKAGE template talus::handle<shape> talus::world<name>::add_global( \
      const talus::body<shape>&)
#define TALUS_SHARED_FINITE_SHAPE(name, shape)                                     \
  TALUS_SHARED_SHAPE(name, shape);                                                 \
  TALUS_SHARED_SCENE_LINKAGE template talus::system_id talus::world<name>::insert( \
      const talus::body<shape>&, talus::system_id)

#define TALUS_SHARED_SPHERES(name)                \
  TALUS_SHARED_WORLD(name);                       \
  TALUS_SHARED_FINITE_SHAPE(name, talus::sphere); \
  TALUS_SHARED_SHAPE(name, talus::plane)
#define TALUS_SHARED_SOLIDS(name) \
  TALUS_SHARED_SPHERES(name);     \
  TALUS_SHARED_FINITE_SHAPE(name, talus::box)
#define TALUS_SHARED_MACHINES(name)                                                \
  TALUS_SHARED_WORLD(name);                                                        \
  TALUS_SHARED_FINITE_SHAPE(name, talus::sphere);                                  \
  TALUS_SHARED_FINITE_SHAPE(name, talus::box);                                     \
  TALUS_SHARED_SCENE_LINKAGE template talus::energy_balance talus::measure_energy( \
      talus::world<name>&);                                                        \
  TALUS_SHARED_SCENE_LINKAGE template talus::joint_errors talus::measure_joints(talus::world<name>&)
