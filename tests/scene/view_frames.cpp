// Which frames a page of --view has, also of runs in several calls of simulate(), and how large it
// is without its contacts.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
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

using heap = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction>,
                      solver<nonlinear_gauss_seidel, reproducible>,
                      decomposition<grid<dynamic, dynamic>>, transport<threads>>;

/// Spheres in contact, and one more in each 50th step; `simulate(world)` makes the steps. Returns
/// the positions at the end by ids.
template <class Simulate>
std::map<std::uint64_t, vec3> make_page(const std::string& file, Simulate simulate,
                                        std::vector<std::string> more = {}, int side = 2) {
  std::vector<std::string> words{"heap", "--view", file, "--quiet", "--reproducible"};
  if (more.empty() || more.front() != "--ranks") words.insert(words.end(), {"--ranks", "1"});
  words.insert(words.end(), more.begin(), more.end());
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  std::map<std::uint64_t, vec3> at_end;
  std::mutex one_by_one;
  REQUIRE(run<heap>(static_cast<int>(argv.size()), argv.data(), [&](auto& w, const auto&) {
            w.decompose({.cells = {w.ranks(), 1}, .lower = {-3, -3}, .upper = {3, 3}});
            w.gravity({0, 0, -10});
            const auto stone = w.material({.density = 2, .friction = 0.5});
            w.global([&](auto& scope) { scope.add(plane{}, stone); });
            w.fill(simple_cubic{.spacing = 1} &
                       box_region{{-0.5 * side, -0.5 * side, 0}, {0.5 * side, 0.5 * side, 3}},
                   [&](const site& place) {
                     return body<sphere>{
                         .shape = sphere{0.5}, .position = place.position, .material = stone};
                   });
            w.observe(every{50}, [&](auto& world) {
              world.add_if_local(body{.shape = sphere{0.3},
                                      .position = {-2.5 + 0.01 * world.steps(), 2.5, 0.3},
                                      .material = stone});
            });
            simulate(w);
            const std::lock_guard<std::mutex> lock(one_by_one);
            w.for_each_local([&](const auto& b) { at_end[value_of(b.id())] = b.position(); });
          }) == 0);
  return at_end;
}

/// What a reader of the page has: shown frames, each with its bodies and their positions.
struct reader {
  std::vector<double> steps;
  std::map<std::uint64_t, vec3> last;  ///< positions in the last frame
  std::vector<std::size_t> bodies;     ///< of each frame
  std::size_t elements = 0;

  explicit reader(const std::string& file) {
    std::vector<std::uint64_t> ids;
    std::vector<std::uint32_t> rows;
    for (const frame& f : frames_of(file)) {
      ++elements;
      if (f.has("new_id"))
        for (const auto id : f.block<std::uint64_t>("new_id")) ids.push_back(id);
      if (f.has("rows")) rows = f.block<std::uint32_t>("rows");
      if (f.found("table")) continue;
      steps.push_back(f.number("step")), bodies.push_back(rows.size());
      const auto cells = f.block<std::uint16_t>("position");
      REQUIRE(cells.size() == 3 * rows.size());
      last.clear();
      const vec3 lower = f.vector("lower"), cell = f.vector("cell");
      for (std::size_t i = 0; i < rows.size(); ++i) {
        REQUIRE(rows[i] < ids.size());
        vec3& at = last[ids[rows[i]]];
        for (int k = 0; k < 3; ++k) at[k] = lower[k] + cell[k] * cells[3 * i + k];
      }
    }
  }
};

}  // namespace

TEST_CASE("a call of simulate() that ends early leaves later ones their frames") {
  const scratch file;
  (void)make_page(file("page.html"), [](auto& w) {
    w.simulate({.steps = 100000, .dt = 0.001, .stop_when = [&] { return w.steps() >= 10; }});
    w.simulate({.steps = 400, .dt = 0.001});
  });
  const reader page(file("page.html"));
  CHECK(page.steps.size() >= 150);
  CHECK(page.steps.size() <= 301);
}

TEST_CASE("a run in many calls of simulate() has 150 to 300 frames at equal distances") {
  const scratch file;
  for (const char* ranks : {"1", "3"}) {
    const auto truth = make_page(file("page.html"),
                                 [](auto& w) {
                                   for (int k = 0; k < 990; ++k)
                                     w.simulate({.steps = 1, .dt = 0.001});
                                 },
                                 {"--ranks", ranks});
    const reader page(file("page.html"));
    CHECK(page.steps.size() >= 150);
    CHECK(page.steps.size() <= 301);
    CHECK(page.steps.front() == 0);
    CHECK(page.steps.back() == 990);
    const double interval = page.steps[1];
    for (std::size_t k = 1; k + 1 < page.steps.size(); ++k)
      CHECK(page.steps[k] == interval * static_cast<double>(k));
    // Bodies that appeared in a frame that was left out are there, and each at its place.
    CHECK(page.last.size() == truth.size() + 1);  // and the plane
    for (const auto& [id, at] : truth) {
      REQUIRE(page.last.count(id) == 1);
      CHECK((page.last.at(id) - at).norm() < 1e-3);
    }
    for (std::size_t k = 1; k + 1 < page.bodies.size(); ++k)
      CHECK(page.bodies[k] == page.bodies[0] + static_cast<std::size_t>((page.steps[k] - 1) / 50));
    CHECK(page.elements < page.steps.size() + 40);  // of 20 additions
  }
}

TEST_CASE("a long call after a short one does not fill the page") {
  const scratch file;
  (void)make_page(file("page.html"), [](auto& w) {
    w.simulate({.steps = 20, .dt = 0.001});
    w.simulate({.steps = 1500, .dt = 0.001});
  });
  const reader page(file("page.html"));
  CHECK(page.steps.size() >= 150);
  CHECK(page.steps.size() <= 301);
  CHECK(page.steps.back() == 1520);
}

TEST_CASE("--view-every takes all the frames that it names") {
  const scratch file;
  (void)make_page(file("page.html"),
                  [](auto& w) {
                    for (int k = 0; k < 400; ++k) w.simulate({.steps = 1, .dt = 0.001});
                  },
                  {"--view-every", "1"});
  CHECK(reader(file("page.html")).steps.size() == 401);
}

TEST_CASE("contacts are in the page on request, the forces of bodies always") {
  const scratch file;
  const auto simulate = [](auto& w) { w.simulate({.steps = 200, .dt = 0.005}); };
  for (const char* ranks : {"1", "2"}) {
    (void)make_page(file("small.html"), simulate, {"--ranks", ranks, "--view-every", "100"}, 4);
    (void)make_page(file("large.html"), simulate,
                    {"--ranks", ranks, "--view-every", "100", "--view-contacts"}, 4);
    const auto small = frames_of(file("small.html")), large = frames_of(file("large.html"));
    REQUIRE(small.size() == large.size());
    CHECK_FALSE(small.back().has("contact_a"));
    REQUIRE(large.back().has("contact_a"));
    CHECK(small.back().bytes.size() < 0.7 * large.back().bytes.size());
    // The force of a body is the sum of the sizes of those of its contacts.
    const frame& f = large.back();
    const auto a = f.block<std::uint32_t>("contact_a"), b = f.block<std::uint32_t>("contact_b");
    const auto size = f.block<std::uint16_t>("contact_force");
    const auto sums = f.block<std::uint16_t>("force");
    const auto touching = f.block<std::uint8_t>("touching");
    CHECK(small.back().raw("force") == f.raw("force"));
    CHECK(a.size() == f.number("contacts_of"));
    std::vector<double> expected(sums.size());
    std::vector<int> count(sums.size());
    for (std::size_t k = 0; k < a.size(); ++k)
      for (const auto i : {a[k], b[k]}) expected[i] += size[k] * f.number("force_cell"), ++count[i];
    for (std::size_t i = 0; i < sums.size(); ++i) {
      CHECK(count[i] == touching[i]);
      if (i + 1 == sums.size()) continue;  // the plane, whose force has a cell of its own
      CHECK(sums[i] * f.number("body_force_cell") ==
            doctest::Approx(expected[i]).epsilon(0.01).scale(f.number("force_mean")));
    }
    CHECK(sums.back() * f.number("wall_force_cell") ==
          doctest::Approx(expected.back()).epsilon(0.01));
  }
}
