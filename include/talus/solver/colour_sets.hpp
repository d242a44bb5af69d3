#pragma once
// The colours of the contacts of each body.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// A set of colours for each body, without a limit: the first 64 in a word of its own, further ones
/// only for bodies with so many contacts.
class colour_sets {
 public:
  static constexpr std::uint32_t in_word = 64;

  void reset(std::size_t bodies) {
    first_.assign(bodies, 0);
    more_.clear();
  }
  void take(std::int32_t body, std::uint32_t colour) {
    if (colour < in_word) {
      first_[static_cast<std::size_t>(body)] |= std::uint64_t{1} << colour;
      return;
    }
    auto& words = more_[body];
    if (words.size() < colour / in_word) words.resize(colour / in_word, 0);
    words[colour / in_word - 1] |= std::uint64_t{1} << colour % in_word;
  }
  /// The lowest colour that neither of two bodies has (b may be -1: no body), and that is not in
  /// `others`.
  [[nodiscard]] std::uint32_t lowest_free(std::int32_t a, std::int32_t b,
                                          std::span<const std::uint64_t> others = {}) const {
    for (std::uint32_t k = 0;; ++k) {
      std::uint64_t taken = word(a, k);
      if (b >= 0) taken |= word(b, k);
      if (k < others.size()) taken |= others[k];
      if (~taken != 0) return k * in_word + static_cast<std::uint32_t>(std::countr_one(taken));
    }
  }
  /// The set of a body as words.
  [[nodiscard]] std::vector<std::uint64_t> words(std::int32_t body) const {
    std::vector<std::uint64_t> all{word(body, 0)};
    if (const auto at = more_.find(body); at != more_.end())
      all.insert(all.end(), at->second.begin(), at->second.end());
    return all;
  }

 private:
  [[nodiscard]] std::uint64_t word(std::int32_t body, std::uint32_t k) const {
    if (k == 0) return first_[static_cast<std::size_t>(body)];
    if (more_.empty()) return 0;
    const auto at = more_.find(body);
    return at != more_.end() && k <= at->second.size() ? at->second[k - 1] : 0;
  }

  plain_vector<std::uint64_t> first_;
  std::unordered_map<std::int32_t, std::vector<std::uint64_t>> more_;
};

}  // namespace talus::detail
