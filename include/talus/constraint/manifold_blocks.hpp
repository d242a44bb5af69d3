#pragma once
// Manifolds in blocks, of as many as a pack has lanes; one that is alone in its block by itself.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>

#include "talus/constraint/manifold_block.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Blocks of manifolds, as many manifolds in each as a pack has lanes. The contacts hold the
/// impulses; the prepared data are stored here. A manifold that is alone in its block, as in a
/// stack, is computed with numbers instead of packs: less work, the same bits.
template <class Contact, class Pack>
class manifold_blocks {
  using work = manifold_work<Contact, Pack>;
  using block = manifold_block<Contact, Pack>;
  using layer = manifold_layer<Contact, Pack>;
  using number = lane_of<Pack>;

 public:
  static constexpr std::size_t lanes = lanes_of<Pack>;

  void clear() { runs_.clear(), used_ = 0; }
  [[nodiscard]] std::size_t size() const { return used_; }
  /// Contacts [first, last) are a manifold, for that lane of all blocks.
  void add(std::size_t slot, std::size_t first, std::size_t last) {
    const auto at = slot / lanes;
    for (; used_ <= at; ++used_) {
      if (used_ == blocks_.size()) blocks_.emplace_back();
      blocks_[used_].depth = blocks_[used_].filled = 0;
    }
    block& b = blocks_[at];
    b.depth = std::max(b.depth, static_cast<std::uint32_t>(last - first));
    ++b.filled;
    runs_.push_back({static_cast<std::uint32_t>(slot), static_cast<std::uint32_t>(first),
                     static_cast<std::uint32_t>(last)});
  }
  /// `spare` is the contact of empty places.
  void prepare(plain_vector<Contact>& contacts, Contact& spare, const solver_state& s) {
    fill(contacts, spare);
    prepare_again(s);
  }
  /// After tensors of inertia have changed.
  void prepare_again(const solver_state& s) {
    each(0, used_, [&](auto w, auto& b, auto* l) { w.prepare(b, l, s); });
  }
  /// Sweeps over the blocks [first, last).
  void sweep_forward(std::size_t first, std::size_t last, solver_state& s) {
    const auto silent = [](auto&&...) {};
    each(first, last,
         [&](auto w, auto& b, auto* l) { w.template sweep<true, false>(b, l, s, silent); });
  }
  template <bool Watched, class Note>
  void sweep_backward(std::size_t first, std::size_t last, solver_state& s, Note& note) {
    for (std::size_t k = last; k-- > first;)
      visit(blocks_[k],
            [&](auto w, auto& b, auto* l) { w.template sweep<false, Watched>(b, l, s, note); });
  }
  template <bool First>
  void correct(std::size_t first, std::size_t last, solver_state& s) {
    each(first, last, [&](auto w, auto& b, auto* l) { w.template correct<First>(b, l, s); });
  }
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.capacity() * sizeof(block) + layers_.capacity() * sizeof(layer) +
           alone_.capacity() * sizeof(alone_[0]) +
           layers_alone_.capacity() * sizeof(layers_alone_[0]) + runs_.capacity() * sizeof(run);
  }

 private:
  struct run {
    std::uint32_t slot, first, last;
  };

  /// f(work, block, its layers), of packs or of numbers.
  template <class F>
  void visit(block& b, F&& f) {
    if constexpr (lanes > 1)
      if (is_alone(b)) {
        auto& one = alone_[b.first];
        f(manifold_work<Contact, number>{}, one, layers_alone_.data() + one.first);
        return;
      }
    if (b.filled > 0) f(work{}, b, layers_.data() + b.first);
  }
  template <class F>
  void each(std::size_t first, std::size_t last, F&& f) {
    for (std::size_t k = first; k < last; ++k) visit(blocks_[k], f);
  }
  static bool is_alone(const block& b) { return lanes > 1 && b.filled == 1; }
  /// Records in the blocks which contacts are theirs.
  void fill(plain_vector<Contact>& contacts, Contact& spare) {
    std::uint32_t count = 0, count_alone = 0;
    alone_.clear();
    for (std::size_t k = 0; k < used_; ++k) {
      block& b = blocks_[k];
      if (is_alone(b)) {
        b.first = static_cast<std::uint32_t>(alone_.size());
        auto& one = alone_.emplace_back();
        one.first = count_alone, one.depth = b.depth, one.filled = 1;
        count_alone += b.depth;
      } else {
        b.first = count;
        count += b.depth;
      }
    }
    if (layers_.size() < count) layers_.resize(count);
    if (layers_alone_.size() < count_alone) layers_alone_.resize(count_alone);
    for (std::size_t k = 0; k < count; ++k) {
      layers_[k].present = mask_of<Pack>{};
      for (Contact*& c : layers_[k].at) c = &spare;
    }
    for (const run& r : runs_)
      visit(blocks_[r.slot / lanes], [&](auto, auto& b, auto* l) {
        const std::size_t wide = std::size(b.a), lane = r.slot % wide;
        const Contact& c = contacts[r.first];
        for (std::size_t i = lane; i < (lane == 0 ? wide : lane + 1); ++i)
          b.a[i] = c.a, b.b[i] = c.b;
        for (std::uint32_t i = r.first; i < r.last; ++i) {
          auto& x = l[i - r.first];
          x.at[lane] = &contacts[i];
          include_lane(x.present, lane);
        }
      });
  }

  plain_vector<block> blocks_;  ///< of which only the first are in use
  std::size_t used_ = 0;
  plain_vector<layer> layers_;                           ///< of all blocks
  plain_vector<manifold_block<Contact, number>> alone_;  ///< blocks' first is the place here
  plain_vector<manifold_layer<Contact, number>> layers_alone_;
  plain_vector<run> runs_;
};

}  // namespace talus::detail
