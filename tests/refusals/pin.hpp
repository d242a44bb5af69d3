#pragma once
// A kind of joint that is declared well enough to be named in joints<...>.
#include "talus/scenario/scenario.hpp"

struct pin {
  using talus_part_of = talus::roles::joints;
  static constexpr const char* name = "pin";
  struct anchors {
    talus::real length = 0;
  };
  void validate() const;
  anchors fix(const talus::pose&, const talus::pose&) const;
  static talus::real distance(const anchors&);

  template <class State>
  struct row {
    using state = State;
    using change = talus::vec3;
    using anchors = pin::anchors;
    static constexpr bool paired = true;
    static constexpr int rows = 3;
    std::int32_t a, b;
    void place(const anchors&, const talus::detail::jointed_body&,
               const talus::detail::jointed_body&, talus::real);
    void prepare(const state&, talus::real, talus::real);
    change relax(const state&);
    void apply(state&, const change&) const;
    void apply_to_a(state&, const change&) const;
    void apply_to_b(state&, const change&) const;
    change impulse_in_frame() const;
    change since(const change&) const;
    void set(const change&);
    change relative_velocity(const state&) const;
    talus::real delassus_trace(const state&) const;
    talus::real speed_of(const change&) const;
    change relax_correction(const state&);
    void correct_a(state&, const change&) const;
    void correct_b(state&, const change&) const;
    talus::wrench on_a() const;
    talus::wrench on_b() const;
  };
};
