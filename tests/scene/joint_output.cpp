// Joints in the output for ParaView and in pictures: each once, with its force, on any ranks.
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/rod.hpp>
#include <talus/io/povray.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/vtk.hpp>
#include <vector>

using namespace talus;

namespace {

using machine =
    scenario<bodies<box>, joints<ball_joint, hinge, rod>, decomposition<grid<dynamic, dynamic>>,
             transport<threads>, features<vtk_output>>;

struct scratch {
  std::string folder = "/tmp/talus_joint_output_" + std::to_string(getpid());
  scratch() { REQUIRE(std::system(("mkdir -p " + folder).c_str()) == 0); }
  ~scratch() { (void)!std::system(("rm -r " + folder).c_str()); }
  std::string operator()(const std::string& name) const { return folder + "/" + name; }
};

/// A bar on a hinge, a second one on a rod below it, and a third on a ball joint at that, at rest
/// under gravity along x; over all ranks. Writes NAME.hdf and NAME.pov after some steps.
void write(int ranks, const std::string& name) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<machine> w(
        link, grid<dynamic, dynamic>{
                  .cells = {ranks, 1}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}});
    w.gravity({10, 0, 0});
    const auto stuff = w.material({.density = 1000});
    const auto bar = [&](real x) {
      return w.add_if_local(
          body{.shape = box{.size = {1, 0.1, 0.1}}, .position = {x, 0, 0}, .material = stuff});
    };
    const auto first = bar(-2.5), second = bar(-0.5), third = bar(0.5);
    (void)w.join(world_frame, first, hinge{.at = {-3, 0, 0}});
    (void)w.join(first, second, rod{.from = {-2, 0, 0}, .to = {-1, 0, 0}});
    (void)w.join(second, third, ball_joint{.at = {0, 0, 0}});
    for (int k = 0; k < 5; ++k) w.step(1e-3);
    write_vtk(w, name);
    write_povray(w, name + ".pov", picture{});
  });
}

std::vector<double> column(const std::string& file, const std::string& path, std::uint32_t width) {
  const detail::hdf5_handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "read");
  const detail::open_dataset set(f, "/VTKHDF/" + path, detail::number_type::f64, width);
  std::vector<double> values(set.rows() * width);
  set.read(0, set.rows(), values.data());
  return values;
}
std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (auto at = text.find(word); at != text.npos; at = text.find(word, at + 1)) ++n;
  return n;
}

}  // namespace

TEST_CASE("joints are lines from centre to centre with their forces, on 1 and 4 ranks") {
  const scratch at;
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    const std::string name = at("machine" + std::to_string(ranks));
    write(ranks, name);
    const auto points = column(name + "_joints.hdf", "Points", 3);
    const auto force = column(name + "_joints.hdf", "CellData/force", 3);
    const auto gap = column(name + "_joints.hdf", "CellData/gap", 1);
    REQUIRE(points.size() == 3 * 4 * 3);
    REQUIRE(force.size() == 3 * 3);
    // Three bars of 10 kg, of which each joint bears those below it.
    std::vector<double> loads, lengths;
    for (std::size_t k = 0; k < 3; ++k) loads.push_back(std::abs(force[3 * k]));
    std::sort(loads.begin(), loads.end());
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(loads[k] == doctest::Approx(100.0 * (static_cast<double>(k) + 1)).epsilon(1e-6));
    for (std::size_t k = 0; k < 3; ++k) lengths.push_back(points[12 * k + 9] - points[12 * k]);
    std::sort(lengths.begin(), lengths.end());
    CHECK(lengths[0] == doctest::Approx(0.5).epsilon(1e-3));  // from the world to a centre
    CHECK(lengths[1] == doctest::Approx(1).epsilon(1e-3));
    CHECK(lengths[2] == doctest::Approx(2).epsilon(1e-3));
    CHECK(*std::max_element(gap.begin(), gap.end()) == doctest::Approx(1).epsilon(1e-6));
    std::ostringstream text;
    text << std::ifstream(name + ".pov").rdbuf();
    CHECK(count(text.str(), "sphere{") == 4);
    CHECK(count(text.str(), "cylinder{") == 1 + 5);  // the rod, and arms: none of the world
  }
}
