#pragma once
// Bodies that Python adds, removes and gives a velocity, between steps.
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "talus/body/body.hpp"
#include "talus/core/error.hpp"
#include "talus/state/state.hpp"
#include "talus/world/state_of.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// A shape from its numbers, in the order of its members. Throws invalid_argument for another count
/// of them, and for shapes that have more than numbers.
template <class Shape>
[[nodiscard]] Shape shape_from(const std::vector<real>& sizes) {
  if constexpr (requires { Shape::numbers; }) {
    constexpr std::size_t count = std::size(Shape::numbers);
    static_assert(std::is_trivially_copyable_v<Shape> && sizeof(Shape) == count * sizeof(real),
                  "the `numbers` of a shape name each of its members, which are all of type real");
    if (sizes.size() != count) {
      std::string names;
      for (const char* const one : Shape::numbers)
        names += (names.empty() ? "" : ", ") + std::string(one);
      fail<std::invalid_argument>(
          "a {} is given by {}: add takes {} numbers before the others, not {}", Shape::name, names,
          count, sizes.size());
    }
    std::array<real, count> values;
    std::copy_n(sizes.begin(), count, values.begin());
    return std::bit_cast<Shape>(values);
  } else {
    fail<std::invalid_argument>("a {} cannot be added by Python: add it in the set-up",
                                Shape::name);
  }
}

/// What Python says of a body besides its shape.
struct new_body {
  std::array<real, 3> position, velocity, angular_velocity;
  std::array<real, 4> orientation;  ///< x, y, z, w
  std::uint16_t material = 0;       ///< number of the material, in the order of the set-up
  std::optional<real> mass, density;
};

/// Calls f(std::type_identity<Shape>{}) for the shape of that name.
template <class Scenario, class F>
void on_shape(world<Scenario>& w, const std::string& name, F&& f) {
  state_of(w).each_finite_shape([&](auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b.movable)>::shape_type;
    if (shape::name == name) f(std::type_identity<shape>{});
  });
}

/// Adds a body and returns its id. Throws invalid_argument as world::add does.
template <class Scenario>
[[nodiscard]] std::uint64_t add_body(world<Scenario>& w, const std::string& name,
                                     const std::vector<real>& sizes, const new_body& how) {
  std::uint64_t id = 0;
  on_shape(w, name, [&]<class Shape>(std::type_identity<Shape>) {
    const auto three = [](const std::array<real, 3>& v) { return vec3(v[0], v[1], v[2]); };
    const auto& q = how.orientation;
    body<Shape> b{.shape = shape_from<Shape>(sizes)};
    b.position = three(how.position), b.velocity = three(how.velocity);
    b.angular_velocity = three(how.angular_velocity);
    b.orientation = quat(q[3], q[0], q[1], q[2]);
    b.material = material_id{how.material};
    if (how.mass) b.mass = *how.mass;
    if (how.density) b.density = *how.density;
    const auto made = w.add_if_local(b);
    if (!made)
      fail<std::invalid_argument>("a {} cannot be added at {}: the place is in no domain",
                                  Shape::name, text(b.position));
    id = value_of(made->id);
  });
  return id;
}

}  // namespace talus::detail
