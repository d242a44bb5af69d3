#pragma once
// A table that is filled row by row and sorted, before all ranks write it.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/io/detail/checkpoint_table.hpp"

namespace talus::detail {

/// Each row is a key and one value for each column, in the order of the columns.
class row_table {
 public:
  /// The sort key; rows of equal keys stay in the order of insertion.
  using key = std::array<std::uint64_t, 3>;

  explicit row_table(std::string path) { part_.path = std::move(path); }

  row_table& column(const char* name, number_type type, std::uint32_t width = 1) {
    part_.columns.push_back({name, type, width});
    part_.memory.emplace_back();
    return *this;
  }
  void begin_row(const key& k) {
    keys_.push_back(k);
    next_ = 0;
  }
  /// Values in any number whose bytes are those of the next column.
  template <class... Values>
  void put(const Values&... values) {
    byte_writer out(part_.memory[next_++]);
    (out.put(values), ...);
  }
  [[nodiscard]] std::size_t rows() const { return keys_.size(); }

  /// The table, its rows sorted.
  [[nodiscard, gnu::cold]] table_part take() {
    std::vector<std::uint32_t> order(keys_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return keys_[a] < keys_[b]; });
    for (std::size_t k = 0; k < part_.columns.size(); ++k) {
      const std::size_t bytes = part_.columns[k].row_bytes();
      byte_buffer& all = part_.memory[k];
      if (all.size() != bytes * keys_.size())
        fail<std::logic_error>("column {} has not one value in each row", part_.columns[k].name);
      byte_buffer sorted(all.size());
      for (std::size_t i = 0; i < order.size(); ++i)
        std::memcpy(sorted.data() + i * bytes, all.data() + order[i] * bytes, bytes);
      all = std::move(sorted);
      part_.columns[k].rows = all.data();
    }
    part_.rows = keys_.size();
    return std::move(part_);
  }

 private:
  table_part part_;
  std::vector<key> keys_;
  std::size_t next_ = 0;
};

}  // namespace talus::detail
