// expects: soft_contact<...> names two laws that bear the bodies, and friction has one normal force
#include "talus/scenario/scenario.hpp"
using namespace talus;

/// A spring of its own that bears friction.
struct my_spring {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "my_spring";
  struct parameters {
    real stiffness = 1;
    friend bool operator==(const parameters&, const parameters&) = default;
  };
  using memory = no_memory;
  static bearing bears(const contact_kinematics&, const parameters& p) { return {0, p.stiffness}; }
  static bearing_force<bearing> force(const contact_kinematics& c, const parameters& p, real,
                                      memory&) {
    bearing_force<bearing> f;
    f.pressing = -p.stiffness * c.gap;
    f.force = f.pressing * c.normal;
    return f;
  }
  static stored_energy stored(const contact_kinematics&, const parameters&, const memory&) {
    return {};
  }
  static real longest_step(const parameters&, real) { return 1; }
  static real duration(const parameters&, const head_on_impact&) { return 1; }
};

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<my_spring, coulomb_friction>>;
#else
using scene = scenario<soft_contact<linear_spring_dashpot, my_spring>>;
#endif

const scene checked;

int main() {}
