// expects: takes a solver, and this type lacks the static function solve(
#include "talus/scenario/scenario.hpp"
using namespace talus;

struct tagged {
  using talus_part_of = roles::solver;
  static constexpr const char* name = "tagged";
#ifdef TALUS_CONTROL
  template <class Lists, class State, class Ranks>
  static detail::solved solve(Lists&, State&, const solver_settings&, bool, Ranks&&);
#endif
};

using scene = scenario<solver<tagged>>;

const scene checked;

int main() {}
