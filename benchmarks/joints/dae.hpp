#pragma once
// Integrates bodies with balls and hinges to high accuracy: accelerations from the equations of
// motion with the constraints differentiated twice, extrapolated midpoint steps of eighth order,
// and a projection of positions and velocities after each step. Redundant constraints are allowed.
#include <Eigen/QR>
#include <cmath>
#include <tuple>
#include <utility>

#include "checker.hpp"

namespace bench::joints {

class dae {
 public:
  explicit dae(const scene& s) : s_(s), now_(start_of(s)) {}

  const std::vector<state>& states() const { return now_; }

  /// Angles by which bodies have turned about z in all steps, for plane mechanisms.
  const Eigen::VectorXd& turned() const { return turned_; }

  void step(double h) {
    constexpr int counts[4] = {2, 4, 6, 8};
    Eigen::VectorXd table[4];
    const Eigen::VectorXd from = packed(now_);
    for (int i = 0; i < 4; ++i) {
      table[i] = midpoint(from, h, counts[i]);
      for (int k = i - 1; k >= 0; --k) {
        const double ratio = static_cast<double>(counts[i]) / counts[k];
        table[k] = table[k + 1] + (table[k + 1] - table[k]) / (ratio * ratio - 1);
      }
    }
    if (turned_.size() == 0) turned_ = Eigen::VectorXd::Zero(now_.size());
    const std::vector<state> before = now_;
    now_ = unpacked(table[0]);
    project();
    for (std::size_t i = 0; i < now_.size(); ++i) {
      const turn by = now_[i].orientation * before[i].orientation.conjugate();
      turned_[i] += 2 * std::atan2(by.w() < 0 ? -by.z() : by.z(), std::abs(by.w()));
    }
  }

 private:
  Eigen::VectorXd packed(const std::vector<state>& now) const {
    Eigen::VectorXd y(13 * now.size());
    for (std::size_t i = 0; i < now.size(); ++i)
      y.segment<13>(13 * i) << now[i].position, now[i].orientation.coeffs(), now[i].velocity,
          now[i].spin;
    return y;
  }

  std::vector<state> unpacked(const Eigen::VectorXd& y) const {
    std::vector<state> now(s_.bodies.size());
    for (std::size_t i = 0; i < now.size(); ++i) {
      now[i].position = y.segment<3>(13 * i);
      now[i].orientation.coeffs() = y.segment<4>(13 * i + 3).normalized();
      now[i].velocity = y.segment<3>(13 * i + 7);
      now[i].spin = y.segment<3>(13 * i + 10);
    }
    return now;
  }

  Eigen::VectorXd midpoint(const Eigen::VectorXd& from, double h, int count) const {
    const double step = h / count;
    Eigen::VectorXd last = from, y = from + step * slope(from);
    for (int i = 1; i < count; ++i) {
      const Eigen::VectorXd next = last + 2 * step * slope(y);
      last = y;
      y = next;
    }
    return y / 2 + (last + step * slope(y)) / 2;
  }

  struct rows {
    Eigen::MatrixXd jacobian, inverse_mass;
    Eigen::VectorXd error, bias;  ///< of position; of acceleration
  };

  rows rows_of(const std::vector<state>& now) const {
    const int n = static_cast<int>(now.size());
    int count = 0;
    for (const joint& j : s_.joints) count += j.type == kind::ball ? 3 : 5;
    rows r{Eigen::MatrixXd::Zero(count, 6 * n), Eigen::MatrixXd::Zero(6 * n, 6 * n),
           Eigen::VectorXd(count), Eigen::VectorXd(count)};
    for (int i = 0; i < n; ++i) {
      const Eigen::Matrix3d to_world = now[i].orientation.toRotationMatrix();
      r.inverse_mass.block<3, 3>(6 * i, 6 * i).diagonal().setConstant(1 / s_.bodies[i].mass);
      r.inverse_mass.block<3, 3>(6 * i + 3, 6 * i + 3) =
          to_world * s_.bodies[i].inertia.cwiseInverse().asDiagonal() * to_world.transpose();
    }
    int row = 0;
    for (const joint& j : s_.joints) {
      r.error.segment<3>(row) = moved_point(s_, now, j.b, j.at) - moved_point(s_, now, j.a, j.at);
      r.bias.segment<3>(row).setZero();
      for (const auto& [of, sign] : {std::pair{j.b, 1.}, std::pair{j.a, -1.}}) {
        if (of == ground) continue;
        const vec arm = moved_point(s_, now, of, j.at) - now[of].position;
        const vec w = now[of].spin;
        for (int k = 0; k < 3; ++k) {
          const vec e = vec::Unit(k);
          r.jacobian.block<1, 3>(row + k, 6 * of) = sign * e.transpose();
          r.jacobian.block<1, 3>(row + k, 6 * of + 3) = sign * arm.cross(e).transpose();
        }
        r.bias.segment<3>(row) += sign * w.cross(w.cross(arm));
      }
      row += 3;
      if (j.type == kind::ball) continue;
      const vec axis = moved_direction(s_, now, j.b, j.axis);
      const vec side = j.axis.unitOrthogonal();
      const vec wb = now[j.b].spin;
      const vec wa = j.a == ground ? vec::Zero() : now[j.a].spin;
      for (const vec& t0 : {side, vec(j.axis.normalized().cross(side))}) {
        const vec t = moved_direction(s_, now, j.a, t0);
        const vec arm = axis.cross(t);
        r.error[row] = axis.dot(t);
        r.jacobian.block<1, 3>(row, 6 * j.b + 3) = arm.transpose();
        if (j.a != ground) r.jacobian.block<1, 3>(row, 6 * j.a + 3) = -arm.transpose();
        r.bias[row] = (wb - wa).dot(wb.cross(axis).cross(t) + axis.cross(wa.cross(t)));
        ++row;
      }
    }
    return r;
  }

  /// Change of velocity that changes the rows by `by`, the smallest one in kinetic energy.
  static Eigen::VectorXd response(const rows& r, const Eigen::VectorXd& by) {
    const Eigen::MatrixXd right = r.inverse_mass * r.jacobian.transpose();
    Eigen::MatrixXd a = r.jacobian * right;
    const Eigen::VectorXd scale = a.diagonal().cwiseSqrt().cwiseInverse();
    a = scale.asDiagonal() * a * scale.asDiagonal();
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    solver.setThreshold(1e-10);
    solver.compute(a);
    return right * (scale.asDiagonal() * solver.solve(scale.cwiseProduct(by)));
  }

  Eigen::VectorXd slope(const Eigen::VectorXd& y) const {
    const std::vector<state> now = unpacked(y);
    const rows r = rows_of(now);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(6 * now.size());
    for (std::size_t i = 0; i < now.size(); ++i) {
      const vec local = now[i].orientation.conjugate() * now[i].spin;
      const vec momentum = now[i].orientation * s_.bodies[i].inertia.cwiseProduct(local);
      force.segment<3>(6 * i) = s_.bodies[i].mass * s_.gravity;
      force.segment<3>(6 * i + 3) = -now[i].spin.cross(momentum);
    }
    for (const spring& k : s_.springs) {
      const vec f = spring_force(s_, now, k);
      for (const auto& [of, at, sign] :
           {std::tuple{k.b, k.at_b, 1.}, std::tuple{k.a, k.at_a, -1.}}) {
        if (of == ground) continue;
        force.segment<3>(6 * of) += sign * f;
        force.segment<3>(6 * of + 3) +=
            sign * (moved_point(s_, now, of, at) - now[of].position).cross(f);
      }
    }
    for (const drive& d : s_.drives) force.segment<3>(6 * d.on + 3) += d.torque;
    Eigen::VectorXd rate = r.inverse_mass * force;
    rate += response(r, -r.bias - r.jacobian * rate);
    Eigen::VectorXd out(y.size());
    for (std::size_t i = 0; i < now.size(); ++i) {
      const vec w = now[i].spin;
      const turn spun = turn(0, w.x(), w.y(), w.z()) * turn(y.segment<4>(13 * i + 3));
      out.segment<13>(13 * i) << now[i].velocity, spun.coeffs() / 2, rate.segment<6>(6 * i);
    }
    return out;
  }

  void project() {
    for (int pass = 0; pass < 2; ++pass) {
      const rows r = rows_of(now_);
      const Eigen::VectorXd by = response(r, -r.error);
      for (std::size_t i = 0; i < now_.size(); ++i) {
        const vec angle = by.segment<3>(6 * i + 3);
        now_[i].position += by.segment<3>(6 * i);
        if (angle.norm() > 0)
          now_[i].orientation =
              turn(Eigen::AngleAxisd(angle.norm(), angle.normalized())) * now_[i].orientation;
        now_[i].orientation.normalize();
      }
    }
    const rows r = rows_of(now_);
    Eigen::VectorXd v(6 * now_.size());
    for (std::size_t i = 0; i < now_.size(); ++i)
      v.segment<6>(6 * i) << now_[i].velocity, now_[i].spin;
    v += response(r, -r.jacobian * v);
    for (std::size_t i = 0; i < now_.size(); ++i) {
      now_[i].velocity = v.segment<3>(6 * i);
      now_[i].spin = v.segment<3>(6 * i + 3);
    }
  }

  scene s_;
  std::vector<state> now_;
  Eigen::VectorXd turned_;
};

}  // namespace bench::joints
