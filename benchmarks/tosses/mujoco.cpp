// MuJoCo: a box on a plane, elliptic cone of friction, its other defaults. It has no coefficient
// of restitution: a contact is a spring of half a period of eight time steps, with the dashpot
// that gives a mass on it this restitution.
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <cstdlib>

#include "runner.hpp"

namespace {

using namespace bench::tosses;

mjModel* load() {
  char xml[900];
  std::snprintf(xml, sizeof xml,
                "<mujoco><compiler balanceinertia='false' boundmass='0' boundinertia='0'/>"
                "<option gravity='0 0 %g' cone='elliptic'/><worldbody>"
                "<geom name='floor' type='plane' size='0 0 1' condim='3'/><body><freejoint/>"
                "<inertial pos='0 0 0' mass='%g' diaginertia='%g %g %g'/>"
                "<geom name='cube' type='box' size='%g %g %g' condim='3'/>"
                "</body></worldbody></mujoco>",
                -gravity, mass, inertia, inertia, inertia, half_edge, half_edge, half_edge);
  char file[] = "/tmp/tosses_XXXXXX";
  const int handle = mkstemp(file);
  if (handle < 0) throw std::runtime_error("there is no place for the model");
  std::FILE* out = fdopen(handle, "w");
  std::fputs(xml, out);
  std::fclose(out);
  char problem[500] = "";
  mjModel* model = mj_loadXML(file, nullptr, problem, sizeof problem);
  std::remove(file);
  if (!model) throw std::runtime_error(problem);
  return model;
}

class mujoco_toss {
 public:
  static constexpr const char* name = "mujoco";

  mujoco_toss(const settings& how, const state& at) {
    static mjModel* const model = load();
    m_ = model;
    m_->opt.timestep = how.dt;
    const double log = std::log(std::max(how.restitution, 1e-6));
    const double damping = -log / std::sqrt(pi * pi + log * log), frequency = pi / (8 * how.dt);
    for (int i = 0; i < m_->ngeom; ++i) {
      m_->geom_friction[3 * i] = how.friction;  // the larger one of the two counts
      m_->geom_solref[mjNREF * i] = -frequency * frequency;
      m_->geom_solref[mjNREF * i + 1] = -2 * damping * frequency;
    }
    d_ = mj_makeData(m_);
    const turn& q = at.orientation;
    const vec spin = q.conjugate() * at.spin;
    const double pose[7] = {
        at.position.x(), at.position.y(), at.position.z(), q.w(), q.x(), q.y(), q.z()};
    std::copy(pose, pose + 7, d_->qpos);
    for (int k = 0; k < 3; ++k) {
      d_->qvel[k] = at.velocity[k];
      d_->qvel[3 + k] = spin[k];
    }
  }
  ~mujoco_toss() { mj_deleteData(d_); }
  mujoco_toss(const mujoco_toss&) = delete;
  mujoco_toss& operator=(const mujoco_toss&) = delete;

  void step() { mj_step(m_, d_); }
  [[nodiscard]] state now() const {
    const double *p = d_->qpos, *v = d_->qvel;
    const turn q(p[3], p[4], p[5], p[6]);
    return {{p[0], p[1], p[2]}, q, {v[0], v[1], v[2]}, q * vec(v[3], v[4], v[5])};
  }

 private:
  mjModel* m_ = nullptr;
  mjData* d_ = nullptr;
};

}  // namespace

int main(int argc, char** argv) { return bench::tosses::run<mujoco_toss>(argc, argv); }
