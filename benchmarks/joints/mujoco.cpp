// MuJoCo: joint coordinates, loops closed by soft equality constraints made as stiff as the time
// step allows, RK4 and implicit integration.
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "runner.hpp"
#include "tree.hpp"

namespace {

using namespace bench::joints;

std::string text(const vec& v) {
  char out[120];
  std::snprintf(out, sizeof out, "%.17g %.17g %.17g", v.x(), v.y(), v.z());
  return out;
}
std::string text(const turn& q) {
  char out[160];
  std::snprintf(out, sizeof out, "%.17g %.17g %.17g %.17g", q.w(), q.x(), q.y(), q.z());
  return out;
}

class mujoco_joints {
 public:
  static constexpr const char* name = "mujoco";
  static std::vector<plan> plans() {
    std::vector<plan> list;
    for (const char* integrator : {"RK4", "implicit"}) {
      list.push_back({"A01", integrator, {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}});
      list.push_back({"A02_2", integrator, {1e-2, 1e-3}, {1e-3}});
      list.push_back({"A02_10", integrator, {1e-2, 1e-3}, {1e-2}});
      list.push_back({"A03", integrator, {1e-4, 1e-5, 1e-6}, {1e-4, 1e-5}});
      list.push_back({"A04", integrator, {1e-2, 1e-3, 1e-4}, {1e-2, 1e-3}});
    }
    list.push_back({"A02_40", "implicit", {1e-2}, {}});
    list.push_back({"A05", "RK4", {1e-5}, {}});
    list.push_back({"A05", "implicit", {1e-4, 1e-5}, {1e-4}});
    return list;
  }
  static std::vector<std::string> notes() {
    return {"grid: the dense matrix of 29,403 loop rows is too large",
            "chain: its reader does not nest 250 bodies (XML_ELEMENT_DEPTH_EXCEEDED)"};
  }

  mujoco_joints(const scene& s, const std::string& integrator, double dt)
      : s_(s), now_(start_of(s)), tree_(tree_of(s)) {
    char file[] = "/tmp/joints_XXXXXX";
    const int handle = mkstemp(file);
    if (handle < 0) throw std::runtime_error("there is no place for the model");
    const std::string xml = model(integrator, dt);
    std::FILE* out = fdopen(handle, "w");
    std::fwrite(xml.data(), 1, xml.size(), out);
    std::fclose(out);
    char problem[500] = "";
    m_ = mj_loadXML(file, nullptr, problem, sizeof problem);
    std::remove(file);
    if (!m_) throw std::runtime_error(problem);
    d_ = mj_makeData(m_);
    for (std::size_t i = 0; i < now_.size(); ++i) start_velocity(static_cast<int>(i));
    for (const drive& d : s.drives)
      for (int k = 0; k < 3; ++k) d_->xfrc_applied[6 * (index(d.on)) + 3 + k] = d.torque[k];
  }
  ~mujoco_joints() {
    mj_deleteData(d_);
    mj_deleteModel(m_);
  }

  void advance(long steps) {
    for (long i = 0; i < steps; ++i) mj_step(m_, d_);
    mj_forward(m_, d_);
    for (std::size_t i = 0; i < now_.size(); ++i) {
      const int b = index(static_cast<int>(i));
      const double *p = d_->xipos + 3 * b, *q = d_->xquat + 4 * b;
      double v[6];
      mj_objectVelocity(m_, d_, mjOBJ_BODY, b, v, 0);
      now_[i] = {
          {p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}, {v[3], v[4], v[5]}, {v[0], v[1], v[2]}};
    }
  }

  const std::vector<state>& states() const { return now_; }

 private:
  int index(int body) const {
    return mj_name2id(m_, mjOBJ_BODY, ("b" + std::to_string(body)).c_str());
  }

  vec local(int i, const vec& at) const {
    if (i == ground) return at;
    const state& b = s_.bodies[i].start;
    return b.orientation.conjugate() * (at - b.position);
  }
  turn attitude(int i) const {
    return i == ground ? turn::Identity() : s_.bodies[i].start.orientation;
  }

  /// A body with those that hang on it; sites for the ends of springs.
  std::string hung(int i) const {
    const body& b = s_.bodies[i];
    const joint& j = s_.joints[tree_.joint_of[i]];
    const int parent = tree_.parent_of[i];
    const std::string type = j.type == kind::ball    ? "ball"
                             : j.type == kind::hinge ? "hinge"
                                                     : "slide";
    std::string xml = "<body name='b" + std::to_string(i) + "' pos='" +
                      text(local(parent, b.start.position)) + "' quat='" +
                      text(attitude(parent).conjugate() * b.start.orientation) + "'>";
    char mass[200];
    std::snprintf(mass, sizeof mass, "<inertial pos='0 0 0' mass='%.17g' diaginertia='%s'/>",
                  b.mass, text(b.inertia).c_str());
    xml += mass;
    xml += "<joint name='j" + std::to_string(i) + "' type='" + type + "' pos='" +
           text(local(i, j.at)) + "' axis='" + text(b.start.orientation.conjugate() * j.axis) +
           "'/>";
    for (std::size_t k = 0; k < s_.springs.size(); ++k)
      for (const auto& [of, at, end] : {std::tuple{s_.springs[k].a, s_.springs[k].at_a, "a"},
                                        std::tuple{s_.springs[k].b, s_.springs[k].at_b, "b"}})
        if (of == i)
          xml += "<site name='" + std::string(end) + std::to_string(k) + "' pos='" +
                 text(local(i, at)) + "'/>";
    for (const int child : tree_.order)
      if (tree_.parent_of[child] == i) xml += hung(child);
    return xml + "</body>";
  }

  std::string model(const std::string& integrator, double dt) const {
    char step[40];
    std::snprintf(step, sizeof step, "%.17g", dt);
    std::string xml =
        "<mujoco><compiler balanceinertia='false' boundmass='0' boundinertia='0'/>"
        "<size njmax='2000' nconmax='10' nstack='20000000'/><option timestep='" +
        std::string(step) + "' gravity='" + text(s_.gravity) + "' integrator='" + integrator +
        "' solver='Newton' iterations='100' tolerance='1e-14'/><worldbody>";
    for (std::size_t k = 0; k < s_.springs.size(); ++k)
      if (s_.springs[k].a == ground)
        xml += "<site name='a" + std::to_string(k) + "' pos='" + text(s_.springs[k].at_a) + "'/>";
    for (const int i : tree_.order)
      if (tree_.parent_of[i] == ground) xml += hung(i);
    xml += "</worldbody><tendon>";
    for (std::size_t k = 0; k < s_.springs.size(); ++k) {
      const spring& p = s_.springs[k];
      char numbers[200];
      std::snprintf(numbers, sizeof numbers,
                    "stiffness='%.17g' damping='%.17g' springlength='%.17g'", p.stiffness,
                    p.damping, p.rest);
      xml += "<spatial " + std::string(numbers) + "><site site='a" + std::to_string(k) +
             "'/><site site='b" + std::to_string(k) + "'/></spatial>";
    }
    xml += "</tendon><equality>";
    // Two time steps are the smallest time constant that is stable.
    char soft[120];
    std::snprintf(soft, sizeof soft, "solref='%.17g 1' solimp='0.9999 0.9999 0.001'", 2 * dt);
    const auto close = [&](const joint& j, const vec& at) {
      xml += "<connect body1='b" + std::to_string(j.b) + "' " +
             (j.a == ground ? "" : "body2='b" + std::to_string(j.a) + "' ") + "anchor='" +
             text(local(j.b, at)) + "' " + soft + "/>";
    };
    for (const int i : tree_.loops) {
      const joint& j = s_.joints[i];
      if (s_.name == "A04") {  // two points of the axis; in plane mechanisms one is enough
        close(j, j.at + j.axis / 2);
        close(j, j.at - j.axis / 2);
      } else
        close(j, j.at);
    }
    return xml + "</equality></mujoco>";
  }

  void start_velocity(int i) {
    const joint& j = s_.joints[tree_.joint_of[i]];
    const int parent = tree_.parent_of[i];
    const auto at = [&](int of) -> std::pair<vec, vec> {
      if (of == ground) return {vec::Zero(), vec::Zero()};
      const state& b = s_.bodies[of].start;
      return {b.spin, b.velocity + b.spin.cross(j.at - b.position)};
    };
    const auto [wa, va] = at(parent);
    const auto [wb, vb] = at(i);
    const int first =
        m_->jnt_dofadr[mj_name2id(m_, mjOBJ_JOINT, ("j" + std::to_string(i)).c_str())];
    const vec axis = j.axis.normalized();
    if (j.type == kind::hinge)
      d_->qvel[first] = axis.dot(wb - wa);
    else if (j.type == kind::slider)
      d_->qvel[first] = axis.dot(vb - va);
    else {
      const vec w = s_.bodies[i].start.orientation.conjugate() * (wb - wa);
      for (int k = 0; k < 3; ++k) d_->qvel[first + k] = w[k];
    }
  }

  scene s_;
  std::vector<state> now_;
  tree tree_;
  mjModel* m_ = nullptr;
  mjData* d_ = nullptr;
};

}  // namespace

int main(int argc, char** argv) { return bench::joints::run<mujoco_joints>(argc, argv); }
