// A chain hangs between two supports, across all domains. It comes to rest in the catenary of a
// chain with rigid links, which has a closed form.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using chain = scenario<bodies<capsule>, joints<ball_joint>,
                       solver<nonlinear_gauss_seidel, reproducible>, decomposition<slabs<dynamic>>,
                       transport<as_launched>, features<damping, user_ids, checkpoints>>;

struct chain_options : options {
  int links = 24;
  double span = 16;

  chain_options() { steps = 4000, dt = 0.01; }  // lengths of a link
  void describe(auto& line) {
    options::describe(line);
    line.add("--links", links, "number of links, each of length 1", 2);
    line.add_positive("--span", span, "from one support to the other; less than the links");
    line.check([this] {
      if (!(span < links)) throw usage_error("--span must be less than --links");
    });
  }
};

/// In link k of n the vertical force is m g (k - (n - 1)/2), the horizontal one is H, and a rigid
/// link has the direction of their sum: its slope is (k - (n - 1)/2) m g / H. H follows from the
/// span. Returns m g / H.
double weight_over_pull(int n, double span) {
  double low = 0, high = 1e6;
  for (int i = 0; i < 200; ++i) {
    const double q = 0.5 * (low + high);
    double width = 0;
    for (int k = 0; k < n; ++k) width += 1 / std::hypot(1, (k - 0.5 * (n - 1)) * q);
    (width > span ? low : high) = q;
  }
  return low;
}

int main(int argc, char** argv) {
  return run<chain, chain_options>(argc, argv, [](auto& world, const chain_options& options) {
    const int n = options.links;
    const double span = options.span, g = 9.81, r = 0.12;
    world.decompose({.lower = 0, .upper = span});
    world.gravity({0, 0, -g});
    world.damping(0.1);
    const auto steel = world.material({.density = 7.8});

    // It is released from the shape of a V.
    const capsule shape{r, 1 - 2 * r};
    const int half = n / 2;
    const double down = std::sqrt(1 - span * span / n / n), along = span / n;
    using joint = joint_handle<chain, ball_joint>;
    std::optional<joint> left;
    std::optional<handle<capsule>> last;
    vec3 end{0, 0, 0};
    for (int k = 0; k < n; ++k) {
      const bool level = 2 * half < n && k == half;  // the middle one of an odd number
      const vec3 link = level ? vec3(1, 0, 0) : vec3(along, 0, k < half ? -down : down);
      const auto next =
          world.add_if_local(body{.shape = shape,
                                  .position = end + 0.5 * link,
                                  .material = steel,
                                  .orientation = rotation({0, 1, 0}, std::atan2(link[0], link[2])),
                                  .user_id = static_cast<std::uint32_t>(k)});
      if (k == 0)
        left = world.join(world_frame, next, ball_joint{.at = end});
      else
        (void)world.join(last, next, ball_joint{.at = end});
      last = next, end += link;
    }
    (void)world.join(last, world_frame, ball_joint{.at = end});
    take_pictures(
        world, options,
        {.from = {0.5 * span, -1.35 * span, -1}, .at = {0.5 * span, 0, -0.27 * span}, .angle = 52});
    world.simulate({.steps = options.steps, .dt = options.dt});

    // Where the ends of the links are, against the catenary.
    std::vector<double> ends(3 * static_cast<std::size_t>(n));
    world.for_each_local([&](const auto& b) {
      const vec3 right = b.position() + rotated(b.orientation(), {0, 0, 0.5});
      for (std::size_t i = 0; i < 3; ++i) ends[3 * b.user_id() + i] = right[i];
    });
    world.link().reduce(reduction::sum, ends);
    const double q = weight_over_pull(n, end[0]), weight = 7.8 * shape.volume() * g;
    double deviation = 0;
    vec3 exact{0, 0, 0};
    for (int k = 0; k < n; ++k) {
      exact += vec3(1, 0, (k - 0.5 * (n - 1)) * q).normalized();
      const auto* x = &ends[3 * static_cast<std::size_t>(k)];
      deviation = std::max(deviation, (vec3(x[0], x[1], x[2]) - exact).norm());
    }
    const vec3 force = measure_joint(world, *left).force;  // on the support
    return results{{"deviation", deviation},
                   {"gap", measure_joints(world).gap},
                   {"pull_error", std::abs(force[0] * q / weight - 1)},
                   {"weight_error", std::abs(-force[2] / (0.5 * n * weight) - 1)},
                   {"sag", *std::min_element(ends.begin(), ends.end())}};
  });
}
