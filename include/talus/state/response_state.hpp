#pragma once
// State of a world for its contacts: hard and soft ones share only the history.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
#include <type_traits>
#include <vector>

#include "talus/constraint/impulse_scale.hpp"
#include "talus/constraint/solver_settings.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/contact/acting_memory.hpp"
#include "talus/contact/history.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/interaction/soft_state.hpp"
#include "talus/solver/coloured_list.hpp"
#include "talus/solver/convergence.hpp"
#include "talus/solver/dependence_cones.hpp"
#include "talus/solver/direct/body_ties.hpp"
#include "talus/solver/direct/direct_islands.hpp"
#include "talus/solver/direct/islands_by_colours.hpp"
#include "talus/solver/either_list.hpp"
#include "talus/state/contact_kinds.hpp"

namespace talus {

/// Iterations and residuals of the contact solver in the steps so far; alike on all ranks.
/// Residuals are NaN until one is measured: in every step if a tolerance is set, else by
/// measure_residual().
struct convergence {
  std::uint64_t iterations = 0;                                      ///< of all steps
  std::uint64_t iterations_max = 0;                                  ///< of a step
  double residual = std::numeric_limits<double>::quiet_NaN();        ///< the last measured
  double residual_worst = std::numeric_limits<double>::quiet_NaN();  ///< of all measured
  std::uint64_t steps_above = 0;  ///< steps that ended above the tolerance

  void add(const detail::solved& done, double tolerance) {
    iterations += static_cast<std::uint64_t>(done.iterations);
    iterations_max = std::max(iterations_max, static_cast<std::uint64_t>(done.iterations));
    if (tolerance == 0) return;
    add_residual(done.residual);
    steps_above += !(done.residual <= tolerance);
  }
  void add_residual(double value) {
    residual = value;
    if (!(residual_worst >= value)) residual_worst = value;
  }
};

namespace detail {

/// The bodies whose velocities are exchanged between this rank and one of its neighbours, in solver
/// indices: fixed from one migration to the next, so that messages need no ids.
struct travelling_velocities {
  int rank = 0;
  plain_vector<std::uint32_t> sent;      ///< own bodies with a copy there that can move
  plain_vector<std::uint32_t> received;  ///< shadow copies of bodies there that can move
};

/// The ranks that hold copies of the fixed bodies that several ranks know.
template <std::size_t Shapes>
struct known_fixed_bodies {
  /// Own ones, by shape, as indices of their store.
  std::array<plain_vector<plain_pair<std::uint32_t, body_holders>>, Shapes> own;
  plain_vector<fixed_body_ties> all;  ///< in solver indices
};

/// How a solver stores the contacts of one kind.
template <class Solver>
struct lists_for {
  template <class Contact>
  using list = contact_list<Contact>;
};
template <class Solver>
requires(solves_by_colours<Solver>) struct lists_for<Solver> {
  template <class Contact>
  using list = coloured_list<Contact>;
};
template <class First, class Second>
struct lists_for<either_solver<First, Second>> {
  template <class Contact>
  using list = either_list<Contact>;
};

/// Whether a run may sweep contacts colour by colour.
template <class Solver>
inline constexpr bool may_sweep_by_colours = solves_by_colours<Solver>;
template <class First, class Second>
inline constexpr bool may_sweep_by_colours<either_solver<First, Second>> = true;

/// The velocities that a neighbour sends and receives in a sweep, in solver indices: before colour
/// k those from `..._from[k]` on.
struct velocities_by_colour {
  int rank = 0;
  plain_vector<std::int32_t> sent, received;
  plain_vector<std::uint32_t> sent_from, received_from;

  [[nodiscard]] bool any(std::uint32_t colour) const {
    return sent_from[colour + 1] > sent_from[colour] ||
           received_from[colour + 1] > received_from[colour];
  }
};

/// The colours of the contacts, the contacts of other ranks that are solved here too, and the
/// messages of each colour.
struct shared_colours {
  colouring all;
  plain_vector<std::size_t> ends;  ///< of the lists, among the units of `all`
  dependence_cones cones;
  std::vector<velocities_by_colour> lines;  ///< one for each neighbour
  /// The messages of a colour: one to each neighbour whose velocities travel before that colour,
  /// and the index of its line.
  struct messages {
    std::vector<neighbour_message> neighbour_messages;
    plain_vector<std::uint32_t> lines;
  };
  std::vector<messages> of_colour;
};
struct no_colours {};
struct no_islands_by_colours {};

/// Work space of step/passivity.hpp, for each body in solver indices.
struct passivity_scratch {
  plain_vector<std::uint32_t> root;    ///< of its island, or a body on the way there
  plain_vector<std::uint32_t> island;  ///< its number
  std::uint32_t islands = 0;
  plain_vector<impulse_work> works;  ///< of each island
  plain_vector<real> excess;         ///< fraction that its impulses lose
  // Across ranks:
  plain_vector<body_motion> common;   ///< velocities that were last sent or received
  plain_vector<body_motion> earlier;  ///< those before the step
  /// After gathered islands were solved: the copies that their owners have refreshed since, and the
  /// velocities that all other ranks hold.
  plain_vector<char> refreshed;
  plain_vector<body_motion> common_before;
  plain_vector<body_motion> received;  ///< the part of it that is from boundary contacts
};

template <class Shapes, class Law, class Solver, class Real, bool Driven>
struct hard_response {
  template <class Contact>
  using list_of = typename lists_for<Solver>::template list<Contact>;
  using lists_type = contact_lists_of<Shapes, Law, Real, list_of, Driven>;
  using history_type = history_of<typename Law::memory>;

  solver_settings settings;
  lists_type contacts;
  history_type history;
  solver_state_of<Real> solver;
  passivity_scratch passive;
  direct_islands<solver_state_of<Real>> islands;
  talus::convergence convergence;
  [[no_unique_address]] std::conditional_t<may_sweep_by_colours<Solver>, shared_colours, no_colours>
      colours;
  [[no_unique_address]] std::conditional_t<may_sweep_by_colours<Solver>,
                                           islands_by_colours<solver_state_of<Real>>,
                                           no_islands_by_colours>
      exact_islands;
  std::vector<travelling_velocities> travelling;     ///< in the coming step, without empty ones
  std::vector<travelling_velocities> travelled;      ///< in the last step
  std::vector<neighbour_message> velocity_messages;  ///< one for each of `travelling`
  known_fixed_bodies<Shapes::size> known_fixed;
  plain_vector<char> at_border;  ///< by solver index: whether the velocity is sent
};

/// `Marked`: contacts that act are marked, among those that the law remembers.
template <class Law, bool Marked>
struct soft_response {
  using lists_type = std::tuple<soft_contacts>;
  using history_type = history_of<
      std::conditional_t<Marked, acting_memory<typename Law::memory>, typename Law::memory>>;

  lists_type contacts;             ///< their number
  history_type history, recorded;  ///< of the last step, and of the one under way
  soft_state<Law> soft;
  talus::convergence convergence;  ///< of features<residual_monitor>: its residuals only
};

/// `Driven`: global bodies may have velocities. `Follows`: a feature follows which contacts act.
template <class Shapes, class Law, class Solver, class Real, bool Driven, bool Follows>
struct response_of {
  using type = hard_response<Shapes, Law, Solver, Real, Driven>;
};
template <class Shapes, class Law, class Solver, class Real, bool Driven, bool Follows>
requires(Law::soft) struct response_of<Shapes, Law, Solver, Real, Driven, Follows> {
  static constexpr bool marked = [] {
    if constexpr (Follows)
      return Law::law::reaches;
    else
      return false;
  }();
  using type = soft_response<Law, marked>;
};

}  // namespace detail
}  // namespace talus
