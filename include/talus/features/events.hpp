#pragma once
// features<events>: contacts that begin and end, impacts, and bodies that enter and leave regions.
//
// The owner of a body reports the contacts of that body: of a contact of two movable bodies, the
// owner of the body that comes first in the contact. The memory of the contacts holds which of them
// acted in the last step. It migrates with the bodies and is in checkpoints. The regions of a body
// are in a column.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/body/column.hpp"
#include "talus/concepts.hpp"
#include "talus/core/error.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/region_check.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

/// What an event is.
enum class event_kind : std::uint8_t {
  contact_begins,  ///< a contact carries a force, and its bodies had none in the step before
  contact_ends,    ///< no contact of the two bodies carries a force any longer
  impact,          ///< a contact has come above the thresholds of events::state::impacts
  enters,          ///< the centre of a body has come into a region
  leaves           ///< it has left the region
};

/// One event of a step.
struct event {
  event_kind kind = event_kind::contact_begins;
  int region = -1;      ///< its number, for `enters` and `leaves`; -1 for contacts
  system_id a = no_id;  ///< the body, or of a contact the one with the lesser id
  system_id b = no_id;  ///< the other body of a contact
  vec3 point{0, 0, 0};  ///< of a contact the point with the largest force; centre of the body
  real impulse = 0;     ///< of a contact in this step, over all points of the two bodies
  real speed = 0;       ///< at which the surfaces approached before the step, at most

  /// The order of events: by ids, then by kind and region. A contact that ends and begins anew in
  /// one step ends first.
  friend bool operator<(const event& x, const event& y) {
    const bool goes_on_x = x.kind != event_kind::contact_ends,
               goes_on_y = y.kind != event_kind::contact_ends;
    return std::tie(x.a, x.b, goes_on_x, x.kind, x.region) <
           std::tie(y.a, y.b, goes_on_y, y.kind, y.region);
  }
};

/// Which contacts are impacts: those with at least both.
struct impact_thresholds {
  real impulse = 0;  ///< of the contacts of two bodies in one step, M L/T
  real speed = 0;    ///< of approach before the step, L/T
};

namespace detail {

/// The regions that the centre of a body is in, one bit each, and whether they are known.
struct regions_of_body {
  using value_type = std::uint32_t;
  static constexpr const char* name = "regions";
  static constexpr talus::travels travel = talus::travels::on_migration;
  static constexpr bool in_output = false, in_digest = false;
};
inline constexpr std::uint32_t regions_known = std::uint32_t{1} << 31;

}  // namespace detail

/// Feature: the events of each step, docs/features.md. Each event is reported once, on one rank:
/// events_of_step(world) is the range of this rank, all_events(world) that of all.
struct events {
  using talus_part_of = roles::features;
  static constexpr const char* name = "events";
  using columns = type_list<detail::regions_of_body>;

  struct hooks;
  /// On each rank; all ranks set it alike: world.feature<events>().
  class state {
   public:
    /// Contacts above both thresholds are impacts. Without this call there are none. Throws
    /// invalid_argument for a threshold that is negative or no number.
    void impacts(const impact_thresholds& least) {
      if (!(least.impulse >= 0) || !(least.speed >= 0))
        detail::fail<std::invalid_argument>(
            "events has impacts with .impulse = {} and .speed = {}: set thresholds of 0 or more",
            least.impulse, least.speed);
      impacts_ = least;
    }
    /// Adds a region; returns its number, from 0. A body that is inside has not entered if it was
    /// not there before this step, or if the region was not. Throws invalid_argument beyond 31
    /// regions, and for a region in which no point lies.
    template <concepts::region Region>
    int region(const Region& region) {
      if (regions_.size() == 31)
        detail::fail<std::invalid_argument>(
            "events has 31 regions, and no room for another: merge regions, or test bodies in "
            "after_each_step");
      detail::require_region(region, "events.region");
      regions_.push_back([region](const vec3& p) { return region.contains(p); });
      return static_cast<int>(regions_.size()) - 1;
    }

    void each_number(auto& visit) {
      for (std::uint64_t& n : totals_) visit.sum(n);
    }
    void each_list(auto& visit) {
      std::vector<std::uint64_t> list{known_regions_};
      visit.alike(list);
      known_regions_ = list.empty() ? 0 : list[0];
    }

   private:
    friend struct hooks;
    template <class World>
    friend const std::vector<event>& events_of_step(const World& w);
    template <class World>
    friend std::array<std::uint64_t, 5> total_events(World& w);

    using pair = std::pair<system_id, system_id>;
    using touch = std::pair<pair, real>;
    struct motion {
      vec3 v{0, 0, 0}, w{0, 0, 0};
    };

    impact_thresholds impacts_{.impulse = std::numeric_limits<real>::infinity()};  ///< none
    std::vector<std::function<bool(const vec3&)>> regions_;
    std::vector<event> of_step_;
    std::array<std::uint64_t, 5> totals_{};  ///< on this rank, by kind
    std::vector<touch> before_;              ///< acted in the last step; sorted
    std::vector<motion> motions_;      ///< before the step, of all known bodies; for hard contacts
    std::vector<pair> parted_;         ///< whose contacts the release of a body has ended
    std::uint64_t known_regions_ = 0;  ///< number of regions at the end of the last step
    bool resting_ = false;             ///< nothing moves here in this step
  };

  struct hooks {
    static void at_start(auto& stage) { stage.state().of_step_.clear(); }
    static void before_detect(auto& stage) {
      auto& s = stage.state();
      s.resting_ = s.parted_.empty() && stage.at_rest();
      if (s.resting_) return;
      s.before_ = touching(stage);
      if (!s.parted_.empty()) {
        std::sort(s.parted_.begin(), s.parted_.end());
        s.parted_.erase(std::unique(s.parted_.begin(), s.parted_.end()), s.parted_.end());
        std::erase_if(s.before_, [&](const touch& one) {
          return std::binary_search(s.parted_.begin(), s.parted_.end(), one.first);
        });
      }
      if constexpr (!is_soft<decltype(stage)>) {
        s.motions_.clear();
        stage.for_each_known([&](const auto& b) {
          s.motions_.push_back({b.velocity(), b.angular_velocity()});
        });
      }
    }
    static void after_solve(auto& stage) {
      auto& s = stage.state();
      if (s.resting_) return;
      const std::vector<touch> now = touching(stage);
      std::vector<touch> begun;
      const auto by_pair = [](const touch& x, const touch& y) { return x.first < y.first; };
      std::set_difference(now.begin(), now.end(), s.before_.begin(), s.before_.end(),
                          std::back_inserter(begun), by_pair);
      const auto end = [&](const pair& both) {
        s.of_step_.push_back({event_kind::contact_ends, -1, both.first, both.second});
      };
      std::vector<touch> ended;
      std::set_difference(s.before_.begin(), s.before_.end(), now.begin(), now.end(),
                          std::back_inserter(ended), by_pair);
      for (const touch& one : ended) end(one.first);
      for (const pair& both : s.parted_) end(both);
      s.parted_.clear();
      // An impact may go on in further steps: the first reports it.
      const bool strikes =
          std::max(s.impacts_.impulse, s.impacts_.speed) < std::numeric_limits<real>::infinity();
      const auto comes = [&](const pair& both) {
        const auto before =
            std::lower_bound(s.before_.begin(), s.before_.end(), touch(both, -1), by_pair);
        if (before == s.before_.end() || before->first != both) return true;
        return !is_soft<decltype(stage)> && before->second < s.impacts_.impulse;
      };
      // Geometry costs, and few contacts need it.
      std::vector<pair> chosen;
      for (const touch& one : now)
        if (std::binary_search(begun.begin(), begun.end(), one, by_pair) ||
            (strikes && one.second >= s.impacts_.impulse && comes(one.first)))
          chosen.push_back(one.first);
      if (chosen.empty()) return;
      const std::vector<strike> strikes_of = contacts(stage, chosen);
      for (std::size_t k = 0; k < chosen.size(); ++k) {
        const pair& both = chosen[k];
        const strike& c = strikes_of[k];
        const auto report = [&](event_kind kind) {
          s.of_step_.push_back({kind, -1, both.first, both.second, c.point, c.impulse, c.speed});
        };
        if (std::binary_search(begun.begin(), begun.end(), touch(both, 0), by_pair))
          report(event_kind::contact_begins);
        if (strikes && c.impulse >= s.impacts_.impulse && c.speed >= s.impacts_.speed &&
            comes(both))
          report(event_kind::impact);
      }
    }
    static void at_end(auto& stage) {
      auto& s = stage.state();
      if (!s.regions_.empty()) note_regions(stage);
      s.known_regions_ = s.regions_.size();
      std::sort(s.of_step_.begin(), s.of_step_.end());
      for (const event& e : s.of_step_) ++s.totals_[static_cast<std::size_t>(e.kind)];
    }

    /// For the functions that clear the memory of contacts.
    static void note_parted(state& s, system_id a, system_id b) {
      s.parted_.push_back(in_order(a, b));
    }

   private:
    using pair = std::pair<system_id, system_id>;
    using touch = std::pair<pair, real>;
    template <class Stage>
    static constexpr bool is_soft = std::remove_cvref_t<Stage>::scenario_type::contact_law::soft;
    /// The contacts of two bodies together.
    struct strike {
      vec3 point{0, 0, 0};
      real impulse = 0, speed = 0, most = -1;
    };

    [[nodiscard]] static pair in_order(system_id a, system_id b) {
      return b < a ? pair(b, a) : pair(a, b);
    }
    /// The pairs that this rank reports, in order, with the impulses of their contacts.
    [[nodiscard]] static std::vector<touch> touching(auto& stage) {
      std::vector<touch> points, all;
      stage.for_each_touching([&](system_id a, system_id b, bool counts_here, real impulse) {
        if (counts_here) points.push_back({in_order(a, b), impulse});
      });
      std::sort(points.begin(), points.end());  // so that sums have the same bits on any ranks
      for (const touch& one : points)
        if (all.empty() || all.back().first != one.first)
          all.push_back(one);
        else
          all.back().second += one.second;
      return all;
    }
    /// The contacts of each of these pairs, which are in order.
    [[nodiscard]] static std::vector<strike> contacts(auto& stage, const std::vector<pair>& pairs) {
      const auto& motions = stage.state().motions_;
      const auto before = [&](std::size_t number) {
        state::motion m;
        if constexpr (is_soft<decltype(stage)>)  // its velocities change after that
          stage.with_body(number, [&](const auto& b) { m = {b.velocity(), b.angular_velocity()}; });
        else if (number < motions.size())
          m = motions[number];
        return m;
      };
      std::vector<strike> all(pairs.size());
      stage.for_each_contact_of(pairs, [&](const auto& c) {
        if (!c.counts_here) return;
        const auto at = std::lower_bound(pairs.begin(), pairs.end(), in_order(c.a, c.b));
        strike& of = all[static_cast<std::size_t>(at - pairs.begin())];
        const real impulse = c.force.norm() * stage.dt();
        of.impulse += impulse;
        if (impulse > of.most) of.most = impulse, of.point = c.point;
        const auto a = before(c.body_a), b = before(c.body_b);
        const vec3 approach = a.v + a.w.cross(vec3(c.point - c.centre_a)) - b.v -
                              b.w.cross(vec3(c.point - c.centre_b));
        of.speed = std::max(of.speed, -c.normal.dot(approach));
      });
      return all;
    }
    static void note_regions(auto& stage) {
      auto& s = stage.state();
      stage.for_each_local([&](const auto& b) {
        const std::uint32_t before = b.template get<detail::regions_of_body>();
        std::uint32_t now = detail::regions_known;
        for (std::size_t k = 0; k < s.regions_.size(); ++k)
          now |= std::uint32_t{s.regions_[k](b.position())} << k;
        if (now == before) return;
        b.template set<detail::regions_of_body>(now);
        if ((before & detail::regions_known) == 0) return;
        for (std::size_t k = 0; k < std::min<std::size_t>(s.known_regions_, s.regions_.size()); ++k)
          if (((now ^ before) >> k & 1) != 0)
            s.of_step_.push_back({(now >> k & 1) != 0 ? event_kind::enters : event_kind::leaves,
                                  static_cast<int>(k), b.id(), no_id, b.position(), 0, 0});
      });
    }
  };
};

}  // namespace talus
