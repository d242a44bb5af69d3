#pragma once
// The joints of an island, and its bodies, while these are moved to where the joints hold.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/constraint/joint_geometry.hpp"
#include "talus/constraint/line_writer.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/ghosts/shared_joints.hpp"
#include "talus/motion/integrate.hpp"
#include "talus/solver/direct/articulations.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/state.hpp"
#include "talus/step/moved_bodies.hpp"

namespace talus::detail {

/// Adds the poses of global bodies after a further time of `ahead`.
template <class Scenario>
void locate_global_ends(world_state<Scenario>& s, plain_vector<joint_end>& ends, real ahead) {
  const jointed_ids& ids = s.joints.ids();
  s.each_shape([&](auto& b) {
    const auto& store = b.global;
    for (std::size_t j = 0; j < store.size(); ++j) {
      const std::size_t k = ids.find(store.id[j]);
      if (k == jointed_ids::unknown) continue;
      ends[k].position = store.position[j] + ahead * store.velocity[j];
      ends[k].orientation =
          turned<real>(store.pose(j).orientation, ahead * store.angular_velocity[j]);
    }
  });
}

/// The joints that this rank solves, and their bodies: those of other ranks in the same islands,
/// too.
template <class Scenario>
class all_moved {
  using state_type = world_state<Scenario>;

 public:
  plain_vector<moved_joint> joints;
  plain_vector<moved_body> bodies;  ///< as joint_table::ends numbers them
  vector_of<plain_vector<std::uint32_t>> islands;

  /// After the integration; global bodies are taken where they will be after `ahead`.
  all_moved(state_type& s, real ahead) : s_(s) {
    find_bodies(ahead);
    constexpr bool coloured = state_type::may_use_colours;
    if constexpr (state_type::two_solvers)
      s.by_colours() ? list_joints<true>() : list_joints<false>();
    else
      list_joints<coloured>();
    find_islands();
  }

 private:
  void find_bodies(real ahead) {
    plain_vector<joint_end> ends = find_joint_ends(s_);
    locate_global_ends(s_, ends, ahead);
    for (std::size_t k = 0; k < s_.joints.ends.size(); ++k) {
      moved_body one;
      one.end = k < ends.size() ? ends[k] : s_.joints.ends[k];
      bodies.push_back(one);
    }
    each_jointed(s_, true, [&](auto& b, std::size_t i, std::size_t k) {
      using store_type = std::remove_cvref_t<decltype(b.movable)>;
      const auto& store = b.movable;
      if (!store.moves(i)) return;
      moved_body& x = bodies[k];
      const std::size_t number = b.first + i;
      x.inertia = store.shape[i].inertia() / store.inverse_mass[i];
      x.inverse_inertia =
          s_.solver.has_tensor(number)
              ? s_.solver.tensor(number)
              : diagonal_matrix<real>(real(s_.solver.bodies[number].inverse_inertia));
      if constexpr (store_type::tensor)
        x.turn = s_.dt * s_.solver.turn[number - s_.solver.first_tensor].w;
    });
    if constexpr (!state_type::link_type::alone)
      exchange_jointed(
          s_, [&](std::uint32_t k, byte_writer& out) { out.put(bodies[k]); },
          [&](std::uint32_t k, byte_reader& in) {
            const auto one = in.template get<moved_body>();
            if (k == joint_partner::ignored) return;
            bodies[k] = one;
            bodies[k].end.own = false;
          });
  }
  template <bool Coloured>
  void list_joints() {
    std::uint32_t kinds = 0;
    s_.joints.each_kind([&](auto& of_kind) {
      using kind = typename std::remove_cvref_t<decltype(of_kind)>::kind;
      const std::uint32_t number = kinds++;
      each_joint_in_order<Coloured>(of_kind, [&](auto& c, auto& r) {
        joints.push_back({number, r.key, &r.anchors.frames, &r.anchors,
                          [](const void* x, line_writer& to) {
                            kind::write(*static_cast<const typename kind::anchors*>(x), to);
                          },
                          &r.coordinates, c.view(),
                          static_cast<std::int32_t>(s_.joints.find_end(r.key.a)),
                          static_cast<std::int32_t>(s_.joints.find_end(r.key.b))});
      });
    });
  }
  void find_islands() {
    disjoint_sets sets(bodies.size());
    const auto moves = [&](std::int32_t k) {
      return bodies[static_cast<std::size_t>(k)].end.moves;
    };
    for (const moved_joint& j : joints)
      if (moves(j.a) && moves(j.b)) sets.join(j.a, j.b);
    plain_vector<std::int32_t> island(bodies.size(), -1);
    for (std::uint32_t n = 0; n < joints.size(); ++n) {
      const moved_joint& j = joints[n];
      std::int32_t& k = island[sets.root(moves(j.a) ? j.a : j.b)];
      if (k < 0) k = static_cast<std::int32_t>(islands.size()), islands.emplace_back();
      islands[static_cast<std::size_t>(k)].push_back(n);
    }
  }

  state_type& s_;
};

/// An island, with its bodies in numbers of its own.
template <class Scenario>
class moved_joints {
  using state_type = world_state<Scenario>;

 public:
  /// `numbers` holds -1 for all bodies, before and after.
  moved_joints(const state_type& s, const all_moved<Scenario>& from,
               const plain_vector<std::uint32_t>& island, plain_vector<std::int32_t>& numbers)
      : s_(s) {
    const auto number = [&](std::int32_t body) {
      std::int32_t& k = numbers[index(body)];
      if (k < 0) {
        k = static_cast<std::int32_t>(members.size());
        members.push_back(static_cast<std::uint32_t>(body));
        of.push_back(from.bodies[index(body)]);
        ends.push_back(of.back().end);
        if (!s.joints.before.empty()) before.push_back(s.joints.before[index(body)]);
      }
      return k;
    };
    std::size_t rows = 0;
    for (const std::uint32_t n : island) {
      moved_joint one = from.joints[n];
      one.a = number(one.a), one.b = number(one.b), one.first = rows;
      rows += static_cast<std::size_t>(one.solved.rows);
      all.push_back(one);
    }
    for (const std::uint32_t k : members) numbers[k] = -1;
    lines_.resize(rows), impulses_.assign(rows, 0);
    bodies.clear();
    for (moved_joint& j : all) {
      const joint_geometry g = geometry(j, ends);
      const joint_end &a = ends[index(j.a)], &b = ends[index(j.b)];
      j.arm = a.lever(g.arm_a) + b.lever(g.arm_b);
      j.length = g.arm_a.norm() + g.arm_b.norm() + a.position.norm() + b.position.norm();
      arm_ = std::max(arm_, j.arm);
    }
  }
  moved_joints(const moved_joints&) = delete;
  moved_joints& operator=(const moved_joints&) = delete;

  plain_vector<moved_joint> all;
  plain_vector<std::uint32_t> members;  ///< as joint_table::ends numbers them
  plain_vector<moved_body> of;          ///< after the integration
  plain_vector<joint_end> ends;         ///< as they are moved
  plain_vector<joint_end> before;       ///< at the start of the step, if the integrator notes it
  moved_bodies bodies{of};

  [[nodiscard]] std::span<joint_line> lines(const moved_joint& j) {
    return {lines_.data() + j.first, static_cast<std::size_t>(j.solved.rows)};
  }
  [[nodiscard]] std::span<const real> impulses(const moved_joint& j) const {
    return {impulses_.data() + j.first, static_cast<std::size_t>(j.solved.rows)};
  }
  [[nodiscard]] joint_geometry geometry(const moved_joint& j,
                                        const plain_vector<joint_end>& at) const {
    const joint_end &a = at[index(j.a)], &b = at[index(j.b)];
    const pose at_a{a.position, a.orientation};
    return geometry_of(*j.frames, at_a,
                       {seen_from(s_, *j.frames, at_a, b.position), b.orientation});
  }
  /// Writes the rows of a joint there.
  void write(const moved_joint& j, const joint_geometry& g) {
    const jointed_body still{};
    joint_coordinates coordinates = *j.coordinates;
    std::fill(lines(j).begin(), lines(j).end(), joint_line{});
    line_writer writer(lines(j), coordinates, g, still, still, {.dt = 1});
    j.write(j.anchors, writer);
  }
  /// The largest error of its rows, as they were written: over the lengths of which it consists.
  [[nodiscard]] real error(const moved_joint& j) { return opening_of(lines(j), j.length).part; }
  /// Repeats: measure() writes the rows with their targets, may set motions, which are 0 before,
  /// and returns the largest error; the joints are solved; move() applies the motions of `bodies`.
  /// Returns the last error.
  template <class Measure, class Move>
  real iterate(int least, Measure&& measure, Move&& move) {
    constexpr int most = 30, most_idle = 3;
    real best = unbounded;
    for (int k = 0, idle = 0;; ++k) {
      bodies.clear();
      const real worst = measure();
      idle += !(worst < real(0.5) * best);
      if (k == most || (k >= least && (worst <= enough || idle == most_idle))) return worst;
      best = std::min(best, worst);
      solve(k == 0);
      system_.share_loads();
      move();
    }
  }
  /// Moves the ends until all rows hold, and never to where the worst of them is worse: repeats
  /// write(joint), which writes the rows with their targets; the joints are solved, and the ends
  /// are moved so, or by a part of it if all of it is too far. Calls left(joint, opening) for the
  /// joints that stay open, and returns whether that makes them better.
  template <class Write, class Left>
  bool close(Write&& write, Left&& left) {
    constexpr int most = 30, most_idle = 3, most_parts = 6;
    constexpr real small = 1e-12, far = 0.5;
    plain_vector<joint_end> best = ends;
    real least = unbounded, first = 0, part = 1, remains = 0;
    for (int k = 0, idle = 0, parts = 0; k < most; ++k) {
      real worst = 0, open = 0, own = 0;
      for (const moved_joint& j : all) {
        write(j);
        worst = larger(worst, error(j));
        open = larger(open, opening_of(lines(j), arm_).part);
        own = larger(own, opening_of(lines(j), j.arm).part);
      }
      if (k == 0) first = open;
      if (open < least) {
        idle += !(open < real(0.5) * least), parts = 0;
        least = open, best = ends, part = 1, remains = own;
        if (worst <= enough || idle > most_idle) break;
        bodies.clear();
        solve(k == 0);
        if (const real turn = largest_turn(); turn > far) {  // too far for rows at one orientation
          for (std::size_t i = 0; i < of.size(); ++i)
            if (of[i].end.moves)
              bodies.stiffen(static_cast<std::int32_t>(i),
                             (turn / far) * mat3(of[i].inverse_inertia.inverse()));
          bodies.clear();
          solve(true);
        }
      } else {
        if (worst <= small || ++parts > most_parts) break;
        ends = best, part *= real(0.25);
      }
      for (std::size_t i = 0; i < ends.size(); ++i) {
        const body_motion& d = bodies.motion(static_cast<std::int32_t>(i));
        ends[i].position += part * d.v;
        ends[i].orientation = turned<real>(ends[i].orientation, part * d.w);
      }
    }
    ends = best, bodies.end_stiffening();
    if (remains > noted_opening)
      for (const moved_joint& j : all) write(j), left(j, opening_of(lines(j), j.arm));
    return least < first;
  }

 private:
  static constexpr real enough = 4e-15;
  static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

  [[nodiscard]] real largest_turn() const {
    real turn = 0;
    for (std::size_t i = 0; i < ends.size(); ++i)
      turn = larger(turn, bodies.motion(static_cast<std::int32_t>(i)).w.norm());
    return turn;
  }
  void solve(bool first) {
    impulses_.assign(impulses_.size(), 0);
    if (first) {
      plain_vector<joint_view> views;
      for (const moved_joint& j : all)
        views.push_back(
            {j.a, j.b, j.solved.rows, lines_.data() + j.first, impulses_.data() + j.first});
      system_.gather({views.data(), views.size()}, bodies);
    }
    system_.renew();
    system_.solve(bodies);
  }

  const state_type& s_;
  plain_vector<joint_line> lines_;
  plain_vector<real> impulses_;
  real arm_ = 0;  ///< the longest
  articulations system_;
};

}  // namespace talus::detail
