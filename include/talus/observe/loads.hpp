#pragma once
// The forces and torques of contacts on many bodies, and the motion of one body on any rank.
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "talus/body/body.hpp"
#include "talus/core/binned_sum.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/id_table.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// What all contacts of a body exert on it together.
struct contact_load {
  vec3 force{0, 0, 0};   ///< as contact_force()
  vec3 torque{0, 0, 0};  ///< about the position of the body, as contact_torque()
};

namespace detail {

/// A sum of loads, the same to the bit for any grouping of the terms.
struct load_sum {
  std::array<binned_sum, 6> parts{};

  void add(const vec3& force, const vec3& torque) {
    for (int k = 0; k < 3; ++k) {
      parts[static_cast<std::size_t>(k)] += force[k];
      parts[static_cast<std::size_t>(k) + 3] += torque[k];
    }
  }
  void add(const load_sum& other) {
    for (std::size_t k = 0; k < parts.size(); ++k) parts[k] += other.parts[k];
  }
  [[nodiscard]] contact_load value() const {
    return {{parts[0].value(), parts[1].value(), parts[2].value()},
            {parts[3].value(), parts[4].value(), parts[5].value()}};
  }
};

constexpr system_id id_in(system_id id) { return id; }
template <class Shape>
constexpr system_id id_in(handle<Shape> h) {
  return h.id;
}
template <class Shape>
constexpr system_id id_in(const std::optional<handle<Shape>>& h) {
  return h ? h->id : no_id;
}
template <class Body>
inline constexpr bool named_on_some_ranks = false;
template <class Shape>
inline constexpr bool named_on_some_ranks<std::optional<handle<Shape>>> = true;

/// The ids of bodies that at least one rank names. Collective if only some ranks may.
template <class Scenario, class Bodies>
[[nodiscard]] std::vector<system_id> agreed_ids(world<Scenario>& w, const Bodies& bodies) {
  std::vector<std::uint64_t> numbers;
  numbers.reserve(std::size(bodies));
  for (const auto& b : bodies) numbers.push_back(value_of(id_in(b)));
  if constexpr (named_on_some_ranks<std::remove_cvref_t<decltype(*std::begin(bodies))>>)
    w.link().reduce(reduction::min, std::span<std::uint64_t>(numbers));
  std::vector<system_id> ids;
  ids.reserve(numbers.size());
  for (const std::uint64_t n : numbers) ids.push_back(system_id{n});
  return ids;
}

/// Collective: the loads of the bodies of a table, in its order.
template <class Scenario>
[[nodiscard]] std::vector<contact_load> loads_of(world<Scenario>& w, const id_table& bodies,
                                                 std::size_t count) {
  auto& s = state_of(w);
  const body_places<Scenario> places(s);
  plain_vector<load_sum> sums(count, load_sum{});
  plain_vector<std::uint8_t> used(count, 0);
  const auto add = [&](system_id id, const vec3& point, const vec3& centre, const vec3& force,
                       const vec3& moment) {
    const std::uint32_t at = bodies.find(id);
    if (at == id_table::unknown) return;
    vec3 about = centre;
    places.visit(id, [&](const auto& store, std::size_t i, bool global) {
      if (global) about = store.position[i];
    });
    sums[at].add(force, vec3(vec3(point - about).cross(force) + moment));
    used[at] = 1;
  };
  const auto on_both = [&](system_id a, system_id b, const vec3& point, const vec3& centre_a,
                           const vec3& centre_b, const vec3& force, const vec3& moment) {
    add(a, point, centre_a, force, moment);
    add(b, point, centre_b, vec3(-force), vec3(-moment));
  };
  if constexpr (Scenario::contact_law::soft) {
    observe_forces(s, [&](const contact_key& key, const vec3& point, const vec3& centre_a,
                          const vec3& centre_b, const pair_force& f, bool counts) {
      if (counts) on_both(key.a, key.b, point, centre_a, centre_b, f.force, f.moment);
    });
  } else {
    each_loaded_contact(s, places, [&](const loaded_contact& c, bool counts) {
      if (counts) on_both(c.a, c.b, c.point, c.centre_a, c.centre_b, c.force, {0, 0, 0});
    });
  }
  if (w.ranks() > 1) {
    byte_buffer mine;
    byte_writer out(mine);
    for (std::size_t k = 0; k < count; ++k)
      if (used[k] != 0) out.put(static_cast<std::uint64_t>(k)), out.put(sums[k]), sums[k] = {};
    for (const byte_buffer& theirs : w.link().gather_all(mine))
      for (byte_reader in(theirs); !in.empty();) {
        const auto k = static_cast<std::size_t>(in.get<std::uint64_t>());
        sums[k].add(in.get<load_sum>());
      }
  }
  std::vector<contact_load> loads;
  loads.reserve(count);
  for (const load_sum& sum : sums) loads.push_back(sum.value());
  return loads;
}

}  // namespace detail

/// Collective: contact_force() of each body, and contact_torque() about its position, alike on all
/// ranks: of any number of bodies in one pass over the contacts and one exchange. `bodies` is a
/// vector or array of handles or ids, the same on all ranks, or of what add_if_local() returns, as
/// long on all; the loads are in its order. The sums
/// do not depend on the number of ranks. Zero for a body that does not exist, and before the first
/// step.
template <class Scenario, class Bodies>
[[nodiscard]] std::vector<contact_load> contact_forces(world<Scenario>& w, const Bodies& bodies) {
  w.require_all_ranks("contact_forces");
  detail::id_table ids;
  ids.reset(std::size(bodies));
  std::size_t different = 0;
  std::vector<std::uint32_t> at;
  at.reserve(std::size(bodies));
  for (const system_id id : detail::agreed_ids(w, bodies)) {
    if (!ids.has(id)) ids.add(id), ++different;
    at.push_back(ids.find(id));
  }
  const std::vector<contact_load> loads = detail::loads_of(w, ids, different);
  std::vector<contact_load> all;
  all.reserve(at.size());
  for (const std::uint32_t k : at) all.push_back(loads[k]);
  return all;
}

/// One body, alike on all ranks: what its owner knows.
struct body_reading {
  bool exists = false;             ///< otherwise all else is 0
  vec3 position{0, 0, 0};          ///< of the centre of mass
  vec3 velocity{0, 0, 0};          ///< of the centre of mass
  vec3 angular_velocity{0, 0, 0};  ///< world frame
  quat orientation{1, 0, 0, 0};    ///< the identity where none is stored
  double mass = 0;                 ///< by density and volume; 0 of what has none, as a plane
  material_id material{};          ///< see world.materials()
  bool fixed = false;              ///< it cannot move
  bool global = false;             ///< it is known on all ranks
  int owner = 0;                   ///< the rank that has it; 0 for a global body
};

/// Collective: the body, whichever rank owns it. All ranks name the same one. Costs one reduction.
template <class Scenario, class Shape>
[[nodiscard]] body_reading measure_body(world<Scenario>& w, handle<Shape> h) requires(
    detail::takes_shape<Scenario, Shape>) {
  w.require_all_ranks("measure_body");
  std::array<double, 19> sums{};  // of one rank, and zeros
  if (const auto b = w.find(h); b && (b->is_global() ? w.rank() == 0 : !b->is_remote())) {
    const vec3 &x = b->position(), &v = b->velocity(), &turn = b->angular_velocity();
    const quat q = b->orientation();
    double mass = 0;
    if constexpr (Shape::finite) mass = b->mass();
    sums = {1,
            x[0],
            x[1],
            x[2],
            v[0],
            v[1],
            v[2],
            turn[0],
            turn[1],
            turn[2],
            q.w(),
            q.x(),
            q.y(),
            q.z(),
            mass,
            static_cast<double>(b->material()),
            b->is_fixed() ? 1.0 : 0.0,
            b->is_global() ? 1.0 : 0.0,
            static_cast<double>(w.rank())};
  }
  w.link().reduce(reduction::sum, std::span<double>(sums));
  body_reading r;
  if (sums[0] == 0) return r;
  const auto real_at = [&](std::size_t k) { return static_cast<real>(sums[k]); };
  const auto three = [&](std::size_t k) {
    return vec3(real_at(k), real_at(k + 1), real_at(k + 2));
  };
  r.exists = true;
  r.position = three(1), r.velocity = three(4), r.angular_velocity = three(7);
  r.orientation = quat(real_at(10), real_at(11), real_at(12), real_at(13));
  r.mass = sums[14];
  r.material = static_cast<material_id>(sums[15]);
  r.fixed = sums[16] != 0, r.global = sums[17] != 0;
  r.owner = static_cast<int>(sums[18]);
  return r;
}
/// Collective: the body that add_if_local() has added, which only some ranks have a handle of.
template <class Scenario, class Shape>
[[nodiscard]] body_reading measure_body(
    world<Scenario>& w,
    const std::optional<handle<Shape>>& h) requires(detail::takes_shape<Scenario, Shape>) {
  w.require_all_ranks("measure_body");
  return measure_body(w, handle<Shape>{detail::agreed_ids(w, std::span(&h, 1))[0]});
}
/// Refuses a shape that the scenario does not name.
template <class Scenario, class Shape,
          detail::sentence Says = detail::words_on_missing_shape<Shape>()>
body_reading measure_body(world<Scenario>&,
                          handle<Shape>) requires(!detail::takes_shape<Scenario, Shape>) = delete;
/// Refuses a shape that the scenario does not name.
template <class Scenario, class Shape,
          detail::sentence Says = detail::words_on_missing_shape<Shape>()>
body_reading measure_body(world<Scenario>&, const std::optional<handle<Shape>>&) requires(
    !detail::takes_shape<Scenario, Shape>) = delete;

}  // namespace talus
