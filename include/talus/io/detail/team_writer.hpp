#pragma once
// Writing an HDF5 file with all ranks: rank 0 composes the file in memory, without its rows, and
// writes it to a file beside the old one, with room on the disk for everything; then all ranks
// write their rows; then rank 0 adds the rest, all ranks read back what they have written, and the
// file is renamed. Before that, the old file is unchanged in any case.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/output_file.hpp"
#include "talus/io/detail/checkpoint_table.hpp"
#include "talus/io/detail/checkpoint_team.hpp"
#include "talus/io/detail/file_kind.hpp"
#include "talus/io/detail/hdf5.hpp"
#include "talus/io/detail/hdf5_image.hpp"
#include "talus/io/detail/system_file.hpp"

namespace talus::detail {

class team_writer {
  static_assert(std::endian::native == std::endian::little, "these files are little-endian");

 public:
  /// With `force` it also replaces a file of another kind.
  team_writer(checkpoint_team& team, file_kind& kind, std::string file, bool force = false)
      : team_(team), kind_(kind), file_(std::move(file)), force_(force) {}

  /// Collective; `small` is that of rank 0. Throws runtime_error alike on all ranks.
  [[gnu::cold]] void write(std::vector<table_part>& tables,
                           const std::vector<small_dataset>& small);

  /// Collective. Throws runtime_error if the file could not be made, before hours of computing.
  /// True if a file of this kind exists, which will be replaced; on rank 0 alone.
  [[gnu::cold]] bool require_writable();

 private:
  /// Rows of this rank in one dataset.
  struct row_block {
    std::uint64_t at = 0;  ///< in the file
    std::span<const std::byte> bytes;
  };

  template <class F>
  void together(F&& f) {
    try {
      team_.together([&] {
        try {
          f();
        } catch (const std::exception& e) {
          fail<std::runtime_error>("{} {} {}", kind_.name(), file_, e.what());
        }
      });
    } catch (...) {
      opened_.reset();
      part_ = {};
      throw;
    }
  }

  bool require_replaceable() const;
  void make_part();
  /// Throws runtime_error for a failed write that still needs `needs` bytes; `error` is its errno.
  [[noreturn]] void fail_to_write(std::uint64_t needs, int error) const;

  /// On rank 0: a file in which every dataset has its position, and all but rows is written.
  void make_file(const std::vector<table_part>& tables, const counted_rows& counts,
                 const std::vector<small_dataset>& small);
  void compose(const std::vector<table_part>& tables, const counted_rows& counts,
               const std::vector<small_dataset>& small);
  void make_table(hid_t file, const table_part& t, std::size_t k, const counted_rows& counts);

  /// Collective: the positions of the datasets of the tables, and their file.
  void share_layout();
  [[nodiscard]] std::vector<row_block> rows_of(const std::vector<table_part>& tables,
                                               const std::vector<table_place>& places) const;
  /// Other machines may see a new file on a shared disk a moment late.
  void open_part();
  void write_rows(const std::vector<row_block>& rows) const;
  /// Flushes this machine's buffers of it to the disk.
  void bring_to_disk() const;
  void seal() const;
  /// Each rank reads what it has written, from the disk if the system drops its cache.
  void verify(const std::vector<row_block>& rows) const;
  void give_name();

  checkpoint_team& team_;
  file_kind& kind_;
  std::string file_;
  bool force_;
  std::string part_name_;
  std::vector<std::uint64_t> begin_;   ///< of the datasets of the tables
  std::optional<system_file> opened_;  ///< the file beside, on each rank
  // On rank 0:
  part_file part_;
  std::optional<sparse_bytes> image_;
  std::uint64_t bytes_ = 0;  ///< of the file
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/team_writer_definitions.hpp"
#endif
