#pragma once
// features<surface_liquid>: the films of liquid on bodies, and what passes between them and the
// liquid bridges of from_films<...>.
//
// A bridge forms in two steps, so that both ranks of a contact know how many bridges start at each
// of its bodies. In the step of the first touch the owner of a body counts them, and writes into a
// column what the film gives to each. In the next step both ranks have this column of both bodies,
// compute the volume of the bridge, and each takes the share of its own body off the film.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "talus/body/columns.hpp"
#include "talus/body/features.hpp"
#include "talus/core/error.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/type_list.hpp"
#include "talus/interaction/film_bridge.hpp"

namespace talus {

/// Column: the volume of the film of liquid on a body. Bodies that cannot move neither give liquid
/// nor take any.
struct liquid {
  using value_type = real;
  static constexpr const char *name = "liquid", *unit = "L^3";
  static constexpr real initial = 0;
  static constexpr talus::travels travel = talus::travels::on_migration;
};

namespace detail {

/// What the film of a body gives to each bridge that starts at it.
struct liquid_share {
  using value_type = real;
  static constexpr const char *name = "liquid_share", *unit = "L^3";
  static constexpr real initial = 0;
  static constexpr talus::travels travel = talus::travels::with_every_refresh;
  static constexpr bool in_output = false;
};

template <class Part>
struct is_film_law : std::bool_constant<takes_liquid<Part>> {};
/// The law of a scenario that takes liquid.
template <class Scenario>
using film_law = find_type<typename Scenario::contact_law::list, is_film_law, void>;

}  // namespace detail

/// Feature: bodies carry liquid, in the column `liquid`. Where two of them touch for the first
/// time, a bridge of from_films<...> takes `fraction` of both films, or less if a film would not do
/// for all bridges that start at a body in this step (the shares are then equal); it never takes
/// more than the `volume` of its parameters. When it ruptures, each body gets half of it (Mani,
/// Kadau, Herrmann 2013; Roy, Luding, Weinhart 2016). Walls and fixed bodies neither give nor take:
/// the liquid of a bridge to them comes from the other body and returns there. The sum over films
/// and bridges is constant up to round-off: total_liquid(world).
struct surface_liquid {
  using talus_part_of = roles::features;
  static constexpr const char* name = "surface_liquid";
  using columns = type_list<liquid, detail::liquid_share>;

  /// On each rank; set it alike on all: world.feature<surface_liquid>().
  struct state {
    real fraction = 1;  ///< of a film that a new bridge takes, from 0 to 1; LIGGGHTS has 0.05
  };

  struct hooks {
    /// Films offer liquid to the contacts that began in the last step.
    static void before_detect(auto& stage) {
      using law = law_of<decltype(stage)>;
      stage.template for_each_memory<law>(
          [](const auto& m) { return m.phase == detail::bridge_phase::wanted; },
          [&](const auto& c) {
            c.memory.volume = share_of(stage, c.body_a) + share_of(stage, c.body_b);
            c.memory.phase = detail::bridge_phase::offered;
          });
    }
    /// New bridges take their liquid off the films, ruptured ones give it back, and the films
    /// divide what they have among the contacts that began in this step.
    static void after_solve(auto& stage) {
      using law = law_of<decltype(stage)>;
      using enum detail::bridge_phase;
      // Bridges of bodies that left the range of the law within the step.
      stage.template for_each_former_memory<law>(
          [](const auto& before, const auto* now) {
            return before.phase == wet && (now == nullptr || now->phase == none);
          },
          [&](const auto& c) { give_back(stage, c, c.memory.volume); });
      std::map<std::size_t, std::uint32_t> starts;  // contacts that began, for each body
      stage.template for_each_memory<law>(
          [](const auto& m) {
            return m.phase == formed || m.phase == ruptured || m.phase == wanted;
          },
          [&](const auto& c) {
            auto& m = c.memory;
            if (m.phase == wanted) {
              ++starts[c.body_a], ++starts[c.body_b];
            } else if (m.phase == formed) {
              take(stage, c, m.volume);
              m.phase = wet;
            } else {
              give_back(stage, c, m.volume);
              m = {};
            }
          });
      const real fraction = stage.state().fraction;
      if (!(fraction >= 0 && fraction <= 1))
        detail::fail<std::runtime_error>(
            "surface_liquid has .fraction = {}: set a number from 0 to 1, on all ranks alike",
            fraction);
      for (const auto& [number, count] : starts)
        stage.with_local(number, [&](const auto& body) {
          const real film = body.template get<liquid>();
          if (!(film >= 0) || !std::isfinite(film))
            detail::fail<std::runtime_error>(
                "the film of liquid on body {} has the volume {}: set a finite volume that is not "
                "negative",
                value_of(body.id()), film);
          body.template set<detail::liquid_share>(film * std::min(fraction, 1 / real(count)));
        });
    }

   private:
    template <class Stage>
    using law_of = detail::film_law<typename std::remove_cvref_t<Stage>::scenario_type>;

    /// Whether a body cannot move; the other body of a contact then gives and gets all the liquid.
    static bool is_wall(const auto& stage, std::size_t number) {
      bool wall = false;
      if (number != unknown) stage.with_body(number, [&](const auto& b) { wall = b.is_fixed(); });
      return wall;
    }
    static real share_of(const auto& stage, std::size_t number) {
      real share = 0;
      if (number != unknown && !is_wall(stage, number))
        stage.with_body(number,
                        [&](const auto& b) { share = b.template get<detail::liquid_share>(); });
      return share;
    }
    static void add(auto& stage, std::size_t number, real volume) {
      stage.with_local(number, [&](const auto& body) {
        body.template set<liquid>(std::max(real(0), body.template get<liquid>() + volume));
      });
    }
    /// A bridge of this volume has formed.
    static void take(auto& stage, const auto& c, real volume) {
      const real a = share_of(stage, c.body_a), b = share_of(stage, c.body_b), all = a + b;
      if (a > 0) add(stage, c.body_a, -(volume < all ? volume * (a / all) : a));
      if (b > 0) add(stage, c.body_b, -(volume < all ? volume * (b / all) : b));
    }
    static void give_back(auto& stage, const auto& c, real volume) {
      const bool wall_a = is_wall(stage, c.body_a), wall_b = is_wall(stage, c.body_b);
      if (!wall_a) add(stage, c.body_a, wall_b ? volume : volume / 2);
      if (!wall_b) add(stage, c.body_b, wall_a ? volume : volume / 2);
    }

    static constexpr std::size_t unknown = ~std::size_t{0};
  };
};

}  // namespace talus
