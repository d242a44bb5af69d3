// Features that a scenario does not name are not stored: columns, contacts, arrays of the solver.
// (tests/symbols checks that the program does not contain them either.)
// alone
#include <doctest/doctest.h>

#include <talus/observe/memory.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>
#include <tuple>
#include <type_traits>
#include <vector>

#ifdef MPI_VERSION
#error "a serial world includes MPI"
#endif

using namespace talus;
using namespace talus::detail;

namespace {

template <class Law, class... Shapes>
using serial_world = scenario<bodies<Shapes...>, Law, transport<serial>>;
using full_law = hard_contact<coulomb_friction, newton_restitution, split_correction>;
using spheres = serial_world<full_law, sphere>;
using boxes = serial_world<full_law, sphere, box>;

template <class Shape, class... Features>
using store_of = body_store<Shape, type_list<Features...>>;

static_assert(!complete<threads> && !complete<mpi> && !complete<as_launched>,
              "a serial world includes another transport");

// Spheres store no orientation, no tensor, no forces unless requested; boxes have an orientation.
using ball_store = store_of<sphere>;
static_assert(std::is_same_v<ball_store::list,
                             type_list<columns::id, columns::position, columns::velocity,
                                       columns::angular_velocity, columns::shape<sphere>,
                                       columns::inverse_mass, columns::material, columns::flags>>);
static_assert(!ball_store::tensor && !ball_store::oriented && !ball_store::forced &&
              !ball_store::numbered && !ball_store::sleeps);
static_assert(store_of<sphere, orientation>::has<columns::orientation> &&
              store_of<sphere, orientation>::oriented && !store_of<sphere, orientation>::tensor);
static_assert(store_of<sphere, forces>::has<columns::force> &&
              store_of<sphere, forces>::has<columns::torque>);
static_assert(store_of<sphere, user_ids>::has<columns::user_id>);
static_assert(store_of<box>::tensor && store_of<box>::oriented);
static_assert(store_of<sphere, sleeping>::has<columns::quiet>);
static_assert(
    !store_of<plane, orientation, forces, sleeping>::oriented &&
    std::is_same_v<store_of<plane, orientation, forces, sleeping>::list, store_of<plane>::list>);

// One storage for each named shape, and one list for each kind of contact they make.
template <class Scenario>
using state_of = world_state<Scenario>;
static_assert(std::is_same_v<state_of<spheres>::tuple_type,
                             std::tuple<bodies_of_shape<sphere, type_list<>, hash_grid>>>);
static_assert(
    std::is_same_v<
        state_of<spheres>::lists_type,
        std::tuple<contact_list<isotropic_contact<contact_rows<full_law>, partner::moving>>,
                   contact_list<isotropic_contact<contact_rows<full_law>, partner::immovable>>>>);
static_assert(std::tuple_size_v<state_of<serial_world<full_law, sphere, plane>>::lists_type> == 2);
static_assert(std::tuple_size_v<state_of<boxes>::lists_type> > 2);

// No body sleeps, and no data for it are stored.
template <class State>
concept keeps_what_features_keep = requires(State& s) {
  s.sleep;
}
|| requires(State& s) { s.driving; }
|| requires(State& s) { s.impacts; }
|| requires(State& s) { s.balance; };
static_assert(!keeps_what_features_keep<state_of<spheres>> && !state_of<spheres>::sleeps &&
              std::is_empty_v<slots_of_features<spheres::features, spheres>>);

// The domain of a single rank is all of space.
static_assert(std::is_empty_v<state_of<spheres>::domain_type>);

// Frictionless contacts have no tangent.
template <class Contact>
constexpr bool tangential = requires(Contact c) {
  c.rt;
}
|| requires(Contact c) { c.friction; }
|| requires(Contact c) { c.arm_a; }
|| requires(typename Contact::change d) { d.t; };
using rough = isotropic_contact<hard_contact<coulomb_friction>, partner::moving>;
using smooth = isotropic_contact<hard_contact<>, partner::moving>;
static_assert(tangential<rough> && !tangential<smooth>);
static_assert(sizeof(smooth::change) == sizeof(real));
static_assert(sizeof(smooth) == sizeof(rough) - sizeof(tangential_rows<real, coulomb_friction>));
using bouncy = isotropic_contact<hard_contact<newton_restitution>, partner::moving>;
static_assert(may_rebound<bouncy> && !may_rebound<smooth> && !may_rebound<rough>);
using rough_box =
    general_contact<hard_contact<coulomb_friction>, contact_side::tensor, contact_side::scalar>;
using smooth_box = general_contact<hard_contact<>, contact_side::tensor, contact_side::scalar>;
static_assert(smooth_box::rows == 1 && rough_box::rows == 3);
static_assert(sizeof(smooth_box) < sizeof(rough_box));

/// A small heap of overlapping spheres, and a box if there are boxes, after some steps.
template <class Scenario, class Check>
void after_steps(Check&& check) {
  serial::link link;
  world<Scenario> w(link);
  const auto stuff = w.material({.restitution = 0.3, .friction = 0.5});
  w.gravity({0, 0, -10});
  for (int k = 0; k < 64; ++k)
    w.add(body<sphere>{.shape = {0.5},
                       .position = {0.9 * (k % 4), 0.9 * (k / 4 % 4), 0.9 * (k / 16)},
                       .material = stuff});
  if constexpr (Scenario::template has_shape<box>)
    w.add(body<box>{.shape = {{1, 1, 1}}, .position = {1.4, 1.4, 3.6}, .material = stuff});
  w.simulate({.steps = 5, .dt = 0.001});
  check(w);
}

}  // namespace

TEST_CASE("a sphere takes the bytes of its columns and no more") {
  const std::size_t needed = sizeof(system_id) + 3 * sizeof(vec3) + sizeof(sphere) + sizeof(real) +
                             sizeof(material_id) + sizeof(std::uint8_t);
  MESSAGE("bytes per sphere: ", ball_store::bytes_per_body(), "; with orientation ",
          store_of<sphere, orientation>::bytes_per_body(), "; with forces ",
          store_of<sphere, forces>::bytes_per_body(), "; a box: ", store_of<box>::bytes_per_body());
  CHECK(ball_store::bytes_per_body() == needed);
  CHECK(store_of<sphere, orientation>::bytes_per_body() == needed + sizeof(quat));
  CHECK(store_of<sphere, forces>::bytes_per_body() == needed + 2 * sizeof(vec3));
  CHECK(store_of<sphere, user_ids>::bytes_per_body() == needed + sizeof(std::uint32_t));
  CHECK(store_of<sphere, visibility, damping>::bytes_per_body() == needed);
}

TEST_CASE("a contact takes the bytes of its law") {
  MESSAGE("bytes per contact of spheres: ", sizeof(rough), " with friction, ", sizeof(smooth),
          " without; of a box and a sphere: ", sizeof(rough_box), " and ", sizeof(smooth_box));
  CHECK(sizeof(smooth) <= 80);
  CHECK(sizeof(rough) <= 136);
}

TEST_CASE("a world of spheres holds no tensors and corrects no rotations; one with boxes does") {
  after_steps<spheres>([](auto& w) {
    const solver_state& s = talus::detail::state_of(w).solver;
    CHECK(s.bodies.size() == 64);
    CHECK(s.shift.size() == 64);
    CHECK(s.tensors.capacity() == 0);
    CHECK(s.turn.capacity() == 0);
    CHECK(s.boundary_contacts.capacity() == 0);
    CHECK(talus::detail::state_of(w).neighbours.capacity() == 0);
    MESSAGE("bytes in use per sphere, contacts, grids and solver included: ", bytes_in_use(w) / 64);
  });
  after_steps<boxes>([](auto& w) {
    CHECK(talus::detail::state_of(w).solver.tensors.size() == 1);
    CHECK(talus::detail::state_of(w).solver.turn.size() == 1);
  });
}

TEST_CASE("without correction nothing is held for it") {
  after_steps<serial_world<hard_contact<coulomb_friction, no_correction>, sphere>>(
      [](auto& w) { CHECK(talus::detail::state_of(w).solver.shift.capacity() == 0); });
}

TEST_CASE("without friction no contact is handed an impulse across its normal") {
  after_steps<serial_world<hard_contact<>, sphere, box>>([](auto& w) {
    std::size_t contacts = 0;
    talus::detail::state_of(w).each_contact_list([&](const auto& list) {
      list.each([&](const auto& c, bool) {
        ++contacts;
        vec3 normal;
        if constexpr (requires { c.normal; })
          normal = c.normal;
        else
          normal = c.frame.row(0);
        CHECK(c.impulse().cross(normal).norm() <= 1e-15 * (1 + c.impulse().norm()));
      });
    });
    CHECK(contacts > 64);
  });
}
