#pragma once
// Fields from bodies: density, velocity and stress on a grid.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/core/binned_sum.hpp"
#include "talus/core/error.hpp"
#include "talus/core/field_names.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// A box of space divided into equal cells.
struct field_grid {
  vec3 lower{0, 0, 0}, upper{1, 1, 1};  ///< corners, lengths
  std::array<int, 3> cells{1, 1, 1};    ///< along x, y and z

  /// Throws invalid_argument for a box without volume, and for fewer than one cell or more than a
  /// billion.
  void validate() const {
    if (!detail::finite(lower) || !detail::finite(upper) || !(upper[0] > lower[0]) ||
        !(upper[1] > lower[1]) || !(upper[2] > lower[2]))
      detail::fail<std::invalid_argument>(
          "a field_grid needs a lower and an upper corner with a volume between them, but has {} "
          "and {}",
          lower, upper);
    double all = 1;
    for (const int n : cells) all *= n > 0 ? n : 0;
    if (!(all >= 1 && all <= 1e9))
      detail::fail<std::invalid_argument>(
          "a field_grid has from 1 to a billion cells, but was given {} times {} times {}",
          cells[0], cells[1], cells[2]);
  }
  /// Number of cells.
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(cells[0]) * static_cast<std::size_t>(cells[1]) *
           static_cast<std::size_t>(cells[2]);
  }
  /// Edges of a cell, lengths.
  [[nodiscard]] vec3 cell_size() const {
    vec3 h = upper - lower;
    for (int k = 0; k < 3; ++k) h[k] /= cells[static_cast<std::size_t>(k)];
    return h;
  }
  /// Index of a cell; x varies fastest.
  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(cells[0]) *
               (static_cast<std::size_t>(j) +
                static_cast<std::size_t>(cells[1]) * static_cast<std::size_t>(k));
  }
  /// Index of the cell that contains a point, or size().
  [[nodiscard]] std::size_t cell_of(const vec3& p) const {
    const vec3 h = cell_size();
    int at[3];
    for (int k = 0; k < 3; ++k) {
      const real x = std::floor((p[k] - lower[k]) / h[k]);
      if (!(x >= 0 && x < cells[static_cast<std::size_t>(k)])) return size();
      at[k] = static_cast<int>(x);
    }
    return index(at[0], at[1], at[2]);
  }
};

/// Means over the cells of a grid: the coarse graining of Goldhirsch (Granular Matter 12, 239,
/// 2010) with the cell itself as the coarse-graining function, so that integrals over cells are
/// exact. A body counts in the cell where its centre is. Stress is positive in tension: in a heap
/// at rest its zz component is minus the weight above a unit of area.
class coarse_fields {
 public:
  /// All zero, to which states are added: of no sample, or of one that is filled in later. Throws
  /// invalid_argument for an invalid grid.
  explicit coarse_fields(const field_grid& g, std::uint64_t samples = 0)
      : grid_((g.validate(), g)), sums_(g.size() * width), samples_(samples) {}

  /// The grid of the fields.
  [[nodiscard]] const field_grid& grid() const { return grid_; }
  /// The number of states in the means.
  [[nodiscard]] std::uint64_t samples() const { return samples_; }

  // The following functions return the values of cell `c`.

  /// Bodies that can move, in the mean over the samples.
  [[nodiscard]] double bodies(std::size_t c) const { return sum(c, count) / samples(1); }
  /// Mean mass in a cell.
  [[nodiscard]] double mass(std::size_t c) const { return sum(c, masses) / samples(1); }
  /// Mean mass in a cell over its volume.
  [[nodiscard]] double density(std::size_t c) const { return mass(c) / volume(); }
  /// The volume fraction of bodies.
  [[nodiscard]] double solid_fraction(std::size_t c) const {
    return sum(c, volumes) / (samples(1) * volume());
  }
  /// Mean velocity of the mass in a cell; zero without mass.
  [[nodiscard]] vec3 velocity(std::size_t c) const {
    const double m = sum(c, masses);
    if (!(m > 0)) return {0, 0, 0};
    return {sum(c, momenta) / m, sum(c, momenta + 1) / m, sum(c, momenta + 2) / m};
  }
  /// Stress by motion relative to the mean velocity of the cell (over the samples, too), force per
  /// area.
  [[nodiscard]] mat3 kinetic_stress(std::size_t c) const {
    const double m = sum(c, masses);
    const vec3 v = velocity(c);
    mat3 stress;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        stress(i, j) = -(sum(c, flux, i, j) - m * v[i] * v[j]) / (samples(1) * volume());
    return stress;
  }
  /// Stress by contact forces, force per area. The forces act along the lines from centre to
  /// centre, or from a centre to the contact point with something immovable; each line counts with
  /// the part of it that lies in the cell.
  [[nodiscard]] mat3 contact_stress(std::size_t c) const {
    mat3 stress;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) stress(i, j) = -sum(c, virial, i, j) / (samples(1) * volume());
    return stress;
  }
  /// Stress, force per area, positive in tension.
  [[nodiscard]] mat3 stress(std::size_t c) const { return kinetic_stress(c) + contact_stress(c); }
  /// A third of the trace of the stress, and positive in compression.
  [[nodiscard]] double pressure(std::size_t c) const {
    const mat3 s = stress(c);
    return -(s(0, 0) + s(1, 1) + s(2, 2)) / 3;
  }

  /// The means over the samples of both. Throws invalid_argument for another grid.
  coarse_fields& operator+=(const coarse_fields& other) {
    if (grid_.lower != other.grid_.lower || grid_.upper != other.grid_.upper ||
        grid_.cells != other.grid_.cells)
      detail::fail<std::invalid_argument>(
          "fields on two grids were added, that from {} to {} and that from {} to {}: means are "
          "taken on one grid",
          grid_.lower, grid_.upper, other.grid_.lower, other.grid_.upper);
    for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += other.sums_[i];
    samples_ += other.samples_;
    return *this;
  }

  // The accumulation of one state in measure_fields().

  void add_body(const vec3& centre, const vec3& v, double mass, double volume) {
    const std::size_t c = grid_.cell_of(centre);
    if (c == grid_.size()) return;
    detail::binned_sum* s = &sums_[c * width];
    s[count] += 1, s[masses] += mass, s[volumes] += volume;
    for (int i = 0; i < 3; ++i) {
      s[momenta + i] += mass * v[i];
      for (int j = 0; j < 3; ++j) s[flux + 3 * i + j] += mass * v[i] * v[j];
    }
  }
  /// A force on a body at `head`, from a body or point at `tail`.
  void add_force(const vec3& head, const vec3& tail, const vec3& force) {
    const vec3 line = head - tail, h = grid_.cell_size();
    cuts_.clear();
    cuts_.push_back(0), cuts_.push_back(1);
    for (int k = 0; k < 3; ++k) {
      if (line[k] == 0) continue;
      const int planes = grid_.cells[static_cast<std::size_t>(k)];
      const auto number = [&](real x) {
        return static_cast<int>(
            std::clamp((x - grid_.lower[k]) / h[k], real(-1), real(planes) + 1));
      };
      const int a = number(tail[k]), b = number(head[k]);
      for (int n = std::max(0, std::min(a, b)); n <= std::min(planes, std::max(a, b) + 1); ++n) {
        const real s = (grid_.lower[k] + n * h[k] - tail[k]) / line[k];
        if (s > 0 && s < 1) cuts_.push_back(s);
      }
    }
    detail::sort_values(cuts_);
    for (std::size_t n = 1; n < cuts_.size(); ++n) {
      const real part = cuts_[n] - cuts_[n - 1];
      const std::size_t c = grid_.cell_of(tail + 0.5 * (cuts_[n] + cuts_[n - 1]) * line);
      if (!(part > 0) || c == grid_.size()) continue;
      detail::binned_sum* s = &sums_[c * width];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) s[virial + 3 * i + j] += force[i] * line[j] * part;
    }
  }
  /// Replaces the sums of this rank by those of all ranks, alike to the bit on any ranks.
  template <class Link>
  void add_ranks(Link& link) {
    if (link.size() == 1) return;
    constexpr std::size_t most = 65536;  // at a time
    detail::plain_vector<std::uint64_t> numbers;
    for (std::size_t first = 0; first < sums_.size(); first += most) {
      const std::span some(sums_.data() + first, std::min(most, sums_.size() - first));
      numbers.clear();
      for (const auto& x : some) numbers.push_back(x.top());
      link.reduce(reduction::max, std::span<std::uint64_t>(numbers.data(), numbers.size()));
      for (std::size_t i = 0; i < some.size(); ++i) some[i].raise(numbers[i]);
      numbers.clear();
      for (auto& x : some)
        for (const std::uint64_t digit : x.digits()) numbers.push_back(digit);
      link.reduce(reduction::sum, std::span<std::uint64_t>(numbers.data(), numbers.size()));
      const std::uint64_t* next = numbers.data();
      for (auto& x : some)
        for (std::uint64_t& digit : x.digits()) digit = *next++;
    }
  }

 private:
  enum column : std::size_t {
    count,
    masses,
    volumes,
    momenta,
    flux = momenta + 3,
    virial = flux + 9,
    width = virial + 9
  };
  [[nodiscard]] double sum(std::size_t c, std::size_t k) const {
    return sums_[c * width + k].value();
  }
  [[nodiscard]] double sum(std::size_t c, std::size_t matrix, int i, int j) const {
    return sum(c, matrix + static_cast<std::size_t>(3 * i + j));
  }
  [[nodiscard]] double samples(std::uint64_t least) const {
    return static_cast<double>(std::max(samples_, least));
  }
  [[nodiscard]] double volume() const {
    const vec3 h = grid_.cell_size();
    return h[0] * h[1] * h[2];
  }

  field_grid grid_;
  detail::plain_vector<detail::binned_sum> sums_;
  detail::plain_vector<real> cuts_;
  std::uint64_t samples_;
};

/// Collective: the fields of the present state, alike on all ranks. Fixed and global bodies
/// contribute only by the forces that they exert. The sums over bodies, contacts, ranks and samples
/// do not depend on their order: bodies in the same state give the same bits on any ranks. Reduces
/// 24 numbers for each cell over the ranks, and then 96. Throws invalid_argument for an invalid
/// grid.
template <class Scenario>
[[nodiscard]] coarse_fields measure_fields(world<Scenario>& w, const field_grid& grid) {
  w.require_all_ranks("measure_fields");
  coarse_fields fields(grid, 1);
  w.for_each_local([&](const auto& b) {
    if (!b.is_fixed()) fields.add_body(b.position(), b.velocity(), b.mass(), b.shape().volume());
  });
  for_each_contact(w, [&](const loaded_contact& c) {
    if (c.moves_a && c.moves_b)
      fields.add_force(c.centre_a, c.centre_b, c.force);
    else if (c.moves_a)
      fields.add_force(c.centre_a, c.point, c.force);
    else
      fields.add_force(c.centre_b, c.point, -c.force);
  });
  fields.add_ranks(w.link());
  return fields;
}

/// Refuses other fields.
template <class Scenario, detail::sentence Fields = detail::fields::field_grid>
detail::fields::no_field_grid<Fields> measure_fields(world<Scenario>&, ...) TALUS_REFUSED;

}  // namespace talus
