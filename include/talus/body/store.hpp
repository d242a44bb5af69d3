#pragma once
// Storage of the bodies of one shape: structure of arrays, locals before shadow copies. A column
// that the scenario does not need does not exist.
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "talus/body/features.hpp"
#include "talus/body/material.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

enum body_flag : std::uint8_t {
  flag_fixed = 1,
  flag_invisible = 2,
  flag_asleep = 4,     ///< its island is left out of the steps
  flag_disturbed = 8,  ///< of something immovable: the user put or changed it since the last step
  flag_released = 16   ///< it was fixed; until all ranks that hold copies have heard of that
};

/// Stands for a column that this scenario does not store.
struct no_column {
  void clear() {}
};

template <bool Stored, class T>
using column = std::conditional_t<Stored, vector_of<T>, no_column>;

/// A value to be overwritten: Eigen's types would leave theirs undefined.
template <class T>
[[nodiscard]] T blank() {
  if constexpr (requires { T::Zero(); })
    return T::Zero();
  else if constexpr (requires { T::Identity(); })
    return T::Identity();
  else
    return T{};
}

/// What springs, dashpots and friction of soft contacts do to a body, each by itself.
struct split_forces {
  vec3 spring{0, 0, 0}, spring_torque{0, 0, 0};
  vec3 dashpot{0, 0, 0}, dashpot_torque{0, 0, 0};
  vec3 friction{0, 0, 0}, friction_torque{0, 0, 0};
};

template <class Shape, class Features>
struct body_store {
  using shape_type = Shape;
  static constexpr bool oriented =
      Shape::finite && (!Shape::isotropic || contains_type<Features, orientation>);
  static constexpr bool tensor =
      Shape::finite && !Shape::isotropic;  ///< inertia is not a multiple of 1
  static constexpr bool forced = Shape::finite && contains_type<Features, forces>;
  static constexpr bool keeps_contact_forces =
      Shape::finite && contains_type<Features, contact_forces>;
  static constexpr bool splits_forces =
      Shape::finite && contains_type<Features, split_contact_forces>;
  static constexpr bool sleeps = Shape::finite && contains_type<Features, sleeping>;
  static constexpr bool numbered = contains_type<Features, user_ids>;

  plain_vector<system_id> id;
  plain_vector<vec3> position;
  plain_vector<vec3> velocity;
  plain_vector<vec3> angular_velocity;
  vector_of<Shape> shape;
  plain_vector<real> inverse_mass;  ///< 0 for a fixed body
  plain_vector<material_id> material;
  plain_vector<std::uint8_t> flags;
  column<oriented, quat> orientation_of;
  column<forced, vec3> force;                         ///< world frame, cleared after each step
  column<forced, vec3> torque;                        ///< about the centre of mass, world frame
  column<keeps_contact_forces, vec3> contact_force;   ///< of the present contacts, world frame
  column<keeps_contact_forces, vec3> contact_torque;  ///< likewise, about the centre of mass
  column<splits_forces, split_forces> split;          ///< the sum of both, in parts
  column<numbered, std::uint32_t> user_id;
  column<sleeps, float> quiet;  ///< for how long the island has been at rest, units of time
  std::size_t locals = 0;       ///< bodies [0, locals) are owned here, the rest are shadow copies

  [[nodiscard]] std::size_t size() const { return id.size(); }

  /// Calls f(column) for every column that exists.
  template <class F>
  void each_column(F&& f) {
    f(id), f(position), f(velocity), f(angular_velocity), f(shape), f(inverse_mass), f(material),
        f(flags);
    if constexpr (oriented) f(orientation_of);
    if constexpr (forced) f(force), f(torque);
    if constexpr (keeps_contact_forces) f(contact_force), f(contact_torque);
    if constexpr (splits_forces) f(split);
    if constexpr (numbered) f(user_id);
    if constexpr (sleeps) f(quiet);
  }
  template <class F>
  void each_column(F&& f) const {
    const_cast<body_store*>(this)->each_column([&](const auto& c) { f(c); });
  }

  /// Calls f(name) for every column that exists, in the same order.
  template <class F>
  static void each_column_name(F&& f) {
    f("id"), f("position"), f("velocity"), f("angular_velocity"), f("shape"), f("inverse_mass"),
        f("material"), f("flags");
    if constexpr (oriented) f("orientation");
    if constexpr (forced) f("force"), f("torque");
    if constexpr (keeps_contact_forces) f("contact_force"), f("contact_torque");
    if constexpr (splits_forces) f("split_forces");
    if constexpr (numbered) f("user_id");
    if constexpr (sleeps) f("quiet");
  }

  /// Calls f(column, the same column of `other`).
  template <class F>
  void each_column_with(const body_store& other, F&& f) {
    f(id, other.id), f(position, other.position), f(velocity, other.velocity),
        f(angular_velocity, other.angular_velocity), f(shape, other.shape),
        f(inverse_mass, other.inverse_mass), f(material, other.material), f(flags, other.flags);
    if constexpr (oriented) f(orientation_of, other.orientation_of);
    if constexpr (forced) f(force, other.force), f(torque, other.torque);
    if constexpr (keeps_contact_forces)
      f(contact_force, other.contact_force), f(contact_torque, other.contact_torque);
    if constexpr (splits_forces) f(split, other.split);
    if constexpr (numbered) f(user_id, other.user_id);
    if constexpr (sleeps) f(quiet, other.quiet);
  }

  /// Likewise for what a step changes of a body.
  template <class F>
  void each_moving_column(F&& f) {
    f(position), f(velocity), f(angular_velocity);
    if constexpr (oriented) f(orientation_of);
    if constexpr (forced) f(force), f(torque);
    if constexpr (keeps_contact_forces) f(contact_force), f(contact_torque);
    if constexpr (splits_forces) f(split);
    if constexpr (sleeps) f(quiet);
  }

  [[nodiscard]] talus::pose pose(std::size_t i) const {
    if constexpr (oriented)
      return {position[i], orientation_of[i]};
    else
      return {position[i], quat{1, 0, 0, 0}};
  }
  [[nodiscard]] bool fixed(std::size_t i) const { return flags[i] & flag_fixed; }
  [[nodiscard]] bool asleep(std::size_t i) const {
    if constexpr (sleeps)
      return flags[i] & flag_asleep;
    else
      return (void)i, false;
  }
  /// Whether forces and contacts can move it in this step.
  [[nodiscard]] bool moves(std::size_t i) const { return inverse_mass[i] != 0 && !asleep(i); }

  /// Bytes that one body takes in the columns.
  [[nodiscard]] static std::size_t bytes_per_body() {
    std::size_t sum = 0;
    body_store{}.each_column([&](const auto& c) { sum += sizeof(c[0]); });
    return sum;
  }

  void resize(std::size_t n) {
    each_column([&](auto& c) { c.resize(n); });
  }
  void drop_shadows() { resize(locals); }
  /// The shadow copies, which are then no longer here.
  [[nodiscard]] body_store take_shadows() {
    body_store taken;
    for (std::size_t i = locals; i < size(); ++i) taken.append_from(*this, i);
    drop_shadows();
    return taken;
  }

  /// Makes room for one more local, after the others, and returns its index. The shadow copies
  /// keep their order.
  std::size_t insert_local() {
    resize(size() + 1);
    each_column([&](auto& c) {
      for (std::size_t i = c.size() - 1; i > locals; --i) c[i] = c[i - 1];
      c[locals] = blank<typename std::remove_cvref_t<decltype(c)>::value_type>();
    });
    return locals++;
  }
  /// Removes local `i`: the last local takes its place. The shadow copies keep their order.
  void remove_local(std::size_t i) {
    each_column([&](auto& c) {
      c[i] = c[locals - 1];
      c.erase(c.begin() + static_cast<std::ptrdiff_t>(locals - 1));
    });
    --locals;
  }
  /// Local k becomes the one that was local order[k].
  void permute_locals(const plain_vector<std::uint32_t>& order) {
    each_column([&](auto& c) {
      const auto before = c;
      for (std::size_t k = 0; k < order.size(); ++k) c[k] = before[order[k]];
    });
  }
  /// Appends body `i` of another store.
  void append_from(const body_store& other, std::size_t i) {
    each_column_with(other, [&](auto& c, const auto& from) { c.push_back(from[i]); });
  }

  /// Appends bodies [first, last) of another store.
  void append_from(const body_store& other, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) append_from(other, i);
  }

  void pack(std::size_t i, byte_writer& out) const {
    each_column([&](const auto& c) { out.put(c[i]); });
  }
  /// Appends the next body of a message.
  void unpack(byte_reader& in) {
    each_column([&](auto& c) {
      c.push_back(in.get<typename std::remove_cvref_t<decltype(c)>::value_type>());
    });
  }
  /// The same with what a step changes, for a body that the receiver has.
  void pack_motion(std::size_t i, byte_writer& out) {
    each_moving_column([&](const auto& c) { out.put(c[i]); });
  }
  void unpack_motion(std::size_t i, byte_reader& in) {
    each_moving_column(
        [&](auto& c) { c[i] = in.get<typename std::remove_cvref_t<decltype(c)>::value_type>(); });
  }
};

}  // namespace talus::detail
