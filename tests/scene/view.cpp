// The page of --view holds the state: positions to the error that it states, the same on any number
// of ranks; and what cannot be written or shown gets a message.
#include <doctest/doctest.h>
#include <sys/stat.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <string>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/scene/run.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/nonlinear_gauss_seidel.hpp>
#include <variant>
#include <vector>

#include "view_reader.hpp"

using namespace talus;
using namespace talus::view_pages;

namespace {

using pile = scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction>,
                      solver<nonlinear_gauss_seidel, reproducible>,
                      decomposition<grid<dynamic, dynamic>>, transport<threads>>;

/// A small heap, some bodies of which appear in step 20; what bodies there are at the end.
int make_page(const std::string& file, int ranks, std::map<std::uint64_t, vec3>& at_end,
              std::vector<std::string> more = {}) {
  std::vector<std::string> words{"heap",           "--view",         file, "--view-every", "10",
                                 "--quiet",        "--steps",        "40", "--dt",         "0.01",
                                 "--reproducible", "--view-contacts"};
  words.insert(words.end(), {"--ranks", std::to_string(ranks)});
  words.insert(words.end(), more.begin(), more.end());
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  std::mutex one_by_one;
  return run<pile>(static_cast<int>(argv.size()), argv.data(), [&](auto& w, const auto& o) {
    const int rows = w.ranks() % 2 == 0 ? 2 : 1;
    w.decompose({.cells = {w.ranks() / rows, rows}, .lower = {-3, -3}, .upper = {3, 3}});
    w.gravity({0, 0, -10});
    const auto stone = w.material({.density = 2, .friction = 0.5});
    w.global([&](auto& scope) { scope.add(plane{}, stone); });
    w.fill(simple_cubic{.spacing = 1} & box_region{{-1.6, -1.6, 0.4}, {1.6, 1.6, 3}},
           [&](const site& place, random_stream& random) {
             std::variant<body<sphere>, body<box>> made;
             if (random.uniform(0., 1.) < 0.5)
               made = body{.shape = sphere{random.uniform(0.3, 0.48)},
                           .position = place.position,
                           .material = stone};
             else
               made = body{.shape = box{{0.6, 0.5, 0.4}},
                           .position = place.position,
                           .material = stone,
                           .velocity = random.unit_vector(),
                           .orientation = random.rotation()};
             return made;
           });
    w.observe(every{20}, [&](auto& world) {
      if (world.steps() == 20)
        world.add_if_local(
            body{.shape = sphere{0.3}, .position = {0.1, 0.2, 6}, .material = stone});
    });
    w.simulate({.steps = o.steps, .dt = o.dt});
    const std::lock_guard<std::mutex> lock(one_by_one);
    w.for_each_local([&](const auto& b) { at_end[value_of(b.id())] = b.position(); });
  });
}

}  // namespace

TEST_CASE("a page holds the positions of all bodies to the error that it states") {
  const scratch file;
  std::map<std::uint64_t, vec3> truth;
  REQUIRE(make_page(file("page.html"), 2, truth) == 0);
  const auto frames = frames_of(file("page.html"));
  REQUIRE(frames.size() == 5);  // steps 0, 10, ..., 40
  std::vector<std::uint64_t> ids;
  std::vector<std::uint8_t> shapes;
  std::vector<std::uint32_t> rows;
  for (const frame& f : frames) {
    if (f.has("new_id")) {
      for (const auto id : f.block<std::uint64_t>("new_id")) ids.push_back(id);
      for (const auto s : f.block<std::uint8_t>("new_shape")) shapes.push_back(s);
    }
    if (f.has("rows")) rows = f.block<std::uint32_t>("rows");
  }
  const frame& last = frames.back();
  CHECK(last.number("step") == 40);
  const auto cells = last.block<std::uint16_t>("position");
  REQUIRE(cells.size() == 3 * rows.size());
  const vec3 lower = last.vector("lower"), cell = last.vector("cell");
  const double stated = last.number("position_error");
  CHECK(stated > 0);
  CHECK(stated < 1e-3);
  double worst = 0;
  std::size_t found = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto at = truth.find(ids[rows[i]]);
    if (shapes[rows[i]] == 6) continue;  // the plane
    REQUIRE(at != truth.end());
    ++found;
    for (int k = 0; k < 3; ++k)
      worst = std::max(worst, std::abs(lower[k] + cell[k] * cells[3 * i + k] - at->second[k]));
  }
  CHECK(found == truth.size());
  CHECK(worst <= stated * (1 + 1e-6));
  CHECK(worst > 0.2 * stated);  // the statement is no exaggeration

  SUBCASE("bodies that appear get rows, and frames without changes refer to the rows before") {
    CHECK(frames[0].has("new_id"));
    CHECK_FALSE(frames[1].has("rows"));
    CHECK_FALSE(frames[2].has("new_id"));
    CHECK(frames[3].block<std::uint64_t>("new_id").size() == 1);
    CHECK(frames[3].has("rows"));
    CHECK_FALSE(frames[4].has("rows"));
  }
  SUBCASE("contacts join bodies that touch") {
    const auto a = last.block<std::uint32_t>("contact_a"),
               b = last.block<std::uint32_t>("contact_b");
    CHECK(a.size() == last.number("contacts_of"));
    for (std::size_t k = 0; k < a.size(); ++k) CHECK(a[k] < rows.size());
  }
}

TEST_CASE("a reproducible run has the same page on 1 and 4 ranks, but for the ranks of bodies") {
  const scratch file;
  std::map<std::uint64_t, vec3> one, four;
  REQUIRE(make_page(file("one.html"), 1, one) == 0);
  REQUIRE(make_page(file("four.html"), 4, four) == 0);
  const auto x = frames_of(file("one.html")), y = frames_of(file("four.html"));
  REQUIRE(x.size() == y.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    for (const char* name : {"step", "position_error", "speed_cell", "force_cell", "contacts_of"})
      CHECK(x[k].found(name) == y[k].found(name));
    for (const char* name : {"position", "rows", "new_id", "new_size", "new_mass", "new_flags",
                             "velocity", "orientation", "force", "touching", "contact_a",
                             "contact_b", "contact_point", "contact_force"}) {
      CAPTURE(k);
      CAPTURE(name);
      REQUIRE(x[k].has(name) == y[k].has(name));
      if (x[k].has(name)) CHECK(x[k].raw(name) == y[k].raw(name));
    }
  }
  CHECK(y[0].has("rank"));
  CHECK_FALSE(x[0].has("rank"));
  CHECK(y[0].head.find("\"domains\":[{\"rank\":0,") != std::string::npos);
}

TEST_CASE("a page does not change the run") {
  const scratch file;
  const auto digest_of = [&](std::vector<std::string> more) {
    std::vector<std::string> words{"heap", "--quiet", "--steps", "40",
                                   "--dt", "0.01",    "--json",  file("r.json")};
    words.insert(words.end(), more.begin(), more.end());
    std::vector<char*> argv;
    for (std::string& w : words) argv.push_back(w.data());
    REQUIRE(run<pile>(static_cast<int>(argv.size()), argv.data(), [](auto& w, const auto& o) {
              w.decompose({.cells = {1, 1}, .lower = {-3, -3}, .upper = {3, 3}});
              w.gravity({0, 0, -10});
              const auto stone = w.material({.density = 2, .friction = 0.5});
              w.global([&](auto& scope) { scope.add(plane{}, stone); });
              w.fill(simple_cubic{.spacing = 0.9} & box_region{{-2, -2, 0.4}, {2, 2, 3}},
                     [&](const site& place) {
                       return body<sphere>{
                           .shape = sphere{0.5}, .position = place.position, .material = stone};
                     });
              w.simulate({.steps = o.steps, .dt = o.dt});
            }) == 0);
    const std::string json = content(file("r.json"));
    std::string kept;
    for (const char* key : {"\"state_digest\"", "\"residual\"", "\"residual_worst\""})
      if (const auto at = json.find(key); at != json.npos)
        kept += json.substr(at, json.find('\n', at) - at);
    CHECK(kept.find("state_digest") != kept.npos);
    return kept;
  };
  CHECK(digest_of({"--ranks", "1"}) ==
        digest_of({"--ranks", "1", "--view", file("page.html"), "--view-every", "7"}));
}

TEST_CASE("what a page cannot be written to is refused before the first step") {
  const scratch file;
  using detail::view_page;
  CHECK_THROWS_WITH_AS(view_page(file("no/page.html"), false),
                       doctest::Contains("name a file in a folder that exists, is writable"),
                       std::runtime_error);
  std::ofstream(file("mine.html")) << "<!doctype html><p>precious";
  CHECK_THROWS_WITH_AS(view_page(file("mine.html"), false),
                       doctest::Contains("is there already and is not a page of talus"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(view_page("/dev/stdout", false), doctest::Contains("is a stream"),
                       std::runtime_error);
  std::map<std::uint64_t, vec3> bodies;
  CHECK(make_page(file("mine.html"), 1, bodies) == 1);
  CHECK(content(file("mine.html")) == "<!doctype html><p>precious");
  CHECK(bodies.empty());
  CHECK(make_page(file("mine.html"), 1, bodies, {"--force"}) == 0);
  CHECK(make_page(file("mine.html"), 1, bodies) == 0);  // a page replaces a page
  CHECK(frames_of(file("mine.html")).size() == 5);
  CHECK(make_page(file("both.html"), 1, bodies, {"--json", file("both.html")}) == 2);

  setenv("TALUS_THREE", file("absent.js").c_str(), 1);
  CHECK_THROWS_WITH_AS(view_page(file("page.html"), false),
                       doctest::Contains("install Debian's package libjs-three"),
                       std::runtime_error);
  setenv("TALUS_THREE", file("mine.html").c_str(), 1);
  CHECK_THROWS_WITH_AS(view_page(file("page.html"), false),
                       doctest::Contains("is not three.js as a plain script"), std::runtime_error);
}

TEST_CASE("a run that an error ends leaves a complete page of its frames") {
  const scratch file;
  std::vector<std::string> words{"bang",    "--view",  file("page.html"), "--view-every",
                                 "1",       "--quiet", "--steps",         "9",
                                 "--ranks", "1"};
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  CHECK(run<pile>(static_cast<int>(argv.size()), argv.data(), [](auto& w, const auto& o) {
          w.decompose({.cells = {1, 1}, .lower = {-3, -3}, .upper = {3, 3}});
          const auto stone = w.material({});
          w.add_if_local(body{.shape = sphere{1}, .material = stone});
          w.observe(every{1}, [](auto& world) {
            if (world.steps() == 3) throw std::runtime_error("bang");
          });
          w.simulate({.steps = o.steps, .dt = o.dt});
        }) == 1);
  CHECK(frames_of(file("page.html")).size() >= 3);
  CHECK(content(file("page.html")).find("The run ended before its last step.") !=
        std::string::npos);
}

TEST_CASE(
    "bodies whose state is not finite are left out of a frame, with a message that names one") {
  using namespace detail;
  view_part part;
  for (std::uint64_t k = 0; k < 3; ++k) {
    view_body b;
    b.id = system_id{k}, b.rank = 1, b.size = {1, 1, 1};
    b.position = {static_cast<double>(k), 0, k == 1 ? std::nan("") : 0.0};
    part.bodies.push_back(b);
  }
  view_frames frames;
  std::vector<view_part> parts{view_part{}, part};
  const view_frame made = frames.make(parts);
  CHECK(made.warning.find("1 bodies are left out") != std::string::npos);
  CHECK(made.warning.find("body 0x1 of rank 1 is at (1, 0, nan)") != std::string::npos);
  CHECK(made.head.str().find("\"rows\":[\"u32\",") != std::string::npos);
  std::vector<view_part> none{view_part{}};
  CHECK(frames.make(none).head.str().find("\"bodies\":0") != std::string::npos);
}

TEST_CASE("positions are single precision where cells would be coarse beside the smallest body") {
  using namespace detail;
  view_part part;
  for (const double x : {0.0, 1000.25}) {
    view_body b;
    b.id = system_id{static_cast<std::uint64_t>(x)}, b.size = {0.01F, 0.01F, 0.01F};
    b.position = {x, 0, 0};
    part.bodies.push_back(b);
  }
  view_frames frames;
  std::vector<view_part> parts{part};
  const view_frame made = frames.make(parts);
  const frame read{made.head.str(),
                   {reinterpret_cast<const char*>(made.bytes.data()), made.bytes.size()}};
  CHECK(read.head.find("\"position\":[\"f32\",") != std::string::npos);
  CHECK(read.block<float>("position")[3] == 1000.25F);
  CHECK(read.number("position_error") < 1e-4);
}

TEST_CASE("a message holds a contribution, and base64 and JSON are those of their standards") {
  using namespace detail;
  view_part part;
  part.seconds = {1, 2, 3, 4};
  part.contacts.push_back({system_id{5}, system_id{6}, 7, {1, 2, 3}, {0, 0, 9}});
  plain_vector<std::uint64_t> sent;
  const std::vector<vec3> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const std::vector<std::uint32_t> corners{0, 1, 2, 3}, ends{4};
  const auto id = add_form(part, sent, points, corners, ends);
  CHECK(add_form(part, sent, points, corners, ends) == id);
  const view_part read = view_part::unpacked(part.packed());
  CHECK(read.seconds == part.seconds);
  REQUIRE(read.forms.size() == 1);
  CHECK(std::vector<std::uint32_t>(read.forms[0].corners.begin(), read.forms[0].corners.end()) ==
        std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3});
  CHECK(read.contacts[0].force[2] == 9);
  byte_buffer cut = part.packed();
  cut.resize(cut.size() - 9);
  CHECK_THROWS_AS((void)view_part::unpacked(cut), std::runtime_error);

  for (const auto& [plain, coded] : std::map<std::string, std::string>{
           {"", ""}, {"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foobar", "Zm9vYmFy"}}) {
    std::string text;
    append_base64(text, std::as_bytes(std::span(plain)));
    CHECK(text == coded);  // RFC 4648
  }
  CHECK(quoted_text("a\"b\\c\n</script>") == R"("a\"b\\c\u000a\u003c/script>")");
  CHECK(view_json::number(std::numeric_limits<double>::infinity()) == "null");
}
