#pragma once
// The scenes of pinned digests, each compiled in a file of its own.
#include <string>

/// A run on 1 or 4 ranks.
struct course {
  int ranks, steps;
  double dt;
  std::string save = "", load = "";  ///< a checkpoint written halfway through, or restarted from
};

inline int interval = 0;  ///< steps between printed digests; 0: none

// Each runs its scene, and returns the digest of the state at the end; of all but the shapes no run
// saves or loads.
std::string balls(const course&);
std::string crates(const course&);
std::string shapes(const course&);
std::string shear(const course&);
std::string sand(const course&);
