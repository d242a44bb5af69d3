// The output of --output is the state, complete and each body once, on any number of ranks, and a
// series continues with a restarted run.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/force.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/pictures.hpp>
#include <talus/scene/region.hpp>
#include <talus/scene/run.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/vtk.hpp>
#include <vector>

using namespace talus;

namespace {

using clump = union_of<sphere, box>;
using pile = scenario<bodies<sphere, clump, plane>, hard_contact<coulomb_friction>,
                      decomposition<grid<dynamic, dynamic>>, transport<threads>,
                      features<vtk_output, checkpoints, user_ids>>;

/// The beginning of the names of files of this process, removed at the end.
struct scratch {
  std::string folder = "/tmp/talus_output_" + std::to_string(getpid());
  scratch() { REQUIRE(std::system(("mkdir -p " + folder).c_str()) == 0); }
  ~scratch() { (void)!std::system(("rm -r " + folder).c_str()); }
  std::string operator()(const std::string& name) const { return folder + "/" + name; }
};

const clump& dumbbell() {
  static const clump one{
      {{.shape = sphere{0.3}, .at = {{0.2, 0, 0}}}, {.shape = box{{0.4, 0.3, 0.5}}}}};
  return one;
}

/// A heap of 27 bodies over the middle of the domain, on the ground and a global sphere; of four
/// ranks in a row the outer two are empty.
template <class World>
handle<plane> set_up(World& w) {
  if (w.ranks() > 1) w.decompose({.cells = {w.ranks(), 1}, .lower = {-8, -2}, .upper = {8, 2}});
  w.gravity({0, 0, -10});
  const auto stone = w.material({.density = 2, .friction = 0.5});
  handle<plane> ground;
  w.global([&](auto& scope) {
    ground = scope.add(plane{}, stone);
    scope.add(sphere{0.7}, stone, {1, 0, -0.2});
  });
  w.fill(simple_cubic{.spacing = 1} & box_region{{-1, -1, 0.4}, {1, 1, 3.3}},
         [&](const site& place, random_stream& random) {
           std::variant<body<sphere>, body<clump>> made;
           if (random.uniform(0., 1.) < 0.5)
             made = body{.shape = sphere{random.uniform(0.3, 0.48)},
                         .position = place.position,
                         .material = stone,
                         .angular_velocity = random.unit_vector(),
                         .user_id = 7};
           else
             made = body{.shape = dumbbell(),
                         .position = place.position,
                         .material = stone,
                         .velocity = random.unit_vector(),
                         .angular_velocity = random.unit_vector(),
                         .orientation = random.rotation(),
                         .user_id = 8};
           return made;
         });
  return ground;
}

/// A file read by HDF5.
struct file_reader {
  detail::hdf5_handle file;
  explicit file_reader(const std::string& name)
      : file(H5Fopen(name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "read") {}
  template <class T>
  std::vector<T> get(const std::string& path, detail::number_type type, std::uint32_t width) const {
    const detail::open_dataset set(file, "/VTKHDF/" + path, type, width);
    std::vector<T> values(set.rows() * width);
    set.read(0, set.rows(), values.data());
    return values;
  }
  std::vector<double> reals(const std::string& path, std::uint32_t width = 1) const {
    return get<double>(path, detail::number_type::f64, width);
  }
  std::vector<std::uint64_t> ids(const std::string& path) const {
    return get<std::uint64_t>(path, detail::number_type::u64, 1);
  }
  std::vector<std::int64_t> whole(const std::string& path) const {
    return get<std::int64_t>(path, detail::number_type::i64, 1);
  }
};

/// Cells in the form of VTK: one piece, in which cell k takes its corners one after the other.
void check_cells(const file_reader& f, std::size_t cells, std::size_t corners, std::uint8_t kind) {
  const auto number = [&](const char* path) { return f.whole(path).at(0); };
  CHECK(number("NumberOfPoints") == static_cast<std::int64_t>(cells * corners));
  CHECK(number("NumberOfCells") == static_cast<std::int64_t>(cells));
  CHECK(number("NumberOfConnectivityIds") == static_cast<std::int64_t>(cells * corners));
  const auto ends = f.whole("Offsets"), points = f.whole("Connectivity");
  REQUIRE(ends.size() == cells + 1);
  REQUIRE(points.size() == cells * corners);
  for (std::size_t k = 0; k <= cells; ++k)
    REQUIRE(ends[k] == static_cast<std::int64_t>(k * corners));
  for (std::size_t k = 0; k < points.size(); ++k)
    REQUIRE(points[k] == static_cast<std::int64_t>(k));
  const auto types = f.get<std::uint8_t>("Types", detail::number_type::u8, 1);
  CHECK(types == std::vector<std::uint8_t>(cells, kind));
}

/// All data of a file about a body, except its rank, by id and part.
using table = std::map<std::pair<std::uint64_t, std::uint32_t>, std::vector<double>>;
table bodies_in(const file_reader& f) {
  using detail::number_type;
  const auto ids = f.ids("PointData/id");
  const auto part = f.get<std::uint32_t>("PointData/part", number_type::u32, 1);
  table all;
  const auto add = [&](const auto& values, std::size_t width) {
    REQUIRE(values.size() == ids.size() * width);
    for (std::size_t i = 0; i < values.size(); ++i)
      all[{ids[i / width], part[i / width]}].push_back(static_cast<double>(values[i]));
  };
  add(f.reals("Points", 3), 3);
  add(f.get<std::uint8_t>("PointData/shape", number_type::u8, 1), 1);
  add(f.get<std::uint8_t>("PointData/fixed", number_type::u8, 1), 1);
  add(f.get<std::uint16_t>("PointData/material", number_type::u16, 1), 1);
  add(f.reals("PointData/mass"), 1);
  add(f.reals("PointData/radius"), 1);
  add(f.reals("PointData/size", 3), 3);
  add(f.reals("PointData/velocity", 3), 3);
  add(f.reals("PointData/angular_velocity", 3), 3);
  add(f.reals("PointData/orientation", 4), 4);
  add(f.get<std::uint32_t>("PointData/user_id", number_type::u32, 1), 1);
  REQUIRE(all.size() == ids.size());  // none twice
  return all;
}

std::string text_of(const std::string& file) {
  std::ostringstream out;
  out << std::ifstream(file).rdbuf();
  return out.str();
}
/// The steps of a series, in order.
std::vector<int> steps_in(const std::string& index) {
  std::vector<int> steps;
  std::istringstream lines(text_of(index));
  for (std::string line; std::getline(lines, line);)
    if (const auto at = line.find(".hdf\""); at != line.npos)
      steps.push_back(std::stoi(line.substr(at - 10, 10)));
  return steps;
}

}  // namespace

TEST_CASE("an output holds every body once, as it is, on any number of ranks") {
  const scratch files;
  table alone;
  for (const int ranks : {1, 4}) {
    const std::string name = files("first" + std::to_string(ranks));
    table expected;
    threads::launch({.ranks = ranks}, [&](auto& link) {
      world<pile> w(link);
      set_up(w);
      write_vtk(w, name);
      if (ranks == 1)
        w.for_each_local([&](const auto& b) {
          const auto row = [&](std::uint32_t part, const auto& shape, const pose& at, double mass) {
            const vec3 size = 2 * shape.half_extents(pose{}),
                       v = b.velocity() + b.angular_velocity().cross(at.position - b.position());
            const double kind = std::is_same_v<decltype(shape), const box&>;
            double radius = shape.bounding_radius();
            const quat& q = at.orientation;
            const vec3 &p = at.position, &s = b.angular_velocity();
            expected[{value_of(b.id()), part}] = {p[0],    p[1],
                                                  p[2],    kind,
                                                  0,       0,
                                                  mass,    radius,
                                                  size[0], size[1],
                                                  size[2], v[0],
                                                  v[1],    v[2],
                                                  s[0],    s[1],
                                                  s[2],    q.w(),
                                                  q.x(),   q.y(),
                                                  q.z(),   static_cast<double>(b.user_id())};
          };
          if constexpr (requires { b.shape().parts(); }) {
            std::uint32_t part = 0;
            b.shape().each_part([&](const auto& shape, const pose& at) {
              row(part, shape, detail::combined(b.pose(), at), part == 0 ? b.mass() : 0);
              ++part;
            });
          } else {
            row(0, b.shape(), b.pose(), b.mass());
          }
        });
    });
    const file_reader f(name + ".hdf");
    const table all = bodies_in(f);
    check_cells(f, all.size(), 1, 1);
    CHECK(f.ids("PointData/id").size() == all.size());
    CHECK(f.whole("FieldData/step") == std::vector<std::int64_t>{0});
    if (ranks == 1) {
      CHECK(expected.size() > 35);
      CHECK(all.size() == expected.size() + 1);  // the global sphere; the plane cannot be drawn
      std::size_t alike = 0;
      for (const auto& [key, row] : expected) alike += all.at(key) == row;
      CHECK(alike == expected.size());
      alone = all;
      const auto ids = f.ids("PointData/id");
      CHECK(std::is_sorted(ids.begin(), ids.end()));
    } else {
      CHECK(all == alone);
      const auto rank = f.get<std::uint32_t>("PointData/rank", detail::number_type::u32, 1);
      CHECK(std::is_sorted(rank.begin(), rank.end()));
      CHECK(std::count(rank.begin(), rank.end(), 1u) > 8);
      CHECK(std::count(rank.begin(), rank.end(), 3u) == 0);
    }
    // No step was made, so there is no contact yet.
    check_cells(file_reader(name + "_contacts.hdf"), 0, 2, 3);
  }
}

TEST_CASE("contacts are lines between the bodies, each once, and their forces bear the weight") {
  const scratch files;
  for (const int ranks : {1, 2}) {
    const std::string name = files("heap" + std::to_string(ranks));
    vec3 pressed{0, 0, 0};
    system_id floor{};
    threads::launch({.ranks = ranks}, [&](auto& link) {
      world<pile> w(link);
      const handle<plane> ground = set_up(w);
      w.simulate({.steps = 40, .dt = 0.02});
      write_vtk(w, name);
      const vec3 f = contact_force(w, ground);
      if (w.rank() == 0) pressed = f, floor = ground.id;
    });
    const file_reader b(name + ".hdf"), c(name + "_contacts.hdf");
    CHECK(b.reals("FieldData/time").at(0) == doctest::Approx(0.8));
    const auto of_a = c.ids("CellData/id_a"), of_b = c.ids("CellData/id_b");
    check_cells(c, of_a.size(), 2, 3);
    CHECK(of_a.size() > 20);
    // Of a union, whose parts are points of their own, the centre is not in the file.
    std::map<std::uint64_t, vec3> centres;
    const auto ids = b.ids("PointData/id");
    const auto places = b.reals("Points", 3);
    const auto users = b.get<std::uint32_t>("PointData/user_id", detail::number_type::u32, 1);
    for (std::size_t i = 0; i < ids.size(); ++i)
      if (users[i] == 7) centres[ids[i]] = {places[3 * i], places[3 * i + 1], places[3 * i + 2]};
    const auto points = c.reals("Points", 3), touch = c.reals("CellData/point", 3),
               force = c.reals("CellData/force", 3), normal = c.reals("CellData/normal", 3),
               along = c.reals("CellData/normal_force"),
               across = c.reals("CellData/tangential_force");
    vec3 sum{0, 0, 0};
    const std::uint64_t pedestal = *std::max_element(ids.begin(), ids.end());  // global
    std::size_t looked_at = 0, on_pedestal = 0;
    std::map<std::vector<double>, int> seen;
    for (std::size_t k = 0; k < of_a.size(); ++k) {
      const auto at = [&](const auto& all, std::size_t row) {
        return vec3(all[3 * row], all[3 * row + 1], all[3 * row + 2]);
      };
      const vec3 f = at(force, k), n = at(normal, k);
      CHECK(n.norm() == doctest::Approx(1));
      CHECK(along[k] == doctest::Approx(n.dot(f)));
      CHECK(across[k] == doctest::Approx((f - along[k] * n).norm()).epsilon(1e-6));
      ++seen[{static_cast<double>(of_a[k]), static_cast<double>(of_b[k]), f[0], f[1], f[2]}];
      if (of_b[k] == value_of(floor)) {
        sum -= f;
        CHECK(at(points, 2 * k + 1) == at(touch, k));  // a plane has no centre
        CHECK(at(touch, k)[2] == doctest::Approx(0).epsilon(0.05));
      } else if (const auto end = centres.find(of_b[k]); end != centres.end()) {
        CHECK(at(points, 2 * k + 1) == end->second);
        ++looked_at;
      } else if (of_b[k] == pedestal) {
        CHECK(at(points, 2 * k + 1) == at(touch, k));
        ++on_pedestal;
      }
      if (const auto end = centres.find(of_a[k]); end != centres.end())
        CHECK(at(points, 2 * k) == end->second);
    }
    CHECK(seen.size() == of_a.size());
    CHECK(looked_at > 1);
    CHECK(on_pedestal > 0);
    CHECK(sum[2] == doctest::Approx(pressed[2]).epsilon(1e-9));
    CHECK(-sum[2] > 0);
  }
}

TEST_CASE(
    "an output of surfaces has the faces of every box, at its place, on any number of ranks") {
  const scratch files;
  std::map<std::uint64_t, vec3> alone;
  for (const int ranks : {1, 4}) {
    const std::string name = files("faces" + std::to_string(ranks));
    std::map<std::uint64_t, vec3> expected;
    threads::launch({.ranks = ranks}, [&](auto& link) {
      world<pile> w(link);
      set_up(w);
      write_vtk(w, name, {.surfaces = true});
      if (ranks == 1)
        w.for_each_local([&](const auto& b) {
          if constexpr (requires { b.shape().parts(); })
            b.shape().each_part([&](const auto& shape, const pose& at) {
              if constexpr (requires { shape.size; })
                expected[value_of(b.id())] = detail::combined(b.pose(), at).position;
            });
        });
    });
    const file_reader f(name + "_surfaces.hdf");
    const auto ids = f.ids("CellData/id");
    const auto ends = f.whole("Offsets"), corners = f.whole("Connectivity");
    const auto points = f.reals("Points", 3);
    const auto types = f.get<std::uint8_t>("Types", detail::number_type::u8, 1);
    CHECK(types == std::vector<std::uint8_t>(ids.size(), 7));
    CHECK(f.whole("NumberOfCells").at(0) == static_cast<std::int64_t>(ids.size()));
    CHECK(f.whole("NumberOfConnectivityIds").at(0) == static_cast<std::int64_t>(corners.size()));
    CHECK(f.whole("NumberOfPoints").at(0) * 3 == static_cast<std::int64_t>(points.size()));
    REQUIRE(ends.size() == ids.size() + 1);
    // Six times the volume of each body, from tetrahedra on its faces, and the middle of its
    // corners.
    std::map<std::uint64_t, double> volume;
    std::map<std::uint64_t, vec3> middle;
    std::map<std::uint64_t, int> faces;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      const auto corner = [&](std::int64_t c) {
        const auto at = static_cast<std::size_t>(3 * corners.at(static_cast<std::size_t>(c)));
        return vec3(points.at(at), points.at(at + 1), points.at(at + 2));
      };
      REQUIRE(ends[k + 1] - ends[k] == 4);
      const vec3 a = corner(ends[k]);
      for (std::int64_t c = ends[k]; c < ends[k + 1]; ++c) {
        auto& sum = middle.try_emplace(ids[k], vec3(0, 0, 0)).first->second;
        sum += corner(c) / 24;
        if (c > ends[k] + 1) volume[ids[k]] += a.cross(corner(c - 1)).dot(corner(c));
      }
      ++faces[ids[k]];
    }
    if (ranks == 1) {
      CHECK(expected.size() > 5);
      CHECK(middle.size() == expected.size());
      for (const auto& [id, place] : expected) CHECK((middle.at(id) - place).norm() < 1e-12);
      alone = middle;
    }
    REQUIRE(middle.size() == alone.size());
    for (const auto& [id, place] : middle) {
      CHECK((alone.at(id) - place).norm() < 1e-14);
      CHECK(faces[id] == 6);
      CHECK(volume[id] / 6 == doctest::Approx(0.4 * 0.3 * 0.5));
    }
  }
}

TEST_CASE("surfaces of spheres alone are refused with what to do instead") {
  using balls = scenario<bodies<sphere, plane>, transport<threads>>;
  threads::launch({.ranks = 2}, [&](auto& link) {
    world<balls> w(link);
    CHECK_THROWS_WITH(write_vtk(w, "/tmp/none", {.surfaces = true}),
                      "an output has no surfaces where all bodies are spheres or planes: leave "
                      "surfaces out, and draw the points of the output as spheres of their radius");
  });
}

namespace {

int run_pile(std::vector<std::string> words, int ranks = 2) {
  words.insert(words.begin(), "pile");
  words.insert(words.end(), {"--quiet", "--ranks", std::to_string(ranks), "--output-every", "10"});
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  return run<pile>(static_cast<int>(argv.size()), argv.data(),
                   [](auto& world, const options& options) {
                     set_up(world);
                     take_pictures(world, options);
                     world.simulate({.steps = options.steps, .dt = options.dt});
                   });
}

}  // namespace

TEST_CASE("a series of a restarted run is the one of a run that was never interrupted") {
  const scratch files;
  const std::vector<int> whole{0, 10, 20, 30, 40};
  const std::string index = files("a.hdf.series"), contacts = files("a_contacts.hdf.series");
  // Steps 30 and 35 come after the checkpoint.
  REQUIRE(run_pile({"--steps", "35", "--output", files("a"), "--checkpoint", files("a.h5"),
                    "--checkpoint-every", "20"}) == 0);
  REQUIRE(run_pile({"--steps", "25", "--output", files("b"), "--checkpoint", files("b.h5"),
                    "--checkpoint-every", "20"}) == 0);
  // The last state has a file, too, and the continued series leaves it out.
  CHECK(steps_in(index) == std::vector<int>{0, 10, 20, 30, 35});
  CHECK(steps_in(files("b_contacts.hdf.series")) == std::vector<int>{0, 10, 20, 25});
  REQUIRE(std::rename(files("b.h5").c_str(), files("a.h5").c_str()) == 0);  // of step 25
  const std::string before = text_of(files("a_contacts_0000000020.hdf"));
  std::ofstream(files("a_0000000030.hdf")) << "of another future";
  REQUIRE(run_pile({"--steps", "40", "--output", index, "--restart", files("a.h5"), "--log",
                    files("log")}) == 0);
  CHECK(text_of(files("log")).find(", restarted at step 25\n") != std::string::npos);
  CHECK(steps_in(index) == whole);
  CHECK(steps_in(contacts) == whole);
  CHECK(text_of(files("a_contacts_0000000020.hdf")) == before);
  CHECK(bodies_in(file_reader(files("a_0000000030.hdf"))).size() > 35);

  // The same, had the run been killed between its two indices, and at a step that has an output.
  REQUIRE(run_pile({"--steps", "20", "--output", files("c"), "--output-surfaces", "--checkpoint",
                    files("c.h5")}) == 0);
  const std::string all = text_of(files("c_contacts.hdf.series"));
  REQUIRE(steps_in(files("c_contacts.hdf.series")) == std::vector<int>{0, 10, 20});
  const auto last = all.find(",\n    {\"name\": \"c_contacts_0000000020");
  REQUIRE(last != all.npos);
  std::ofstream(files("c_contacts.hdf.series")) << all.substr(0, last) << "\n  ]\n}\n";
  REQUIRE(run_pile({"--steps", "40", "--output", files("c"), "--output-surfaces", "--restart",
                    files("c.h5")}) == 0);
  CHECK(steps_in(files("c.hdf.series")) == whole);
  CHECK(steps_in(files("c_surfaces.hdf.series")) == whole);
  CHECK(steps_in(files("c_contacts.hdf.series")) == whole);

  CHECK(text_of(files("c.hdf.series"))
            .starts_with("{\n  \"file-series-version\": \"1.0\",\n  \"files\": [\n"
                         "    {\"name\": \"c_0000000000.hdf\", \"time\": 0},\n"
                         "    {\"name\": \"c_0000000010.hdf\", \"time\": "));
  CHECK(run_pile({"--steps", "10", "--output", files("c")}) == 0);  // a new one replaces the old
  CHECK(steps_in(files("c_surfaces.hdf.series")).empty());  // and lists no faces of another run
  CHECK(steps_in(files("c.hdf.series")) == std::vector<int>{0, 10});
  CHECK(std::system(("ls " + files.folder + " | grep -q part").c_str()) != 0);
}

TEST_CASE("the state at the end of a run is in its output, once, wherever it ends") {
  const scratch files;
  const auto steps_of = [&](std::vector<std::string> more, int code, int ranks) {
    more.insert(more.end(), {"--output", files("a")});
    REQUIRE(run_pile(more, ranks) == code);
    const auto steps = steps_in(files("a.hdf.series"));
    CHECK(steps == steps_in(files("a_contacts.hdf.series")));
    char digits[16];
    std::snprintf(digits, sizeof digits, "%010d", steps.back());
    const file_reader last(files(std::string("a_") + digits + ".hdf"));
    CHECK(last.whole("FieldData/step").at(0) == steps.back());
    CHECK(bodies_in(last).size() > 35);
    return steps;
  };
  CHECK(steps_of({"--steps", "0"}, 0, 1) == std::vector<int>{0});
  for (const int ranks : {1, 3}) {
    CHECK(steps_of({"--steps", "7"}, 0, ranks) == std::vector<int>{0, 7});
    CHECK(steps_of({"--steps", "20"}, 0, ranks) == std::vector<int>{0, 10, 20});
  }
  CHECK(steps_of({"--steps", "13", "--checkpoint", files("a.h5")}, 0, 2) ==
        std::vector<int>{0, 10, 13});
  // A restart that makes no step, and one on other ranks.
  CHECK(steps_of({"--steps", "13", "--restart", files("a.h5")}, 0, 3) ==
        std::vector<int>{0, 10, 13});
  CHECK(steps_of({"--steps", "22", "--restart", files("a.h5")}, 0, 3) ==
        std::vector<int>{0, 10, 20, 22});
  // The time limit ends it after some step.
  const auto limited =
      steps_of({"--steps", "1000000", "--time-limit", "1s"}, detail::exit_code_of_time_limit, 2);
  CHECK(limited.size() > 1);
}

TEST_CASE("an output that cannot be written is said before anything is computed") {
  threads::launch({.ranks = 2}, [&](auto& link) {
    world<pile> w(link);
    const auto begin = [&](const std::string& name, bool goes_on) {
      const vtk_series<pile> series(w, name, goes_on);
    };
    for (const bool goes_on : {false, true})
      CHECK_THROWS_WITH(begin("/tmp/none/a", goes_on),
                        "the output /tmp/none/a.hdf.series cannot be written: No such file or "
                        "directory; name a file in a folder that exists, is writable and has room");
    CHECK_THROWS_WITH(begin("/tmp/", false), doctest::Contains("has no name"));
    set_up(w);
    CHECK_THROWS_WITH(write_vtk(w, "/tmp/none/a"),
                      doctest::Contains("the output /tmp/none/a.hdf cannot be written"));
  });
  using plain = scenario<bodies<sphere>, transport<threads>>;
  options asked;
  command_line line("");
  asked.describe(line);
  detail::withdraw_options<plain>(line, asked);
  const char* const words[] = {"pile", "--output", "a"};
  CHECK_THROWS_WITH(line.parse(3, words),
                    doctest::Contains("name features<vtk_output> in its scenario"));
}

TEST_CASE("an output replaces outputs and pictures, and nothing else unless it is forced") {
  const scratch files;
  const auto diary = [&](const std::string& name) { std::ofstream(files(name)) << "a diary"; };
  const auto run_with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"--steps", "10", "--every", "5", "--output", files("a"), "--frames",
                               files("pictures")});
    return run_pile(more);
  };
  REQUIRE(run_with({}) == 0);
  CHECK(run_with({}) == 0);
  const std::string index = text_of(files("a.hdf.series"));
  const std::string picture = text_of(files("pictures/frame_00001.pov"));
  // Each is detected before the first step: a later file of the series, too.
  for (const std::string name :
       {"a.hdf.series", "a_contacts.hdf.series", "a_0000099990.hdf", "a_contacts_0000000010.hdf",
        "pictures/frame_00001.pov", "pictures/frame_00077.pov"}) {
    CAPTURE(name);
    const std::string kept = files.folder + "_kept";
    REQUIRE(std::system(("cp -r " + files.folder + " " + kept).c_str()) == 0);
    if (name.starts_with("a_")) std::remove(files("a.hdf.series").c_str());
    if (name.starts_with("a_")) std::remove(files("a_contacts.hdf.series").c_str());
    diary(name);
    CHECK(run_with({}) == 1);
    CHECK(text_of(files(name)) == "a diary");
    CHECK(run_with({"--force"}) == 0);
    if (name.find("77") == name.npos && name.find("9999") == name.npos)
      CHECK(text_of(files(name)) != "a diary");
    // A link is not followed.
    diary("text");
    std::remove(files(name).c_str());
    REQUIRE(symlink(files("text").c_str(), files(name).c_str()) == 0);
    CHECK(run_with({}) == 1);
    CHECK(run_with({"--force"}) == 0);
    CHECK(text_of(files("text")) == "a diary");
    REQUIRE(std::system(
                ("rm -r " + files.folder + " && mv " + kept + " " + files.folder).c_str()) == 0);
  }
  CHECK(text_of(files("a.hdf.series")) == index);
  CHECK(text_of(files("pictures/frame_00001.pov")) == picture);
  diary("text");
  CHECK(run_pile({"--steps", "10", "--output", files("b"), "--frames", files("text")}) == 1);
  CHECK(text_of(files("text")) == "a diary");
  // A run that is refused leaves the output of another one as it is.
  CHECK(run_pile({"--steps", "10", "--output", files("a"), "--frames", files("text")}) == 1);
  CHECK(text_of(files("a.hdf.series")) == index);
  CHECK(std::system(("ls -R " + files.folder + " | grep -q part").c_str()) != 0);
}

namespace {

/// The output of a run on standard error; `code` is the required exit code.
std::string said_by_pile(const std::vector<std::string>& words, int code, int ranks) {
  const scratch log;
  const std::string name = log.folder + "_said";
  const int before = dup(2), file = open(name.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0600);
  dup2(file, 2);
  const int got = run_pile(words, ranks);
  std::fflush(stderr);
  dup2(before, 2);
  close(before);
  close(file);
  std::string text = text_of(name);
  std::remove(name.c_str());
  CHECK(got == code);
  return text;
}

}  // namespace

// (A file that HDF5 cannot write makes it crash at the end of the program, and this test with it.)
TEST_CASE("a full disk ends the run with the bytes that are missing, and old outputs are whole") {
  const std::string folder = "/tmp/talus_disk_" + std::to_string(getpid());
  REQUIRE(std::system(("mkdir -p " + folder).c_str()) == 0);
  const auto write = [&](int ranks, const std::string& why) {
    const std::string text = said_by_pile({"--steps", "10", "--output", folder + "/a"}, 1, ranks);
    CAPTURE(text);
    CHECK(text.find(folder + "/a") != text.npos);  // an output, or its configuration
    CHECK(text.find(why) != text.npos);
    CHECK(text.find("bytes are missing") != text.npos);
    CHECK(std::count(text.begin(), text.end(), '\n') == 1);
  };
  const auto compare_old = [&](const std::string& old) {
    CHECK(text_of(folder + "/a_0000000000.hdf") == old);
    CHECK(std::system(("ls " + folder + " | grep -q part").c_str()) != 0);
  };
  REQUIRE(run_pile({"--steps", "10", "--output", folder + "/a"}) == 0);
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  const std::string old = text_of(folder + "/a_0000000000.hdf");
  for (const int ranks : {1, 2}) {
    const rlimit small{old.size() / 2, before.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
    write(ranks, "it needs some");
    REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
    compare_old(old);
  }
  // A disk of its own, if this process may mount one.
  if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      mount("none", folder.c_str(), "tmpfs", 0, "size=400k") != 0) {
    MESSAGE("no disk to fill");
  } else {
    for (const int free : {0, 4, 8, 12, 16}) {
      for (const int ranks : {1, 2}) {
        REQUIRE(run_pile({"--steps", "10", "--output", folder + "/a"}) == 0);
        const std::string here = text_of(folder + "/a_0000000000.hdf");
        REQUIRE(std::system(("cat /dev/zero >" + folder + "/ballast 2>/dev/null; truncate -s -" +
                             std::to_string(free) + "K " + folder + "/ballast")
                                .c_str()) == 0);
        write(ranks, "there is no room for");
        compare_old(here);
        REQUIRE(std::remove((folder + "/ballast").c_str()) == 0);
      }
    }
    CHECK(umount(folder.c_str()) == 0);
  }
  CHECK(std::system(("rm -r " + folder).c_str()) == 0);
}
