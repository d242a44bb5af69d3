#pragma once
// Impulses or velocities of many contacts, three numbers each.
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <utility>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// A vector of blocks of three. Sums and products give vectors.
class contact_vector {
 public:
  contact_vector() = default;
  explicit contact_vector(int contacts) { set_zero(contacts); }
  contact_vector(std::initializer_list<vec3> blocks) : blocks_(blocks) {}
  contact_vector(const real* from, int contacts) : contact_vector(contacts) {
    for (int i = 0; i < contacts; ++i)
      for (int k = 0; k < 3; ++k) (*this)(i)[k] = from[3 * i + k];
  }

  [[nodiscard]] int contacts() const { return static_cast<int>(blocks_.size()); }
  void resize(int contacts) { blocks_.resize(static_cast<std::size_t>(contacts)); }
  void set_zero(int contacts) { blocks_.assign(static_cast<std::size_t>(contacts), vec3{0, 0, 0}); }

  [[nodiscard]] vec3& operator()(int contact) { return blocks_[static_cast<std::size_t>(contact)]; }
  [[nodiscard]] const vec3& operator()(int contact) const {
    return blocks_[static_cast<std::size_t>(contact)];
  }
  // All numbers in a row.
  [[nodiscard]] real* data() { return blocks_.empty() ? nullptr : blocks_[0].data(); }
  [[nodiscard]] const real* data() const { return blocks_.empty() ? nullptr : blocks_[0].data(); }
  [[nodiscard]] std::size_t size() const { return 3 * blocks_.size(); }
  [[nodiscard]] const real* begin() const { return data(); }
  [[nodiscard]] const real* end() const { return data() + size(); }

  [[nodiscard]] real dot(const contact_vector& x) const {
    real sum = 0;
    for (std::size_t i = 0; i < blocks_.size(); ++i) sum += blocks_[i].dot(x.blocks_[i]);
    return sum;
  }
  [[nodiscard]] real norm() const { return std::sqrt(dot(*this)); }
  [[nodiscard]] bool is_finite() const {
    for (const real x : *this)
      if (!std::isfinite(x)) return false;
    return true;
  }
  /// Adds `factor` times x.
  void add(real factor, const contact_vector& x) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) blocks_[i] += factor * x.blocks_[i];
  }
  contact_vector& operator+=(const contact_vector& x) { return add(1, x), *this; }
  contact_vector& operator-=(const contact_vector& x) { return add(-1, x), *this; }
  contact_vector& operator*=(real factor) {
    for (vec3& b : blocks_) b *= factor;
    return *this;
  }
  friend contact_vector operator+(contact_vector x, const contact_vector& y) { return x += y; }
  friend contact_vector operator-(contact_vector x, const contact_vector& y) { return x -= y; }
  friend contact_vector operator*(real factor, contact_vector x) { return x *= factor; }
  friend bool operator==(const contact_vector& x, const contact_vector& y) {
    if (x.size() != y.size()) return false;
    for (std::size_t k = 0; k < x.size(); ++k)
      if (x.data()[k] != y.data()[k]) return false;
    return true;
  }

 private:
  plain_vector<vec3> blocks_;
};

}  // namespace talus::detail
