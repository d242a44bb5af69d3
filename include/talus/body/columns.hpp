#pragma once
// The columns of talus: those of all bodies, and those of its features.
#include <cstdint>
#include <limits>

#include "talus/body/column.hpp"
#include "talus/body/material.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

enum body_flag : std::uint8_t {
  flag_fixed = 1,
  flag_invisible = 2,
  flag_asleep = 4,     ///< its island is left out of the steps
  flag_disturbed = 8,  ///< of something immovable: the user added or changed it since the last step
  flag_released = 16,  ///< it was fixed; until all ranks that hold copies are notified
  flag_own_mass = 32   ///< it is fixed, and its store keeps the mass that it has when released
};

/// How far a body has moved by its velocity while it was slow, in a third of the time after which
/// it may sleep; see features/sleeping/rest.hpp.
struct drift_while_slow {
  vec3 travel{0, 0, 0};
  real since =
      0;  ///< the part of that time that has passed; -1 from falling asleep to the next step
  vec3 turn{0, 0, 0};
  real early = 0, farthest = 0;   ///< largest distance in the first half of that time, and so far
  real last = 0;                  ///< the largest distance in the third before
  vec3 load{0, 0, 0};             ///< the force of fields: awake in this step, asleep in its first
  vec3 v{0, 0, 0}, w{0, 0, 0};    ///< at the start of the third
  vec3 dv{0, 0, 0}, dw{0, 0, 0};  ///< changes of the velocities in the third before
  real steady = 0;                ///< thirds in a row in which they changed alike
};

namespace columns {

struct id {
  using value_type = system_id;
  static constexpr const char* name = "id";
  static constexpr travels travel = travels::when_changed;
  struct storage {
    plain_vector<system_id> id;
  };
  static constexpr auto member = &storage::id;
};
struct position {
  using value_type = vec3;
  static constexpr const char *name = "position", *unit = "L";
  struct storage {
    plain_vector<vec3> position;
  };
  static constexpr auto member = &storage::position;
};
struct velocity {
  using value_type = vec3;
  static constexpr const char *name = "velocity", *unit = "L/T";
  struct storage {
    plain_vector<vec3> velocity;
  };
  static constexpr auto member = &storage::velocity;
};
struct angular_velocity {
  using value_type = vec3;
  static constexpr const char *name = "angular_velocity", *unit = "1/T";
  struct storage {
    plain_vector<vec3> angular_velocity;
  };
  static constexpr auto member = &storage::angular_velocity;
};
template <class Shape>
struct shape {
  using value_type = Shape;
  static constexpr const char* name = "shape";
  static constexpr travels travel = travels::when_changed;
  struct storage {
    vector_of<Shape> shape;
  };
  static constexpr auto member = &storage::shape;
};
/// 0 for a fixed body.
struct inverse_mass {
  using value_type = real;
  static constexpr const char *name = "inverse_mass", *unit = "1/M";
  static constexpr travels travel = travels::when_changed;
  struct storage {
    plain_vector<real> inverse_mass;
  };
  static constexpr auto member = &storage::inverse_mass;
};
struct material {
  using value_type = material_id;
  static constexpr const char* name = "material";
  static constexpr travels travel = travels::when_changed;
  struct storage {
    plain_vector<material_id> material;
  };
  static constexpr auto member = &storage::material;
};
struct flags {
  using value_type = std::uint8_t;
  static constexpr const char* name = "flags";
  static constexpr travels travel = travels::when_changed;
  struct storage {
    plain_vector<std::uint8_t> flags;
  };
  static constexpr auto member = &storage::flags;
};
/// All shapes except balls always carry it; balls carry it with features<orientation>.
struct orientation {
  using value_type = quat;
  static constexpr const char* name = "orientation";
  static constexpr int place = 0;
  template <class Shape>
  static constexpr bool carried_by = Shape::finite&& Shape::isotropic;  // by the feature
  struct storage {
    plain_vector<quat> orientation_of;
  };
  static constexpr auto member = &storage::orientation_of;
};

// Columns that features add. `place` orders them in messages and checkpoints.

/// By the user, world frame; cleared after each step.
struct force {
  using value_type = vec3;
  static constexpr const char *name = "force", *unit = "M L/T^2";
  static constexpr int place = 1;
  template <class Shape>
  static constexpr bool carried_by = Shape::finite;
  struct storage {
    plain_vector<vec3> force;
  };
  static constexpr auto member = &storage::force;
};
/// The torque by the user about the centre of mass, world frame; cleared after each step.
struct torque {
  using value_type = vec3;
  static constexpr const char *name = "torque", *unit = "M L^2/T^2";
  static constexpr int place = 2;
  template <class Shape>
  static constexpr bool carried_by = Shape::finite;
  struct storage {
    plain_vector<vec3> torque;
  };
  static constexpr auto member = &storage::torque;
};
/// The sum of the present contact forces on a body, world frame. Its owner alone needs it.
struct contact_force {
  using value_type = vec3;
  static constexpr const char *name = "contact_force", *unit = "M L/T^2";
  static constexpr int place = 3;
  static constexpr travels travel = travels::on_migration;
  template <class Shape>
  static constexpr bool carried_by = Shape::finite;
  struct storage {
    plain_vector<vec3> contact_force;
  };
  static constexpr auto member = &storage::contact_force;
};
/// The sum of the torques of the present contact forces about the centre of mass, world frame. Its
/// owner alone needs it.
struct contact_torque {
  using value_type = vec3;
  static constexpr const char *name = "contact_torque", *unit = "M L^2/T^2";
  static constexpr int place = 4;
  static constexpr travels travel = travels::on_migration;
  template <class Shape>
  static constexpr bool carried_by = Shape::finite;
  struct storage {
    plain_vector<vec3> contact_torque;
  };
  static constexpr auto member = &storage::contact_torque;
};
struct user_id {
  using value_type = std::uint32_t;
  static constexpr const char* name = "user_id";
  static constexpr int place = 5;
  static constexpr travels travel = travels::when_changed;
  static constexpr bool in_output = true;
  struct storage {
    plain_vector<std::uint32_t> user_id;
  };
  static constexpr auto member = &storage::user_id;
};
/// The time for which the island has rested.
struct quiet {
  using value_type = float;
  static constexpr const char *name = "quiet", *unit = "T";
  static constexpr int place = 6;
  template <class Shape>
  static constexpr bool carried_by = Shape::finite;
  struct storage {
    plain_vector<float> quiet;
  };
  static constexpr auto member = &storage::quiet;
};
/// The time since something immovable has borne the island; `initial` if nothing has since the body
/// was added, woke, or lost what bore it.
struct unborne {
  using value_type = float;
  static constexpr float initial = std::numeric_limits<float>::max();
  static constexpr const char *name = "unborne", *unit = "T";
  static constexpr int place = 7;
  template <class Shape>
  static constexpr bool carried_by = Shape::finite;
  struct storage {
    plain_vector<float> unborne;
  };
  static constexpr auto member = &storage::unborne;
};
struct drift {
  using value_type = drift_while_slow;
  static constexpr const char* name = "drift";
  static constexpr int place = 8;
  static constexpr travels travel = travels::on_migration;
  template <class Shape>
  static constexpr bool carried_by = Shape::finite;
  struct storage {
    plain_vector<drift_while_slow> drift;
  };
  static constexpr auto member = &storage::drift;
};

}  // namespace columns

/// The columns of a shape in every scenario.
template <class Shape>
using columns_of_shape = join_lists<
    type_list<columns::id, columns::position, columns::velocity, columns::angular_velocity,
              columns::shape<Shape>, columns::inverse_mass, columns::material, columns::flags>,
    std::conditional_t<Shape::finite && !Shape::isotropic, type_list<columns::orientation>,
                       type_list<>>>;

}  // namespace talus::detail
