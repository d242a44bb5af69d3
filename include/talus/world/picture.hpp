#pragma once
// The view of a world, of its pictures and of its page for a browser.
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"

namespace talus {

/// The view of a world. Lengths are in the units of the scene, angles in degrees.
struct picture {
  /// automatic: by material if one has a name or a colour, and on one rank; otherwise by rank
  enum class colouring { automatic, rank, speed, material };

  vec3 from{10, -20, 10};  ///< position of the camera
  vec3 at{0, 0, 0};        ///< point at which it looks
  /// The upward direction in the picture
  vec3 up{0, 0, 1};
  real angle = 40;  ///< of view, horizontally
  /// Colours show the material, the rank or the speed of the bodies
  colouring colour = colouring::automatic;
  real fastest = 0;      ///< the speed that is red; 0: that of the fastest body
  real walls = 0.35;     ///< opacity of fixed and global bodies but planes; 1: solid, 0: hidden
  bool copies = false;   ///< show shadow copies, as thin shells, in the colour of their holder
  bool domains = false;  ///< show the domain of each rank, as glass
  bool ground = true;    ///< show planes, those that face the camera
  bool joints = true;  ///< show joints: a ball at each, bars to its bodies and between points apart
  bool force = false;  ///< replace a file that is not a picture of talus
  /// a body, handle.id: `from` and `at` are measured from its centre and move with it; one rank may
  /// know it alone
  system_id follow = no_id;
};

}  // namespace talus
