// A hinged bar with a motor above falling spheres: the module that drive.py drives. Its set-up
// observes, simulates twice, returns results, and fails on request.
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <talus/checkpoint.hpp>
#include <talus/events.hpp>
#include <talus/python.hpp>
#include <talus/talus.hpp>
#include <talus/vtk.hpp>

using namespace talus;

using mechanism =
    scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction, newton_restitution>,
             joints<hinge>, transport<serial>, features<checkpoints, events, vtk_output>>;

struct mechanism_options : options {
  double speed = 2;
  std::size_t fail_at = 0;
  bool fail_first = false;
  double bar_mass = 0;
  mechanism_options() {
    steps = 40;
    dt = 0.01;
  }
  void describe(command_line& cli) {
    options::describe(cli);
    cli.add_positive("--speed", speed, "of the motor, radians per unit of time");
    cli.add("--fail-at", fail_at, "step in which an observer throws");
    cli.add("--bar_mass", bar_mass, "refused unless it is 0: its name has an underscore");
    cli.add("--fail-first", fail_first, "the set-up throws");
  }
};

PYBIND11_MODULE(mechanism, module) {
  python::scenario<mechanism, mechanism_options>(
      module, [](auto& world, const auto& options) -> results {
        if (options.bar_mass != 0) throw std::invalid_argument("the bar has its own mass");
        if (options.fail_first) throw std::invalid_argument("the set-up has no wood");
        world.gravity({0, 0, -10});
        world.template feature<events>().impacts({.speed = 2});
        const auto wood = world.material({.density = 1, .friction = 0.5});
        world.global([&](auto& scope) { scope.add(plane{}, wood); });
        for (int k = 0; k < 3; ++k) world.add(sphere{0.5}, wood, {2.0 * k, 5, 0.5 + k});
        const auto bar = world.add(box{{2, 0.2, 0.2}}, wood, {0, 0, 8});
        world.join(world_frame, bar,
                   hinge{.at = {0, 0, 8},
                         .axis = {0, 1, 0},
                         .motor = {.velocity = options.speed, .largest_torque = 1e3}});
        // Variables of the set-up that the observer refers to live as long as it does.
        const auto calls = std::make_unique<std::size_t>(0);
        world.observe(every{1}, [&](auto& w) {
          ++*calls;
          if (options.fail_at > 0 && w.steps() == options.fail_at)
            throw std::runtime_error("the bar broke in step " + std::to_string(w.steps()));
        });
        world.simulate({.steps = options.steps / 2, .dt = options.dt});
        world.gravity({0, 0, -5});
        world.simulate({.steps = options.steps - options.steps / 2, .dt = options.dt});
        return {{"calls", static_cast<double>(*calls)}};
      });
}
