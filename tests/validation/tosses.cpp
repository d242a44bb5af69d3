// Tosses of a cube (./dev bench tosses): reading them, how far a simulation is off, and talus on a
// flight and an impact with known ends. With TALUS_TOSSES=FILE, the table of measured tosses, .csv
// or .csv.gz, talus is judged on those, too.
// alone
#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>

#include "../../benchmarks/tosses/talus_toss.hpp"

using namespace bench::tosses;

namespace {

const std::string columns = "toss,frame,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz\n";

std::vector<toss> tosses_of(const std::string& rows) {
  std::istringstream in(columns + rows);
  return read(in);
}

double no_clock() { return 0; }

/// Frames of a flight without impacts.
toss flight(int number, const state& start, int frames) {
  toss t{number};
  for (int k = 0; k < frames; ++k) {
    const double time = k / rate;
    state s = start;
    s.position += time * start.velocity - 0.5 * gravity * time * time * vec::UnitZ();
    s.velocity.z() -= gravity * time;
    if (const double w = start.spin.norm(); w > 0)
      s.orientation = turn(Eigen::AngleAxisd(w * time, start.spin / w)) * start.orientation;
    t.frames.push_back(s);
  }
  return t;
}

/// An engine in which the cube stays where it is.
struct stuck {
  stuck(const settings&, const state& s) : s_(s) {}
  void step() {}
  [[nodiscard]] state now() const { return s_; }
  state s_;
};

}  // namespace

TEST_CASE("a table of tosses is read in metres, with the spin in the world") {
  const double half = std::sqrt(0.5);
  const std::string turned = std::to_string(half) + "," + std::to_string(half) + ",0,0";
  const auto all =
      tosses_of("4,0,2,0,3,1,0,0,0,1,0,0,0,0,5\n4,1,2,0,3,1,0,0,0,1,0,0,0,0,5\n7,0,0,0,1," +
                turned + ",0,0,0,0,0,2\n7,1,0,0,1," + turned + ",0,0,0,0,0,2\n");
  REQUIRE(all.size() == 2);
  CHECK((all[0].frames[0].position - half_edge * vec(2, 0, 3)).norm() < 1e-15);
  CHECK((all[0].frames[1].velocity - half_edge * vec(1, 0, 0)).norm() < 1e-15);
  CHECK((all[0].frames[0].spin - vec(0, 0, 5)).norm() < 1e-15);
  CHECK((all[1].frames[0].spin - vec(0, -2, 0)).norm() < 1e-12);  // a quarter turn about x
  CHECK(half_of(all, false).size() == 1);
  CHECK(half_of(all, true).front().number == 7);
}

TEST_CASE("a table that is no table of tosses is refused") {
  std::istringstream other("toss,x,y,z\n");
  CHECK_THROWS_WITH(read(other), doctest::Contains("must name the columns"));
  CHECK_THROWS_WITH(tosses_of("4,0,2,0,3\n"), doctest::Contains("line 2 has no 15 numbers"));
  CHECK_THROWS_WITH(tosses_of("4,0,2,0,3,1,0,0,0,1,0,0,0,0,5\n4,2,2,0,3,1,0,0,0,1,0,0,0,0,5\n"),
                    doctest::Contains("line 3 is not the next frame of toss 4"));
  CHECK_THROWS_WITH(tosses_of("4,0,2,0,3,1,0,0,0,1,0,0,0,0,5\n"),
                    doctest::Contains("toss 4 has a single frame"));
  CHECK_THROWS_WITH(judge<stuck>({}, {}, 1, no_clock), doctest::Contains("no tosses"));
}

TEST_CASE("errors are means over frames in edges and radians, and a wrong face counts") {
  const double edge = 2 * half_edge;
  state start, moved;
  start.position = moved.position = {0, 0, half_edge};
  moved.position.x() = edge;
  moved.orientation = turn(Eigen::AngleAxisd(pi / 2, vec::UnitX()));
  const errors e = judge<stuck>(
      {toss{0, {start, start, moved}}, toss{2, {start, start, start, start}}}, {}, 3, no_clock);
  CHECK(e.distance == doctest::Approx(0.25));  // half an edge in one of two tosses
  CHECK(e.angle == doctest::Approx(pi / 8));
  CHECK(e.faces == doctest::Approx(0.5));
  CHECK(e.objective() == doctest::Approx(0.25 + pi / 16));
  CHECK(e.steps == 15);
  REQUIRE(e.distances.size() == 3);
  CHECK(e.distances[1] == 0);
  CHECK(e.distances[2] == doctest::Approx(0.5));
  CHECK(e.angles[2] == doctest::Approx(pi / 4));
}

TEST_CASE("the face on top has an axis and a sign") {
  state s;
  CHECK(top_face(s) == 3);
  s.orientation = turn(Eigen::AngleAxisd(3 * pi / 4 + 0.1, vec::UnitX()));
  CHECK(top_face(s) == -3);
  s.orientation = turn(Eigen::AngleAxisd(pi / 2 + 0.2, vec::UnitX()));
  CHECK(top_face(s) == 2);
  s.orientation = turn(Eigen::AngleAxisd(pi / 2, vec::UnitY()));
  CHECK(top_face(s) == -1);
}

TEST_CASE("talus follows a flight with spin, and twice the steps halve the error") {
  state start;
  start.position = {0.1, 0, 0.8};
  start.velocity = {1, -0.5, 0.5};
  start.spin = {3, 5, -4};
  const std::vector<toss> one{flight(0, start, 30)};
  const errors coarse = judge<talus_toss>(one, {0.2, 0.1}, 4, no_clock),
               fine = judge<talus_toss>(one, {0.2, 0.1}, 8, no_clock);
  CHECK(coarse.angle < 1e-4);  // a cube turns about any axis at an even rate
  CHECK(coarse.distance < 0.01);
  CHECK(fine.distance < 0.6 * coarse.distance);
  CHECK(coarse.faces == 1);
}

TEST_CASE("a cube of talus that falls flat rebounds with its restitution, and friction stops it") {
  const double dt = 1 / rate / 4, fall = 0.05, edge = 2 * half_edge;
  state start;
  start.position = {0, 0, half_edge + fall};
  talus_toss bouncing({0.2, 0.5, dt}, start);
  double up = 0;
  for (int i = 0; i < 100; ++i) {
    bouncing.step();
    up = std::max(up, bouncing.now().velocity.z());
  }
  CHECK(up == doctest::Approx(0.5 * std::sqrt(2 * gravity * fall)).epsilon(0.02));

  start.position.z() = half_edge;
  start.velocity = {0.6, 0, 0};
  talus_toss sliding({0.3, 0, dt}, start);
  for (int i = 0; i < 200; ++i) sliding.step();
  const double way = 0.6 * 0.6 / (2 * 0.3 * gravity);
  CHECK(sliding.now().velocity.norm() < 1e-9);
  CHECK(std::abs(sliding.now().position.x() - way) < 0.02 * edge);
}

TEST_CASE("talus is as near to the measured tosses as the page says") {
  const char* const file = std::getenv("TALUS_TOSSES");
  if (file == nullptr) {
    MESSAGE("skipped: TALUS_TOSSES names no table of measured tosses");
    return;
  }
  std::string table, name = file, command = "gzip -cdf '" + name + "'";
  REQUIRE(name.find('\'') == std::string::npos);
  std::FILE* const unpacked = popen(command.c_str(), "r");
  REQUIRE(unpacked != nullptr);
  char block[65536];
  while (const std::size_t n = std::fread(block, 1, sizeof block, unpacked)) table.append(block, n);
  REQUIRE(pclose(unpacked) == 0);
  std::istringstream in(table);
  const std::vector<toss> tosses = half_of(read(in), false);
  REQUIRE(tosses.size() > 200);
  const errors e = judge<talus_toss>(tosses, {0.18, 0.1}, 1, no_clock);
  CHECK(e.distance < 0.15);
  CHECK(e.angle * 180 / pi < 20);
  CHECK(e.faces > 0.78);
}
