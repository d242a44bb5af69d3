#pragma once
// The parameters of interaction laws for each pair of materials: those that the scenario set, or
// those combined from the two materials.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include "talus/body/material.hpp"
#include "talus/body/pair_table.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/type_list.hpp"
#include "talus/interaction/composed_law.hpp"

namespace talus::detail {

/// Throws invalid_argument for a movable rigid body: two of them would push each other with
/// unbounded forces.
template <class Law, class Shape>
void require_yielding(const material& m) {
  if (const char* field = Law::rigid_by(m))
    fail<std::invalid_argument>(
        "a {} that moves cannot be of a rigid material: give that material a finite {}, or add "
        "the body in world.global(...) or with .fixed = true",
        Shape::name, field);
}

/// What a scenario gives to a part for a pair of materials: its parameters, or its type `given`,
/// from which and from the materials it derives them.
template <class Part>
struct given_type {
  using type = typename Part::parameters;
};
template <class Part>
requires requires { typename Part::given; }
struct given_type<Part> {
  using type = typename Part::given;
};
template <class Part>
using given_of = typename given_type<Part>::type;
/// The name of that type, for messages.
template <class Part>
inline constexpr const char* given_name = requires {
  typename Part::given;
}
? "given" : "parameters";

/// What was given to a part for pairs of materials.
template <class Part>
struct given_parameters {
  pair_table<given_of<Part>> of_pairs;
};

template <class Law, class Parts>
class pair_parameters;
/// The pairs of a table of materials, derived again only if that or a given parameter has changed:
/// for few materials all pairs, for many those that meet.
template <class Law, class... Parts>
class pair_parameters<Law, type_list<Parts...>> : given_parameters<Parts>... {
  static constexpr std::size_t few = 64;

 public:
  using parameters = typename Law::parameters;

  /// Sets the parameters of a part for contacts between `a` and `b`, in either order. Throws
  /// invalid_argument for materials of another world.
  template <class Part>
  void give(const material_table& materials, material_id a, material_id b,
            const given_of<Part>& p) {
    (void)materials[a], (void)materials[b];
    given_parameters<Part>::of_pairs.set(number(a), number(b), p);
    ++given_;
  }
  /// What was given to a part.
  template <class Part>
  [[nodiscard]] const pair_table<given_of<Part>>& given() const {
    return given_parameters<Part>::of_pairs;
  }

  void follow(const material_table& materials) {
    materials_ = &materials;
    const std::uint64_t now = materials.revision() + given_;
    if (revision_ == now) return;
    revision_ = now;
    if constexpr (Law::reaches) require_few(materials);
    met_.clear();
    size_ = materials.size() <= few ? materials.size() : 0;
    pairs_.resize(size_ * size_);
    for (std::size_t i = 0; i < size_; ++i)
      for (std::size_t j = 0; j < size_; ++j)
        pairs_[i * size_ + j] = derived(static_cast<material_id>(i), static_cast<material_id>(j));
  }
  /// Whether pair() returns values that stay where they are until materials change.
  [[nodiscard]] bool holds_all() const { return size_ != 0; }
  /// Valid until the next call.
  [[nodiscard]] const parameters& pair(material_id a, material_id b) {
    if (size_ != 0)
      return pairs_[static_cast<std::size_t>(a) * size_ + static_cast<std::size_t>(b)];
    return of_many(a, b);
  }
  /// The range beyond its surface of a body of this material and radius on any other one.
  [[nodiscard]] real range(material_id m, real radius) const {
    real furthest = 0;
    const parameters* row = pairs_.data() + static_cast<std::size_t>(m) * size_;
    for (std::size_t j = 0; j < size_; ++j)
      if (row[j].known) furthest = std::max(furthest, Law::range(row[j], radius));
    return furthest;
  }
  /// Throws runtime_error if this part has no parameters for a pair.
  template <class Part>
  void require_part(material_id a, material_id b) const {
    if constexpr (!combines<Part>)
      if (given<Part>().find(number(a), number(b)) == nullptr)
        fail<std::runtime_error>(
            "{} has no parameters for the materials {} and {}: give them to world.interaction, as "
            "a value of {}::{}",
            Part::name, number(a), number(b), Part::name, given_name<Part>);
  }
  /// Throws runtime_error for a touching pair of bodies whose parameters were not set.
  static void require_known(const parameters& p, material_id a, material_id b) {
    if constexpr (Law::needs_parameters)
      if (!p.known) refuse_unknown(a, b);
  }
  [[nodiscard]] std::size_t bytes() const {
    return pairs_.capacity() * sizeof(parameters) + met_.bytes();
  }

 private:
  static std::uint32_t number(material_id m) { return static_cast<std::uint32_t>(m); }

  [[nodiscard]] parameters derived(material_id a, material_id b) const {
    parameters all;
    const material &x = (*materials_)[a], &y = (*materials_)[b];
    const pair_material both = materials_->pair(a, b);
    (derive<Parts>(all, a, b, x, y, both), ...);
    return all;
  }
  template <class Part>
  void derive(parameters& all, material_id a, material_id b, const material& x, const material& y,
              const pair_material& both) const {
    auto& own = Law::template of<Part>(all);
    if (const auto* given = given_parameters<Part>::of_pairs.find(number(a), number(b))) {
      if constexpr (requires { typename Part::given; })
        own = Part::combine(x, y, both, *given);
      else
        own = *given;
    } else if constexpr (combines<Part>)
      own = Part::combine(x, y, both);
    else
      all.known = false;
  }
  [[nodiscard, gnu::noinline]] const parameters& of_many(material_id a, material_id b) {
    const auto i = static_cast<std::uint32_t>(a), j = static_cast<std::uint32_t>(b);
    if (const parameters* known = met_.find(i, j)) return *known;
    met_.set(i, j, derived(std::min(a, b), std::max(a, b)));
    return *met_.find(i, j);
  }
  static void require_few(const material_table& materials) {
    if (materials.size() > few)
      fail<std::runtime_error>(
          "a contact law that acts beyond touch takes at most {} materials, and this world has {}: "
          "reuse some of them",
          few, materials.size());
  }
  [[gnu::cold, gnu::noinline]] static void refuse_unknown(material_id a, material_id b) {
    const char *name = "", *type = "";
    const auto look = [&]<class Part>() {
      if (!combines<Part>) name = Part::name, type = given_name<Part>;
    };
    (look.template operator()<Parts>(), ...);
    fail<std::runtime_error>(
        "bodies of the materials {} and {} touch, and {} has no parameters for that pair: give "
        "them to world.interaction, as a value of {}::{}",
        number(a), number(b), name, name, type);
  }

  const material_table* materials_ = nullptr;
  plain_vector<parameters> pairs_;
  pair_table<parameters> met_;  ///< for more than a few materials
  std::size_t size_ = 0;        ///< of `pairs_`; 0 for more
  std::uint64_t revision_ = 0;  ///< of an empty table
  std::uint64_t given_ = 0;     ///< number of calls that set parameters
};

template <class Law>
using pair_parameters_of = pair_parameters<Law, typename Law::parts>;

/// The part that is given this type, or void.
template <class Parameters, class Parts>
struct part_with;
template <class Parameters>
struct part_with<Parameters, type_list<>> {
  using type = void;
};
template <class Parameters, class First, class... Rest>
struct part_with<Parameters, type_list<First, Rest...>> {
  using type = typename std::conditional_t<std::is_same_v<Parameters, given_of<First>>,
                                           std::type_identity<First>,
                                           part_with<Parameters, type_list<Rest...>>>::type;
};

}  // namespace talus::detail
