// Third-party frictional contact problems: readers, error measures, and the solvers of assembled
// problems on problems from files and on random ones.
#include <doctest/doctest.h>

#include <Eigen/Core>
#include <filesystem>
#include <numeric>
#include <span>

#include "../../benchmarks/fc3d/problem.hpp"
#include "../contact_problems.hpp"
#include "record.hpp"
#include "talus/solver/direct/solve_assembled.hpp"

using namespace talus;
using namespace talus::detail;

namespace {

/// The text format: W dense (storage 0) or in blocks (1).
std::string as_text(const assembled_problem& p, int storage) {
  const int n = p.contacts();
  std::string s = fmt::format("3\n{}\n{}\n{}\n{}\n", n, storage, 3 * n, 3 * n);
  const auto list = [&](const auto& values) {
    for (const auto& x : values) s += fmt::format("{}\t", x);
    s += '\n';
  };
  if (storage == 0) {
    Eigen::MatrixXd w = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    for (int i = 0; i < n; ++i)
      for (auto k = p.start[i]; k < p.start[i + 1]; ++k)
        w.block<3, 3>(3 * i, 3 * p.column[k]) = Eigen::Matrix3d(p.block[k]);
    s += fmt::format("{}\t{}\n", 3 * n, 3 * n);
    list(w.reshaped());
  } else {
    s += fmt::format("{}\n{}\n{}\n", p.block.size(), n, n);
    std::vector<int> ends(n);
    for (int i = 0; i < n; ++i) ends[i] = 3 * i + 3;
    list(ends), list(ends);
    s += fmt::format("{}\n{}\n", p.start.size(), p.column.size());
    list(p.start), list(p.column);
    for (std::size_t k = 0; k < p.block.size(); ++k) {
      s += fmt::format("{}\n", k);
      list(std::span(p.block[k].data(), 9));
    }
  }
  list(p.q), list(p.mu);
  return s + "0\nwhat follows is not read";
}

bool same(const assembled_problem& a, const assembled_problem& b) {
  return a.start == b.start && a.column == b.column && a.block == b.block && a.q == b.q &&
         a.mu == b.mu && a.diagonal == b.diagonal;
}

/// The deviation of r and u = W r + q from Coulomb's law and Signorini's condition, contact by
/// contact: the largest violation over the largest |u| + |q| and |r|.
real worst_violation(const assembled_problem& p, const contact_vector& r) {
  contact_vector u;
  p.velocity(r, u);
  const real speed = u.norm() + p.q.norm(), impulse = r.norm();
  real worst = 0;
  for (int i = 0; i < p.contacts(); ++i) {
    const vec3 ri = r(i), ui = u(i);
    const real t = std::hypot(ri[1], ri[2]), v = std::hypot(ui[1], ui[2]), mu = p.mu[i];
    const real small_r = 1e-300 + impulse, small_u = 1e-300 + speed;
    worst =
        std::max({worst, -ri[0] / small_r, -ui[0] / small_u, (t - mu * ri[0]) / small_r,
                  // either is zero: no gap opens under load,
                  std::min(ri[0] / small_r, std::abs(ui[0]) / small_u),
                  // sliding contacts are on the cone (in the convex relaxation u_n = mu v too),
                  std::min((mu * ri[0] - t) / small_r, v / small_u),
                  // and friction opposes it
                  std::min({t / small_r, v / small_u,
                            v > 0 && t > 0 ? 1 + (ri[1] * ui[1] + ri[2] * ui[2]) / (t * v) : 0})});
  }
  return worst;
}

std::filesystem::path samples() {
  for (auto at : {std::filesystem::path(__FILE__).parent_path(), std::filesystem::current_path()})
    for (at = std::filesystem::absolute(at); at.has_relative_path(); at = at.parent_path())
      if (std::filesystem::exists(at / "shared/fc3d/INDEX.tsv")) return at / "shared/fc3d";
  return {};
}

}  // namespace

TEST_CASE("problems in Siconos' text format come out as they went in, dense and in blocks") {
  generator random{std::mt19937_64(3)};
  const assembled_problem p = random_cluster(5, 9, 2, 1, random).problem();
  CHECK(same(fc3d::read_text(as_text(p, 1)), p));
  const assembled_problem dense = fc3d::read_text(as_text(p, 0));
  CHECK(same(dense, p));
  CHECK(fc3d::read_text("3 0 1 0 0").contacts() == 0);
}

TEST_CASE("compressed rows, compressed columns and triplets are the same matrix") {
  // [1 0 2 0 0 0; 0 3 ...]: elements (row, column, value) of 6 x 6
  const std::vector<std::tuple<int, int, double>> w{{0, 0, 1}, {0, 2, 2}, {1, 1, 3}, {2, 2, 4},
                                                    {2, 5, 5}, {3, 3, 6}, {4, 4, 7}, {5, 2, 8}};
  const auto make = [&](int nz) {
    auto sorted = w;
    if (nz == -1)
      std::sort(sorted.begin(), sorted.end(),
                [](const auto& a, const auto& b) { return std::get<1>(a) < std::get<1>(b); });
    std::vector<int> p(nz < 0 ? 7 : 0, 0), i;
    std::vector<double> x;
    for (const auto& [row, column, value] : sorted) {
      if (nz < 0) ++p[(nz == -1 ? column : row) + 1];
      if (nz >= 0) p.push_back(column);
      i.push_back(nz == -2 ? column : row);
      x.push_back(value);
    }
    if (nz < 0) std::partial_sum(p.begin(), p.end(), p.begin());
    return assemble(fc3d::compressed_blocks(nz, 6, p, i, x), {vec3::Ones(), vec3::Ones()},
                    {0.5, 0.5});
  };
  const auto rows = make(-2);
  CHECK(rows.own(0)(0, 2) == 2);
  CHECK(rows.block[1](2, 2) == 5);  // the block of contact 0 and 1
  CHECK(same(rows, make(-1)));
  CHECK(same(rows, make(static_cast<int>(w.size()))));
  CHECK_THROWS_AS(fc3d::compressed_blocks(-2, 6, {0, 1}, {0}, {1}), std::runtime_error);
  CHECK_THROWS_AS(fc3d::compressed_blocks(1, 6, {6}, {0}, {1}), std::runtime_error);
  CHECK_THROWS_AS(fc3d::compressed_blocks(-3, 6, {}, {}, {}), std::runtime_error);
}

TEST_CASE("damaged files are refused, and the message says what is wrong") {
  generator random{std::mt19937_64(4)};
  const std::string text = as_text(random_cluster(3, 4, 0, 1, random).problem(), 1);
  const std::string good = text.substr(0, text.rfind("0\nwhat"));
  int refused = 0;
  for (std::size_t length = 0; length < good.size() - 30; length += 7) {
    try {
      (void)fc3d::read_text(good.substr(0, length));
    } catch (const std::exception&) {
      ++refused;
    }
  }
  CHECK(refused == static_cast<int>((good.size() - 30 + 6) / 7));
  const auto says = [](const char* file, const char* words) {
    CHECK_THROWS_WITH(fc3d::read_text(file), doctest::Contains(words));
  };
  says("", "the file ends where the dimension should be");
  says("2 1 0", "the dimension should be in 3 to 3, but is 2");
  says("3 1 7", "the storage (0 dense, 1 blocks) should be in 0 to 1, but is 7");
  says("3 1 0 3 4", "the number of columns of W should be in 3 to 3, but is 4");
  says("3 1 0 3 3 3 3 1 0 0 0 x", "an element of W should be a number, but is 'x'");
  says("3 1 0 3 3 3 3 1 0 0 0 nan", "should be finite");
  says("3 1 0 3 3 3 3 1 0 0 0 1 0 0 0 1 -1 0 0 -0.5", "friction must be finite and >= 0");
  says("3 -1 0 3 3", "the number of contacts should be in 0");
  says("3 99999999999999999999 0 3 3", "should be an integer");
}

TEST_CASE("the error measures have the values computed by hand") {
  assembled_problem p = assemble({{0, 0, detail::diagonal_matrix(vec3(1, 2, 3))}}, {vec3(-1, 1, 0)},
                                 talus::detail::plain_vector<real>{0.5});
  // u = (1, 1, 0), û = (1.5, 1, 0); with rho = 1/2 the step lands inside of the cone, at
  // (1.25, -0.5, 0); with rho = 1 at (0.5, -1, 0), whose projection is (0.8, -0.4, 0).
  const contact_error e = error_of(p, {vec3(2, 0, 0)});
  CHECK(e.scaled == doctest::Approx(std::sqrt(0.8125) / 2).epsilon(1e-15));
  CHECK(e.by_q == doctest::Approx(std::sqrt(0.8)).epsilon(1e-15));
  CHECK(e.relative == doctest::Approx(std::sqrt(0.4)).epsilon(1e-15));
  // Sliding: u = (0, 0.5, 0)... r = (1, -0.5, 0) gives u = (0, 0, 0): exactly on the cone.
  CHECK(error_of(p, {vec3(1, -0.5, 0)}).scaled < 1e-16);
  p.q.set_zero(1);
  CHECK(error_of(p, {vec3(0, 0, 0)}).by_q == 0);
  // Scaling lengths, masses and times scales impulses and velocities apart; err_scaled stays.
  generator random{std::mt19937_64(5)};
  assembled_problem a = random_cluster(4, 8, 1, 1, random).problem();
  contact_vector r(a.contacts());
  for (int i = 0; i < a.contacts(); ++i) r(i) = {random(-1, 1), random(-1, 1), random(-1, 1)};
  const real before = error_of(a, r).scaled;
  for (auto& b : a.block) b *= 1e6;
  a.q *= 1e-3, r *= 1e-9;
  CHECK(error_of(a, r).scaled == doctest::Approx(before).epsilon(1e-12));
}

TEST_CASE("random problems are solved to 1e-6 and 1e-10, and what is handed back obeys the law") {
  const unsigned seed = 11;
  MESSAGE("seed ", seed);
  generator random{std::mt19937_64(seed)};
  std::vector<std::pair<std::string, assembled_problem>> all;
  for (const real mu : {0., 0.3, 2.})
    for (const real ratio : {1., 1e3, 1e6, 1e-4})
      for (const real push : {0., 0.04, 1.})
        all.emplace_back(fmt::format("stack of 10, ratio {}, mu {}, push {}", ratio, mu, push),
                         stack_of_boxes(10, ratio, mu, 2, {push, 0.3 * push, 0}).problem());
  all.emplace_back("16 contacts on a face", stack_of_boxes(4, 100, 0.5, 4, {0.03, 0, 0}).problem());
  all.emplace_back("wall", wall_of_boxes(4, 4, 0.6, random).problem());
  for (int k = 0; k < 30; ++k)
    all.emplace_back(fmt::format("cluster {}", k),
                     random_cluster(12, 30, k % 3, 0.5 + 0.25 * (k % 5), random).problem());
  for (int k = 0; k < 6; ++k) {
    auto p = random_cluster(12, 24, 1, 0.8, random).problem();
    for (auto& b : p.block)
      for (real& x : std::span(b.data(), 9)) x *= 1 + 1e-3 * random(-1, 1);
    all.emplace_back(fmt::format("asymmetric {}", k), p);
  }
  for (const real tolerance : {1e-6, 1e-10}) {
    int solved = 0;
    real furthest = 0, law = 0;
    for (const auto& [name, p] : all) {
      CAPTURE(name);
      contact_vector r;
      const auto result = solve_assembled(p, r, tolerance, 5000);
      const real e = error_of(p, r).scaled;
      CHECK(result.error == doctest::Approx(e).epsilon(1e-6));
      CHECK(result.converged);
      if (!result.converged) continue;
      ++solved;
      furthest = std::max(furthest, e);
      const real violation = worst_violation(p, r);
      law = std::max(law, violation);
      CHECK(violation < std::max(10 * std::sqrt(tolerance), 1e-5));
      // From its own solution there is nothing to improve.
      CHECK(solve_assembled(p, r, tolerance).iterations == 0);
    }
    MESSAGE("tolerance ", tolerance, ": ", solved, " of ", all.size(), ", largest error ", furthest,
            ", largest violation of the law ", law);
  }
}

TEST_CASE("a solver that may not go on, or that has no solution to find, says that it failed") {
  generator random{std::mt19937_64(13)};
  int given_up = 0;
  for (int k = 0; k < 20; ++k) {
    const auto p = random_cluster(12, 40, 2, 1, random).problem();
    for (const int most : {0, 1, 5, 20}) {
      contact_vector r;
      const auto result = solve_assembled(p, r, 1e-12, most);
      CHECK(result.converged == (error_of(p, r).scaled <= 1e-12));
      given_up += result.converged ? 0 : 1;
    }
    contact_vector r;
    CHECK_FALSE(solve_assembled(p, r, 1e-6, 1000, [] { return false; }).converged);
  }
  CHECK(given_up > 40);
  // Nothing is compliant: W is zero, and the bodies approach.
  assembled_problem p = assemble({}, {vec3(-1, 0.2, 0)}, talus::detail::plain_vector<real>{0.5});
  contact_vector r;
  auto result = solve_assembled(p, r, 1e-6, 500);
  CHECK_FALSE(result.converged);
  CHECK(r.is_finite());
  // A body between two walls that both approach.
  contact_scene s;
  s.box(1, {1, 1, 1}, {0, 0, 0});
  s.contacts.push_back({0, -1, {-0.5, 0, 0}, {1, 0, 0}, 0.3, 1});
  s.contacts.push_back({0, -1, {0.5, 0, 0}, {-1, 0, 0}, 0.3, 1});
  p = s.problem();
  result = solve_assembled(p, r, 1e-6, 500);
  CHECK_FALSE(result.converged);
  CHECK(r.is_finite());
  // It continues as long as allowed.
  int asked = 0;
  CHECK_FALSE(
      solve_assembled(p, r, 1e-6, 1'000'000'000, [&] { return ++asked < 50'000; }).converged);
  CHECK(asked >= 50'000);
  // A contact of two fixed bodies at rest has no effect.
  p = assemble({}, {vec3(0, 0, 0)}, talus::detail::plain_vector<real>{0.5});
  CHECK(solve_assembled(p, r, 1e-6).converged);
}

TEST_CASE("the sample of third-party problems is solved to 1e-6 and to 1e-10") {
  const auto folder = samples();
  if (folder.empty()) {
    MESSAGE("no ../shared/fc3d here: skipped");
    return;
  }
  for (const real tolerance : {1e-6, 1e-10}) {
    int count = 0, solved = 0;
    for (const auto& file : std::filesystem::directory_iterator(folder)) {
      if (file.path().extension() != ".dat") continue;
      CAPTURE(file.path().string());
      const auto p = fc3d::read_text(fc3d::contents(file.path().string()));
      ++count;
      contact_vector r;
      const auto result = solve_assembled(p, r, tolerance, 20000);
      CHECK(result.converged);
      CHECK(result.converged == (error_of(p, r).scaled <= tolerance));
      CHECK(worst_violation(p, r) < std::max(10 * std::sqrt(tolerance), 1e-5));
      solved += result.converged ? 1 : 0;
    }
    talus::validation::check_absolute("third-party problems",
                                      fmt::format("solved to {}", tolerance), count, solved, 0);
  }
}
