// A serial world of spheres (with TALUS_BOXES of boxes and with monitors, with TALUS_SOFT with soft
// contacts), which check.sh inspects. It is compiled without optimisation: nothing is inlined, so
// all code in use has a symbol.
#include <talus/talus.hpp>
using namespace talus;

#ifdef TALUS_BOXES
using scene = scenario<bodies<sphere, box>, transport<serial>,
                       features<energy_ledger, momentum_balance, penetration_monitor>>;
#elif defined(TALUS_SOFT)
using scene = scenario<bodies<sphere>, transport<serial>,
                       soft_contact<linear_spring_dashpot, coulomb_friction>>;
#else
using scene = scenario<bodies<sphere>, transport<serial>>;
#endif

int main() {
  serial::launch({}, [](serial::link& link) {
    world<scene> w(link);
    const auto stuff =
        w.material({.density = 2, .restitution = 0.5, .friction = 0.3, .stiffness = 1e4});
    w.gravity({0, 0, -10});
    w.global([&](auto& scope) {
      scope.add(body{.shape = sphere{10}, .position = {0, 0, -10}, .material = stuff});
    });
    const auto ball = w.add(body{
        .shape = sphere{0.5}, .position = {0, 0, 1}, .material = stuff, .velocity = {1, 0, 0}});
#ifdef TALUS_BOXES
    w.add(body{.shape = box{{1, 1, 1}}, .position = {0, 5, 1}, .material = stuff});
#endif
    w.simulate({.steps = 10, .dt = 0.01});
    w[ball].set_velocity({0, 0, 1});
    w.for_each_local([](auto& b) { b.translate({0, 0, 1}); });
    (void)measure_penetration(w);
    (void)measure_motion(w);
    (void)bytes_in_use(w);
    w.destroy(ball);
  });
}
