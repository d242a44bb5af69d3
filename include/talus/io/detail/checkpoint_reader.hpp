#pragma once
// Reading a checkpoint: the first block and all descriptions of the tables are checked before HDF5
// reads them, the rows as they are read.
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "talus/io/detail/checkpoint_block.hpp"
#include "talus/io/detail/checkpoint_table.hpp"
#include "talus/io/detail/checkpoint_writer.hpp"
#include "talus/io/detail/hdf5.hpp"

namespace talus::detail {

/// An open checkpoint. Holds HDF5's mutex during its lifetime: each rank reads by itself.
class checkpoint_reader {
 public:
  /// Throws runtime_error for a file that cannot be opened, is not a checkpoint, or is damaged.
  [[gnu::cold]] explicit checkpoint_reader(const std::string& name);

  /// Whether there is such a dataset.
  [[nodiscard]] bool has(const std::string& path) const {
    return H5Lexists(*file_, path.c_str(), H5P_DEFAULT) > 0;
  }
  /// All numbers of a small dataset. `rows` is the required number, or `any`.
  static constexpr std::uint64_t any = ~std::uint64_t{0};
  template <class T>
  [[nodiscard]] std::vector<T> numbers(const std::string& path, number_type type,
                                       std::uint64_t rows = any, std::uint32_t width = 1) const {
    const open_dataset set(*file_, path, type, width);
    if ((rows != any && set.rows() != rows) || set.rows() > most_small)
      fail<std::runtime_error>("is damaged: its dataset {} is not what it should be", path);
    std::vector<T> values(set.rows() * width);
    set.read(0, set.rows(), values.data());
    return values;
  }
  [[nodiscard]] std::vector<double> reals(const std::string& path, std::uint64_t rows = any,
                                          std::uint32_t width = 1) const {
    return numbers<double>(path, number_type::f64, rows, width);
  }
  [[nodiscard]] std::vector<std::uint64_t> integers(const std::string& path,
                                                    std::uint64_t rows = any,
                                                    std::uint32_t width = 1) const {
    return numbers<std::uint64_t>(path, number_type::u64, rows, width);
  }
  /// The numbers in a row of a dataset of reals.
  [[nodiscard]] std::uint32_t width(const std::string& path) const {
    return open_dataset(*file_, path, number_type::f64, 0).width();
  }
  [[nodiscard]] std::string text(const std::string& path) const;
  [[nodiscard]] table_reader table(const std::string& path, std::vector<table_column> columns,
                                   bool extras) const {
    return {*file_, path, std::move(columns), extras};
  }

 private:
  static constexpr std::uint64_t most_small = 1 << 24;
  std::unique_lock<std::mutex> only_;
  silent_hdf5 silent_;
  std::optional<hdf5_handle> file_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/checkpoint_reader_definitions.hpp"
#endif
