#pragma once
// Warm starting: contacts load their impulses of the last step.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>

#include "talus/contact/history.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// A kind of contact with several per pair of bodies.
template <class Contact>
concept comes_in_manifolds = Contact::manifolds;

/// A kind of contact whose impulse is stored in a frame around its normal.
template <class Contact>
concept framed = requires(const Contact c, const mat3& frame) {
  c.impulse(frame);
};

/// The entries of one pair of bodies in the history: consecutive, or found by key.
class kept_pair {
 public:
  kept_pair(const contact_history& history, const contact_key& key, const history_place* place)
      : history_(history), key_(key), searched_(place == nullptr) {
    if (searched_) return;
    const auto at = *place == history_place::arrived ? history.find_arrived(key) : *place;
    if (at == history_place::none) return;
    row_ = history.row(at, key);
    searched_ = row_.empty();
  }
  [[nodiscard]] const vec3* find(const contact_key& key) const {
    if (searched_) return history_.find(key);
    for (const stored_contact& old : row_)
      if (old.key.feature == key.feature) return &old.memory;
    return nullptr;
  }
  /// Whether its entries are those of these points, in this order.
  [[nodiscard]] bool same_points(std::span<const contact_key> keys) const {
    if (searched_ || row_.size() != keys.size()) return false;
    for (std::size_t k = 0; k < keys.size(); ++k)
      if (row_[k].key.feature != keys[k].feature) return false;
    return true;
  }
  /// The entries of the row.
  [[nodiscard]] std::span<const stored_contact> row() const { return row_; }
  template <class F>
  void each(F&& f) const {
    if (searched_) return history_.each_of_pair(key_, f);
    for (const stored_contact& old : row_) f(old);
  }

 private:
  const contact_history& history_;
  const contact_key& key_;
  std::span<const stored_contact> row_;
  bool searched_;
};

/// The stored impulses of a pair of bodies; of more points than there is room, none.
class stored_pair {
 public:
  explicit stored_pair(const kept_pair& kept) {
    kept.each([&](const stored_contact& old) {
      if (size_ < most) found_[size_] = {&old, false};
      ++size_;
    });
  }
  [[nodiscard]] bool complete() const { return size_ <= most; }
  /// The impulse of a point, which is then marked as found; or null.
  [[nodiscard]] const vec3* find(const contact_key& key) {
    for (std::size_t k = 0; k < size_; ++k)
      if (found_[k].old->key.feature == key.feature) {
        found_[k].present = true;
        return &found_[k].old->memory;
      }
    return nullptr;
  }
  /// The sum of those that were not found, in an order that does not depend on where they are
  /// stored: ranks must agree to the bit.
  [[nodiscard]] vec3 lost() {
    const auto end = std::remove_if(found_.begin(), found_.begin() + size_,
                                    [](const entry& e) { return e.present; });
    std::sort(found_.begin(), end, [](const entry& x, const entry& y) {
      return x.old->key.feature < y.old->key.feature;
    });
    vec3 sum{0, 0, 0};
    for (auto e = found_.begin(); e != end; ++e) sum += e->old->memory;
    return sum;
  }

 private:
  struct entry {
    const stored_contact* old;
    bool present;
  };
  static constexpr std::size_t most = 16;
  std::array<entry, most> found_;
  std::size_t size_ = 0;
};

/// Converts impulses of contacts to and from the frames around their normals; consecutive contacts
/// with the same normal share one frame.
template <class Contact>
class shared_frame {
 public:
  void load_impulse(Contact& c, const vec3& impulse) {
    if constexpr (framed<Contact>)
      c.load_impulse(impulse, of(c));
    else
      c.load_impulse(impulse);
  }
  [[nodiscard]] vec3 impulse(const Contact& c) {
    if constexpr (framed<Contact>)
      return c.impulse(of(c));
    else
      return c.impulse();
  }

 private:
  const mat3& of(const Contact& c) {
    // To the bit: the frames around 0 and -0 are not the same.
    if (std::memcmp(&c.axis(), &normal_, sizeof normal_) != 0)
      normal_ = c.axis(), frame_ = c.axes();
    return frame_;
  }
  vec3 normal_{0, 0, 0};
  mat3 frame_ = mat3::Zero();
};

/// Warm starts the contacts of one pair from the impulses stored for their keys. The impulses of
/// points of a manifold that no longer exist are distributed to new ones, in equal parts: while a
/// body slides or rocks, the touching parts change, but hardly the load.
template <class Contact>
void recall_patch(stored_pair& before, std::span<const contact_key> keys,
                  std::span<Contact> contacts) {
  std::array<std::size_t, 64> heirs;
  std::size_t count = 0;
  shared_frame<Contact> frame;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (const vec3* p = before.find(keys[i]))
      frame.load_impulse(contacts[i], *p);
    else if (count < heirs.size())
      heirs[count++] = i;
  if (count == 0) return;
  const vec3 share = before.lost() / static_cast<real>(count);
  if (share == vec3(0, 0, 0)) return;
  for (std::size_t k = 0; k < count; ++k) frame.load_impulse(contacts[heirs[k]], share);
}

/// Warm starts each contact from the impulse stored for its key.
template <class Contact>
void load_impulses(const contact_history& history, const plain_vector<contact_key>& keys,
                   const plain_vector<history_place*>& places, plain_vector<Contact>& contacts) {
  for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
    const kept_pair kept(history, keys[first], places[first]);
    while (last < contacts.size() && keys[last].same_pair(keys[first])) ++last;
    if constexpr (comes_in_manifolds<Contact>) {
      if (kept.same_points(std::span(keys).subspan(first, last - first))) {
        shared_frame<Contact> frame;
        for (std::size_t i = first; i < last; ++i)
          frame.load_impulse(contacts[i], kept.row()[i - first].memory);
        continue;
      }
      stored_pair before(kept);
      if (before.complete()) {
        recall_patch(before, std::span(keys).subspan(first, last - first),
                     std::span(contacts).subspan(first, last - first));
        continue;
      }
    }
    for (std::size_t i = first; i < last; ++i)
      if (const vec3* p = kept.find(keys[i])) contacts[i].load_impulse(*p);
  }
}

/// The reverse; records for each pair where its contacts are stored.
template <class Contacts>
void store_impulses(contact_history& history, const plain_vector<contact_key>& keys,
                    const plain_vector<history_place*>& places, const Contacts& contacts) {
  [[maybe_unused]] shared_frame<std::remove_cvref_t<decltype(contacts[0])>> frame;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (places[i] != nullptr && (i == 0 || places[i] != places[i - 1]))
      *places[i] = history.next_place();
    if constexpr (requires { contacts.impulse(i); })
      history.add(keys[i], contacts.impulse(i));
    else
      history.add(keys[i], frame.impulse(contacts[i]));
  }
}

}  // namespace talus::detail
