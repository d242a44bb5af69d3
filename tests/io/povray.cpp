// Scene files for POV-Ray: every body once, by its owner; copies and domains on request.
#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <talus/io/povray.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>

using namespace talus;
using scene = scenario<bodies<sphere, box, plane>, transport<threads>, decomposition<grid<2, 2>>,
                       features<visibility>>;

namespace {

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (auto at = text.find(word); at != text.npos; at = text.find(word, at + 1)) ++n;
  return n;
}

/// Four spheres, one of them across a boundary and one invisible, a rotated box, a floor.
std::string draw(const std::filesystem::path& file, const picture& look) {
  threads::launch({.ranks = 4}, [&](threads::link& link) {
    world<scene> w(link, {.lower = {-1, -1}, .upper = {1, 1}});
    const auto stuff = w.material({});
    w.global([&](auto& s) { s.add(plane{.offset = -1}, stuff); });
    for (const real x : {-3.0, -0.2, 3.0, 5.0})
      if (const auto h = w.add_if_local(body{.shape = sphere{0.5},
                                             .position = {x, 2, 0},
                                             .material = stuff,
                                             .velocity = {x, 0, 0}});
          h && x == 5)
        w[*h].set_visible(false);
    w.add_if_local(body{.shape = box{{1, 2, 3}},
                        .position = {-4, -4, 2},
                        .material = stuff,
                        .orientation = rotation({0, 0, 1}, pi / 2)});
    w.synchronize();
    write_povray(w, file.string(), look);
  });
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

const auto folder = std::filesystem::temp_directory_path();
const auto file = folder / ("talus_picture_" + std::to_string(std::rand()) + ".pov");

}  // namespace

TEST_CASE("a picture shows each visible body once, whichever rank owns it") {
  const auto text = draw(file, {});
  CHECK(count(text, "sphere{") == 3);
  CHECK(count(text, "box{") == 1);
  CHECK(count(text, "plane{") == 1);
  CHECK(count(text, "camera{") == 1);
  CHECK(text.find("box{<-0.5,-1,-1.5>,<0.5,1,1.5>") != text.npos);
  CHECK(count(draw(file, {.ground = false}), "plane{") == 0);
  CHECK(count(draw(file, {.from = {5, -9, -1.1}}), "plane{") == 0);  // it would hide the others
  std::filesystem::remove(file);
}

TEST_CASE("a picture shows shadow copies and domains where asked") {
  CHECK(count(draw(file, {.copies = true}), "sphere{") > 3);
  const auto text = draw(file, {.domains = true});
  CHECK(count(text, "intersection{") >= 4);
  CHECK(count(text, "plane{") == 1 + 4 * 2);  // two cuts bound each of four quadrants
  std::filesystem::remove(file);
}

TEST_CASE("bodies are coloured by rank or by speed") {
  CHECK(draw(file, {}) != draw(file, {.colour = picture::colouring::speed}));
  std::filesystem::remove(file);
}

TEST_CASE("a picture that cannot be written is an error that names the file") {
  CHECK_THROWS_WITH_AS(draw(folder / "no such folder" / "a.pov", {}),
                       doctest::Contains("no such folder/a.pov"), std::runtime_error);
}

TEST_CASE("POV-Ray accepts the picture, where it is installed") {
  if (std::system("command -v povray >/dev/null 2>&1") != 0) {
    MESSAGE("povray is not installed");
    return;
  }
  draw(file, {.copies = true, .domains = true});
  const auto png = file.string() + ".png";
  CHECK(std::system(("povray -D +W64 +H48 +I" + file.string() + " +O" + png + " >/dev/null 2>&1")
                        .c_str()) == 0);
  CHECK(std::filesystem::file_size(png) > 100);
  std::filesystem::remove(file);
  std::filesystem::remove(png);
}

TEST_CASE("a picture inside an exclusive section is a runtime_error, as all ranks must take part") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scenario<bodies<sphere>>> w(link);
    w.exclusive(0, [&] {
      CHECK_THROWS_WITH_AS(write_povray(w, file.string(), {}),
                           doctest::Contains("all ranks must take part"), std::runtime_error);
    });
  });
}
