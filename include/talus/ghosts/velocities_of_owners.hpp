#pragma once
// An integrator that refreshes shadow copies in the middle of the step leaves them the velocities
// of that moment. Observers of soft contacts need those at its end.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/state/candidate_pairs.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Collective: sets the velocities of shadow copies to those of their owners. No step depends on
/// them: it refreshes the copies before it uses them. Bodies may have been added or destroyed since
/// the last refresh.
template <class Scenario>
void refresh_velocities(world_state<Scenario>& s) {
  using code = typename world_state<Scenario>::copy_code;
  struct motion {
    system_id id = no_id;  ///< none: it was destroyed, or has migrated
    vec3 v{0, 0, 0}, w{0, 0, 0};
  };
  std::vector<neighbour_message> messages;
  std::vector<std::size_t> with;  // the neighbour of each message
  for (std::size_t n = 0; n < s.neighbours.size(); ++n) {
    const auto& other = s.neighbours[n];
    if (other.rank == s.link->rank()) continue;  // images of own bodies have no velocity of theirs
    std::size_t sent = 0, received = 0;
    for (std::size_t k = 0; k < other.copies.size(); ++k)
      sent += other.shadowed[k].size(), received += other.copies[k];
    if (sent + received == 0) continue;  // on both ends
    with.push_back(n);
    neighbour_message& m = messages.emplace_back(neighbour_message{.rank = other.rank});
    m.in.resize(received * sizeof(motion));
  }
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    const auto& store = b.movable;
    const auto& noted = s.choice.bodies[k];
    const auto now =
        numbers_now(numbers_before(noted, std::span(store.id).first(store.locals)), noted.size());
    for (std::size_t m = 0; m < messages.size(); ++m) {
      byte_writer out(messages[m].out);
      for (const auto copy : s.neighbours[with[m]].shadowed[k])
        if (const std::uint32_t i = now[code::body(copy)]; i != nobody)
          out.put(motion{store.id[i], store.velocity[i], store.angular_velocity[i]});
        else
          out.put(motion{});
    }
    ++k;
  });
  s.link->start_fixed(messages);
  s.link->finish_fixed(messages);
  std::vector<byte_reader> in;
  for (const neighbour_message& m : messages) in.emplace_back(m.in);
  k = 0;
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    std::size_t copy = store.locals, m = 0;
    for (std::size_t n = 0; n < s.neighbours.size(); ++n) {
      const bool sends = m < with.size() && with[m] == n;
      for (std::size_t c = 0; c < s.neighbours[n].copies[k]; ++c, ++copy) {
        if (!sends) continue;
        const auto of_owner = in[m].template get<motion>();
        if (copy >= store.size() || store.id[copy] != of_owner.id) continue;
        store.velocity[copy] = of_owner.v, store.angular_velocity[copy] = of_owner.w;
      }
      m += sends;
    }
    ++k;
  });
}

}  // namespace talus::detail
