#pragma once
// Joints in a step: their bodies, their rows for the solver, and the impulses that they keep.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "talus/body/jointed_body.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/state/kinematic_bodies.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Calls f(bodies of a shape, i, number of the member) for the movable bodies known here that have
/// joints, those owned here first.
template <class Scenario, class F>
void each_jointed(world_state<Scenario>& s, bool owned_here, F&& f) {
  const jointed_ids& ids = s.joints.ids();
  if (ids.members.empty()) return;
  s.each_finite_shape([&](auto& b) {
    const std::size_t end = owned_here ? b.movable.locals : b.movable.size();
    for (std::size_t i = owned_here ? 0 : b.movable.locals; i < end; ++i)
      if (const std::size_t k = ids.find(b.movable.id[i]); k != jointed_ids::unknown) f(b, i, k);
  });
}

/// The rank that owns copy i of a shape.
template <class Scenario, class Bodies>
[[nodiscard]] int owner_of_copy(const world_state<Scenario>& s, const Bodies& b, std::size_t i) {
  using shape = typename Bodies::shape_type;
  constexpr auto k = index_of<typename world_state<Scenario>::finite_shapes, shape>;
  std::size_t end = b.movable.locals;
  for (const auto& n : s.neighbours)
    if (i < (end += n.copies[k])) return n.rank;
  return -1;
}

/// The bodies of the joints of this rank, as jointed_ids numbers them.
template <class Scenario>
[[nodiscard]] plain_vector<joint_end> find_joint_ends(world_state<Scenario>& s) {
  const jointed_ids& ids = s.joints.ids();
  plain_vector<joint_end> ends(ids.members.size());
  if (ends.empty()) return ends;
  for (const bool own : {true, false})
    each_jointed(s, own, [&](auto& b, std::size_t i, std::size_t k) {
      if (ends[k].known) return;  // an image of a body that is here
      using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
      const auto& store = b.movable;
      joint_end& end = ends[k];
      end.known = true, end.own = own, end.moves = store.moves(i), end.asleep = store.asleep(i);
      end.number = static_cast<std::int32_t>(b.first + i);
      end.position = store.position[i];
      if constexpr (world_state<Scenario>::periodic)
        if (const image_copy* copy = copy_of<shape>(s, i)) end.position = copy->home;
      end.orientation = store.pose(i).orientation;
      end.velocity = store.velocity[i], end.spin = store.angular_velocity[i];
      end.inverse_mass = store.inverse_mass[i];
      end.radius = store.shape[i].bounding_radius();
      if constexpr (!world_state<Scenario>::link_type::alone) {
        end.at_border = b.first + i < s.at_border.size() && s.at_border[b.first + i];
        if (!own) end.owner = owner_of_copy(s, b, i);
      }
    });
  return ends;
}
/// The body of the solver's arrays that stands for all that never moves.
template <class Scenario>
[[nodiscard]] std::int32_t number_of_wall(world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::drives) {
    return static_cast<std::int32_t>(s.driving.first);
  } else {
    if (s.joints.wall == no_wall) {
      s.joints.wall = s.solver.bodies.size();
      s.solver.bodies.push_back({});
    }
    return static_cast<std::int32_t>(s.joints.wall);
  }
}
/// Adds the global bodies to them, and the frame of the world.
template <class Scenario>
void find_global_ends(world_state<Scenario>& s, plain_vector<joint_end>& ends) {
  s.joints.wall = no_wall;
  const jointed_ids& ids = s.joints.ids();
  if (ends.empty()) return;
  if (const std::size_t k = ids.find(id_of_world); k != jointed_ids::unknown) {
    ends[k].known = ends[k].global = true;
    ends[k].number = number_of_wall(s);
  }
  s.each_shape([&](auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    const auto& store = b.global;
    for (std::size_t j = 0; j < store.size(); ++j) {
      const std::size_t k = ids.find(store.id[j]);
      if (k == jointed_ids::unknown) continue;
      joint_end& end = ends[k];
      end.known = end.global = true;
      end.position = store.position[j], end.orientation = store.pose(j).orientation;
      end.velocity = store.velocity[j], end.spin = store.angular_velocity[j];
      if constexpr (world_state<Scenario>::drives)
        end.number = number_of_global<shape>(s, j, end.velocity, end.spin, -1, 0);
      else
        end.number = number_of_wall(s);
    }
  });
}

template <class Scenario>
[[noreturn, gnu::cold]] void fail_jointed(const world_state<Scenario>& s, system_id known,
                                          const vec3& place, system_id missing, real distance) {
  fail<std::runtime_error>(
      "body {} at {} on rank {} is joined to body {}, which this rank does not know in step {}: it "
      "is further away than connections reach; connect ranks within {} of each other, by that "
      "reach in world.decompose(..., reach)",
      known, text(place), s.link->rank(), missing, s.steps, text(distance, 4));
}

[[nodiscard]] inline jointed_body body_of(const joint_end& x, const vec3& position) {
  return {{position, x.orientation}, x.spin, x.velocity};
}
[[nodiscard]] inline jointed_body body_of(const joint_end& x) { return body_of(x, x.position); }

/// Whether the joints are solved together, exactly, and hold after the step: not where positions
/// follow several velocities.
template <class Scenario>
inline constexpr bool solves_joints_directly = !uses_substeps<typename Scenario::solver>;

/// Calls f(rows, record) for the joints of a kind on this rank and the far ones, in the order of
/// their keys. `Coloured`: the lists of the solver in use.
template <bool Coloured, class OfKind, class F>
void each_joint_in_order(OfKind& of_kind, F&& f) {
  using row = typename OfKind::row;
  plain_vector<row*> own(of_kind.records.size(), nullptr);
  auto& list = list_in_use<Coloured>(of_kind.list);
  const auto note = [&](row& c, auto...) { own[c.record] = &c; };
  if constexpr (Coloured)
    list.edit_all(note);
  else
    list.edit_interior_contacts(note), list.edit_boundary_contacts(note);
  std::size_t next = 0;
  const auto pass_far = [&](const joint_key* until) {
    for (; next < of_kind.far.size() && (until == nullptr || of_kind.far[next].key < *until);
         ++next)
      f(of_kind.far_rows[next], of_kind.far[next]);
  };
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i] == nullptr) continue;
    pass_far(&of_kind.records[i].key);
    f(*own[i], of_kind.records[i]);
  }
  pass_far(nullptr);
}

/// Finds which ranks have the record of a joint of the bodies a and b.
template <class Record>
void find_holders(Record& r, const joint_end& a, const joint_end& b) {
  r.acts = (a.own && a.movable()) || (b.own && b.movable());
  r.follows = !r.acts && (a.movable() || b.movable());
  r.follower = -1;
  for (const joint_end* x : {&a, &b})
    if (r.acts && x->known && !x->own && !x->global && !x->movable()) r.follower = x->owner;
}

/// The nearest image of the second body of a joint, seen from the point of the joint on the first:
/// the origin of the frame of the world may be anywhere in a periodic box.
template <class State>
[[nodiscard]] vec3 seen_from(const State& s, const joint_frames& of, const pose& a, const vec3& b) {
  if constexpr (State::periodic)
    return seen_from(s, a.position + rotated(a.orientation, of.on_a), b);
  return (void)s, (void)of, (void)a, b;
}

/// The errors of rows: the largest gap, and the larger of its part of an arm and the largest error
/// of an angle. Limits count where they are passed.
[[nodiscard]] inline joint_opening opening_of(std::span<const joint_line> lines, real arm) {
  joint_opening x;
  real angle = 0;
  for (const joint_line& line : lines) {
    if (line.use == line_use::off || drives(line.use)) continue;
    if (line.use == line_use::limits && line.error >= 0) continue;
    real& worst = line.force == vec3(0, 0, 0) ? angle : x.gap;
    worst = larger(worst, std::abs(line.error));
  }
  x.part = std::max(angle, arm > 0 ? x.gap / arm : x.gap);
  return x;
}

/// Writes the rows of a joint of the bodies a and b. They begin with the impulses of the last step,
/// but not where a joint is torn apart by more than its arm, or turned by more than a radian: its
/// rows are others then, those of a rod far larger, and such impulses would leave the round-off of
/// velocities far above all others.
template <class Scenario, class Row, class Record>
void place_rows(const world_state<Scenario>& s, Row& c, Record& r, const joint_end& a,
                const joint_end& b) {
  c.a = a.number, c.b = b.number;
  const joint_moment when{s.dt, world_state<Scenario>::midpoint, world_state<Scenario>::midpoint};
  const vec3 at_b = seen_from(s, r.anchors.frames, {a.position, a.orientation}, b.position);
  c.place(r.anchors, body_of(a), body_of(b, at_b), when, r.coordinates);
  if (opening_of(c.lines, a.lever(r.anchors.frames.on_a) + b.lever(r.anchors.frames.on_b)).part > 1)
    r.impulse = {};
  c.set(r.impulse), c.earlier = r.impulse;
}

/// Fills the lists of joints for the step under way. Those of two movable bodies on two ranks are
/// boundary constraints of both.
template <class Scenario>
void place_joints(world_state<Scenario>& s) {
  s.each_joint_list([](auto& list) { list.clear(); });
  plain_vector<joint_end>& ends = s.joints.ends;
  ends = find_joint_ends(s);
  find_global_ends(s, ends);
  const jointed_ids& ids = s.joints.ids();
  std::uint32_t kinds = 0;
  s.joints.each_kind([&](auto& of_kind) {
    const std::uint32_t kind = kinds++;
    std::uint32_t number = 0;
    for (auto& r : of_kind.records) {
      const std::uint32_t record = number++;
      const std::size_t at_a = ids.find(r.key.a), at_b = ids.find(r.key.b);
      const joint_end &a = ends[at_a], &b = ends[at_b];
      if (!a.known) fail_jointed(s, r.key.b, b.position, r.key.a, ids.members[at_a].reach);
      if (!b.known) fail_jointed(s, r.key.a, a.position, r.key.b, ids.members[at_b].reach);
      find_holders(r, a, b);
      if (!(a.own && a.moves) && !(b.own && b.moves)) continue;
      typename std::remove_cvref_t<decltype(of_kind.list)>::contact_type c;
      c.record = record;
      place_rows(s, c, r, a, b);
      if constexpr (!solves_joints_directly<Scenario>) {  // otherwise, settle_joints() notes it
        joint_opening open =
            opening_of(c.lines, a.lever(r.anchors.frames.on_a) + b.lever(r.anchors.frames.on_b));
        open.step = s.steps, open.kind = kind, open.key = r.key;
        if (open.part > noted_opening) s.joints.opening.note(open);
      }
      const contact_key key{r.key.a, r.key.b, r.key.number};
      if (a.moves && b.moves && a.own != b.own)
        of_kind.list.add_boundary(c, key, a.own, nullptr);
      else
        of_kind.list.add(c, key, a.moves, b.moves, nullptr, a.at_border || b.at_border);
    }
  });
}

/// After the response: for the next step, and for handles.
template <class Scenario>
void store_joint_impulses(world_state<Scenario>& s) {
  s.joints.each_kind([&](auto& of_kind) {
    using kind = typename std::remove_cvref_t<decltype(of_kind)>::kind;
    of_kind.list.each([&](const auto& c, bool) {
      auto& r = of_kind.records[c.record];
      r.impulse = c.impulse_in_frame();
      r.load = c.on_a();
      r.load.moment -= c.arm_a.cross(r.load.impulse);
      if constexpr (has_axes<kind>) r.drives = c.drives_of_axes(s.solver);
    });
    if constexpr (requires { kind::roams; })
      if (!of_kind.records.empty()) s.joints.changed();  // how far it reaches
  });
}

/// Removes the joints that the load of the step breaks: both ranks of a joint have the same load.
template <class Scenario>
void break_joints(world_state<Scenario>& s) {
  s.joints.each_kind([&](auto& of_kind) {
    using kind = typename std::remove_cvref_t<decltype(of_kind)>::kind;
    using record = typename std::remove_cvref_t<decltype(of_kind)>::record;
    if constexpr (requires(const record& r) { kind::breaks(r.anchors, real(0), real(0)); }) {
      std::size_t kept = 0;
      for (const record& r : of_kind.records)
        if (!kind::breaks(r.anchors, r.load.impulse.norm() / s.dt, r.load.moment.norm() / s.dt))
          of_kind.records[kept++] = r;
      if (kept == of_kind.records.size()) return;
      of_kind.records.resize(kept);
      s.joints.changed();
      s.changed = true;
    }
  });
}

/// Bodies reach their jointed partners, so that both owners know both bodies.
template <class Scenario>
void reach_jointed(world_state<Scenario>& s) {
  const jointed_ids& ids = s.joints.ids();
  for (const bool own : {true, false})
    each_jointed(s, own, [&](auto& b, std::size_t i, std::size_t k) {
      b.reach[i] = std::max(b.reach[i], ids.members[k].reach);
    });
}

/// Throws logic_error if a body that is to be destroyed has joints.
template <class Scenario>
void refuse_jointed(world_state<Scenario>& s, const char* shape, system_id id) {
  if (s.joints.ids().find(id) != jointed_ids::unknown)
    fail<std::logic_error>(
        "the {} {} was destroyed on rank {} while it has a joint: release its joints first, on all "
        "ranks",
        shape, id, s.link->rank());
}

}  // namespace talus::detail
