#pragma once
// The state of a scene's balls in a file, so that a pile that has settled once can be measured many
// times; and how much memory this process holds.
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "pile_scene.hpp"
#include "report.hpp"
#include "scene.hpp"

namespace bench {

/// Numbers as they are in memory: for this machine only.
inline void save_state(const std::vector<ball>& balls, const std::string& file) {
  const std::uint64_t count = balls.size();
  std::string text(reinterpret_cast<const char*>(&count), sizeof count);
  text.append(reinterpret_cast<const char*>(balls.data()), count * sizeof(ball));
  write_file(text, file, state_output);
}

/// Replaces the initial state of the scene; refuses that of another scene.
inline void load_state(scene& s, const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::uint64_t count = 0;
  in.read(reinterpret_cast<char*>(&count), sizeof count);
  if (!in) throw std::runtime_error("cannot read '" + file + "'");
  if (count != s.balls.size())
    throw std::runtime_error("'" + file + "' has " + std::to_string(count) +
                             " bodies, but the scene has " + std::to_string(s.balls.size()));
  std::vector<ball> balls(count);
  in.read(reinterpret_cast<char*>(balls.data()),
          static_cast<std::streamsize>(count * sizeof(ball)));
  if (!in) throw std::runtime_error("'" + file + "' ends too early");
  for (std::size_t i = 0; i < count; ++i)
    if (balls[i].radius != s.balls[i].radius)
      throw std::runtime_error("'" + file + "' belongs to another scene");
  s.balls = std::move(balls);
}

/// The options of programs that look at a pile from inside, and the pile: afresh, or settled
/// before.
struct pile_run {
  explicit pile_run(arguments& args)
      : bodies(args.count("bodies", 8000)),
        settle(args.count("settle", 720)),
        measure(args.count("measure", 120)),
        tiles(args.count("tiles", 1)),
        from(args.text("from", "")),
        file(args.json_file()) {}
  [[nodiscard]] bench::scene scene() const {
    bench::scene s = pile_scene(bodies);
    if (!from.empty()) load_state(s, from);
    return tiles > 1 ? tiled(s, tiles) : s;
  }

  std::uint64_t bodies, settle, measure;  ///< the latter two in steps
  std::uint64_t tiles;                    ///< copies of the pile along each side of the box
  std::string from, file;
};

/// Pages that this process has received from the kernel so far.
inline double page_faults() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return static_cast<double>(use.ru_minflt + use.ru_majflt);
}

/// Bytes of this process that are in memory.
inline double resident_bytes() {
  std::ifstream in("/proc/self/statm");
  double size = 0, resident = 0;
  in >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

}  // namespace bench
