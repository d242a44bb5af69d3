// A house of cards stands if friction is large enough to hold the feet of its cards, and falls
// otherwise.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using cards = scenario<bodies<box, plane>, hard_contact<coulomb_friction>,
                       solver<nonlinear_gauss_seidel, reproducible>, decomposition<slabs<dynamic>>,
                       transport<as_launched>, features<checkpoints>>;

struct cards_options : options {
  int storeys = 3;
  double friction = 0.6, lean = 25;

  cards_options() {
    steps = 4000;
    dt = 0.002;
  }
  void describe(auto& line) {
    options::describe(line);
    line.add("--storeys", storeys, "of the house", 1);
    line.add("--friction", friction, "of cards, on each other and on the table", 0.0, 10.0);
    line.add("--lean", lean, "of the cards against the vertical, in degrees", 5.0, 45.0);
  }
};

int main(int argc, char** argv) {
  return run<cards, cards_options>(argc, argv, [](auto& world, const cards_options& options) {
    const double L = 1, w = 0.7, e = 0.02;  // a card: length, width, thickness
    const double a = options.lean * pi / 180, tangent = std::tan(a);
    const double foot = L * std::sin(a), ridge = e * std::cos(a);  // half widths of a pair
    const double pitch = 2 * (foot + ridge) + e;
    const double high = L * std::cos(a) + e * std::sin(a);  // of a storey, without its board

    world.decompose({.axis = {1, 0, 0},
                     .lower = -0.5 * options.storeys * pitch,
                     .upper = 0.5 * options.storeys * pitch});
    world.gravity({0, 0, -9.81});
    const auto paper = world.material({.friction = options.friction});
    world.global([&](auto& scope) { scope.add(plane{}, paper); });
    const auto add = [&](const vec3& size, const vec3& place, double turned) {
      world.add_if_local(body{.shape = box{size},
                              .position = place,
                              .material = paper,
                              .orientation = rotation({0, 1, 0}, turned)});
    };

    // The house falls with less friction than this. One card of each pair converts half its weight
    // W and the load P on its top into a force H against the other card, which acts L cos a above
    // its foot. The moments about the foot give H L cos a = (W / 2 + P) (L sin a - e cos a). The
    // foot carries W + P and must hold H. Uneven loads, or a ridge whose two edges do not push
    // horizontally, need more friction.
    double needed = 0, above = 0;  // cards above a storey
    for (int pairs = 1; pairs <= options.storeys; ++pairs) {
      const double load = above / (2 * pairs);
      needed = std::max(needed, (0.5 + load) / (1 + load) * (tangent - e / L));
      above += 2 * pairs + (pairs + 1) * pitch / L;
    }
    double z = 0;
    for (int pairs = options.storeys; pairs > 0; --pairs) {
      for (int k = 0; k < pairs; ++k)
        for (const int side : {-1, 1})
          add({e, w, L},
              {(k - 0.5 * (pairs - 1)) * pitch + 0.5 * side * (foot + ridge), 0, z + 0.5 * high},
              -side * a);
      z += high;
      // One long card: single cards would load only one card of the outer pairs, and only friction
      // above 1 / tan a could hold their ridges.
      if (pairs > 1) add({pairs * pitch, w, e}, {0, 0, z + 0.5 * e}, 0);
      if (pairs > 1) z += e;
    }
    world.synchronize();
    take_pictures(world, options, {.from = {2.5, -7, 2.6}, .at = {0, 0, 0.45 * z}, .angle = 36});
    world.simulate({.steps = options.steps, .dt = options.dt});

    double top = 0;
    world.for_each_local([&](const auto& b) {
      top = std::max(top, b.position()[2] + b.shape().half_extents(b.pose())[2]);
    });
    world.link().reduce(reduction::max, std::span(&top, 1));
    return results{{"height_kept", top / z}, {"friction_needed", needed}};
  });
}
