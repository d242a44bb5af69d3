#pragma once
// The ghost exchange of a solver: in its iterations, shadow velocities are refreshed from their
// owners by one message per neighbour, velocities only, in a fixed order.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <functional>
#include <limits>
#include <span>
#include <type_traits>

#include "talus/core/plain_vector.hpp"
#include "talus/ghosts/joint_supports.hpp"
#include "talus/ghosts/shared_joints.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

template <class Shape>
struct has_tensor : std::bool_constant<!Shape::isotropic> {};

template <class Scenario>
class shared_velocities {
 public:
  using state_type = world_state<Scenario>;
  using number = solved_scalar<Scenario>;
  using solver_type = solver_state_of<number>;
  static constexpr bool alone = state_type::link_type::alone;
  static constexpr bool coloured = false;
  /// Whether the position correction rotates bodies: some have a tensor of inertia.
  static constexpr bool turning =
      filter_types<typename state_type::finite_shapes, has_tensor>::size > 0;

  /// Whether joints are solved all at once.
  static constexpr bool solves_joints = state_type::has_joints && solves_joints_directly<Scenario>;

  explicit shared_velocities(state_type& s) : s_(s) {}

  [[nodiscard]] bool single() const { return s_.on_one_rank(); }

  std::function<void()> before_strikes;  ///< see impact_stage.hpp

  /// The joints of this rank, and those of other ranks in the same islands, in an order that does
  /// not depend on the ranks.
  template <bool Coloured>
  [[nodiscard]] plain_vector<joint_view> joint_views() {
    plain_vector<joint_view> views;
    s_.joints.each_kind([&](auto& of_kind) {
      each_joint_in_order<Coloured>(of_kind,
                                    [&](auto& c, const auto&) { views.push_back(c.view()); });
    });
    return views;
  }
  /// The velocities of the bodies of islands of joints on several ranks; `first` in a step, also
  /// their masses.
  void share_jointed(bool first) {
    if constexpr (solves_joints && !alone) share_jointed_velocities(s_, first);
  }

  /// Calls f(supports) with the contacts of jointed bodies with what cannot move, and stores their
  /// impulses, if that is `needed` or another rank may need them. Returns whether.
  template <class Lists, class F>
  bool with_supports(Lists& lists, bool needed, F&& f) {
    if constexpr (solves_joints && std::is_same_v<number, real>) {
      if (!needed && s_.joints.partners.empty()) return false;
      joint_supports<Scenario> supports(s_);
      supports.gather(lists);
      f(supports.all);
      supports.put(lists);
      return true;
    } else {
      return (void)lists, (void)needed, (void)f, false;
    }
  }

  /// Calls f(rows) for the same joints, in the same order.
  template <class F>
  void each_joint(F&& f) {
    s_.joints.each_kind([&](auto& of_kind) {
      each_joint_in_order<coloured>(of_kind, [&](auto& c, const auto&) { f(c); });
    });
  }
  /// For solvers that solve joints at once: as the lists of contacts do it, but alike on all ranks
  /// of an island. The impulses of the last step go to all bodies here, in the order of the joints.
  void warm_start_joints() {
    each_joint([&](const auto& c) { c.apply(s_.solver, c.impulse_in_frame()); });
  }
  /// After share_jointed(true).
  void prepare_joints() {
    each_joint([&](auto& c) { c.prepare(s_.solver, 1, 1); });
  }
  /// One sweep of the position correction.
  void correct_joints() {
    if constexpr (!alone) {
      std::array<correction, of_correction> values{};
      exchange_jointed(
          s_,
          [&](std::uint32_t k, byte_writer& out) {
            put_correction(static_cast<std::uint32_t>(s_.joints.ends[k].number), values.data());
            out.put(values);
          },
          [&](std::uint32_t k, byte_reader& in) {
            values = in.get<std::array<correction, of_correction>>();
            if (k != joint_partner::ignored)
              get_correction(static_cast<std::uint32_t>(s_.joints.ends[k].number), values.data());
          });
    }
    each_joint([&](auto& c) {
      const auto d = c.relax_correction(s_.solver);
      c.correct_a(s_.solver, d), c.correct_b(s_.solver, d);
    });
  }

  /// Besides the velocities: the number of parts into which each body's mass is split at the
  /// boundary, and data for shared islands.
  void share_velocities_and_counts() {
    s_.passive.refreshed.clear();
    exchange<11, real>(
        [&](std::uint32_t i, real* out) {
          put_velocity(i, out);
          out[6] = s_.solver.boundary_contacts[i];
          const body_ties& ties = s_.islands.ties(i);
          const auto [high, low] = ties.holders.packed();
          out[7] = ties.of_owner, out[8] = high, out[9] = low;
          out[10] = s_.islands.is_hub(i);
        },
        [&](std::uint32_t i, const real* in) {
          get_velocity(i, in);
          s_.solver.boundary_contacts[i] = static_cast<std::uint32_t>(in[6]);
          body_ties& ties = s_.islands.ties(i);
          ties.of_owner = static_cast<std::int32_t>(in[7]);
          ties.holders.unpack(in[8], in[9]);
          if (in[10] != 0) s_.islands.add_hub(i);
        });
  }
  /// To be called before any impulse is applied, and after share_velocities_and_counts().
  template <class Lists>
  void look_for_shared_islands(Lists& lists) {
    if constexpr (!state_type::islands_across_ranks) return (void)lists;
    const auto all = access_to<solver_type>(lists);
    s_.islands.look(all, s_.solver, s_.link->rank(), travelling(), s_.known_fixed.all,
                    sees_single_images(s_));
  }
  template <class Lists>
  void solve_shared_islands(Lists& lists) {
    const auto all = access_to<solver_type>(lists);
    s_.islands.solve_shared(all, s_.solver);
  }
  /// After the last sweep.
  template <class Lists>
  void solve_gathered_islands(Lists& lists) {
    if constexpr (!state_type::islands_across_ranks) return (void)lists;
    std::vector<neighbour_message> neighbour_messages;
    const auto exchange = [&] {
      const stage_clock clock(s_.seconds.exchange);
      s_.link->start(neighbour_messages);
      s_.link->finish(neighbour_messages);
    };
    s_.islands.solve_gathered(access_to<solver_type>(lists), s_.solver, s_.link->rank(),
                              travelling(), neighbour_messages, exchange);
    if (neighbour_messages.empty()) return;
    // Exchanges the new velocities of the copies with these ranks.
    const auto with = [&](int rank) -> const auto& {
      return *std::find_if(s_.travelling.begin(), s_.travelling.end(),
                           [&](const auto& other) { return other.rank == rank; });
    };
    std::array<real, 6> values{};
    s_.passive.common_before = s_.passive.common;
    s_.passive.refreshed.assign(s_.solver.bodies.size(), 0);
    for (neighbour_message& p : neighbour_messages) {
      p.out.clear();
      byte_writer out(p.out);
      for (const std::uint32_t i : with(p.rank).sent)
        put_velocity(i, values.data()), out.put(values);
    }
    exchange();
    for (neighbour_message& p : neighbour_messages) {
      byte_reader in(p.in);
      for (const std::uint32_t i : with(p.rank).received)
        get_velocity(i, in.get<std::array<real, 6>>().data()), s_.passive.refreshed[i] = 1;
    }
  }
  void share_velocities() { start_velocities(), finish_velocities(); }
  /// Starts the exchange of velocities that finish_velocities() ends. Until then the caller must
  /// not change the values that are sent, and those to be received are not available.
  void start_velocities() {
    start<6, number>([&](std::uint32_t i, number* out) { put_velocity(i, out); });
  }
  void finish_velocities() {
    finish<6, number>([&](std::uint32_t i, const number* in) { get_velocity(i, in); });
  }
  /// Sums over all ranks, to be taken by finish_reduce() later.
  void start_reduce(std::span<const double> sums) { s_.link->start_reduce(reduction::sum, sums); }
  void finish_reduce(std::span<double> sums) {
    const stage_clock clock(s_.seconds.exchange);
    s_.link->finish_reduce(sums);
  }
  /// Replaces sums by those over all ranks, whatever their number.
  template <std::size_t N>
  void sum_exactly(std::array<signed_sum, N>& sums) {
    const stage_clock clock(s_.seconds.exchange);
    detail::sum_exactly(*s_.link, sums);  // while a reduction around the step may be open
  }
  /// Whether the velocity of a body on any rank differs by more than round-off from `before`.
  [[nodiscard]] bool changed_since(const plain_vector<solver_body_of<number>>& before) const {
    std::array<double, 2> largest{0, 0};  // change and velocity, squared
    s_.each_finite_shape([&](const auto& b) {
      for (std::size_t i = b.first; i < b.first + b.movable.locals; ++i) {
        const vec3 v = v_of(s_.solver.bodies[i]);
        largest[0] = std::max<double>(largest[0], (v - v_of(before[i])).squaredNorm());
        largest[1] = std::max<double>(largest[1], v.squaredNorm());
      }
    });
    if constexpr (!alone) s_.link->reduce(reduction::max, std::span(largest));
    constexpr double round_off = 4 * std::numeric_limits<number>::epsilon();
    return largest[0] > round_off * round_off * largest[1];
  }
  /// One value of each body.
  void share_values(plain_vector<real>& values) {
    exchange<1, real>([&](std::uint32_t i, real* out) { out[0] = values[i]; },
                      [&](std::uint32_t i, const real* in) { values[i] = in[0]; });
  }
  void start_corrections() {
    start<of_correction, correction>(
        [&](std::uint32_t i, correction* out) { put_correction(i, out); });
  }
  void finish_corrections() {
    finish<of_correction, correction>(
        [&](std::uint32_t i, const correction* in) { get_correction(i, in); });
  }

 protected:
  static constexpr int of_correction = turning ? 6 : 3;
  using correction = std::conditional_t<turning, real, number>;

  void put_correction(std::uint32_t i, correction* out) const {
    const solver_type& solver = s_.solver;
    const bool turns = turning && i >= solver.first_tensor;
    for (int k = 0; k < 3; ++k) {
      out[k] = solver.shift[i].v[k];
      if (turning) out[3 + k] = turns ? solver.turn[i - solver.first_tensor].w[k] : 0;
    }
  }
  void get_correction(std::uint32_t i, const correction* in) {
    solver_type& solver = s_.solver;
    const bool turns = turning && i >= solver.first_tensor;
    for (int k = 0; k < 3; ++k) {
      solver.shift[i].v[k] = static_cast<number>(in[k]);
      if (turns) solver.turn[i - solver.first_tensor].w[k] = in[3 + k];
    }
  }

  template <class Real>
  void put_velocity(std::uint32_t i, Real* out) const {
    const solver_body_of<number>& b = s_.solver.bodies[i];
    s_.passive.common[i] = {v_of(b), w_of(b)};
    for (int k = 0; k < 3; ++k) out[k] = b.v[k], out[3 + k] = b.w[k];
  }
  template <class Real>
  void get_velocity(std::uint32_t i, const Real* in) {
    solver_body_of<number>& b = s_.solver.bodies[i];
    for (int k = 0; k < 3; ++k)
      b.v[k] = static_cast<number>(in[k]), b.w[k] = static_cast<number>(in[3 + k]);
    s_.passive.common[i] = {v_of(b), w_of(b)};
  }

  state_type& s_;

 private:
  [[nodiscard]] std::vector<travelling_bodies> travelling() const {
    std::vector<travelling_bodies> all;
    for (const auto& other : s_.travelling) all.push_back({other.rank, other.sent, other.received});
    return all;
  }
  template <int Scalars, class Real, class Put, class Get>
  void exchange(Put&& put, Get&& get) {
    start<Scalars, Real>(put);
    finish<Scalars, Real>(get);
  }
  template <int Scalars, class Real, class Put>
  void start(Put&& put) {
    constexpr std::size_t bytes = Scalars * sizeof(Real);
    const stage_clock clock(s_.seconds.exchange);
    Real values[Scalars];
    std::size_t count = 0;
    for (const auto& other : s_.travelling) {
      neighbour_message& p = s_.velocity_messages[count++];
      p.out.resize(other.sent.size() * bytes);
      p.in.resize(other.received.size() * bytes);
      std::byte* to = p.out.data();
      for (const std::uint32_t i : other.sent) {
        put(i, values);
        std::memcpy(to, values, bytes);
        to += bytes;
      }
    }
    s_.link->start_fixed(s_.velocity_messages);
  }
  template <int Scalars, class Real, class Get>
  void finish(Get&& get) {
    constexpr std::size_t bytes = Scalars * sizeof(Real);
    const stage_clock clock(s_.seconds.exchange);
    s_.link->finish_fixed(s_.velocity_messages);
    Real values[Scalars];
    std::size_t count = 0;
    for (const auto& other : s_.travelling) {
      const std::byte* from = s_.velocity_messages[count++].in.data();
      for (const std::uint32_t i : other.received) {
        std::memcpy(values, from, bytes);
        get(i, values);
        from += bytes;
      }
    }
  }
};

}  // namespace talus::detail
