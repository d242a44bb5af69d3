// For engines that are programs of their own: writes the bodies of PILE as text, and judges the
// positions that came out by the checker of all engines.
#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "scenes/checker.hpp"
#include "scenes/pile_scene.hpp"
#include "scenes/protocol.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto bodies = args.count("bodies", 8000);
    const auto seed = args.count("seed", 1);
    const auto write = args.text("write", "");  // a line for each body: x y z radius
    const auto read = args.text("read", "");    // a line for each body: x y z vx vy vz
    const auto file = args.json_file();
    if (!args.done()) return;

    bench::scene s = bench::pile_scene(bodies, seed);
    if (!write.empty()) {
      std::ostringstream out;
      out.precision(std::numeric_limits<double>::max_digits10);
      for (const bench::ball& b : s.balls)
        out << b.position[0] << ' ' << b.position[1] << ' ' << b.position[2] << ' ' << b.radius
            << '\n';
      bench::write_file(out.str(), write, bench::state_output);
    }
    if (read.empty()) return;
    std::ifstream in(read);
    for (bench::ball& b : s.balls) {
      for (double& x : b.position) in >> x;
      for (double& x : b.velocity) in >> x;
    }
    if (!in) throw std::runtime_error("'" + read + "' has too few numbers");
    const auto found = bench::check(s.balls, s.walls, s.blocks);
    bench::record out;
    out.add("scene_digest", bench::digest(bench::pile_scene(bodies, seed)));
    out.add("bodies", bodies);
    out.add("penetration_mean", found.penetration_mean);
    out.add("penetration_max", found.penetration_max);
    out.add("touching_pairs", found.touching_pairs);
    out.add("kinetic_energy_median", bench::kinetic_energy(s.balls, s.density).median);
    out.add("escaped", found.not_finite + found.behind_walls);
    out.write(file);
  });
}
