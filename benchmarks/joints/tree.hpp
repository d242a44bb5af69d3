#pragma once
// A spanning tree of the joints, for engines with joint coordinates. The joints that are not in
// the tree close the loops.
#include <vector>

#include "scene.hpp"

namespace bench::joints {

struct tree {
  std::vector<int> joint_of;   ///< the joint that moves each body, -1: none, the body is free
  std::vector<int> parent_of;  ///< the body it hangs on, or ground
  std::vector<int> order;      ///< the bodies, parents first
  std::vector<int> loops;      ///< the other joints
};

inline tree tree_of(const scene& s) {
  tree t;
  t.joint_of.assign(s.bodies.size(), -1);
  t.parent_of.assign(s.bodies.size(), ground);
  std::vector<bool> placed(s.bodies.size(), false), used(s.joints.size(), false);
  for (bool grown = true; grown;) {
    grown = false;
    for (std::size_t i = 0; i < s.joints.size(); ++i) {
      const joint& j = s.joints[i];
      if (used[i] || placed[j.b] || (j.a != ground && !placed[j.a])) continue;
      t.joint_of[j.b] = static_cast<int>(i);
      t.parent_of[j.b] = j.a;
      t.order.push_back(j.b);
      placed[j.b] = used[i] = grown = true;
    }
  }
  for (std::size_t i = 0; i < s.joints.size(); ++i)
    if (!used[i]) t.loops.push_back(static_cast<int>(i));
  for (std::size_t i = 0; i < s.bodies.size(); ++i)
    if (!placed[i]) t.order.push_back(static_cast<int>(i));
  return t;
}

}  // namespace bench::joints
