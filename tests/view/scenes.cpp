// Scenes whose pages tests look at in a browser (check_page.py): --scene known has one sphere with
// a known path, --scene shapes has bodies of all shapes, joints and walls, --scene many has
// --bodies spheres close together that drift, --scene look has materials with names and colours,
// and a camera of its own that follows a body.
#include <talus/mesh.hpp>
#include <talus/talus.hpp>
using namespace talus;

namespace {

using clump = union_of<sphere, box>;
using scene =
    scenario<bodies<sphere, box, capsule, cylinder, convex_polyhedron, clump, triangle_mesh, plane>,
             hard_contact<coulomb_friction>, decomposition<grid<dynamic, dynamic>>,
             transport<threads>, joints<ball_joint>, features<penetration_monitor>>;

struct scene_options : options {
  std::string scene = "known";
  int bodies = 100000;
  void describe(auto& cli) {
    options::describe(cli);
    cli.add("--scene", scene, "known, shapes, many or look");
    cli.add("--bodies", bodies, "spheres of --scene many", 1);
  }
};

/// A red sphere (it is of rank 0) that goes from (0, 0, 0) to (4, 0, 0).
void add_known(auto& world, material_id stone) {
  world.add_if_local(
      body{.shape = sphere{1}, .position = {0, 0, 0}, .material = stone, .velocity = {4, 0, 0}});
}

/// A green ball that slides along x over a plane, between blue posts, in a tube.
void add_look(auto& world, material_id stone, const scene_options& options) {
  const auto grass = world.material({.density = 1, .name = "grass", .colour = {0.1, 0.8, 0.1}});
  const auto sky = world.material({.name = "sky <blue>", .colour = {0.1, 0.2, 0.9}});
  world.gravity({0, 0, -10});
  world.units({.length = "mm", .mass = "<kg>", .time = "s"});
  world.after_each_step([&world] { world.record("way", static_cast<real>(world.time()), "L T"); });
  world.global([&](auto& scope) {
    scope.add(plane{}, stone);
    scope.add(tube_surface({.radius = 3, .height = 2}), stone, {0, 0, 1});
  });
  const auto ball = world.add_if_local(body{
      .shape = sphere{0.5}, .position = {-2, 0, 0.5}, .material = grass, .velocity = {2, 0, 0}});
  for (const double y : {-1.5, 1.5})
    world.add_if_local(
        body{.shape = box{{0.4, 0.4, 2}}, .position = {0, y, 1}, .material = sky, .fixed = true});
  const auto above = world.add_if_local(
      body{.shape = box{{0.3, 0.3, 0.3}}, .position = {0, 1.5, 2.6}, .material = sky});
  const auto below = world.add_if_local(
      body{.shape = sphere{0.2}, .position = {0.8, 1.5, 2.6}, .material = grass});
  world.join(above, below, ball_joint{.at = {0.4, 1.5, 2.6}});
  take_pictures(world, options,
                {.from = {0, -9, 4}, .angle = 50, .follow = ball ? ball->id : no_id});
}

void add_shapes(auto& world, material_id stone, material_id oak) {
  world.gravity({0, 0, -10});
  world.global([&](auto& scope) {
    scope.add(plane{}, stone);
    scope.add(tube_surface({.radius = 4.5, .height = 3}), stone, {0, 0, 1.5});
    scope.add(box{{0.4, 3, 0.8}}, stone, {-2, 0, 0.4});
  });
  const convex_polyhedron wedge({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0.6}});
  const clump hammer{
      {{.shape = sphere{0.35}, .at = {{0.5, 0, 0}}}, {.shape = box{{0.9, 0.3, 0.3}}}}};
  world.fill(simple_cubic{.spacing = 1.2} & box_region{{-2.5, -2.5, 2}, {2.5, 2.5, 7}},
             [&](const site& place, random_stream& random) {
               std::variant<body<sphere>, body<box>, body<capsule>, body<cylinder>,
                            body<convex_polyhedron>, body<clump>>
                   made;
               const auto give = [&](auto shape, material_id of) {
                 made = body<decltype(shape)>{.shape = shape,
                                              .position = place.position,
                                              .material = of,
                                              .velocity = random.unit_vector(),
                                              .orientation = random.rotation()};
               };
               switch (static_cast<int>(random.uniform(0., 6.))) {
                 case 0:
                   give(box{{0.7, 0.5, 0.4}}, oak);
                   break;
                 case 1:
                   give(capsule{.radius = 0.2, .length = 0.5}, stone);
                   break;
                 case 2:
                   give(cylinder{.radius = 0.3, .length = 0.5}, oak);
                   break;
                 case 3:
                   give(wedge, stone);
                   break;
                 case 4:
                   give(hammer, oak);
                   break;
                 default:
                   made = body<sphere>{.shape = sphere{random.uniform(0.2, 0.5)},
                                       .position = place.position,
                                       .material = stone};
               }
               return made;
             });
  // A chain that hangs above the heap.
  std::optional<handle<sphere>> last;
  for (int k = 0; k < 6; ++k) {
    const vec3 at{-1.5 + 0.6 * k, 0, 8.5};
    const auto link =
        world.add_if_local(body{.shape = sphere{0.2}, .position = at, .material = oak});
    if (k > 0) world.join(last, link, ball_joint{.at = at - vec3(0.3, 0, 0)});
    last = link;
  }
}

}  // namespace

int main(int argc, char** argv) {
  return run<scene, scene_options>(argc, argv, [](auto& world, const auto& options) {
    const auto stone = world.material({.density = 2, .friction = 0.5});
    const auto oak = world.material({.density = 0.8, .friction = 0.4});
    const int rows = world.ranks() % 2 == 0 ? 2 : 1;
    world.decompose({.cells = {world.ranks() / rows, rows}, .lower = {-5, -5}, .upper = {5, 5}},
                    reach{11});
    if (options.scene == "known") add_known(world, stone);
    if (options.scene == "shapes") add_shapes(world, stone, oak);
    if (options.scene == "look") add_look(world, stone, options);
    if (options.scene == "leaves") {
      world.units({.length = "m", .mass = "kg", .time = "s"});
      add_known(world, stone);
      world.add_if_local(body{.shape = sphere{1}, .position = {-3, 0, 0}, .material = stone});
      world.after_each_step([&] {
        if (world.steps() == 50)
          world.destroy_if([](const auto& b) { return b.velocity()[0] > 0; });
      });
    }
    if (options.scene == "many") {
      const double edge = std::cbrt(options.bodies);
      world.fill(simple_cubic{.spacing = 1} &
                     box_region{{-edge / 2, -edge / 2, 0}, {edge / 2, edge / 2, edge}},
                 [&](const site& place, random_stream& random) {
                   return body<sphere>{.shape = sphere{random.uniform(0.42, 0.5)},
                                       .position = place.position,
                                       .material = stone,
                                       .velocity = random.unit_vector()};
                 });
    }
    world.simulate({.steps = options.steps, .dt = options.dt});
  });
}
