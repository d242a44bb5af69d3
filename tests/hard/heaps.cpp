// What many small islands and moving heaps cost, by counts.
// alone
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <new>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>

namespace {

std::atomic<std::size_t> allocated{0};  ///< bytes, by all forms of new

void* counted(std::size_t bytes, std::size_t alignment) {
  allocated += bytes;
  void* const memory = std::aligned_alloc(alignment, (bytes / alignment + 1) * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t bytes) { return counted(bytes, alignof(std::max_align_t)); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return counted(bytes, std::max(static_cast<std::size_t>(alignment), alignof(std::max_align_t)));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

using namespace talus;

namespace {

using scene = scenario<bodies<box, sphere, plane>, transport<serial>>;
constexpr real dt = 1.0 / 240;

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Of a body and step.
struct cost {
  double bytes = 0, median = 0, worst = 0;
};
/// Stacks of three boxes that fall by 2 mm with small velocities.
cost drop_stacks(int stacks) {
  serial::link link;
  world<scene> w(link);
  const auto stuff = w.material({.density = 1, .friction = 0.5});
  w.gravity({0, 0, -9.81});
  w.global([&](auto& scope) { scope.add(plane{}, stuff); });
  random_stream random(7, 1);
  const int side = static_cast<int>(std::ceil(std::sqrt(stacks)));
  for (int k = 0; k < stacks; ++k)
    for (int row = 0; row < 3; ++row)
      w.add(body{.shape = box{{1, 1, 1}},
                 .position = {2.5 * (k % side), 2.5 * (k / side), row + 0.502},
                 .material = stuff,
                 .velocity = 0.01 * random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1))});
  constexpr int steps = 24;
  w.step(dt);  // the first one makes room
  std::vector<double> seconds;
  const std::size_t before = allocated;
  for (int k = 0; k < steps; ++k) {
    const double start = thread_seconds();
    w.step(dt);
    seconds.push_back((thread_seconds() - start) / (3 * stacks));
  }
  const auto bytes = static_cast<double>(allocated - before);
  std::sort(seconds.begin(), seconds.end());
  return {bytes / (3.0 * stacks * steps), seconds[steps / 2], seconds.back()};
}

}  // namespace

TEST_CASE("a stack costs the same beside ten thousand others as beside a hundred") {
  const cost few = drop_stacks(100), many = drop_stacks(10'000);
  MESSAGE("bytes allocated for a body in a step: ", few.bytes, " and ", many.bytes,
          "; microseconds: ", 1e6 * few.median, " and ", 1e6 * many.median);
  CHECK(many.bytes < 1.3 * few.bytes);
  // Of the same run, so that the machine does not matter; a copy of all bodies for each island
  // takes ten times as long.
  CHECK(many.median < 4 * few.median);
  CHECK(many.worst < 4 * few.worst);
}

TEST_CASE("a heap of spheres with radii of 1 to 5 falls and settles by its sweeps") {
  serial::link link;
  world<scene> w(link);
  const auto stuff = w.material({.density = 2500, .restitution = 0.2, .friction = 0.5});
  w.gravity({0, 0, -9.81});
  constexpr int bodies = 500, row = 5;
  constexpr real spacing = 1.01, side = row * spacing;
  w.global([&](auto& scope) {
    scope.add(plane{}, stuff);
    for (const vec3& n : {vec3(1, 0, 0), vec3(0, 1, 0)}) {
      scope.add(plane{.normal = n}, stuff);
      scope.add(plane{.normal = -1 * n, .offset = -side}, stuff);
    }
  });
  random_stream random(7, 1);
  for (int k = 0; k < bodies; ++k)
    w.add(body{.shape = sphere{random.uniform(0.1, 0.5)},
               .position = spacing * vec3(k % row + 0.5, k / row % row + 0.5, k / row / row + 0.5),
               .material = stuff,
               .velocity = random.uniform(vec3(-0.5, -0.5, 0), vec3(0.5, 0.5, 0))});
  const auto& state = detail::state_of(w);
  double sweeps = 0;  // at 600 operations for each contact
  real overlap = 0;
  for (int k = 1; k <= 600; ++k) {
    w.step(dt);
    std::size_t contacts = 0;
    state.each_contact_list([&](const auto& list) { contacts += list.size(); });
    sweeps += 600. * w.solver().iterations * static_cast<double>(contacts);
    if (k % 24 == 0) overlap = std::max(overlap, measure_penetration(w).mean);
  }
  MESSAGE("solutions of islands took ", state.solver.islands.spent() / sweeps,
          " of the operations of the sweeps, largest mean overlap ", overlap);
  CHECK(state.solver.islands.spent() < 0.15 * sweeps);
  CHECK(state.solver.islands.islands_solved() > 0);
  CHECK(state.solver.islands.skipped() == 0);
  CHECK(overlap < 0.02);
  CHECK(measure_penetration(w).mean < 2e-3);
}
