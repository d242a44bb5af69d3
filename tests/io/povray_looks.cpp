// What pictures show of materials, walls and a body that the camera follows.
#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <talus/io/povray.hpp>
#include <talus/mesh.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>

using namespace talus;
using scene =
    scenario<bodies<sphere, triangle_mesh>, transport<threads>, decomposition<grid<2, 1>>>;

namespace {

/// The text of the file that `write` makes.
template <class Write>
std::string written(const Write& write) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("talus_look_" + std::to_string(std::rand()) + ".pov");
  write(file.string());
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  std::filesystem::remove(file);
  return text.str();
}

/// A grey and a nameless sphere on two ranks in a tube.
std::string draw(const picture& look, bool coloured, bool follows = false) {
  return written([&](const std::string& file) {
    threads::launch({.ranks = 2}, [&](threads::link& link) {
      world<scene> w(link, {.lower = {-9, -9}, .upper = {9, 9}});
      const auto stone = w.material(
          coloured ? material{.name = "stone", .colour = {0.25, 0.5, 0.75}} : material{});
      const auto other = w.material({});
      w.global([&](auto& s) {
        s.add(tube_surface({.radius = 4, .height = 3}), other, {0, 0, 1.5});
      });
      const auto first =
          w.add_if_local(body{.shape = sphere{0.5}, .position = {3, 1, 2}, .material = stone});
      w.add_if_local(body{.shape = sphere{0.5}, .position = {-3, 0, 2}, .material = other});
      picture mine = look;
      if (follows && first) mine.follow = first->id;  // one rank alone knows it
      w.synchronize();
      write_povray(w, file, mine);
    });
  });
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != text.npos; }
int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
  return n;
}

/// A sphere on a floor, between a global box and a fixed one on each rank.
std::string draw_barrel(const picture& look) {
  using barrel = scenario<bodies<sphere, box, plane>, transport<threads>, decomposition<grid<2>>>;
  return written([&](const std::string& file) {
    threads::launch({.ranks = 2}, [&](threads::link& link) {
      world<barrel> w(link, {.lower = {-9}, .upper = {9}});
      const auto stone = w.material({});
      w.global([&](auto& s) {
        s.add(plane{}, stone);
        s.add(box{{6, 1, 1}}, stone, {0, 2, 0.5});
      });
      for (const real x : {-3, 3})
        w.add_if_local(body{
            .shape = box{{1, 6, 1}}, .position = {x, 0, 0.5}, .material = stone, .fixed = true});
      w.add_if_local(body{.shape = sphere{0.5}, .position = {1, 0, 0.5}, .material = stone});
      w.synchronize();
      write_povray(w, file, look);
    });
  });
}

}  // namespace

TEST_CASE("a picture of one rank tells nameless materials apart") {
  using alone = scenario<bodies<sphere>, transport<serial>>;
  const auto drawn = [](picture::colouring colour) {
    return written([&](const std::string& file) {
      serial::launch({}, [&](serial::link& link) {
        world<alone> w(link);
        const material_id of[] = {w.material({}), w.material({.density = 2})};
        for (const int k : {0, 1})
          w.add(body{.shape = sphere{0.5}, .position = {3. * k, 0, 2}, .material = of[k]});
        write_povray(w, file, {.colour = colour});
      });
    });
  };
  const std::string automatic = drawn(picture::colouring::automatic);
  CHECK(automatic == drawn(picture::colouring::material));
  CHECK(automatic != drawn(picture::colouring::rank));
}

TEST_CASE("bodies have the colours of their materials, if a material has a name or a colour") {
  const std::string coloured = draw({}, true), plain = draw({}, false);
  CHECK(has(coloured, "srgbt<0.25,0.5,0.75,0>"));
  CHECK_FALSE(has(plain, "srgbt<0.25,0.5,0.75,0>"));
  CHECK(plain == draw({.colour = picture::colouring::rank}, false));
  CHECK_FALSE(has(draw({.colour = picture::colouring::rank}, true), "srgbt<0.25,0.5,0.75,0>"));
  // Without colours of their own, two materials differ.
  CHECK(draw({.colour = picture::colouring::material}, false) != plain);
}

TEST_CASE("bodies are seen through walls: fixed and global bodies, but not planes") {
  CHECK(has(draw({}, false), ",0.65>}}"));
  CHECK_FALSE(has(draw({.walls = 1}, false), ",0.65>}}"));
  CHECK_FALSE(has(draw({.walls = 0}, false), "mesh{"));
  // A global box and a fixed one of either rank, each with two faces on a ray; plane and sphere.
  const std::string barrel = draw_barrel({.walls = 0.36});
  CHECK(count(barrel, "box{") == 3);
  CHECK(count(barrel, ",0.8>}}") == 3);
  CHECK(count(barrel, ",0>}}") == 2);
  CHECK(count(draw_barrel({.walls = 1}), ",0>}}") == 5);
  CHECK(count(draw_barrel({.walls = 0}), "box{") == 0);
  CHECK(has(barrel, "max_trace_level"));  // a ray meets many faces
}

TEST_CASE("a camera that follows a body is beside it, whichever rank owns it") {
  const picture look{.from = {0, -8, 1}, .at = {0, 0, 0}};
  CHECK(has(draw(look, false, true), "camera{location <3,-7,3>"));
  CHECK(has(draw(look, false, true), "look_at <3,1,2>"));
  CHECK(has(draw(look, false), "camera{location <0,-8,1>"));
}

TEST_CASE("a material whose colour is no colour, or whose name is too long, is refused") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scenario<bodies<sphere>>> w(link);
    for (const real bad : {-0.1, 1.5, std::numeric_limits<real>::quiet_NaN()})
      CHECK_THROWS_WITH_AS(w.material({.colour = {0.5, bad, 0.5}}),
                           doctest::Contains("red, green and blue from 0 to 1, but is (0.5, "),
                           std::invalid_argument);
    CHECK_THROWS_WITH_AS(w.material({.name = std::string(32, 'x')}),
                         doctest::Contains("at most 31 bytes: shorten 'xxx"),
                         std::invalid_argument);
    CHECK(w.material({.name = std::string(31, 'x')}) == material_id{0});
  });
}
