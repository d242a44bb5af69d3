#include "talus/scenario/scenario.hpp"

#include <doctest/doctest.h>

#include <type_traits>

#include "talus/parallel/by_hand.hpp"
#include "talus/parallel/serial.hpp"
#include "talus/parallel/threads.hpp"
#include "talus/shape/box.hpp"

using namespace talus;

namespace {
template <class A, class B>
constexpr bool same = std::is_same_v<A, B>;

using standard = scenario<>;
using well =
    scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction, newton_restitution>,
             solver<nonlinear_gauss_seidel>, decomposition<grid<2, 2>>>;
}  // namespace

TEST_CASE("a scenario without policies has the documented defaults") {
  static_assert(same<standard::shapes, type_list<sphere, plane>>);
  static_assert(standard::contact_law::friction && standard::contact_law::restitution &&
                standard::contact_law::correction);
  static_assert(same<standard::solver, nonlinear_gauss_seidel>);
  static_assert(same<standard::broad_phase, linear_hash_grid>);
  static_assert(same<standard::integrator, semi_implicit_euler>);
  static_assert(same<standard::decomposition, grid<dynamic>>);
  static_assert(same<standard::transport, threads>);
  static_assert(same<standard::precision, double>);
  static_assert(same<standard::features, type_list<>>);
  static_assert(std::is_empty_v<standard>);
  CHECK(describe<standard>() ==
        "bodies<sphere, plane> "
        "hard_contact<coulomb_friction, newton_restitution, split_correction> "
        "solver<nonlinear_gauss_seidel> broad_phase<linear_hash_grid> "
        "integrator<semi_implicit_euler> decomposition<grid<dynamic>> transport<threads> "
        "precision<double> features<>");
}

TEST_CASE("the order of policies does not matter") {
  using turned =
      scenario<decomposition<grid<2, 2>>, solver<nonlinear_gauss_seidel>,
               hard_contact<newton_restitution, coulomb_friction>, bodies<sphere, box, plane>>;
  static_assert(same<turned::shapes, well::shapes>);
  static_assert(same<turned::decomposition, grid<2, 2>> && same<well::decomposition, grid<2, 2>>);
  static_assert(turned::contact_law::friction && turned::contact_law::restitution);
  CHECK(turned::has_shape<box>);
}

TEST_CASE("what a contact law leaves out is not there, but the correction is") {
  using bare = scenario<hard_contact<>>::contact_law;
  static_assert(!bare::friction && !bare::restitution && bare::correction);
  using plastic = hard_contact<no_correction, coulomb_friction>;
  static_assert(plastic::friction && !plastic::restitution && !plastic::correction);
  static_assert(hard_contact<split_correction>::correction);
  static_assert(concepts::contact_law<bare>);
  CHECK(plastic::describe() == "hard_contact<no_correction, coulomb_friction>");
}

TEST_CASE("every policy can be named") {
  using all = scenario<features<orientation, forces, user_ids, visibility, damping>,
                       precision<double>, transport<serial>, decomposition<by_hand>,
                       integrator<semi_implicit_euler>, broad_phase<linear_hash_grid>,
                       solver<nonlinear_gauss_seidel>, hard_contact<>, bodies<box>>;
  static_assert(all::has_feature<orientation> && all::has_feature<damping>);
  static_assert(!well::has_feature<orientation>);
  static_assert(same<all::decomposition, by_hand> && same<all::transport, serial>);
  static_assert(all::has_shape<box> && !all::has_shape<sphere>);
  static_assert(detail::require_shape<all, box>() && detail::require_feature<all, forces>());
  CHECK(describe<all>() ==
        "bodies<box> hard_contact<> solver<nonlinear_gauss_seidel> broad_phase<linear_hash_grid> "
        "integrator<semi_implicit_euler> decomposition<by_hand> transport<serial> "
        "precision<double> features<orientation, forces, user_ids, visibility, damping>");
}

TEST_CASE("a serial scenario may name a grid of many ranks: it collapses to one domain") {
  using collapsed = scenario<transport<serial>, decomposition<grid<2, 2>>>;
  CHECK(describe<collapsed>().find("decomposition<grid<2, 2>> transport<serial>") !=
        std::string::npos);
}

TEST_CASE("the models in this library play their roles") {
  static_assert(concepts::finite_shape<sphere> && concepts::finite_shape<box>);
  static_assert(concepts::shape<plane> && !concepts::finite_shape<plane>);
  static_assert(concepts::region<half_space>);
  static_assert(concepts::decomposition<grid<2, 2>> && concepts::decomposition<by_hand>);
  static_assert(concepts::partition<grid_cells>);
  static_assert(concepts::transport<serial> && concepts::transport<threads>);
  static_assert(concepts::link<serial::link> && concepts::link<threads::link>);
  static_assert(concepts::solver<nonlinear_gauss_seidel>);
  static_assert(concepts::integrator<semi_implicit_euler>);
  static_assert(concepts::broad_phase<linear_hash_grid>);
  static_assert(concepts::feature<damping>);
  static_assert(!concepts::shape<int> && !concepts::transport<sphere>);
}
