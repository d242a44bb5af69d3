// STL files as programs write them, with faults in their triangles or words.
#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>
#include <talus/mesh.hpp>
#include <vector>

#include "../landscape.hpp"

using namespace talus;

namespace {

using triangle = triangle_mesh::triangle;

std::string text_of(const std::vector<triangle>& all, const std::string& title) {
  std::string text = "solid " + title + "\n";
  for (const triangle& t : all) {
    text += "facet normal 0 0 1\nouter loop\n";
    for (const vec3& v : t) {
      std::array<char, 100> line;
      std::snprintf(line.data(), line.size(), "vertex %.17g %.17g %.17g\n", v[0], v[1], v[2]);
      text += line.data();
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid " + title + "\n";
}
/// The surface in a file of this content.
triangle_mesh surface(const std::string& content, surface_report* report = nullptr) {
  const std::string file = "/tmp/talus_io_stl_" + std::to_string(getpid()) + ".stl";
  std::ofstream(file, std::ios::binary) << content;
  try {
    const triangle_mesh m = read_stl(file, 1, report);
    std::remove(file.c_str());
    return m;
  } catch (...) {
    std::remove(file.c_str());
    throw;
  }
}
std::vector<triangle> sheet(int n) {
  return landscape(n, 2, [](real, real) { return 0; });
}

}  // namespace

TEST_CASE("corners near to each other and to edges divide these a finite number of times") {
  std::mt19937 random(1);
  for (const real noise : {3e-7, 6e-7, 1e-6, 2e-6, 5e-6}) {
    std::uniform_real_distribution<real> in(-noise, noise);
    for (int k = 0; k < 20; ++k) {
      auto all = sheet(12);
      for (triangle& t : all)
        for (vec3& v : t) v += vec3(in(random), in(random), in(random));
      CAPTURE(noise);
      CAPTURE(k);
      surface_report report;
      const triangle_mesh m = surface(text_of(all, "noise"), &report);
      CHECK(m.triangles() < 5 * all.size());
      CHECK(m.volume() == doctest::Approx(4).epsilon(1e-4));
      CHECK(report.joined.size() < 5 * all.size());
    }
  }
}

TEST_CASE("triangles without an area do not change the tolerance of a surface, wherever they are") {
  const auto given = sheet(4);
  const vec3 ways[] = {{1, 0, 0}, {1, 0.1, 0.3}, {0.7, -0.3, 0.11}};
  for (const real far : {3.0, 1e3, 1e6, 1e9})
    for (const vec3& way : ways)
      for (const auto& [a, b, c] :
           {std::array{1.0, 1.0, 1.0}, {1.0, 1.0, 1.1}, {1.0, 1.05, 1.1}, {-1.3, 1.1, 0.7}}) {
        const vec3 at = far * way;
        CAPTURE(far);
        CAPTURE(b);
        auto all = given;
        all.insert(all.begin() + 7, triangle{vec3(a * at), vec3(b * at), vec3(c * at)});
        surface_report report;
        const triangle_mesh m = surface(text_of(all, "null"), &report);
        CHECK(m == triangle_mesh(given));
        CHECK(report.without_area == 1);
        CHECK(report.open_edges.size() == 16);
        CHECK((placed(m).position - vec3(0, 0, 0)).norm() == 0);
      }
  // A part far from the origin, at which other programs put triangles that they have removed.
  auto all = given;
  for (triangle& t : all)
    for (vec3& v : t) v += vec3(1e6, 2e6, 0);
  const triangle_mesh alone(all);
  all.push_back({vec3(0, 0, 0), vec3(0, 0, 0), vec3(0, 0, 0)});
  CHECK(surface(text_of(all, "part")) == alone);
}

TEST_CASE("a text of several solids of which the last is cut off is refused") {
  auto beside = sheet(2);
  for (triangle& t : beside)
    for (vec3& v : t) v += vec3(5, 0, 0);
  const std::string one = text_of(sheet(1), "one"), two = text_of(beside, "two");
  CHECK(surface(one + two).triangles() == 10);
  for (const char* const cut : {"endsolid", "facet normal", "outer", "endfacet", "endloop"}) {
    const std::string part = one + two.substr(0, two.rfind(cut));
    CAPTURE(cut);
    CHECK_THROWS_WITH(surface(part), doctest::Contains("ends without 'endsolid': it was cut off"));
  }
  CHECK_THROWS_WITH(surface(one + "solid two\n"), doctest::Contains("it was cut off"));
  std::string without = one;
  without.erase(without.rfind("endfacet"), 8);
  CHECK_THROWS_WITH(surface(without), doctest::Contains("has no 'endfacet'"));
}

TEST_CASE("a text in UTF-16 is refused with that reason") {
  const std::string text = text_of(sheet(3), "one");
  for (const bool big : {false, true}) {
    std::string wide = big ? "\xfe\xff" : "\xff\xfe";
    for (const char c : text) wide += big ? std::string({'\0', c}) : std::string({c, '\0'});
    CHECK_THROWS_WITH(surface(wide), doctest::Contains("is in UTF-16: save it as UTF-8"));
  }
}

TEST_CASE("the title of a text may have any words") {
  const triangle_mesh given(sheet(2));
  for (const char* const title :
       {"facet of a vertex", "endfacet of endsolid", "solid solid", "a facet", "vertex 1 2 x",
        "facet normal", "facet normal to solid"}) {
    CAPTURE(title);
    CHECK(surface(text_of(sheet(2), title)) == given);
  }
}

TEST_CASE("a remark with the word solid begins no solid") {
  const triangle_mesh given(sheet(2));
  const std::string text = text_of(sheet(2), "one");
  for (const char* const remark :
       {"# end of solid one\n", "; made by a solid modeller", "a solid"}) {
    CAPTURE(remark);
    CHECK(surface(text + remark) == given);
    CHECK(surface(remark + ("\n" + text)) == given);
  }
}
