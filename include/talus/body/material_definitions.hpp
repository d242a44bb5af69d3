#pragma once
// The definitions of material.hpp, in the compiled part or in each program.
#include "talus/body/material.hpp"
#include "talus/core/linkage.hpp"

namespace talus {

TALUS_INLINE material_id material_table::add(const material& m) {
  detail::require_positive(m.density, "the density of a material");
  check(m.restitution, m.friction, m.sliding_friction());
  check_soft(m);
  if (materials_.size() >= std::numeric_limits<std::uint16_t>::max())
    detail::fail<std::invalid_argument>("a world holds at most 65535 materials; reuse them");
  materials_.push_back(m);
  means_.push_back({m.restitution, m.friction, m.sliding_friction(), 0});
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
  means_[index(a)].has_pairs = means_[index(b)].has_pairs = 1;
  ++revision_;
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
