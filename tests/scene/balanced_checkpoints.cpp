// A run with moving cuts continues from a checkpoint as the one that wrote it.
// long
#include "../world/balanced_heap.hpp"

#include <unistd.h>

#include <talus/checkpoint.hpp>
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/threads.hpp>

namespace {

struct scratch_file {
  std::string name = "/tmp/talus_balanced_" + std::to_string(getpid()) + ".h5";
  ~scratch_file() { unlink(name.c_str()); }
};

struct outcome {
  std::string digest;
  std::vector<bisection_cut> cuts;
  bool operator==(const outcome&) const = default;
};

using alike = corner<threads, checkpoints>;
using in_order = scenario<bodies<sphere, plane>, decomposition<bisection<dynamic>>,
                          transport<threads>, features<balancing, checkpoints>>;

/// Steps from `from` on, from a file unless that is 0, and writes one after `written`.
template <class Scenario>
outcome course(int ranks, int from, int to, int written, const std::string& file,
               std::uint64_t every = 7) {
  outcome end;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
    fill_corner(w, {.name = "", .every = every});
    if (from > 0) CHECK(read_checkpoint(w, file).empty());
    CHECK(w.steps() == static_cast<std::uint64_t>(from));
    for (int k = from; k < to; ++k) {
      w.step(1.0 / 240);
      tend_corner(w, k);
      if (k + 1 == written) write_checkpoint(w, file);
    }
    (void)w.audit();
    const std::string digest = state_digest(w);
    if (link.rank() == 0) end = {digest, w.divided().cuts};
  });
  return end;
}

}  // namespace

TEST_CASE("on the same number of ranks a restart finds the cuts where they were") {
  const scratch_file file;
  for (const int ranks : {4, 7})
    for (const int half : {70, 100}) {  // between two checks, and before one
      CAPTURE(ranks);
      const outcome whole = course<in_order>(ranks, 0, 160, half, file.name);
      CHECK(!whole.cuts.empty());
      CHECK(course<in_order>(ranks, half, 160, 0, file.name) == whole);
    }
}

TEST_CASE("with the reproducible solver, a restart on any ranks ends with the same bits") {
  const scratch_file file;
  const std::string one = course<alike>(1, 0, 160, 0, file.name).digest;
  for (const int ranks : {1, 4, 7}) {
    CHECK(course<alike>(ranks, 0, 160, 100, file.name).digest == one);
    for (const int others : {1, 3, 4, 7})
      for (const std::uint64_t every : {0, 5})
        CHECK(course<alike>(others, 100, 160, 0, file.name, every).digest == one);
  }
}

TEST_CASE("a file without cuts is read as it is, and one with cuts where they cannot move") {
  const scratch_file file;
  using still =
      scenario<bodies<sphere, plane>, solver<reproducible>, decomposition<any_decomposition>,
               transport<threads>, features<checkpoints>>;
  std::string written, read;
  threads::launch({.ranks = 4}, [&](threads::link& link) {
    world<still> w(link, grid<2, 2>{});
    fill_corner(w, {.name = ""});
    for (int k = 0; k < 20; ++k) w.step(1.0 / 240);
    write_checkpoint(w, file.name);
    const std::string digest = state_digest(w);
    if (link.rank() == 0) written = digest;
  });
  CHECK(course<alike>(4, 20, 20, 0, file.name).digest == written);
  const outcome balanced = course<alike>(4, 0, 30, 30, file.name);
  threads::launch({.ranks = 4}, [&](threads::link& link) {
    world<still> w(link, grid<2, 2>{});
    fill_corner(w, {.name = ""});
    (void)read_checkpoint(w, file.name);
    const std::string digest = state_digest(w);
    if (link.rank() == 0) read = digest;
  });
  CHECK(read == balanced.digest);
}
