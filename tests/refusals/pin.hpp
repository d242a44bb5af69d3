#pragma once
// A kind of joint that is declared well enough to be named in joints<...>.
#include "talus/scenario/scenario.hpp"

struct pin {
  using talus_part_of = talus::roles::joints;
  static constexpr const char* name = "pin";
  static constexpr int rows = 3;
  struct anchors {
    talus::detail::joint_frames frames;
  };
  void validate() const;
  anchors fix(const talus::pose&, const talus::pose&) const;
  static void write(const anchors&, talus::detail::line_writer&);
};
