#pragma once
// The definitions of row_table.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/row_table.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE row_table& row_table::column(const char* name, number_type type,
                                               std::uint32_t width) {
  part_.columns.push_back({name, type, width});
  part_.memory.emplace_back();
  return *this;
}

TALUS_HDF5_INLINE void row_table::begin_row(const key& k) {
  keys_.push_back(k);
  next_ = 0;
}

TALUS_HDF5_INLINE table_part row_table::take() {
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

}  // namespace talus::detail
