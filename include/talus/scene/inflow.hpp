#pragma once
// Inflow of bodies during a run: a number of bodies, or a mass, per unit of time, at random free
// places of a region.
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "talus/body/body.hpp"
#include "talus/body/features.hpp"
#include "talus/body/mass.hpp"
#include "talus/core/error.hpp"
#include "talus/core/field_names.hpp"
#include "talus/core/random.hpp"
#include "talus/detect/narrow.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/scenario/made_bodies.hpp"
#include "talus/scene/detail/run_guard.hpp"
#include "talus/scene/region.hpp"
#include "talus/scene/site.hpp"
#include "talus/state/periodic_ghosts.hpp"
#include "talus/world/body_checks.hpp"
#include "talus/world/state_of.hpp"

namespace talus {

/// Settings of insert_by_rate. One of `bodies` and `mass` is positive, the other zero.
struct inflow {
  real bodies = 0;                                                 ///< number per unit of time
  real mass = 0;                                                   ///< mass per unit of time
  real from = 0;                                                   ///< time at which it begins
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();  ///< bodies, in all
  int tries = 20;               ///< places tried for a body in one step
  std::string name = "inflow";  ///< of its random numbers and in checkpoints: one for each inflow
};

/// Bodies and mass inserted so far; the same on all ranks.
struct inserted {
  std::uint64_t count = 0;  ///< of bodies
  real mass = 0;            ///< of these
};

namespace detail {

/// A number of a name for random_stream, unlike those of others (FNV-1a; 0 is that of fill).
[[nodiscard, gnu::cold]] inline std::uint32_t purpose_of(const std::string& name, bool second) {
  std::uint32_t h = 2166136261u;
  for (const char c : name) h = (h ^ static_cast<unsigned char>(c)) * 16777619u;
  return h << 2 | 2u | second;
}

/// A body, or a variant of bodies.
template <class T>
inline constexpr bool is_made_body = false;
template <class Shape>
inline constexpr bool is_made_body<body<Shape>> = true;
template <class... Bodies>
inline constexpr bool is_made_body<std::variant<Bodies...>> = (is_made_body<Bodies> && ...);

/// The argument of insert_by_rate: a function of a site and random numbers, and its result.
template <class Make>
inline constexpr bool takes_site = std::is_invocable_v<Make&, const site&, random_stream&>;
template <class Make>
consteval bool makes_bodies() {
  if constexpr (takes_site<Make>)
    return is_made_body<std::invoke_result_t<Make&, const site&, random_stream&>>;
  else
    return false;
}

/// The first shape of its bodies that the scenario does not name; else void.
template <class World, class Make>
using missing_in_inflow = missing_in_result_t<typename World::scenario_type, site, Make>;

template <class World, class Region, class Make>
class inserter {
  using made = std::invoke_result_t<Make&, const site&, random_stream&>;

 public:
  inserter(World& w, const inflow& how, Region region, Make make)
      : w_(&w), how_(how), region_(std::move(region)), make_(std::move(make)) {
    if (!((how.bodies > 0) != (how.mass > 0)) || !(how.bodies >= 0 && how.mass >= 0) ||
        !std::isfinite(how.bodies + how.mass))
      fail<std::invalid_argument>(
          "an inflow has so many bodies or so much mass per unit of time, one of them positive, "
          "but "
          "'{}' has {} and {}",
          how.name, how.bodies, how.mass);
    if (how.tries < 1)
      fail<std::invalid_argument>("an inflow tries at least one place for a body, but '{}' {}",
                                  how.name, how.tries);
    const region_extent extent = extent_of(region_);
    lower_ = extent.lower, upper_ = extent.upper;
    for (int k = 0; k < 3; ++k)
      if (!std::isfinite(lower_[k]) || !std::isfinite(upper_[k]) || !(lower_[k] <= upper_[k]))
        fail<std::invalid_argument>(
            "the region of the inflow '{}' must have bounds and lie between them, but goes from {} "
            "to {}: intersect it with a box_region",
            how.name, lower_, upper_);
  }
  [[nodiscard]] inserted& count() { return count_; }

  /// Adds the bodies that are due, in the order of their numbers, each at the first of its places
  /// that is free. The first one without a free place ends the step, so bodies are tried in
  /// batches: one more than the previous step placed, then twice as many. The cost of a step does
  /// not depend on the number of waiting bodies. Collective if any is due: one reduction for each
  /// batch.
  void insert() {
    const real time = w_->time() - how_.from;
    random_stream places(w_->seed(), w_->steps(), purpose_of(how_.name, true));
    inserted due = count_;
    std::vector<candidate> placed, batch;
    bool waits = false;
    std::size_t tried = 0, bodies = last_placed_ + 1;
    for (bool more = true; more && !waits; bodies *= 2) {
      batch.clear();
      for (std::size_t k = 0; more && k < bodies; ++k)
        more = tried + batch.size() < most_at_once && add_due(places, time, due, batch);
      if (batch.empty()) break;
      tried += batch.size();
      waits = !place(batch, placed);
    }
    for (const candidate& c : placed)
      with(c.what, [&](const auto& b) { (void)w_->add_if_local(b); });
    last_placed_ = placed.size();
    if (!placed.empty()) waits_ = 0, since_ = w_->time();
    if (waits) mention_waiting();
  }

 private:
  static constexpr std::size_t most_at_once = 20000;  ///< places in a step
  static constexpr std::uint64_t patience = 1000;     ///< steps without room before a warning
  struct candidate {
    made what;
    std::uint64_t number;
  };

  /// Appends the places of the next body to `batch` if that body is due.
  bool add_due(random_stream& places, real time, inserted& due, std::vector<candidate>& batch) {
    if (due.count >= how_.most) return false;
    candidate first = candidate_at(somewhere(places), due.count);
    const real mass = mass_of(first);
    if (how_.bodies > 0 ? static_cast<real>(due.count) + 1 > how_.bodies * time
                        : due.mass + mass > how_.mass * time)
      return false;
    batch.push_back(std::move(first));
    for (int k = 1; k < how_.tries; ++k)
      batch.push_back(candidate_at(somewhere(places), due.count));
    ++due.count, due.mass += mass;
    return true;
  }
  candidate candidate_at(const vec3& p, std::uint64_t number) {
    const site place{.position = p, .index = number};
    random_stream random(w_->seed(), number, purpose_of(how_.name, false));
    candidate made{make_(place, random), number};
    with(made.what, [&](auto& b) {
      if (!((b.position - p).norm() <= b.shape.bounding_radius()))
        fail<std::invalid_argument>(
            "body {} of the inflow '{}' is made at {}, away from its site at {}: give it .position "
            "= site.position",
            number, how_.name, b.position, p);
      require_sane(b, w_->materials());
      b = with_own_inertia(b, w_->materials());
    });
    return made;
  }
  vec3 somewhere(random_stream& random) const {
    for (int k = 0; k < 100000; ++k)
      if (const vec3 p = random.uniform(lower_, upper_); region_.contains(p)) return p;
    fail<std::runtime_error>(
        "the region of the inflow '{}' is empty, or hardly fills its bounds from {} to {}",
        how_.name, lower_, upper_);
  }
  template <class What, class F>
  static void with(What&& what, F&& f) {
    if constexpr (requires { what.valueless_by_exception(); })
      std::visit(f, what);
    else
      f(what);
  }
  real mass_of(const candidate& c) const {
    real mass = 0;
    with(c.what, [&](const auto& b) { mass = detail::mass_of(b, w_->materials()); });
    return mass;
  }
  bool overlap(const candidate& x, const candidate& y) const {
    bool found = false;
    with(x.what, [&](const auto& a) {
      with(y.what, [&](const auto& b) {
        collide_pair(
            a.shape, pose{a.position, a.orientation}, b.shape,
            pose{detail::seen_from(detail::view_of(*w_), a.position, b.position), b.orientation}, 0,
            [&](const contact_geometry& g) { found = found || g.gap < 0; });
      });
    });
    return found;
  }
  /// Puts each body at the first of its places that is free. Returns whether all have found one. A
  /// body without a free place waits, and so do those behind it; otherwise small sizes would be
  /// preferred.
  bool place(std::vector<candidate>& batch, std::vector<candidate>& placed) {
    std::vector<std::uint64_t> taken;
    for (const candidate& c : batch)
      with(c.what, [&](const auto& b) {
        taken.push_back(w_->overlaps(b.shape, b.position, b.orientation));
      });
    w_->link().reduce(reduction::max, std::span(taken));
    const std::uint64_t last = batch.back().number;
    for (std::size_t k = 0; k < batch.size(); ++k) {
      candidate& c = batch[k];
      if (count_.count > c.number) continue;  // it has found a place
      if (c.number > count_.count) break;     // the one before has not
      if (taken[k] != 0) continue;
      bool free = true;
      for (const candidate& other : placed) free = free && !overlap(c, other);
      if (!free) continue;
      ++count_.count, count_.mass += mass_of(c);
      placed.push_back(std::move(c));
    }
    return count_.count > last;
  }
  [[gnu::cold]] void mention_waiting() {
    const bool long_since = how_.bodies == 0 || (w_->time() - since_) * how_.bodies > 10;
    if (++waits_ > patience && long_since && !std::exchange(said_, true) && w_->rank() == 0)
      say_in_run(
          compose("the inflow '{}' has found no room for its body {} in {} steps, and waits: "
                  "let its region be free of walls and of what came before, larger than the "
                  "bodies, or its rate be lower\n",
                  how_.name, count_.count, patience));
  }

  World* w_;
  inflow how_;
  Region region_;
  Make make_;
  vec3 lower_, upper_;
  inserted count_;
  std::size_t last_placed_ = 0;  ///< bodies, in the step before
  std::uint64_t waits_ = 0;      ///< steps in a row in which a body was due and found no room
  real since_ = 0;               ///< when one last did
  bool said_ = false;
};

}  // namespace detail

/// Inserts bodies into a region after the steps of simulate(), at the given rate of bodies or mass.
/// f(site, random) returns a body with its centre at site.position, or a std::variant of bodies of
/// several shapes, as in world.fill. It is tried at several random places, with the same random
/// numbers at each, and added at the first without overlap. Without a free place the inflow waits,
/// and missing bodies enter later. The bodies, their ids, sizes and places depend on the seed and
/// the state alone, not on the ranks. If bodies are due, the ranks agree by one reduction; rank 0
/// warns on standard error if there is no room for long. Returns the total so far. All ranks make
/// the same call. Throws invalid_argument for invalid rates, a region without bounds, and a body
/// further from its site than its own radius.
template <class World, class Region, class F>
std::shared_ptr<const inserted> insert_by_rate(
    World& w, const inflow& how, const Region& region,
    F f) requires(std::is_void_v<detail::missing_in_inflow<World, F>>) {
  static_assert(detail::takes_site<F>,
                "insert_by_rate takes a function of a site and its random numbers: write [&](const "
                "site& place, random_stream& random) { return body{...}; }");
  static_assert(
      !detail::takes_site<F> || detail::makes_bodies<F>(),
      "insert_by_rate takes a function that returns a body, or a std::variant of bodies of "
      "several shapes, and this one returns something else: write return body{.shape = "
      "sphere{random.uniform(0.3, 0.5)}, .position = place.position};");
  if constexpr (detail::makes_bodies<F>()) {
    w.require_all_ranks("insert_by_rate", false);
    auto one = std::make_shared<detail::inserter<World, Region, F>>(w, how, region, std::move(f));
    if constexpr (World::scenario_type::template has_feature<checkpoints>)
      w.keep("inflow " + how.name, one->count());
    w.after_each_step(how.name, [one] { one->insert(); });
    return {one, &one->count()};
  } else {
    return nullptr;
  }
}

/// Refuses a shape that the scenario does not name.
template <
    class World, class Region, class F,
    detail::sentence Says = detail::missing_shape_or_none<detail::missing_in_inflow<World, F>>()>
std::shared_ptr<const inserted> insert_by_rate(World&, const inflow&, const Region&, F) requires(
    !std::is_void_v<detail::missing_in_inflow<World, F>>) = delete;
/// Refuses other fields.
template <class World, detail::sentence Fields = detail::fields::inflow>
detail::fields::no_inflow<Fields> insert_by_rate(World&, ...) TALUS_REFUSED;

}  // namespace talus
