#pragma once
// Writing an HDF5 file with all ranks: rank 0 makes a file beside the old one, with the place of
// everything in it fixed and reserved; then all ranks write their rows, through MPI-IO or in turns;
// then rank 0 adds what is missing and gives it its name. Whatever happens before that, the old
// file is as it was.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "talus/io/detail/checkpoint_table.hpp"
#include "talus/io/detail/checkpoint_team.hpp"
#include "talus/io/detail/file_kind.hpp"
#include "talus/io/detail/hdf5.hpp"
#include "talus/io/detail/system_file.hpp"

namespace talus::detail {

class team_writer {
 public:
  team_writer(checkpoint_team& team, file_kind& kind, std::string file)
      : team_(team), kind_(kind), file_(std::move(file)), part_(file_ + ".part") {}

  /// Collective; `small` is that of rank 0. Throws runtime_error alike on all ranks.
  [[gnu::cold]] void write(std::vector<table_part>& tables,
                           const std::vector<small_dataset>& small) {
    std::optional<no_size_signal> unharmed;  // a signal is of the process
    if (team_.rank() == 0 || team_.of_processes()) unharmed.emplace();
    try {
      const auto counts = gather_counts(team_, tables);
      team_.together([&] {
        if (team_.rank() == 0) explain([&] { make_file(tables, counts, small); });
      });
      const auto places = share_places(team_, tables.size(), counts);
      if (parallel())
        write_together(tables, places);
      else
        team_.together([&] { explain([&] { in_turns([&] { write_in_turn(tables, places); }); }); });
      team_.together([&] {
        if (team_.rank() == 0) explain([&] { finish(); });
      });
    } catch (...) {
      if (team_.rank() == 0) ::unlink(part_.c_str());
      throw;
    }
  }

  /// Throws runtime_error if the file could not be made: found out before hours of computing.
  [[gnu::cold]] void require_writable() {
    team_.together([&] {
      if (team_.rank() != 0) return;
      explain([&] {
        const bool there =
            ::access(part_.c_str(), F_OK) == 0;  // of a run that writes, or was killed
        open_part(O_RDWR | O_CREAT);
        if (!there) ::unlink(part_.c_str());
      });
    });
  }

 private:
  [[nodiscard]] bool parallel() const {
#ifdef H5_HAVE_PARALLEL
    return team_.size() > 1 && team_.communicator() != MPI_COMM_NULL;
#else
    return false;
#endif
  }

  template <class F>
  void explain(F&& f) {
    try {
      f();
    } catch (const std::exception& e) {
      fail<std::runtime_error>("{} {} {}", kind_.name(), file_, e.what());
    }
  }
  /// One rank after the other. Each takes its turn even if an earlier one has failed.
  template <class F>
  void in_turns(F&& f) {
    std::exception_ptr problem;
    for (int r = 0; r < team_.size(); ++r) {
      if (r == team_.rank()) try {
          f();
        } catch (...) {
          problem = std::current_exception();
        }
      team_.barrier();
    }
    if (problem) std::rethrow_exception(problem);
  }

  void open_part(int flags) {
    const system_file file(part_, flags);
    if (!file.good())
      fail<std::runtime_error>(
          "cannot be written: {}: {}; name a file in a folder that exists, is writable and has "
          "room",
          part_, system_words());
  }

  [[nodiscard]] static hdf5_handle access_list() {
    hdf5_handle list(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "written");
    hdf5_ok(H5Pset_libver_bounds(list, H5F_LIBVER_V18, H5F_LIBVER_V18), "written");
#if H5_VERSION_GE(1, 10, 7)
    hdf5_ok(H5Pset_file_locking(list, false, true), "written");  // network disks often refuse
#endif
    return list;
  }

  /// On rank 0: a file in which everything has its place, and all is written but rows.
  void make_file(const std::vector<table_part>& tables, const counted_rows& counts,
                 const std::vector<small_dataset>& small) {
    const std::lock_guard only(hdf5_mutex());
    const silent_hdf5 silent;
    std::size_t columns = 0;
    std::uint64_t bytes = 1 << 16;
    for (std::size_t k = 0; k < tables.size(); ++k) {
      columns += tables[k].columns.size() + 1;
      for (const auto& one : counts) {
        for (const table_column& c : tables[k].columns) bytes += one[k].rows * c.row_bytes();
        bytes += one[k].extra + kind_.more_bytes(one[k]);
      }
    }
    for (const small_dataset& s : small) bytes += s.bytes.size() + 512;
    open_part(O_RDWR | O_CREAT | O_TRUNC);
    require_size_allowed(bytes);
    {
      const hdf5_handle how(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "written");
      hdf5_ok(H5Pset_userblock(how, kind_.block_bytes(columns)), "written");
      hdf5_handle file(H5Fcreate(part_.c_str(), H5F_ACC_TRUNC, how, access_list()), H5Fclose,
                       "written");
      for (std::size_t k = 0; k < tables.size(); ++k) make_table(file, tables[k], k, counts);
      for (const small_dataset& s : small)
        write_small(file, s.path, s.type, s.rows, s.width, s.bytes.data());
      kind_.describe_file(file);
      file.close("written");
    }
    bytes_ = reserve_file(part_);
  }
  void make_table(hid_t file, const table_part& t, std::size_t k, const counted_rows& counts) {
    table_place all;
    for (const auto& one : counts) all.row += one[k].rows, all.extra += one[k].extra;
    const auto add = [&](const std::string& name, const dataset_shape& shape) {
      const std::uint64_t at = create_dataset(file, t.path + "/" + name, shape);
      if (shape.rows > 0) kind_.placed(at, shape.rows * shape.row_bytes());
    };
    for (const table_column& c : t.columns) add(c.name, {c.type, all.row, c.width});
    if (t.extras) add("extra", {number_type::u8, all.extra, 1});
    kind_.describe(file, t, k, counts);
  }
  /// The file again, on all ranks or on the one whose turn it is.
  hdf5_handle open_file() const {
    const hdf5_handle access = access_list();
#ifdef H5_HAVE_PARALLEL
    if (parallel())
      hdf5_ok(H5Pset_fapl_mpio(access, team_.communicator(), MPI_INFO_NULL), "written");
#endif
    return {H5Fopen(part_.c_str(), H5F_ACC_RDWR, access), H5Fclose, "written"};
  }
  /// The datasets of one table: its columns, and its extras.
  using table_sets = std::vector<hdf5_handle>;

  /// Through MPI-IO. All ranks have opened all datasets before the first writes to one: who failed
  /// there alone would leave the others waiting in a write that is collective.
  void write_together(const std::vector<table_part>& tables,
                      const std::vector<table_place>& places) {
    const silent_hdf5 silent;
    std::optional<hdf5_handle> file;
    std::vector<table_sets> sets;
    try {
      team_.together([&] { explain([&] { file.emplace(open_file()); }); });
      team_.together([&] { explain([&] { sets = open_sets(*file, tables); }); });
    } catch (...) {
      for (table_sets& of_table : sets)
        for (hdf5_handle& set : of_table) set.leave_open();
      if (file) file->leave_open();
      throw;
    }
    team_.together([&] { explain([&] { write_rows(*file, sets, tables, places); }); });
  }
  void write_in_turn(const std::vector<table_part>& tables,
                     const std::vector<table_place>& places) {
    const std::lock_guard only(hdf5_mutex());
    const silent_hdf5 silent;
    hdf5_handle file = open_file();
    auto sets = open_sets(file, tables);
    write_rows(file, sets, tables, places);
  }
  [[nodiscard]] static std::vector<table_sets> open_sets(hid_t file,
                                                         const std::vector<table_part>& tables) {
    std::vector<table_sets> sets;
    for (const table_part& t : tables) {
      table_sets& of_table = sets.emplace_back();
      const auto open = [&](const std::string& name) {
        of_table.emplace_back(H5Dopen2(file, (t.path + "/" + name).c_str(), H5P_DEFAULT), H5Dclose,
                              "written");
      };
      for (const table_column& c : t.columns) open(c.name);
      if (t.extras) open("extra");
    }
    return sets;
  }
  /// The rows of this rank. Where a write fails, it takes part in the others still.
  void write_rows(hdf5_handle& file, std::vector<table_sets>& sets,
                  const std::vector<table_part>& tables,
                  const std::vector<table_place>& places) const {
    std::string problem;
    const auto attempt = [&](auto&& f) {
      try {
        f();
      } catch (const std::exception& e) {
        if (problem.empty()) problem = e.what();
      }
    };
    const hdf5_handle how(H5Pcreate(H5P_DATASET_XFER), H5Pclose, "written");
#ifdef H5_HAVE_PARALLEL
    if (parallel()) hdf5_ok(H5Pset_dxpl_mpio(how, H5FD_MPIO_COLLECTIVE), "written");
#endif
    const auto write = [&](hid_t set, number_type type, std::uint32_t width, std::uint64_t first,
                           std::uint64_t rows, const std::byte* data) {
      static constexpr std::byte nothing{};
      attempt([&] {
        const hdf5_handle all(H5Dget_space(set), H5Sclose, "written");
        if (H5Sget_simple_extent_npoints(all) == 0) return;  // it has no place in the file
        const row_selection part(set, first, rows, width);
        hdf5_ok(H5Dwrite(set, type_in_memory(type), part.memory(), part.file(), how,
                         rows > 0 ? data : &nothing),
                "written");
      });
    };
    for (std::size_t k = 0; k < tables.size(); ++k) {
      const table_part& t = tables[k];
      for (std::size_t j = 0; j < t.columns.size(); ++j) {
        const table_column& c = t.columns[j];
        write(sets[k][j], c.type, c.width, places[k].row, t.rows, c.rows);
      }
      if (t.extras)
        write(sets[k].back(), number_type::u8, 1, places[k].extra, t.extra.size(), t.extra.data());
    }
    sets.clear();
    attempt([&] { file.close("written"); });
    if (kind_.durable()) attempt([&] { bring_to_disk(); });
    if (!problem.empty()) throw std::runtime_error(problem);
  }
  /// What this machine holds of it.
  void bring_to_disk() const {
    const system_file written(part_, O_RDWR);
    if (!written.good() || ::fsync(written.id()) != 0)
      fail<std::runtime_error>("cannot be written to the disk: {}", system_words());
  }

  void finish() {
    {
      const system_file file(part_, O_RDWR);
      struct stat found {};
      if (!file.good() || ::fstat(file.id(), &found) != 0)
        fail<std::runtime_error>("cannot be written: {}", system_words());
      if (static_cast<std::uint64_t>(found.st_size) != bytes_)
        throw std::runtime_error("cannot be written: HDF5 has changed its length");
      kind_.seal(file, bytes_);
      if (kind_.durable() && ::fsync(file.id()) != 0)
        fail<std::runtime_error>("cannot be written to the disk: {}", system_words());
    }
    if (::rename(part_.c_str(), file_.c_str()) != 0)
      fail<std::runtime_error>("cannot be given its name: {}", system_words());
    if (!kind_.durable()) return;
    const auto slash = file_.find_last_of('/');
    const std::string folder = slash == file_.npos ? "." : file_.substr(0, slash + 1);
    const system_file entry(folder, O_RDONLY | O_DIRECTORY);
    if (entry.good()) ::fsync(entry.id());  // some file systems cannot, and need not
  }

  checkpoint_team& team_;
  file_kind& kind_;
  std::string file_, part_;
  std::uint64_t bytes_ = 0;  ///< of the file, on rank 0
};

}  // namespace talus::detail
