#pragma once
// The definitions of view_content.hpp, in the compiled part or in each program.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "talus/core/linkage.hpp"
#include "talus/core/sort.hpp"
#include "talus/io/detail/view_content.hpp"

namespace talus::detail {

/// Velocities, orientations and states of bodies, in the order of the frame, and what they have
/// most.
TALUS_INLINE void put_motion(view_json& head, view_blocks& to, const plain_vector<view_body>& all,
                             const plain_vector<std::uint32_t>& order, bool several_ranks) {
  constexpr double most = std::numeric_limits<double>::max();
  vec3 lower{most, most, most}, upper{-most, -most, -most};
  double fastest = 0, speed = 0;
  bool asleep = false;
  std::size_t movable = 0;
  for (const view_body& b : all) {
    for (int k = 0; k < 3; ++k) speed = std::max(speed, std::abs(b.velocity[k]));
    asleep = asleep || b.asleep != 0;
    if ((b.flags & view_wall) != 0) continue;
    fastest = std::max(fastest, b.velocity.norm()), movable += b.part == 0;
    const double half = std::max({b.size[0], b.size[1], b.size[2]}) / 2;
    for (int k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], b.position[k] - half);
      upper[k] = std::max(upper[k], b.position[k] + half);
    }
  }
  const double speed_cell = std::max(speed / 32767, 1e-300);
  plain_vector<std::int16_t> velocities, turns;
  plain_vector<std::uint16_t> ranks;
  plain_vector<std::uint8_t> sleep;
  const auto small = [](double x) {
    return static_cast<std::int16_t>(std::clamp(std::round(x), -32767.0, 32767.0));
  };
  for (const std::uint32_t i : order) {
    const view_body& b = all[i];
    for (int k = 0; k < 3; ++k) velocities.push_back(small(b.velocity[k] / speed_cell));
    const quat& q = b.orientation;
    if (b.shape != view_shape::sphere)
      for (const double x : {q.x(), q.y(), q.z(), q.w()}) turns.push_back(small(32767 * x));
    ranks.push_back(static_cast<std::uint16_t>(b.rank)), sleep.push_back(b.asleep);
  }
  to.put("velocity", velocities);
  if (!turns.empty()) to.put("orientation", turns);
  if (several_ranks) to.put("rank", ranks);
  if (asleep) to.put("asleep", sleep);
  head.add("bodies", static_cast<double>(movable));
  if (movable > 0) {
    std::string box = view_json::vector(lower) + "," + view_json::vector(upper);
    std::erase_if(box, [](char c) { return c == '[' || c == ']'; });
    head.add_raw("box", "[" + box + "]");
  }
  head.add("speed_cell", speed_cell);
  head.add("speed_max", fastest);
}

struct stronger {
  [[nodiscard]] bool operator()(const view_contact& x, const view_contact& y) const {
    const double f = x.force.squaredNorm(), g = y.force.squaredNorm();
    if (f != g) return f > g;
    if (x.a != y.a) return value_of(x.a) < value_of(y.a);
    return x.b != y.b ? value_of(x.b) < value_of(y.b) : x.feature < y.feature;
  }
};

/// What the contacts of a body add up to.
struct view_load {
  double force = 0;
  std::uint32_t contacts = 0;
};
/// Walls have a cell of their own: they may carry all that the others weigh. The parts of a union
/// have the force of the whole.
TALUS_INLINE void put_loads(view_json& head, view_blocks& to, const view_places& places,
                            const plain_vector<view_contact>& contacts) {
  std::size_t count = 0;
  places.each([&](const view_body&, std::uint32_t) { ++count; });
  plain_vector<view_load> loads(count);
  for (const view_contact& c : contacts)
    for (const system_id id : {c.a, c.b})
      if (const std::uint32_t at = places.of(id); at < count)
        loads[at].force += c.force.norm(), ++loads[at].contacts;
  double most[2]{0, 0};
  const view_body* first = nullptr;
  view_load whole;
  places.each([&](const view_body& b, std::uint32_t at) {
    if (first == nullptr || first->id != b.id) first = &b, whole = loads[at];
    loads[at] = whole;
    double& m = most[(b.flags & view_wall) != 0];
    m = std::max(m, whole.force);
  });
  const double cell[2]{std::max(most[0] / 65535, 1e-300), std::max(most[1] / 65535, 1e-300)};
  plain_vector<std::uint16_t> forces(count);
  plain_vector<std::uint8_t> touching(count);
  places.each([&](const view_body& b, std::uint32_t at) {
    forces[at] = cells_of(loads[at].force / cell[(b.flags & view_wall) != 0]);
    touching[at] = static_cast<std::uint8_t>(std::min<std::uint32_t>(loads[at].contacts, 255));
  });
  to.put("force", forces), to.put("touching", touching);
  head.add("body_force_cell", cell[0]);
  head.add("wall_force_cell", cell[1]);
}

TALUS_INLINE void put_contacts(view_json& head, view_blocks& to, const view_grid& grid,
                               const view_places& places, plain_vector<view_contact>& contacts,
                               bool each) {
  sort_values(contacts, stronger{});
  head.add("contacts_of", static_cast<double>(contacts.size()));
  if (contacts.empty()) return;
  double sum = 0;
  for (const view_contact& c : contacts) sum += c.force.norm();
  head.add("force_mean", sum / static_cast<double>(contacts.size()));
  put_loads(head, to, places, contacts);
  if (each) {
    const double force_cell = std::max(contacts[0].force.norm() / 65535, 1e-300);
    head.add("force_cell", force_cell);
    if (contacts.size() > most_view_contacts) contacts.resize(most_view_contacts);
    plain_vector<std::uint32_t> a, b;
    plain_vector<std::uint16_t> sizes;
    for (const view_contact& c : contacts) {
      a.push_back(places.of(c.a)), b.push_back(places.of(c.b));
      sizes.push_back(cells_of(c.force.norm() / force_cell));
    }
    to.put("contact_a", a), to.put("contact_b", b), to.put("contact_force", sizes);
    grid.put("contact_point", to, [&](auto&& put) {
      for (const view_contact& c : contacts) put(c.point);
    });
  }
}

TALUS_INLINE std::string view_materials(const material_table& all) {
  std::string out = "[";
  for (std::size_t k = 0; k < all.size(); ++k) {
    const material& m = all[material_id{static_cast<std::uint16_t>(k)}];
    view_json one;
    if (!m.name.text().empty()) one.add_text("name", m.name.text());
    if (m.colour[0] == m.colour[0]) one.add_raw("colour", view_json::vector(m.colour));
    (out += k > 0 ? "," : "") += one.str();
  }
  return out += "]";
}

TALUS_INLINE std::string view_look(const picture& look) {
  constexpr const char* names[] = {"", "rank", "speed", "material"};
  view_json out;
  out.add_raw("from", view_json::vector(look.from));
  out.add_raw("at", view_json::vector(look.at));
  out.add_raw("up", view_json::vector(look.up));
  out.add("angle", look.angle);
  out.add("walls", look.walls);
  if (look.colour != picture::colouring::automatic)
    out.add_text("colour", names[static_cast<std::size_t>(look.colour)]);
  if (look.fastest > 0) out.add("fastest", look.fastest);
  if (look.follow != no_id) out.add_text("follow", std::to_string(value_of(look.follow)));
  return out.str();
}

TALUS_INLINE void put_joints(view_blocks& to, const view_grid& grid, const view_places& places,
                             plain_vector<view_joint>& joints) {
  // Both ranks of a joint report it.
  sort_values(joints);
  std::size_t kept = 0;
  for (const view_joint& j : joints)
    if (kept == 0 || joints[kept - 1] < j) joints[kept++] = j;
  joints.resize(kept);
  if (!joints.empty()) {
    plain_vector<std::uint32_t> a, b;
    for (const view_joint& j : joints) a.push_back(places.of(j.a)), b.push_back(places.of(j.b));
    to.put("joint_a", a), to.put("joint_b", b);
    const auto put_ends = [&](const char* name, bool first) {
      grid.put(name, to, [&](auto&& put) {
        for (const view_joint& j : joints) {
          const view_body *x = places.find(j.a), *y = places.find(j.b);
          if (!first) std::swap(x, y);
          vec3 on = first ? j.on_a : j.on_b;
          if (x == nullptr && y != nullptr) x = y, on = first ? j.on_b : j.on_a;
          put(x != nullptr ? vec3(x->position + rotated(x->orientation, on)) : vec3(0, 0, 0));
        }
      });
    };
    put_ends("joint_point", true), put_ends("joint_other", false);
  }
}

}  // namespace talus::detail
