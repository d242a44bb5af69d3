#pragma once
// The definitions of material.hpp, in the compiled part or in each program.
#include <algorithm>
#include <stdexcept>

#include "talus/body/material.hpp"
#include "talus/core/linkage.hpp"

namespace talus {

TALUS_INLINE const char* detail::name_of(pair_rule rule) {
  constexpr const char* names[] = {"mean", "least", "product", "table"};
  return names[static_cast<std::size_t>(rule)];
}

TALUS_INLINE material_id material_table::add(const material& m) {
  detail::require_positive(m.density, "the density of a material");
  check(m.restitution, m.friction, m.sliding_friction());
  check_soft(m);
  const vec3& c = m.colour;
  if ((c[0] == c[0] || c[1] == c[1] || c[2] == c[2]) &&
      !(c[0] >= 0 && c[0] <= 1 && c[1] >= 0 && c[1] <= 1 && c[2] >= 0 && c[2] <= 1))
    detail::fail<std::invalid_argument>(
        "the colour of a material has red, green and blue from 0 to 1, but is {}", detail::text(c));
  if (materials_.size() >= std::numeric_limits<std::uint16_t>::max())
    detail::fail<std::invalid_argument>("a world holds at most 65535 materials; reuse them");
  materials_.push_back(m);
  means_.push_back({m.restitution, m.friction, m.sliding_friction(), rules_ != pair_rules{}});
  rebounds_ = rebounds_ || m.restitution > 0;
  ++revision_;
  return material_id{static_cast<std::uint16_t>(materials_.size() - 1)};
}

TALUS_INLINE void material_table::set_pair(material_id a, material_id b, const pair_material& p) {
  const pair_material all{p.restitution, p.friction, p.sliding_friction(), p.cohesion};
  check(all.restitution, all.friction, all.dynamic_friction);
  if (!(p.cohesion >= 0) || !std::isfinite(p.cohesion))
    detail::fail<std::invalid_argument>(
        "the cohesion of a pair of materials must be finite and not negative, but is {}",
        p.cohesion);
  require_known(a);
  require_known(b);
  pairs_.set(number(a), number(b), all);
  rebounds_ = rebounds_ || p.restitution > 0;
  means_[index(a)].looked_up = means_[index(b)].looked_up = 1;
  ++revision_;
}

TALUS_INLINE void material_table::set_rules(const pair_rules& rules) {
  for (const pair_rule rule : {rules.restitution, rules.friction})
    if (rule > pair_rule::table)
      detail::fail<std::invalid_argument>(
          "the rule of a pair of materials is mean, least, product or table, but is {}",
          static_cast<int>(rule));
  if (rules == rules_) return;
  rules_ = rules;
  for (contribution& m : means_) m.looked_up = 1;
  ++revision_;
}

TALUS_INLINE pair_material material_table::looked_up(material_id a, material_id b) const {
  if (const pair_material* own = own_pair(a, b)) return *own;
  return by_rule(a, b);
}

TALUS_INLINE pair_material material_table::by_rule(material_id a, material_id b) const {
  const contribution &x = means_[index(a)], &y = means_[index(b)];
  const auto of = [&](pair_rule rule, real u, real v, const char* what) {
    if (rule == pair_rule::mean) return 0.5 * (u + v);
    if (rule == pair_rule::least) return std::min(u, v);
    if (rule == pair_rule::product) return u * v;
    detail::fail<std::runtime_error>(
        "the materials {} and {} may touch, and world.pair_rules takes the {} of a pair from the "
        "table, which has no entry for them: add one by world.material_pair",
        index(a), index(b), what);
  };
  return {of(rules_.restitution, x.restitution, y.restitution, "restitution"),
          of(rules_.friction, x.friction, y.friction, "friction"),
          of(rules_.friction, x.dynamic_friction, y.dynamic_friction, "friction")};
}

TALUS_INLINE std::string material_table::describe_rules() const {
  return detail::compose(
      "of two materials: friction by the {}, restitution by the {}; {} with values of their own",
      detail::name_of(rules_.friction), detail::name_of(rules_.restitution),
      pairs_.entries().size());
}

TALUS_INLINE void material_table::require_known(material_id m) const {
  if (index(m) >= materials_.size())
    detail::fail<std::invalid_argument>(
        "material {} is unknown to this world, which has {}; make it with world.material(...)",
        index(m), materials_.size());
}

TALUS_INLINE void material_table::check(real restitution, real friction, real dynamic) {
  if (!(restitution >= 0 && restitution <= 1))
    detail::fail<std::invalid_argument>(
        "the restitution of a material must lie in [0, 1], but is {}", restitution);
  if (!(friction >= 0) || !std::isfinite(friction))
    detail::fail<std::invalid_argument>(
        "the friction of a material must be finite and not negative, but is {}", friction);
  if (!(dynamic >= 0 && dynamic <= friction))
    detail::fail<std::invalid_argument>(
        "the dynamic friction of a material must lie between 0 and the static one, {}, but is {}",
        friction, dynamic);
}

TALUS_INLINE void material_table::check_soft(const material& m) {
  const auto not_negative = [](real value, const char* what) {
    if (!(value >= 0) || !std::isfinite(value))
      detail::fail<std::invalid_argument>("{} must be finite and not negative, but is {}", what,
                                          value);
  };
  const auto stiffness = [&](real value, const char* what) {
    if (value != rigid) not_negative(value, what);
  };
  stiffness(m.stiffness, "the stiffness of a material");
  stiffness(m.youngs_modulus, "Young's modulus of a material");
  not_negative(m.rolling_friction, "the rolling friction of a material");
  if (!(m.poisson_ratio >= 0 && m.poisson_ratio <= 0.5))
    detail::fail<std::invalid_argument>(
        "Poisson's ratio of a material must lie in [0, 0.5], but is {}", m.poisson_ratio);
}

}  // namespace talus
