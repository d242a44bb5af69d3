#pragma once
// Some contacts and their bodies, apart from the rest of the world.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "talus/constraint/island_contact.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// The contacts of an island in a state of their own bodies, numbered from 0 in the order of the
/// world: a solution of an island costs the size of the island, not that of the world.
struct isolated_island {
  plain_vector<island_contact> contacts;
  plain_vector<std::uint32_t> bodies;  ///< their numbers in the world
  solver_state state;                  ///< velocities, masses, inertias; gravity

  /// `numbers` holds -1 for each body of the world, before and after.
  template <class State>
  isolated_island(plain_vector<island_contact> of, const State& s,
                  plain_vector<std::int32_t>& numbers)
      : contacts(std::move(of)) {
    const auto each_end = [&](auto&& f) {
      for (island_contact& c : contacts)
        for (std::int32_t* end : {&c.a, &c.b})
          if (*end >= 0) f(*end, numbers[static_cast<std::size_t>(*end)]);
    };
    each_end([&](std::int32_t body, std::int32_t& number) {
      if (number < 0) bodies.push_back(static_cast<std::uint32_t>(body)), number = 0;
    });
    std::sort(bodies.begin(), bodies.end());
    state.fall = s.fall;
    for (const std::uint32_t i : bodies) {
      numbers[i] = static_cast<std::int32_t>(state.bodies.size());
      const auto& b = s.bodies[i];
      state.bodies.push_back({v_of(b), real(b.inverse_mass), w_of(b), real(b.inverse_inertia)});
      if (i < s.first_tensor)
        ++state.first_tensor;
      else
        state.tensors.push_back(s.tensor(i));
    }
    each_end([](std::int32_t& body, std::int32_t number) { body = number; });
    for (const std::uint32_t i : bodies) numbers[i] = -1;
  }
};

}  // namespace talus::detail
