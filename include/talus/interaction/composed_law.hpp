#pragma once
// Several interaction laws and resistances as one law: their forces and energies add up, each has
// its own parameters and its own memory.
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "talus/body/material.hpp"
#include "talus/concepts.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/core/type_list.hpp"
#include "talus/interaction/contact_kinematics.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// The bearing of a law for friction; a plain bearing if no law has one.
template <class Law>
struct bearing_of_law {
  using type = decltype(Law::bears(contact_kinematics{}, typename Law::parameters{}));
};
template <>
struct bearing_of_law<void> {
  using type = bearing;
};
/// The bearing of a law for friction, for several contacts at once if `Number` is a pack.
template <class Law, class Number>
struct bearing_in {
  using type = typename bearing_of_law<Law>::type::template with<Number>;
};
template <class Law>
struct bearing_in<Law, real> : bearing_of_law<Law> {};

/// Parameters and memory of a part, of one contact or of several at once.
template <class Part, class Number>
struct part_in {
  using parameters = typename Part::template parameters_of<Number>;
  using memory = typename Part::template memory_of<Number>;
};
template <class Part>
struct part_in<Part, real> {
  using parameters = typename Part::parameters;
  using memory = typename Part::memory;
};
/// Whether a part can be evaluated for several contacts at once: its parameters, its memory and its
/// force are templates of the number.
template <class Part>
concept in_packs = requires {
  typename Part::template parameters_of<wide_pack<real>>;
  typename Part::template memory_of<wide_pack<real>>;
};
/// Whether that is so for the stored energy, too. What a law with a memory along the normal
/// releases is booked one contact at a time.
template <class Law>
concept stores_in_packs = in_packs<Law> && std::is_empty_v<typename Law::memory> &&
    requires(const contact_kinematics_of<wide_pack<real>>& c,
             const typename Law::template parameters_of<wide_pack<real>>& p,
             const typename Law::template memory_of<wide_pack<real>>& m) {
  Law::stored(c, p, m);
};

// The declared properties of a part.

/// Whether the force of a part is along the normal, and its moment zero.
template <class Part>
inline constexpr bool is_central = requires {
  requires Part::central;
};
template <class Part>
inline constexpr bool has_force = !requires {
  requires !Part::exerts_force;
};
template <class Part>
inline constexpr bool has_moment = !is_central<Part> && !requires {
  requires !Part::exerts_moment;
};
/// Whether a part acts beyond touch.
template <class Part>
inline constexpr bool has_range = requires(const typename Part::parameters& p) {
  Part::range(p, real{});
};
/// Whether the parameters of a part follow from two materials; otherwise the scenario sets them.
template <class Part>
inline constexpr bool combines = requires(const material& m, const pair_material& p) {
  Part::combine(m, m, p);
};
/// Whether a part bounds the time step by each body.
template <class Part>
inline constexpr bool bounds_bodies = requires(const material& m) {
  Part::longest_step_of_body(m, real{});
};

/// A part's own parameters and memory, distinguished by the part.
template <class Part, class Number = real>
struct parameters_of_part {
  typename part_in<Part, Number>::parameters value{};
};
template <class Part, class Number = real>
struct memory_of_part : part_in<Part, Number>::memory {};

template <class First, class...>
struct first_type {
  using type = First;
};
template <class... Types>
using first_of = typename first_type<Types...>::type;

/// A memory without columns of its own is stored as its bytes.
template <std::size_t Size>
struct raw_bytes {
  using stored_as_bytes = void;
  std::array<std::byte, Size> bytes;
};

/// Whether all parts have parameters for a pair of materials.
template <bool Needed>
struct knowledge {
  bool known = true;
};
template <>
struct knowledge<false> {
  static constexpr bool known = true;
};

/// The force and moment of a contact on body a; the opposite acts on body b.
template <class Number>
struct pair_force_of {
  vectors_of<Number> force = every_lane_of<Number>(0, 0, 0),
                     moment = every_lane_of<Number>(0, 0, 0);
};
using pair_force = pair_force_of<real>;
/// The entries of a contact for the energy ledger: forces and moments on body a, and energies.
template <class Number>
struct booked_contact_of {
  using vector = vectors_of<Number>;

  vector spring = every_lane_of<Number>(0, 0, 0), dashpot = spring, friction = spring;
  vector spring_moment = spring, friction_moment = spring;
  Number stored{};         ///< stored_energy::normal
  Number released{};       ///< the part of that released at once by a change of memory
  Number across_before{};  ///< stored_energy::kept before the step
  Number across{};         ///< the same now
  Number yielded{};        ///< loss of both without motion of the bodies
};
using booked_contact = booked_contact_of<real>;
struct not_booked {};

/// `Bearer` is the law whose normal force bounds friction, or void.
template <class Bearer, class Laws, class Resistances>
struct composed_law;
template <class Bearer, class... Laws, class... Resistances>
struct composed_law<Bearer, type_list<Laws...>, type_list<Resistances...>> {
  using parts = type_list<Laws..., Resistances...>;

  /// Whether the scenario must set parameters for pairs of materials.
  static constexpr bool needs_parameters =
      !(... && combines<Laws>) || !(... && combines<Resistances>);

  template <class Number>
  struct parameters_of : parameters_of_part<Laws, Number>...,
                         parameters_of_part<Resistances, Number>...,
                         knowledge<needs_parameters> {
    friend bool operator==(const parameters_of& x, const parameters_of& y) {
      return x.known == y.known && (... && (of<Laws>(x) == of<Laws>(y))) &&
             (... && (of<Resistances>(x) == of<Resistances>(y)));
    }
  };
  using parameters = parameters_of<real>;
  template <class Number>
  struct memory_of : memory_of_part<Laws, Number>..., memory_of_part<Resistances, Number>... {
    /// Calls f(name, value) for the columns of a checkpoint.
    template <class Memory, class F>
    static void each_column(Memory& m, F&& f) {
      each_part([&]<class Part>() { column_of_part<Part>(of<Part>(m), f); });
    }
  };
  using memory = memory_of<real>;

  template <class Part, class Number>
  [[nodiscard]] static const auto& of(const parameters_of<Number>& p) {
    return static_cast<const parameters_of_part<Part, Number>&>(p).value;
  }
  template <class Part, class Number>
  [[nodiscard]] static auto& of(parameters_of<Number>& p) {
    return static_cast<parameters_of_part<Part, Number>&>(p).value;
  }
  template <class Part, class Number>
  [[nodiscard]] static typename part_in<Part, Number>::memory& of(memory_of<Number>& m) {
    return static_cast<memory_of_part<Part, Number>&>(m);
  }
  template <class Part, class Number>
  [[nodiscard]] static const typename part_in<Part, Number>::memory& of(
      const memory_of<Number>& m) {
    return static_cast<const memory_of_part<Part, Number>&>(m);
  }
  /// Calls f.template operator()<Part>() for all parts.
  template <class F>
  [[gnu::always_inline]] static inline void each_part(F&& f) {
    (f.template operator()<Laws>(), ...);
    (f.template operator()<Resistances>(), ...);
  }

  static constexpr bool central = (... && is_central<Laws>)&&sizeof...(Resistances) == 0;
  static constexpr bool exerts_moment =
      (... || has_moment<Laws>) || (... || has_moment<Resistances>);
  static constexpr bool reaches = (... || has_range<Laws>);
  static constexpr bool bounds_each_body = (... || bounds_bodies<Laws>);
  /// Whether several contacts can be evaluated at once.
  static constexpr bool in_packs =
      !reaches && (... && detail::in_packs<Laws>)&&(... && detail::in_packs<Resistances>);
  /// Whether the energies of several contacts can be evaluated at once, for the ledger.
  static constexpr bool stores_in_packs = in_packs && (... && detail::stores_in_packs<Laws>);
  /// The range of the law beyond touch, for these parameters and this effective radius.
  [[nodiscard]] static real range(const parameters& p, real radius) {
    real furthest = 0;
    const auto reach = [&]<class Law>() {
      if constexpr (has_range<Law>)
        furthest = std::max(furthest, real(Law::range(of<Law>(p), radius)));
    };
    (reach.template operator()<Laws>(), ...);
    return (void)reach, (void)p, (void)radius, furthest;
  }

  /// The force of a contact; `memory` is advanced by `dt`. A booked_contact_of is filled.
  template <class Number, class Booked>
  [[nodiscard, gnu::always_inline]] static inline pair_force_of<Number> force(
      const contact_kinematics_of<Number>& c, const parameters_of<Number>& p, real dt,
      memory_of<Number>& m, Booked& books) {
    pair_force_of<Number> sum;
    typename bearing_in<Bearer, Number>::type b;
    bool bears = false;  // whether the law with the bearing acts
    (add_law<Laws>(sum, b, bears, c, p, dt, m, books), ...);
    (add_resistance<Resistances>(sum, b, bears, c, p, dt, m, books), ...);
    (void)b, (void)bears;
    return sum;
  }
  [[nodiscard]] static interaction_force force(const contact_kinematics& c, const parameters& p,
                                               real dt, memory& m) {
    booked_contact books;
    const pair_force sum = force(c, p, dt, m, books);
    interaction_force f{.force = sum.force, .moment = sum.moment};
    f.conserved = books.spring, f.conserved_moment = books.spring_moment;
    f.lost = books.yielded - books.released;
    return f;
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline stored_energy_of<Number> stored(
      const contact_kinematics_of<Number>& c, const parameters_of<Number>& p,
      const memory_of<Number>& m) {
    stored_energy_of<Number> sum;
    bool bears = false;
    const auto add_law = [&]<class Law>() __attribute__((always_inline)) {
      if constexpr (reaches)
        if (!acts<Law>(c, p)) return;
      const stored_energy_of<Number> e = Law::stored(c, of<Law>(p), of<Law>(m));
      sum.normal += e.normal, sum.kept += e.kept;
      bears = bears || std::is_same_v<Law, Bearer>;
    };
    (add_law.template operator()<Laws>(), ...);
    if constexpr (sizeof...(Resistances) > 0)
      if (bears) {
        const auto b = Bearer::bears(c, of<Bearer>(p));
        ((sum.kept += Resistances::stored(c, b, of<Resistances>(p), of<Resistances>(m))), ...);
      }
    return sum;
  }

  /// The memory of a contact that goes on with another body: that of its resistances. Where a and b
  /// have changed places, vectors of the memory, which are of a relative to b, are reversed.
  [[nodiscard]] static memory of_resistances(memory old, bool swapped) {
    memory m;
    reversal reverses;
    const auto take = [&]<class Part>() {
      typename Part::memory& from = of<Part>(old);
      if (swapped) {
        if constexpr (requires { Part::memory::each_column(from, reverses); })
          Part::memory::each_column(from, reverses);
        else
          return;
      }
      of<Part>(m) = from;
    };
    (take.template operator()<Resistances>(), ...);
    return (void)take, (void)reverses, (void)old, (void)swapped, m;
  }
  /// Whether a bond or a neck holds the bodies, also where its force vanishes.
  [[nodiscard]] static bool is_intact(const memory& m) {
    bool any = false;
    each_part([&]<class Part>() {
      if constexpr (requires { Part::is_intact(of<Part>(m)); })
        any = any || Part::is_intact(of<Part>(m));
    });
    return (void)m, any;
  }

  /// The longest stable step of two bodies of this mass, `stiffer` by this factor than on one
  /// contact.
  [[nodiscard]] static real longest_step(const parameters& p, real mass, real stiffer = 1) {
    real least = std::numeric_limits<real>::infinity();
    const auto bound = [&]<class Law>() {
      if constexpr (requires { Law::longest_step(of<Law>(p), mass, stiffer); })
        least = std::min(least, real(Law::longest_step(of<Law>(p), mass, stiffer)));
      else
        least = std::min(least, real(Law::longest_step(of<Law>(p), mass / stiffer)));
    };
    (bound.template operator()<Laws>(), ...);
    return least;
  }
  /// The longest stable step of a body, for any partner.
  [[nodiscard]] static real longest_step_of_body(const material& m, real radius) {
    real least = std::numeric_limits<real>::infinity();
    const auto bound = [&]<class Law>() {
      if constexpr (bounds_bodies<Law>)
        least = std::min(least, real(Law::longest_step_of_body(m, radius)));
    };
    (bound.template operator()<Laws>(), ...);
    return least;
  }
  /// The shortest duration of an impact, of all laws.
  [[nodiscard]] static real duration(const parameters& p, const head_on_impact& hit) {
    return std::min(
        {std::numeric_limits<real>::infinity(), real(Laws::duration(of<Laws>(p), hit))...});
  }
  /// Throws invalid_argument for a material without a property that a part needs.
  static void require_material(const material& m) {
    each_part([&]<class Part>() {
      if constexpr (requires { Part::require_material(m); }) Part::require_material(m);
    });
  }
  /// The field that makes a material rigid, or null.
  [[nodiscard]] static const char* rigid_by(const material& m) {
    const char* field = nullptr;
    each_part([&]<class Part>() {
      if constexpr (requires { Part::rigid_by(m); })
        if (field == nullptr) field = Part::rigid_by(m);
    });
    return field;
  }

 private:
  template <class Booked>
  static constexpr bool is_booked = !std::is_same_v<Booked, not_booked>;

  struct reversal {
    void operator()(const char*, vec3& x) const { x = -x; }
    template <class Value>
    void operator()(const char*, Value&) const {}
  };

  template <class Part, class Memory, class F>
  static void column_of_part(Memory& m, F&& f) {
    if constexpr (requires { Part::memory::each_column(m, f); }) {
      Part::memory::each_column(m, f);
    } else if constexpr (!std::is_empty_v<Memory>) {
      auto bytes = std::bit_cast<raw_bytes<sizeof(Memory)>>(m);
      f(Part::name, bytes);
      if constexpr (!std::is_const_v<Memory>) m = std::bit_cast<typename Part::memory>(bytes);
    }
  }

  /// A law acts where bodies overlap, and within its range beyond.
  template <class Law>
  [[nodiscard]] static bool acts(const contact_kinematics& c, const parameters& p) {
    if constexpr (!reaches)
      return (void)c, (void)p, true;
    else if constexpr (has_range<Law>)
      return c.gap < 0 || c.gap < Law::range(of<Law>(p), c.radius);
    else
      return c.gap < 0;
  }
  template <class Law, class Number, class Bearing, class Booked>
  [[gnu::always_inline]] static inline void add_law(pair_force_of<Number>& sum, Bearing& b,
                                                    bool& bears,
                                                    const contact_kinematics_of<Number>& c,
                                                    const parameters_of<Number>& p, real dt,
                                                    memory_of<Number>& m, Booked& books) {
    if constexpr (reaches)
      if (!acts<Law>(c, p)) {
        of<Law>(m) = {};
        return;
      }
    stored_energy_of<Number> before;
    if constexpr (is_booked<Booked>) before = Law::stored(c, of<Law>(p), of<Law>(m));
    const auto f = Law::force(c, of<Law>(p), dt, of<Law>(m));
    if constexpr (std::is_same_v<Law, Bearer>) {
      b = f;
      bears = true;
      // Within its range the law bears nothing before the bodies touch.
      if constexpr (has_range<Law>) bears = f.stiffness > 0;
    }
    if constexpr (std::is_same_v<Law, first_of<Laws...>>)
      sum.force = f.force;
    else
      sum.force += f.force;
    if constexpr (has_moment<Law>) sum.moment += f.moment;
    if constexpr (is_booked<Booked>)
      book_law<Law>(books, c, f, before, Law::stored(c, of<Law>(p), of<Law>(m)));
  }
  template <class Part, class Number, class Bearing, class Booked>
  [[gnu::always_inline]] static inline void add_resistance(pair_force_of<Number>& sum,
                                                           const Bearing& b, bool bears,
                                                           const contact_kinematics_of<Number>& c,
                                                           const parameters_of<Number>& p, real dt,
                                                           memory_of<Number>& m, Booked& books) {
    if (!bears) {
      of<Part>(m) = {};
      return;
    }
    if constexpr (is_booked<Booked>)
      books.across_before += Part::stored(c, b, of<Part>(p), of<Part>(m));
    const interaction_force_of<Number> f = Part::force(c, b, of<Part>(p), dt, of<Part>(m));
    if constexpr (has_force<Part>) sum.force += f.force;
    if constexpr (has_moment<Part>) sum.moment += f.moment;
    if constexpr (is_booked<Booked>) {
      books.across += Part::stored(c, b, of<Part>(p), of<Part>(m));
      books.yielded += f.lost;
      books.spring += f.conserved, books.spring_moment += f.conserved_moment;
      books.friction += f.force - f.conserved;
      books.friction_moment += f.moment - f.conserved_moment;
    }
  }

  /// The rest is lost in dashpots along the normal, and in friction across it.
  template <class Law, class Number, class Force>
  [[gnu::always_inline]] static inline void book_law(booked_contact_of<Number>& books,
                                                     const contact_kinematics_of<Number>& c,
                                                     const Force& f,
                                                     const stored_energy_of<Number>& before,
                                                     const stored_energy_of<Number>& after) {
    using vector = vectors_of<Number>;
    books.spring += f.conserved, books.spring_moment += f.conserved_moment;
    const vector rest = f.force - f.conserved;
    if constexpr (is_central<Law>) {
      books.dashpot += rest;
    } else {
      const vector along = dot(c.normal, rest) * c.normal;
      books.dashpot += along, books.friction += rest - along;
      books.friction_moment += f.moment - f.conserved_moment;
    }
    const Number released = before.normal - after.normal;
    books.stored += after.normal, books.released += released;
    books.across_before += before.kept, books.across += after.kept;
    books.yielded += released + f.lost;
  }
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
