#pragma once
// The algorithm of check_connections.
#include <algorithm>

#include "talus/core/id.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/parallel/connection.hpp"
#include "talus/parallel/connection_flaw.hpp"

namespace talus::detail {

/// Whether a flaw of this kind between these ranks is in the list already.
bool known(const std::vector<connection_flaw>& flaws, const connection_flaw& f);

std::string summary(const std::vector<connection_flaw>& flaws);

/// Ownership by hand: a rank owns the points that no connected rank claims.
struct hand_rule {
  static constexpr bool generated = false;
  std::span<const std::vector<connection>> all;
  /// The owner according to a rank.
  [[nodiscard]] int owner(int rank, const vec3& p) const;
  [[nodiscard]] std::vector<int> neighbours(int) const { return {}; }
};

/// Ownership by a partition, the same on all ranks.
template <class Partition>
struct partition_rule {
  static constexpr bool generated = true;
  const Partition& cells;
  [[nodiscard]] int owner(int, const vec3& p) const { return cells.owner(p); }
  [[nodiscard]] std::vector<int> neighbours(int rank) const { return cells.neighbours(rank, 0); }
};

template <class Rule>
class connection_checker {
 public:
  connection_checker(std::span<const std::vector<connection>> all, const Rule& rule,
                     const connection_check& settings)
      : all_(all), rule_(rule), settings_(settings), state_(settings.seed) {}

  std::vector<connection_flaw> run() {
    settings_.last = std::min(settings_.last, ranks());
    for (int rank = settings_.first; rank < settings_.last; ++rank) compare(rank);
    for (int rank = settings_.first; rank < settings_.last; ++rank) sample(rank);
    return std::move(flaws_);
  }

 private:
  [[nodiscard]] int ranks() const { return static_cast<int>(all_.size()); }
  [[nodiscard]] const connection* find(int from, int to) const {
    for (const connection& c : all_[from])
      if (c.rank == to) return &c;
    return nullptr;
  }
  /// Reports a flaw unless there is one of that kind between the ranks; `message()` words it.
  template <class Message>
  void report(flaw kind, int rank, int other, const vec3& at, Message&& message) {
    connection_flaw f{kind, rank, other, at, {}};
    if (known(flaws_, f)) return;
    f.message = message();
    flaws_.push_back(std::move(f));
  }

  /// One-sided connections, from the lists alone, and missing ones as far as the rule determines
  /// them.
  void compare(int rank) {
    for (const connection& c : all_[rank]) {
      if (find(c.rank, rank)) continue;
      const auto planes = c.geometry.planes();
      vec3 at(0, 0, 0);
      if (!planes.empty()) at += planes[0].normal() * planes[0].displacement();
      report(flaw::one_sided, rank, c.rank, at, [&] {
        return compose(
            "rank {0} is connected to rank {1}, but rank {1} is not connected to rank "
            "{0} (boundary {2}, for instance at {3}): call connect({0}, ...) on rank "
            "{1} with the region of rank {0}, or disconnect({1}) on rank {0}",
            rank, c.rank, to_string(c.geometry), text(at));
      });
    }
    for (const int other : rule_.neighbours(rank))
      if (!find(rank, other) && !find(other, rank))
        report(flaw::missing, rank, other, {0, 0, 0}, [&] {
          return compose(
              "ranks {0} and {1} are neighbours in the decomposition, but they are not connected: "
              "call connect({1}, ...) on rank {0} and connect({0}, ...) on rank {1}",
              rank, other);
        });
  }

  void sample(int rank) {
    // Both versions of each boundary: that of this rank and those of the others.
    plain_vector<half_space> planes;
    for (const connection& c : all_[rank]) {
      planes.append(c.geometry.planes());
      if (const connection* back = find(c.rank, rank)) planes.append(back->geometry.planes());
    }
    for (half_space& h : planes)
      if (!h.faces_up()) h = h.flipped();
    sort_values(planes);
    planes.erase(std::unique(planes.begin(), planes.end()), planes.end());

    vec3 low(0, 0, 0), high(0, 0, 0);
    bool any = false;
    for (const connection& c : all_[rank])
      for (const half_space& h : c.geometry.planes()) {
        const vec3 foot = h.normal() * h.displacement();
        low = any ? lower_of(low, foot) : foot;
        high = any ? upper_of(high, foot) : foot;
        any = true;
      }
    const vec3 centre = low + (high - low) / 2;
    size_ = (high - low).norm();
    if (!(size_ > 0)) size_ = std::max(real(1), centre.norm());
    gather_candidates(rank);

    const std::size_t samples = std::max<std::size_t>(settings_.samples, 4 * planes.size());
    for (std::size_t i = 0; i < samples; ++i) {
      vec3 p = centre + size_ * vec3(symmetric(), symmetric(), symmetric());
      const auto& list = all_[rank];
      plain_vector<half_space> at;
      if (!planes.empty()) at.push_back(planes[i % planes.size()]);
      if (!list.empty() && i % 2 == 1) {
        // Near one neighbour, where faces may be small against the size of everything.
        const connection& c = list[next() % list.size()];
        pull(p, c.geometry);
        if (const auto near = c.geometry.planes(); !near.empty())
          at[0] = near[next() % near.size()];
      }
      for (auto more = next() % 3; more > 0 && !planes.empty(); --more)
        at.push_back(planes[next() % planes.size()]);
      examine(rank, p, at);
    }
  }

  /// Moves a point approximately into an intersection of half-spaces, not onto its boundary.
  void pull(vec3& p, const any_geometry& g) {
    for (int sweep = 0; g.convex() && sweep < 8; ++sweep)
      for (const half_space& h : g.planes())
        if (const real v = h.value(p); v < 0) p -= (1.5 + symmetric() / 2) * v * h.normal();
  }

  /// Puts the point onto the planes, as far as they intersect, and tests it and points beside it.
  void examine(int rank, vec3 p, const plain_vector<half_space>& planes) {
    plain_vector<vec3> across;  // orthonormal; moving along the last keeps the planes before it
    bool exact = true;
    for (int pass = 0; pass < 2; ++pass) {
      across.clear();
      for (const half_space& h : planes) {
        const vec3 n = h.normal();
        vec3 u = n;
        for (const vec3& e : across) u -= n.dot(e) * e;
        if (u.norm() < 1e-3) continue;
        u.normalize();
        p -= h.value(p) / n.dot(u) * u;
        across.push_back(u);
        exact = exact && max_norm(n) == 1;
      }
    }
    // The intersection of oblique planes is known to round-off only, so keep a distance from it.
    const real far = std::max(size_, max_norm(p));
    if (exact || across.size() == 1) {
      unique(rank, p);
      around(rank, p, across, 4e-16 * far, false);
    }
    around(rank, p, across, 1e-13 * far, false);
    around(rank, p, across, 1e-11 * far, true);
  }

  void around(int rank, const vec3& p, const plain_vector<vec3>& across, real step, bool adjacent) {
    plain_vector<plain_pair<vec3, int>> points;
    for (unsigned signs = 0; signs < 1u << across.size(); ++signs) {
      vec3 q = p;
      for (std::size_t k = 0; k < across.size(); ++k)
        q += (signs >> k & 1 ? step : -step) * across[k];
      if (const int owner = unique(rank, q); owner >= 0) points.push_back({q, owner});
    }
    for (std::size_t i = 0; adjacent && i < points.size(); ++i)
      for (const auto& [q, owner] : points)
        if (points[i].second != owner) sees(points[i].second, owner, q);
  }

  /// All ranks that may own points near this one: all ranks in a small job.
  void gather_candidates(int rank) {
    candidates_.clear();
    if (ranks() <= 64) {
      for (int r = 0; r < ranks(); ++r) candidates_.push_back(r);
      return;
    }
    candidates_.push_back(rank);
    for (const connection& c : all_[rank]) {
      candidates_.push_back(c.rank);
      for (const connection& d : all_[c.rank]) candidates_.push_back(d.rank);
    }
    std::sort(candidates_.begin(), candidates_.end());
    candidates_.erase(std::unique(candidates_.begin(), candidates_.end()), candidates_.end());
  }

  /// The one owner of a point; -1, and a report, if there are more or none.
  int unique(int rank, const vec3& p) {
    if (Rule::generated) return rule_.owner(rank, p);
    int found = -1;
    for (const int r : candidates_) {
      if (rule_.owner(r, p) != r) continue;
      if (found >= 0) {
        overlap(found, r, p);
        return -1;
      }
      found = r;
    }
    if (found < 0) {
      for (int r = 0; r < ranks(); ++r)
        if (rule_.owner(r, p) == r) return -1;  // a distant rank: not checked by this one
      gap(rank, p);
    }
    return found;
  }

  void overlap(int a, int b, const vec3& p) {
    if (!find(a, b) && !find(b, a)) {
      report(flaw::missing, a, b, p, [&] {
        return compose(
            "ranks {0} and {1} both own the point {2}, and they are not connected: "
            "call connect({1}, ...) on rank {0} and connect({0}, ...) on rank {1}",
            a, b, text(p));
      });
    } else if (find(a, b) && find(b, a) && !explain(a, b, p, "both ranks own")) {
      report(flaw::overlap, a, b, p, [&] {
        return compose(
            "ranks {} and {} both own the point {}: the region that one of them gives "
            "for the other must contain it ({}); make the two regions complementary",
            a, b, text(p), pictures(a, b));
      });
    }
  }

  void gap(int rank, const vec3& p) {
    // Follow the owners until two ranks assign the point to each other, or a circle closes.
    int a = rank, b = rule_.owner(rank, p);
    for (int hops = 0; hops < ranks() && rule_.owner(b, p) != a; ++hops)
      a = std::exchange(b, rule_.owner(b, p));
    if (!find(a, b) || !find(b, a)) return;  // reported as one-sided
    if (explain(a, b, p, "none of the ranks owns")) return;
    report(flaw::gap, a, b, p, [&] {
      return compose(
          "no rank owns the point {}: rank {} leaves it to rank {}, which leaves it to "
          "rank {} ({}); make the two regions complementary",
          text(p), a, b, rule_.owner(b, p), pictures(a, b));
    });
  }

  /// Reports a boundary near p that the two ranks define differently, if it is the cause.
  bool explain(int a, int b, const vec3& p, const char* consequence) {
    const connection* to = find(a, b);
    const connection* back = find(b, a);
    const auto ours = to->geometry.planes(), theirs = back->geometry.planes();
    bool agree = false;  // on some plane, so that another one may well be common to both regions
    for (const half_space& h : ours)
      agree |= std::find(theirs.begin(), theirs.end(), h.flipped()) != theirs.end();
    const auto blame = [&](const half_space& h, const half_space& g, bool opposite) {
      const half_space other = opposite ? g.flipped() : g;
      const real turn = (other.normal() - h.normal()).norm();
      const real shift = std::abs(other.displacement() - h.displacement());
      const real off = std::min(std::abs(h.value(p)), std::abs(g.value(p)));
      if (other == h ? opposite : turn > 1e-3 || shift > 0.05 * size_) return false;
      if (off > 1e-6 * size_) return false;
      report(flaw::mismatch, a, b, p, [&] {
        return opposite ? compose(
                              "ranks {0} and {1} draw their boundary differently: rank {0} gives "
                              "{2}, rank {1} gives {3}, which is {4} off; {5} the point {6}; "
                              "use the same numbers on both ranks, all signs reversed",
                              a, b, to_string(h), to_string(g), text(std::max(shift, turn), 3),
                              consequence, text(p))
                        : compose(
                              "ranks {0} and {1} place each other on the same side of a plane: "
                              "rank {0} gives {2}, and rank {1} gives {3}; {4} the point {5}; "
                              "the normal points towards the remote rank: reverse all signs on "
                              "one of the two",
                              a, b, to_string(h), to_string(g), consequence, text(p));
      });
      return true;
    };
    for (const half_space& h : ours)
      for (const half_space& g : theirs)
        if (blame(h, g, true) || (!agree && blame(h, g, false))) return true;
    return false;
  }

  /// A point that belongs to `owner`, right beside `rank`, must belong to it according to `rank`
  /// too.
  void sees(int rank, int owner, const vec3& p) {
    const connection* to = find(rank, owner);
    if (!to) {
      if (!Rule::generated && !find(owner, rank))
        report(flaw::missing, rank, owner, p, [&] {
          return compose(
              "ranks {0} and {1} meet at {2}, where bodies can pass from one to the "
              "other, but they are not connected: call connect({1}, ...) on rank {0} "
              "and connect({0}, ...) on rank {1}",
              rank, owner, text(p));
        });
      return;
    }
    if (const int seen = rule_.owner(rank, p);
        seen != owner || to->geometry.value(p) < -1e-12 * (size_ + max_norm(p)))
      report(flaw::mismatch, rank, owner, p, [&] {
        return compose(
            "the point {} belongs to rank {}, but in the eyes of rank {}, right beside "
            "it, it {}: correct the region that rank {} gives for rank {} ({})",
            text(p), owner, rank,
            seen != owner ? compose("belongs to rank {}", seen)
                          : std::string("lies outside of the region given for it"),
            rank, owner, to_string(to->geometry));
      });
  }

  [[nodiscard]] std::string pictures(int a, int b) const {
    return compose("rank {} gives {} for rank {}, and rank {} gives {} for rank {}", a,
                   to_string(find(a, b)->geometry), b, b, to_string(find(b, a)->geometry), a);
  }

  std::uint64_t next() { return mix(state_++); }
  real symmetric() { return static_cast<real>(next() >> 11) * 0x1p-52 - 1; }  // in [-1, 1)

  std::span<const std::vector<connection>> all_;
  const Rule& rule_;
  connection_check settings_;
  std::uint64_t state_;
  real size_ = 1;
  std::vector<int> candidates_;
  std::vector<connection_flaw> flaws_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/parallel/detail/check_connections_definitions.hpp"
#endif
