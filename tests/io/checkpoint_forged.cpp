// A checkpoint with correct checksums but wrong content: it is refused, or its content makes a
// world that can continue.
#include <doctest/doctest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>

#include "../fuzz/checkpoint.hpp"

using namespace talus;
using namespace talus::detail;

namespace {

using clump = union_of<sphere, box>;
using pile = scenario<bodies<sphere, clump, plane>, transport<serial>,
                      features<checkpoints, sleeping, orientation>>;

struct scratch_file {
  std::string name = "/tmp/talus_forged_" + std::to_string(getpid()) + ".h5";
  ~scratch_file() { unlink(name.c_str()); }
};

/// A world of two spheres and a clump that touch, and the same materials without bodies.
void with_world(bool bodies, auto&& f) {
  serial::launch({}, [&](auto& link) {
    world<pile> w(link);
    w.gravity({0, 0, -10});
    const auto stone = w.material({.density = 2, .friction = 0.5});
    if (bodies) {
      w.global([&](auto& scope) { scope.add(plane{}, stone); });
      w.add(sphere{0.5}, stone, {0, 0, 0.5});
      w.add(sphere{0.5}, stone, {0, 0, 1.5});
      w.add(clump{{{.shape = sphere{0.3}, .at = {{0.2, 0, 0}}}, {.shape = box{{0.4, 0.4, 0.3}}}}},
            stone, {2, 0, 0.3});
      for (int k = 0; k < 20; ++k) w.step(0.01);
    }
    f(w);
  });
}

/// Changes one number of the written data.
void change(std::vector<table_part>& tables, std::vector<small_dataset>& facts,
            std::mt19937& random) {
  const auto any = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  const auto spoil = [&](std::byte* at, std::size_t bytes) {
    const double odd[] = {std::numeric_limits<double>::quiet_NaN(),
                          std::numeric_limits<double>::infinity(),
                          -1,
                          0,
                          1e300,
                          1e-300};
    if (bytes == 8 && any(2) == 0)
      std::memcpy(at, &odd[any(std::size(odd))], 8);
    else
      at[any(bytes)] ^= static_cast<std::byte>(1 << any(8));
  };
  if (any(4) == 0) {
    small_dataset& s = facts[any(facts.size())];
    if (s.bytes.empty()) return;
    const std::size_t width = bytes_of(s.type), at = any(s.bytes.size() / width);
    spoil(s.bytes.data() + at * width, width);
  } else {
    table_part& t = tables[any(tables.size())];
    if (t.rows == 0) return;
    if (t.extras && any(3) == 0) {
      const std::size_t at = any(t.extra.size() / 8);
      spoil(t.extra.data() + 8 * at, 8);
    } else {
      table_column& c = t.columns[any(t.columns.size())];
      byte_buffer& copy = t.memory.emplace_back(c.rows, c.rows + t.rows * c.row_bytes());
      const std::size_t width = bytes_of(c.type), at = any(copy.size() / width);
      spoil(copy.data() + at * width, width);
      c.rows = copy.data();
    }
    sum_up_pieces(t);
  }
}

}  // namespace

TEST_CASE("whatever number of a checkpoint is another one, it is refused or the run can go on") {
  const scratch_file file;
  constexpr unsigned seed = 1;
  MESSAGE("seed " << seed);
  std::mt19937 random(seed);
  int refused = 0, taken = 0;
  std::vector<std::string> words;
  with_world(true, [&](auto& whole) {
    team_over team(whole.link());
    for (int k = 0; k < 250; ++k) {
      auto tables = tables_of(talus::detail::state_of(whole));
      for (table_part& t : tables) t.memory.reserve(t.memory.size() + 1);  // columns point into it
      auto facts = facts_of(whole, team, {});
      change(tables, facts, random);
      checkpoint_kind kind;
      team_writer(team, kind, file.name).write(tables, facts);
      with_world(false, [&](auto& w) {
        CAPTURE(k);
        try {
          (void)read_checkpoint(w, file.name);
          for (int step = 0; step < 3; ++step) w.step(0.01);
          ++taken;
        } catch (const std::runtime_error& e) {
          CHECK(std::string(e.what()).size() > 20);
          ++refused;
        } catch (const std::invalid_argument& e) {  // a step with values that contradict each other
          CHECK(std::string(e.what()).size() > 20);
          ++refused;
        }
      });
    }
  });
  CHECK(refused > 40);
  CHECK(taken > 40);
}

TEST_CASE("every part of the corpus is accepted or refused with a message, and cut short refused") {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(__FILE__).parent_path() / "../fuzz/checkpoint")) {
    CAPTURE(entry.path().string());
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(in), {});
    const auto all = std::as_bytes(std::span(bytes));
    (void)fuzz::read_part(all);  // aborts
    for (std::size_t cut = 0; cut < bytes.size(); ++cut)
      CHECK(fuzz::read_part(all.first(cut)) != "");
    ++files;
  }
  CHECK(files >= 5);
}
