// The page of --view of a run that was restarted: it says where it begins, and its frames are those
// of a run that was not interrupted.
#include <doctest/doctest.h>

#include <regex>
#include <stdexcept>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/scene/run.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/nonlinear_gauss_seidel.hpp>
#include <vector>

#include "view_reader.hpp"

using namespace talus;
using namespace talus::view_pages;

namespace {

using heap =
    scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction>,
             solver<nonlinear_gauss_seidel, reproducible>, decomposition<grid<dynamic, dynamic>>,
             transport<threads>, features<checkpoints, driven, energy_ledger, penetration_monitor>>;

/// A heap on a table that glides, in two calls of simulate(); an error ends it after step `fails`.
int make_page(const std::string& file, int ranks, std::uint64_t fails,
              std::vector<std::string> more) {
  more.insert(more.begin(), {"heap", "--view", file, "--view-every", "10", "--quiet", "--dt",
                             "0.01", "--reproducible", "--ranks", std::to_string(ranks)});
  std::vector<char*> argv;
  for (std::string& w : more) argv.push_back(w.data());
  return run<heap>(static_cast<int>(argv.size()), argv.data(), [&](auto& w, const auto&) {
    w.decompose({.cells = {w.ranks(), 1}, .lower = {-3, -3}, .upper = {3, 3}});
    w.gravity({0, 0, -10});
    const auto stone =
        w.material({.density = 2, .friction = 0.5, .name = "stone", .colour = {0.25, 0.5, 0.75}});
    handle<box> table;
    w.global([&](auto& s) { table = s.add(box{{5, 5, 1}}, stone, {0, 0, -0.5}); });
    w.fill(simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 0.5}} &
               box_region{{-1.5, -1.5, 0}, {1.5, 1.5, 3}},
           [&](const site& place) {
             return body<sphere>{
                 .shape = sphere{0.5}, .position = place.position, .material = stone};
           });
    w.after_each_step([&, fails] {
      if (w.steps() == fails) throw std::runtime_error("it fails");
    });
    w.simulate({.steps = 20, .dt = 0.01});
    w.drive(table, gliding{{0.5, 0, 0}});
    w.simulate({.steps = 40, .dt = 0.01});
  });
}

/// The values of a frame to plot.
std::string values_of(const frame& f) {
  return std::regex_replace(f.head, std::regex(".*\"values\":\\{([^}]*)\\}.*"), "$1");
}

}  // namespace

TEST_CASE("the page of a restarted run says where it begins, and goes on as the run") {
  const scratch file;
  REQUIRE(make_page(file("whole.html"), 1, 0, {}) == 0);
  REQUIRE(make_page(file("first.html"), 1, 33,
                    {"--checkpoint", file("state.h5"), "--checkpoint-every", "30"}) == 1);
  const auto whole = frames_of(file("whole.html"));
  REQUIRE(whole.size() == 7);
  CHECK(content(file("whole.html")).find("restarted") == std::string::npos);
  for (const int ranks : {1, 2}) {
    REQUIRE(make_page(file("second.html"), ranks, 0, {"--restart", file("state.h5")}) == 0);
    const auto second = frames_of(file("second.html"));
    REQUIRE(second.size() == 4);  // steps 30, 40, 50, 60
    const std::string page = content(file("second.html"));
    CHECK(elements(page, "about")
              .front()
              .find("The page begins at step 30, where the run was restarted from " +
                    file("state.h5")) != std::string::npos);
    for (const char* part : {"\"materials\":[{\"name\":\"stone\"", "\"name\":\"heap\""})
      CHECK(elements(page, "about").front().find(part) != std::string::npos);
    for (std::size_t k = 0; k < 4; ++k) {
      const frame &is = second[k], &should = whole[k + 3];
      for (const char* name : {"step", "time", "speed_cell", "body_force_cell"})
        CHECK(is.number(name) == should.number(name));
      for (const char* block : {"position", "velocity", "force", "touching"})
        CHECK(is.raw(block) == should.raw(block));
      if (ranks > 1) continue;  // sums over ranks have another order
      CAPTURE(k);
      std::string known = values_of(should);
      // Contacts are found in a step, and the checkpoint is from before it.
      if (k == 0)
        for (const char* left_out : {"contacts", "contact_residual", "contact_residual_max"})
          known = std::regex_replace(
              known, std::regex("\"" + std::string(left_out) + "\":[^,]*(,|$)"), "");
      CHECK(std::regex_replace(known, std::regex(",$"), "") == values_of(is));
    }
  }
}
