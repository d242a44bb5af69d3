#pragma once
// The parts of any_geometry outside the hot path: canonical form, nested evaluation, text.
#include "talus/core/linkage.hpp"
#include "talus/geometry/any_geometry.hpp"

namespace talus {

namespace detail {

TALUS_INLINE bool geometry_group::less(const geometry_group& other) const {
  if (all_of != other.all_of) return all_of;
  if (planes != other.planes) return planes < other.planes;
  for (std::size_t i = 0; i < std::min(groups.size(), other.groups.size()); ++i)
    if (groups[i] != other.groups[i]) return groups[i].less(other.groups[i]);
  return groups.size() < other.groups.size();
}

/// Adds a half-space. If another one is parallel to it, an intersection keeps the tighter one, and
/// a merge the wider one.
TALUS_INLINE void geometry_group::add(const half_space& h) {
  auto at = planes.begin();
  for (; at != planes.end(); ++at) {
    if (at->normal() == h.normal()) {
      if (all_of == (*at < h)) *at = h;
      return;
    }
    if (h < *at) break;
  }
  planes.insert(at, h);
}

TALUS_INLINE void geometry_group::add(geometry_group&& group) {
  auto at = groups.begin();
  for (; at != groups.end() && !group.less(*at); ++at)
    if (*at == group) return;
  groups.insert(at, std::move(group));
}

TALUS_INLINE void geometry_group::settle() {
  for (const half_space& h : std::exchange(planes, {})) add(h);
  for (auto& group : std::exchange(groups, {})) {
    const std::size_t parts = group.planes.size() + group.groups.size();
    if (group.all_of != all_of && parts > 1) {
      add(std::move(group));
    } else if (group.all_of != all_of && parts == 0) {
      *this = group;  // nothing, within an intersection; all of space, within a merge
      return;
    } else {
      for (const half_space& h : group.planes) add(h);
      // A single nested group is of this kind again: its parts join this group.
      for (auto& inner : group.groups) {
        if (inner.all_of != all_of) {
          add(std::move(inner));
          continue;
        }
        for (const half_space& h : inner.planes) add(h);
        for (auto& deeper : inner.groups) add(std::move(deeper));
      }
    }
  }
}

TALUS_INLINE void geometry_builder::close() {
  geometry_group done = std::move(path_.back());
  path_.pop_back();
  done.settle();
  path_.back().groups.push_back(std::move(done));
}

/// Writes a region as nested calls of intersect and merge.
struct geometry_text {
  std::string text;
  void open(bool all_of) { separate(), text += all_of ? "intersect(" : "merge("; }
  void plane(const half_space& h) { separate(), text += to_string(h); }
  void close() { text += ')'; }
  void separate() {
    if (!text.empty() && text.back() != '(') text += ", ";
  }
};

/// Forwards the complement of its input.
struct geometry_flip {
  geometry_builder& to;
  void open(bool all_of) { to.open(!all_of); }
  void plane(const half_space& h) { to.plane(h.flipped()); }
  void close() { to.close(); }
};

}  // namespace detail

TALUS_INLINE void any_geometry::adopt(detail::geometry_builder& builder) {
  detail::geometry_group root = builder.root();
  root.settle();
  while (root.planes.empty() && root.groups.size() == 1) {
    detail::geometry_group only = std::move(root.groups.front());
    root = std::move(only);
  }
  if (root.planes.size() == 1 && root.groups.empty()) root.all_of = true;
  planes_.clear(), program_.clear();
  depth_ = emit(root, 1);
  all_of_ = root.all_of;
  if (root.groups.empty()) program_.clear();
}

TALUS_INLINE int any_geometry::emit(const detail::geometry_group& group, std::size_t nesting) {
  if (nesting > max_nesting_)
    detail::fail<std::invalid_argument>(
        "a geometry nests intersect and merge more than {} levels deep; "
        "describe the region by fewer nested parts",
        max_nesting_);
  constexpr int none = 1 << 20;
  int depth = group.all_of ? 0 : none;
  const auto add = [&](int d) { depth = group.all_of ? depth + d : std::min(depth, d); };
  program_.push_back(group.all_of ? token::open_all : token::open_any);
  for (const half_space& h : group.planes) {
    planes_.push_back(h);
    program_.push_back(token::plane);
    add(1);
  }
  for (const auto& inner : group.groups) add(emit(inner, nesting + 1));
  program_.push_back(token::close);
  return depth;
}

TALUS_INLINE real any_geometry::run(const vec3& p) const {
  struct level {
    real value;
    bool all_of;
    void fold(real v) { value = all_of ? std::min(v, value) : std::max(v, value); }
  };
  std::array<level, max_nesting_ + 1> stack;
  stack[0] = {neutral(true), true};
  level* top = stack.data();
  const half_space* plane = planes_.data();
  for (const token t : program_) {
    if (t == token::plane) {
      top->fold((plane++)->value(p));
    } else if (t == token::close) {
      --top;
      top->fold(top[1].value);
    } else {
      *++top = {neutral(t == token::open_all), t == token::open_all};
    }
  }
  return stack[0].value;
}

TALUS_INLINE bool any_geometry::run_owns(const vec3& p) const {
  std::array<std::pair<bool, bool>, max_nesting_ + 1> stack;  // inside so far, all_of
  std::size_t top = 0;
  stack[0] = {true, true};
  const half_space* plane = planes_.data();
  const auto fold = [&](bool in) {
    auto& [inside, all_of] = stack[top];
    inside = all_of ? inside && in : inside || in;
  };
  for (const token t : program_) {
    if (t == token::plane) {
      fold((plane++)->owns(p));
    } else if (t == token::close) {
      --top;
      fold(stack[top + 1].first);
    } else {
      stack[++top] = {t == token::open_all, t == token::open_all};
    }
  }
  return stack[0].first;
}

TALUS_INLINE any_geometry complement(const any_geometry& g) {
  detail::geometry_builder builder;
  detail::geometry_flip flip{builder};
  g.describe(flip);
  any_geometry result;
  result.adopt(builder);
  return result;
}

TALUS_INLINE std::string to_string(const any_geometry& g) {
  if (g.planes().empty()) return g.convex() ? "all of space" : "nothing";
  if (g.planes().size() == 1) return to_string(g.planes()[0]);
  detail::geometry_text text;
  g.describe(text);
  return text.text;
}

}  // namespace talus
