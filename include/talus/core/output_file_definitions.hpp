#pragma once
// The definitions of output_file.hpp, in the compiled part or in each program.
#include <sys/resource.h>

#include <cstdlib>

#include "talus/core/linkage.hpp"
#include "talus/core/lock_holder.hpp"
#include "talus/core/output_file.hpp"

namespace talus::detail {

TALUS_INLINE std::string system_words(int error) { return std::strerror(error); }

TALUS_INLINE bool is_own_stream(const std::string& path) {
  const auto slash = path.find_last_of('/');
  const std::string folder = slash == path.npos ? "." : path.substr(0, slash + 1);
  char* const found = ::realpath(folder.c_str(), nullptr);
  const std::string place = found == nullptr ? "" : found + ('/' + path.substr(slash + 1));
  std::free(found);
  return place == "/dev/stdin" || place == "/dev/stdout" || place == "/dev/stderr" ||
         place.starts_with("/proc/");
}

TALUS_INLINE bool is_stream(const std::string& path) {
  struct stat found {};
  return is_own_stream(path) || (::stat(path.c_str(), &found) == 0 && S_ISFIFO(found.st_mode));
}

TALUS_INLINE std::string objection_to_link(const std::string& path, const output_kind& kind,
                                           bool force) {
  if (force) return {};
  std::string to(4096, '\0');
  const ssize_t length = ::readlink(path.c_str(), to.data(), to.size());
  to.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
  return compose(
      "is a symbolic link to {}: name the file itself{}", to,
      kind.forced ? ", or add --force, which replaces the link and leaves what it leads to" : "");
}

TALUS_INLINE output_target inspect_regular(const std::string& path, const output_kind& kind,
                                           bool force) {
  const int id = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  std::string head(output_head_bytes, '\0');
  const ssize_t length = id >= 0 ? ::read(id, head.data(), head.size()) : -1;
  const int error = errno;
  if (id >= 0) ::close(id);
  if (length >= 0) {
    head.resize(static_cast<std::size_t>(length));
    if (head.empty()) return {};  // nothing to lose
    if (kind.owns(head)) return {.replaces = true};
  }
  if (force) return {};
  if (length < 0)
    return {.objection =
                compose("is there already and cannot be read ({}): name another file{}",
                        system_words(error), kind.forced ? ", or add --force to replace it" : "")};
  return {.objection = compose("is there already and is not {}: name another file{}", kind.name,
                               kind.forced ? ", remove this one, or add --force to replace it"
                                           : " or remove this one")};
}

TALUS_INLINE output_target inspect_target(const std::string& path, const output_kind& kind,
                                          bool force) {
  if (is_own_stream(path))
    return {.objection =
                "is a stream of this program, which this output must not replace: name a "
                "file"};
  if (std::string words = objection_of_other_run(path); !words.empty())
    return {.objection = std::move(words)};
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0) return {};  // absent, or opening it will fail
  if (S_ISREG(found.st_mode)) return inspect_regular(path, kind, force);
  if (S_ISLNK(found.st_mode) && (::stat(path.c_str(), &found) != 0 || S_ISREG(found.st_mode)))
    return {.objection = objection_to_link(path, kind, force)};
  if (S_ISDIR(found.st_mode)) return {.objection = "is a folder: name a file in it"};
  return {.objection =
              "is a device, a pipe or a socket, which this output must not replace: name "
              "a file"};
}

TALUS_INLINE std::string words_of_failed_write(const std::string& path, std::uint64_t needs,
                                               int error) {
  rlimit limit{};
  if (error == EFBIG && ::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    return compose(
        "{} bytes more do not fit: files may have {} bytes (ulimit -f): raise that limit", needs,
        static_cast<std::uint64_t>(limit.rlim_cur));
  if (error != ENOSPC && error != EDQUOT)
    return compose("{}; name a file in a folder that exists, is writable and has room",
                   system_words(error));
  std::uint64_t missing = needs;
  struct statvfs disk {};
  if (::statvfs(path.c_str(), &disk) == 0) {
    const std::uint64_t free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
    if (free < needs) missing = needs - free;
  }
  return compose(
      "there is no room for {} bytes more ({}), {} bytes are missing: make room, or name a file on "
      "another disk",
      needs, system_words(error), missing);
}

[[nodiscard, gnu::cold]] inline std::string letters_of(std::uint64_t number) {
  static constexpr std::string_view alphabet = "abcdefghijklmnopqrstuvwxyz0123456789";
  std::string all;
  for (std::size_t k = 0; k < part_file::letters; ++k, number /= alphabet.size())
    all += alphabet[number % alphabet.size()];
  return all;
}

TALUS_INLINE std::string part_file::seal(std::string_view name) {
  std::uint64_t hash = 0;
  for (const char c : name) hash = mix(hash ^ static_cast<unsigned char>(c));
  return letters_of(hash);
}

/// An open file without a name in the folder of a path, which linkat() can name; -1 otherwise.
[[nodiscard, gnu::cold]] inline int open_without_name(const std::string& path) {
#ifdef O_TMPFILE
  const auto slash = path.find_last_of('/');
  const std::string folder = slash == path.npos ? "." : path.substr(0, slash + 1);
  if (::access("/proc/self/fd", X_OK) == 0)
    return ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
#endif
  return -1;
}

TALUS_INLINE part_file::part_file(const std::string& path, bool named) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    const std::uint64_t random = mix(
        static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count()) ^
        static_cast<std::uint64_t>(::getpid()) << 40 ^ reinterpret_cast<std::uintptr_t>(this));
    name_ = path + std::string(infix) + letters_of(random);
    name_ += seal(std::string_view(name_).substr(path.find_last_of('/') + 1));
    if (!named) id_ = open_without_name(path);
    if (id_ >= 0) return;
    id_ = ::open(name_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    named_ = id_ >= 0;
    if (named_ || errno != EEXIST) return;
  }
}

TALUS_INLINE part_file::~part_file() {
  if (id_ < 0) return;
  ::close(id_);
  if (named_) ::unlink(name_.c_str());
}

TALUS_INLINE bool part_file::rename_to(const std::string& path) {
  const int id = rename_and_keep(path);
  if (id >= 0) ::close(id);
  return id >= 0;
}

TALUS_INLINE int part_file::rename_and_keep(const std::string& path) {
  const int copy = ::dup(id_);  // closing it tells what writing did not, as on NFS
  if (copy < 0 || ::close(copy) != 0) return -1;
  const std::string own = compose("/proc/self/fd/{}", id_);
  named_ =
      named_ || ::linkat(AT_FDCWD, own.c_str(), AT_FDCWD, name_.c_str(), AT_SYMLINK_FOLLOW) == 0;
  if (!named_ || ::rename(name_.c_str(), path.c_str()) != 0) return -1;
  return std::exchange(id_, -1);
}

TALUS_INLINE int part_file::link_and_keep(const std::string& path) {
  const std::string own = named_ ? name_ : compose("/proc/self/fd/{}", id_);
  if (::linkat(AT_FDCWD, own.c_str(), AT_FDCWD, path.c_str(), named_ ? 0 : AT_SYMLINK_FOLLOW) != 0)
    return -1;
  if (std::exchange(named_, false)) ::unlink(name_.c_str());
  return std::exchange(id_, -1);
}

TALUS_INLINE void remove_parts_of(const std::string& path, std::string_view end) {
  const auto slash = path.find_last_of('/');
  const std::string folder = slash == path.npos ? "." : path.substr(0, slash + 1);
  const std::string begin = path.substr(slash + 1);
  const std::string behind = std::string(end) + std::string(part_file::infix);
  DIR* const all = ::opendir(folder.c_str());
  if (all == nullptr) return;
  while (const dirent* const one = ::readdir(all)) {
    const std::string_view whole = one->d_name;
    std::string_view name = whole;
    if (!name.starts_with(begin)) continue;
    name.remove_prefix(begin.size());
    if (!end.empty())
      name.remove_prefix(std::min(name.find_first_not_of("0123456789"), name.size()));
    if (!name.starts_with(behind) || name.size() != behind.size() + 2 * part_file::letters)
      continue;
    const std::size_t sealed = whole.size() - part_file::letters;
    if (part_file::seal(whole.substr(0, sealed)) != whole.substr(sealed)) continue;
    struct stat found {};
    if (::fstatat(::dirfd(all), one->d_name, &found, AT_SYMLINK_NOFOLLOW) == 0 &&
        S_ISREG(found.st_mode) && found.st_uid == ::geteuid())
      ::unlinkat(::dirfd(all), one->d_name, 0);
  }
  ::closedir(all);
}

TALUS_INLINE bool write_text(int id, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(id, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      if (n == 0) errno = ENOSPC;
      return false;
    }
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

TALUS_INLINE int make_output(const std::string& path, std::string_view text) {
  part_file part(path);
  if (part.good() && write_text(part.id(), text)) {
    (void)::fcntl(part.id(), F_SETFL, O_APPEND);
    if (const int id = part.rename_and_keep(path); id >= 0) return id;
  }
  const int error = errno;
  part = {};  // its space is free again
  fail<std::runtime_error>("cannot be written: {}",
                           words_of_failed_write(path, text.size(), error));
}

TALUS_INLINE int begin_output(const std::string& path, std::string_view text,
                              const output_kind& kind, bool force) {
  if (!is_stream(path)) {
    const output_target target = inspect_target(path, kind, force);
    if (!target.objection.empty()) throw std::runtime_error(target.objection);
    return make_output(path, text);
  }
  const int id = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  try {
    add_to_output(id, path, text);
  } catch (...) {
    if (id >= 0) ::close(id);
    throw;
  }
  return id;
}

TALUS_INLINE void require_own_output(int id, const std::string& path) {
  struct stat own {
  }, named{};
  if (::fstat(id, &own) != 0 || !S_ISREG(own.st_mode)) return;
  if ((::stat(path.c_str(), &named) != 0 || own.st_dev != named.st_dev ||
       own.st_ino != named.st_ino) &&
      !is_stream(path))
    fail<std::runtime_error>(
        "is no longer the file that this run has begun: something else has removed or replaced it; "
        "begin again with another name");
}

TALUS_INLINE void add_to_output(int id, const std::string& path, std::string_view text) {
  require_own_output(id, path);
  if (id < 0 || !write_text(id, text))
    fail<std::runtime_error>("cannot be written: {}",
                             words_of_failed_write(path, text.size(), errno));
}

TALUS_INLINE void write_output(const std::string& path, std::string_view text,
                               const output_kind& kind, bool force) {
  if (::close(begin_output(path, text, kind, force)) != 0)
    fail<std::runtime_error>("cannot be written: {}",
                             words_of_failed_write(path, text.size(), errno));
}

}  // namespace talus::detail
