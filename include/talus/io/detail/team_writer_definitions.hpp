#pragma once
// The definitions of team_writer.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/team_writer.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE void team_writer::write(std::vector<table_part>& tables,
                                          const std::vector<small_dataset>& small) {
  std::optional<ignored_signal> unharmed;  // a signal is of the process
  if (team_.rank() == 0 || team_.of_processes()) unharmed.emplace(SIGXFSZ);
  const auto counts = gather_counts(team_, tables);
  together([&] {
    if (team_.rank() == 0) make_file(tables, counts, small);
  });
  share_layout();
  const std::vector<row_block> rows = rows_of(tables, share_places(team_, tables.size(), counts));
  together([&] {
    open_part();
    write_rows(rows);
  });
  together([&] {
    if (team_.rank() == 0) seal();
  });
  if (kind_.durable()) together([&] { verify(rows); });
  together([&] {
    if (team_.rank() == 0) give_name();
  });
  opened_.reset();
}

TALUS_HDF5_INLINE bool team_writer::require_writable() {
  bool replaces = false;
  together([&] {
    if (team_.rank() != 0) return;
    replaces = require_replaceable();
    make_part();
    part_ = {};
  });
  return replaces;
}

TALUS_HDF5_INLINE bool team_writer::require_replaceable() const {
  const output_target target = inspect_target(file_, kind_.looks(), force_);
  if (!target.objection.empty()) throw std::runtime_error(target.objection);
  return target.replaces;
}

TALUS_HDF5_INLINE void team_writer::make_part() {
  part_ = part_file(file_, true);  // all ranks open it
  if (!part_.good())
    fail<std::runtime_error>(
        "cannot be written: {}: {}; name a file in a folder that exists, is writable and has "
        "room",
        file_, system_words());
}

TALUS_HDF5_INLINE void team_writer::fail_to_write(std::uint64_t needs, int error) const {
  fail<std::runtime_error>("cannot be written: {}",
                           words_of_failed_write(part_name_, needs, error));
}

TALUS_HDF5_INLINE void team_writer::make_file(const std::vector<table_part>& tables,
                                              const counted_rows& counts,
                                              const std::vector<small_dataset>& small) {
  (void)require_replaceable();
  compose(tables, counts, small);
  make_part();
  part_name_ = part_.name();
  require_size_allowed(bytes_);
  if (const int error = reserve_file(part_.id(), bytes_); error != 0) {
    (void)::ftruncate(part_.id(), 0);  // the free space without the file
    fail_to_write(bytes_, error);
  }
  image_->each(bytes_, [&](std::uint64_t at, std::span<const std::byte> page) {
    if (write_at(part_.id(), at, page) != page.size()) fail_to_write(bytes_ - at, errno);
  });
}

TALUS_HDF5_INLINE void team_writer::compose(const std::vector<table_part>& tables,
                                            const counted_rows& counts,
                                            const std::vector<small_dataset>& small) {
  const std::lock_guard only(hdf5_mutex());
  const silent_hdf5 silent;
  std::size_t columns = 0;
  for (const table_part& t : tables) columns += t.columns.size() + 1;
  hdf5_image driver;
  {
    const hdf5_handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "written");
    hdf5_ok(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18), "written");
    driver.use_in(access);
    const hdf5_handle how(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "written");
    hdf5_ok(H5Pset_userblock(how, kind_.block_bytes(columns)), "written");
    hdf5_handle file(H5Fcreate(file_.c_str(), H5F_ACC_TRUNC, how, access), H5Fclose, "written");
    for (std::size_t k = 0; k < tables.size(); ++k) make_table(file, tables[k], k, counts);
    for (const small_dataset& s : small)
      write_small(file, s.path, s.type, s.rows, s.width, s.bytes.data());
    kind_.describe_file(file);
    file.close("written");
  }
  bytes_ = driver.length();
  image_ = driver.take_bytes();
}

TALUS_HDF5_INLINE void team_writer::make_table(hid_t file, const table_part& t, std::size_t k,
                                               const counted_rows& counts) {
  table_place all;
  for (const auto& one : counts) all.row += one[k].rows, all.extra += one[k].extra;
  const auto add = [&](const std::string& name, const dataset_shape& shape) {
    const std::uint64_t at = create_dataset(file, t.path + "/" + name, shape);
    if (shape.rows > 0) kind_.placed(at, shape.rows * shape.row_bytes());
    begin_.push_back(at);
  };
  for (const table_column& c : t.columns) add(c.name, {c.type, all.row, c.width});
  if (t.extras) add("extra", {number_type::u8, all.extra, 1});
  kind_.describe(file, t, k, counts);
}

TALUS_HDF5_INLINE void team_writer::share_layout() {
  byte_buffer bytes;
  if (team_.rank() == 0) {
    byte_writer out(bytes);
    out.put(std::span<const std::uint64_t>(begin_));
    out.put(std::span<const char>(part_name_));
  }
  team_.broadcast(bytes);
  byte_reader in(bytes);
  const auto begin = in.get_all<std::uint64_t>();
  begin_.assign(begin.begin(), begin.end());
  const auto name = in.get_all<char>();
  part_name_.assign(name.begin(), name.end());
}

TALUS_HDF5_INLINE std::vector<team_writer::row_block> team_writer::rows_of(
    const std::vector<table_part>& tables, const std::vector<table_place>& places) const {
  std::vector<row_block> all;
  std::size_t set = 0;
  for (std::size_t k = 0; k < tables.size(); ++k) {
    const table_part& t = tables[k];
    for (const table_column& c : t.columns)
      all.push_back({begin_[set++] + places[k].row * c.row_bytes(),
                     std::span(c.rows, t.rows * c.row_bytes())});
    if (t.extras) all.push_back({begin_[set++] + places[k].extra, t.extra});
  }
  return all;
}

TALUS_HDF5_INLINE void team_writer::open_part() {
  for (int wait = 0; !opened_ || !opened_->good(); ++wait) {
    opened_.emplace(part_name_, O_RDWR | O_NOFOLLOW);
    if (opened_->good()) break;
    if (errno != ENOENT || wait == 100)
      fail<std::runtime_error>("cannot be written: {}: {}", part_name_, system_words());
    ::usleep(50000);
  }
}

TALUS_HDF5_INLINE void team_writer::write_rows(const std::vector<row_block>& rows) const {
  std::uint64_t left = 0;
  for (const row_block& r : rows) left += r.bytes.size();
  for (const row_block& r : rows) {
    const std::size_t written = write_at(opened_->id(), r.at, r.bytes);
    if (written != r.bytes.size()) fail_to_write(left - written, errno);
    left -= written;
  }
  if (kind_.durable()) bring_to_disk();
}

TALUS_HDF5_INLINE void team_writer::bring_to_disk() const {
  if (::fsync(opened_->id()) != 0)
    fail<std::runtime_error>("cannot be written to the disk: {}", system_words());
}

TALUS_HDF5_INLINE void team_writer::seal() const {
  kind_.seal(opened_->id(), *image_, bytes_);
  struct stat found {};
  if (::fstat(opened_->id(), &found) != 0 || static_cast<std::uint64_t>(found.st_size) != bytes_)
    throw std::runtime_error("cannot be written: something else has changed its length");
  if (kind_.durable()) bring_to_disk();
}

TALUS_HDF5_INLINE void team_writer::verify(const std::vector<row_block>& rows) const {
  (void)::posix_fadvise(opened_->id(), 0, 0, POSIX_FADV_DONTNEED);
  byte_buffer back;
  for (const row_block& r : rows)
    for (std::size_t at = 0; at < r.bytes.size(); at += back.size()) {
      back.resize(std::min<std::size_t>(1 << 20, r.bytes.size() - at));
      if (!read_at(opened_->id(), r.at + at, back) ||
          std::memcmp(back.data(), r.bytes.data() + at, back.size()) != 0)
        fail<std::runtime_error>(
            "is not on the disk as it was written ({} bytes from byte {} on): is the disk sound, "
            "and does no other run write this file?",
            back.size(), r.at + at);
    }
  if (team_.rank() == 0) kind_.verify(opened_->id());
}

TALUS_HDF5_INLINE void team_writer::give_name() {
  (void)require_replaceable();  // another file may exist there meanwhile
  if (!part_.rename_to(file_))
    fail<std::runtime_error>("cannot be given its name: {}", system_words());
  if (!kind_.durable()) return;
  const auto slash = file_.find_last_of('/');
  const std::string folder = slash == file_.npos ? "." : file_.substr(0, slash + 1);
  const system_file entry(folder, O_RDONLY | O_DIRECTORY);
  if (entry.good() && ::fsync(entry.id()) != 0 && errno == EIO)  // some cannot, and need not
    fail<std::runtime_error>("may be lost if the power fails: its folder cannot be written: {}",
                             system_words());
}

}  // namespace talus::detail
