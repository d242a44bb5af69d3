#pragma once
// The numbers that the shapes of a scenario have in outputs and pages.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "talus/core/type_list.hpp"
#include "talus/shape/union_of.hpp"

namespace talus::detail {

/// The names of shapes by number, as the column `shape` has them: six that have their numbers in
/// all scenarios, then the others of this one.
class shape_numbers {
 public:
  static constexpr std::uint8_t usual = 6;

  shape_numbers() = default;
  template <class... Shapes>
  explicit shape_numbers(type_list<Shapes...>) {
    (add(type_list<Shapes>{}), ...);
  }
  [[nodiscard, gnu::cold]] std::uint8_t number(std::string_view name) const {
    std::uint8_t n = 0;
    while (n < names_.size() && names_[n] != name) ++n;
    return n;
  }
  /// The names after the usual ones, one a line.
  [[nodiscard, gnu::cold]] std::string others() const {
    std::string all;
    for (std::size_t k = usual; k < names_.size(); ++k) all += std::string(names_[k]) + '\n';
    return all;
  }

 private:
  template <class Shape>
  void add(type_list<Shape>) {
    if constexpr (Shape::finite) add_name(Shape::name);
  }
  template <class... Parts>
  void add(type_list<union_of<Parts...>>) {
    (add_name(Parts::name), ...);
  }
  [[gnu::cold]] void add_name(std::string_view name) {
    if (number(name) == names_.size()) names_.push_back(name);
  }

  std::vector<std::string_view> names_{
      "sphere", "box", "capsule", "cylinder", "convex_polyhedron", "triangle_mesh"};
};

}  // namespace talus::detail
