#pragma once
// Liquid bridges whose liquid comes from films on the bodies: the law of a bridge of any volume,
// with a memory that features<surface_liquid> fills and empties.
#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/type_list.hpp"
#include "talus/interaction/contact_kinematics.hpp"

namespace talus {
namespace detail {

/// The life of a bridge between films. The law goes from `none` to `wanted`, from `offered` to
/// `formed` or `dry`, and from `wet` to `ruptured`; the feature does the rest, once in a step.
enum class bridge_phase : std::uint64_t {
  none,     ///< no bridge, and no touch
  wanted,   ///< the bodies touched in this step for the first time
  offered,  ///< the memory holds the volume that the films offer
  formed,   ///< the bridge formed in this step: the films have not given its liquid yet
  wet,      ///< there is a bridge
  dry,      ///< the bodies touch, and their films offered nothing
  ruptured  ///< in this step: the films have not got the liquid back yet
};

/// "from_films<name>".
[[nodiscard]] consteval std::array<char, 64> in_from_films(std::string_view name) {
  std::array<char, 64> text{};
  const std::string_view opening = "from_films<";
  char* end = std::copy(opening.begin(), opening.end(), text.begin());
  *std::copy(name.begin(), name.end(), end) = '>';
  return text;
}

/// A law that takes the liquid of its bridges from the films of bodies.
template <class Part>
inline constexpr bool takes_liquid = requires {
  requires Part::takes_liquid;
};

/// Whether one of the laws of soft_contact<...> takes the liquid of its bridges from the films of
/// bodies.
template <class ContactLaw>
inline constexpr bool law_takes_liquid = false;
template <class ContactLaw>
requires(ContactLaw::soft) inline constexpr bool law_takes_liquid<ContactLaw> =
    []<class... Parts>(type_list<Parts...>) {
      return (false || ... || takes_liquid<Parts>);
    }(typename ContactLaw::list{});

}  // namespace detail

/// Interaction law: a law of liquid bridges, willett_bridge or rabinovich_bridge, whose liquid
/// comes from the films of the two bodies and returns there at the rupture. Needs
/// features<surface_liquid>. `volume` of its parameters is the most that a bridge takes; the range
/// of the law follows from it. A bridge forms in the step after the first touch.
template <class Bridge>
struct from_films final {
  using talus_part_of = roles::contact_law;
  static constexpr auto name_of_law = detail::in_from_films(Bridge::name);
  static constexpr const char* name = name_of_law.data();
  static constexpr bool exerts_moment = false;
  static constexpr bool takes_liquid = true;
  using parameters = typename Bridge::parameters;

  /// What a contact remembers from step to step.
  struct memory {
    real volume = 0;  ///< of the bridge, or offered by the films
    detail::bridge_phase phase = detail::bridge_phase::none;

    /// Volume of the liquid that is in the bridge; 0 if there is none.
    [[nodiscard]] real held() const { return phase == detail::bridge_phase::wet ? volume : 0; }

    /// The columns of a checkpoint.
    template <class Memory, class F>
    static void each_column(Memory& m, F&& f) {
      auto stage = static_cast<std::uint64_t>(m.phase);
      f("bridge_volume", m.volume), f("bridge_phase", stage);
      if constexpr (!std::is_const_v<Memory>) m.phase = static_cast<detail::bridge_phase>(stage);
    }
  };

  static void require_parameters(const parameters& p) { Bridge::require_parameters(p); }
  [[nodiscard]] static real range(const parameters& p, real radius) {
    return Bridge::range(p, radius);
  }
  [[nodiscard]] static interaction_force force(const contact_kinematics& c, const parameters& p,
                                               real dt, memory& m) {
    if (dt > 0) advance(c, p, m);
    return acts(c, p, m) ? Bridge::force_of_bridge(c, p, m.volume) : interaction_force{};
  }
  [[nodiscard]] static stored_energy stored(const contact_kinematics& c, const parameters& p,
                                            const memory& m) {
    return {.normal = acts(c, p, m) ? Bridge::energy_of_bridge(c, p, m.volume) : 0};
  }
  [[nodiscard]] static real longest_step(const parameters& p, real mass) {
    return Bridge::longest_step(p, mass);
  }
  [[nodiscard]] static real duration(const parameters& p, const head_on_impact& hit) {
    return Bridge::duration(p, hit);
  }

 private:
  [[nodiscard]] static bool acts(const contact_kinematics& c, const parameters& p,
                                 const memory& m) {
    return (m.phase == detail::bridge_phase::wet || m.phase == detail::bridge_phase::formed) &&
           Bridge::holds(p, m.volume, c.gap);
  }
  static void advance(const contact_kinematics& c, const parameters& p, memory& m) {
    using enum detail::bridge_phase;
    const bool touches = c.gap < 0;
    if (m.phase == none || m.phase == dry) {
      if (!touches)
        m = {};
      else if (m.phase == none)
        m.phase = wanted;
    } else if (m.phase == offered) {
      m.volume = std::min(m.volume, p.volume);
      m.phase = formed;
      if (!(m.volume > 0) || !acts(c, p, m)) m = {.volume = 0, .phase = touches ? dry : none};
    } else if (m.phase == wet && !acts(c, p, m)) {
      m.phase = ruptured;
    }
  }
};

}  // namespace talus
