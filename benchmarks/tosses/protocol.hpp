#pragma once
// Measured tosses of a cube, without any engine: reading them, and how far a simulation is off.
// Lengths are in half edges of the cube in the file, in metres here; the spin is in the frame of
// the cube there, in the world here.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace bench::tosses {

using vec = Eigen::Vector3d;
using turn = Eigen::Quaterniond;

constexpr double half_edge = 0.0524;  ///< m
constexpr double mass = 0.37;         ///< kg
constexpr double inertia = 8.1e-4;    ///< kg m², about each axis
constexpr double rate = 148;          ///< frames a second
constexpr double gravity = 9.81;      ///< m/s²
constexpr double pi = 3.14159265358979323846;

/// Pose and velocity of the cube: rotation from cube to world, spin in the world.
struct state {
  vec position = vec::Zero();
  turn orientation = turn::Identity();
  vec velocity = vec::Zero();
  vec spin = vec::Zero();
};

/// The frames of a toss; the cube is in the air or on the floor z = 0.
struct toss {
  int number = 0;
  std::vector<state> frames{};
};

/// What an engine is told: the two fitted numbers and the time step.
struct settings {
  double friction = 0;
  double restitution = 0;
  double dt = 1 / rate;
};

/// Reads a table of frames (toss,frame,x,y,z,qw,...,wz); throws runtime_error for another one.
inline std::vector<toss> read(std::istream& in) {
  std::string line;
  if (!std::getline(in, line) || line.rfind("toss,frame,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz", 0))
    throw std::runtime_error("the first line must name the columns toss,frame,x,y,z,qw,...,wz");
  std::vector<toss> all;
  for (std::size_t row = 2; std::getline(in, line); ++row) {
    if (line.empty()) continue;
    for (char& c : line)
      if (c == ',') c = ' ';
    std::istringstream words(line);
    double x[15];
    for (double& value : x)
      if (!(words >> value))
        throw std::runtime_error("line " + std::to_string(row) + " has no 15 numbers");
    const auto number = static_cast<int>(x[0]);
    if (all.empty() || all.back().number != number) all.push_back({number});
    std::vector<state>& frames = all.back().frames;
    if (x[1] != static_cast<double>(frames.size()))
      throw std::runtime_error("line " + std::to_string(row) + " is not the next frame of toss " +
                               std::to_string(number));
    const turn q = turn(x[5], x[6], x[7], x[8]).normalized();
    frames.push_back({half_edge * vec(x[2], x[3], x[4]), q, half_edge * vec(x[9], x[10], x[11]),
                      q * vec(x[12], x[13], x[14])});
  }
  for (const toss& t : all)
    if (t.frames.size() < 2)
      throw std::runtime_error("toss " + std::to_string(t.number) + " has a single frame");
  return all;
}

/// The tosses with even or with odd numbers.
inline std::vector<toss> half_of(const std::vector<toss>& all, bool odd) {
  std::vector<toss> some;
  for (const toss& t : all)
    if ((t.number % 2 != 0) == odd) some.push_back(t);
  return some;
}

/// Distance of the centres, in edges.
inline double distance(const state& a, const state& b) {
  return (a.position - b.position).norm() / (2 * half_edge);
}
/// Angle of the rotation from one to the other, in radians.
inline double angle(const state& a, const state& b) {
  return a.orientation.angularDistance(b.orientation);
}
/// The face that is on top: 1 to 3 for x, y, z, negative for the opposite ones.
inline int top_face(const state& s) {
  const vec up = s.orientation.conjugate() * vec::UnitZ();
  int axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  return up[axis] < 0 ? -(axis + 1) : axis + 1;
}

/// How far an engine is off: means over tosses of the means over their frames after the first.
struct errors {
  double distance = 0;            ///< edges
  double angle = 0;               ///< radians
  double faces = 0;               ///< share of tosses that end with the measured face on top
  double cpu_seconds = 0;         ///< of the steps
  std::size_t steps = 0;          ///<
  std::vector<double> distances;  ///< by frame, while all tosses last
  std::vector<double> angles;     ///<

  /// What the fit makes small: the distance in edges, plus half the angle. The latter is how far
  /// the middle of a face moves, in edges.
  [[nodiscard]] double objective() const { return distance + angle / 2; }
};

/// Simulates each toss from its first frame on with an engine: Engine(settings, state), step(),
/// now(). `cpu` gives the CPU seconds so far.
template <class Engine, class Clock>
errors judge(const std::vector<toss>& tosses, settings how, std::size_t substeps, Clock&& cpu) {
  if (tosses.empty()) throw std::runtime_error("there are no tosses of these numbers");
  how.dt = 1 / rate / static_cast<double>(substeps);
  errors sum;
  std::size_t shortest = tosses.front().frames.size();
  for (const toss& t : tosses) shortest = std::min(shortest, t.frames.size());
  sum.distances.assign(shortest, 0);
  sum.angles.assign(shortest, 0);
  const auto count = static_cast<double>(tosses.size());
  std::vector<state> found;
  for (const toss& t : tosses) {
    Engine engine(how, t.frames.front());
    found.assign(1, t.frames.front());
    const double before = cpu();
    for (std::size_t k = 1; k < t.frames.size(); ++k) {
      for (std::size_t i = 0; i < substeps; ++i) engine.step();
      found.push_back(engine.now());
    }
    sum.cpu_seconds += cpu() - before;
    sum.steps += substeps * (t.frames.size() - 1);
    const double share = 1 / count / static_cast<double>(t.frames.size() - 1);
    for (std::size_t k = 1; k < t.frames.size(); ++k) {
      const double far = distance(found[k], t.frames[k]), turned = angle(found[k], t.frames[k]);
      sum.distance += share * far;
      sum.angle += share * turned;
      if (k < shortest) {
        sum.distances[k] += far / count;
        sum.angles[k] += turned / count;
      }
    }
    if (top_face(found.back()) == top_face(t.frames.back())) sum.faces += 1 / count;
  }
  return sum;
}

}  // namespace bench::tosses
