#pragma once
// The definitions of run_lock.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/core/run_lock.hpp"

namespace talus::detail {

TALUS_INLINE run_lock::run_lock(const std::string& file, const std::string& output)
    : name_(file + ".lock") {
  try {
    take(file);
  } catch (const std::exception& e) {
    fail<std::runtime_error>("{} {}", output, e.what());
  }
  for (auto& place : all_held().locks) {
    run_lock* none = nullptr;
    if (place.compare_exchange_strong(none, this)) break;
  }
}

TALUS_INLINE run_lock::locks_held& run_lock::all_held() {
  static locks_held* const held = new locks_held;  // outlives every exit handler
  return *held;
}

TALUS_INLINE void run_lock::prepare_to_leave() { (void)all_held(); }

TALUS_INLINE void run_lock::leave_all() {
  locks_held& held = all_held();
  held.leaving = true;
  for (const auto& place : held.locks)
    if (const run_lock* const each = place; each != nullptr) each->remove_file();
}

TALUS_INLINE void run_lock::take(const std::string& file) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    open(file);
    const bool locked = ::flock(id_, LOCK_EX | LOCK_NB) == 0;
    const int error = errno;
    // (One that this run has just made has the text of this run.)
    const bool lives =
        !locked && !owns_file_ && lock_holder::from_text(text_of_lock(id_)).lives_here();
    if (!locked && error != EINTR && (lives || (error == EWOULDBLOCK && attempt >= 5))) refuse();
    // (Without locks of the file system, only the text counts; that of another machine is
    // ignored: a run that was killed there would block all others.)
    if (!locked && (error == EINTR || error == EWOULDBLOCK)) {  // others may look at it
      if (!owns_file_) close();
      if (error == EWOULDBLOCK) ::usleep(10000);
      continue;
    }
    if (!is_named()) {  // its holder has meanwhile removed it
      close();
      continue;
    }
    // The new text replaces that of a killed run in place: an empty file would count as a file of
    // somebody else from then on.
    const std::string before = text_of_lock(id_), mine = lock_holder::this_process().text();
    owns_file_ = owns_file_ || before.starts_with(lock_holder::mark);
    if (owns_file_ && before != mine && ::lseek(id_, 0, SEEK_SET) == 0 && write_text(id_, mine))
      (void)::ftruncate(id_, std::ssize(mine));
    locked_ = locked;
    remove_left_over(file);
    return;
  }
  fail<std::runtime_error>("cannot be locked by {}: other runs take the lock again and again",
                           name_);
}

TALUS_INLINE run_lock::~run_lock() {
  locks_held& held = all_held();
  for (auto& place : held.locks) {
    run_lock* own = this;
    if (place.compare_exchange_strong(own, nullptr)) break;
  }
  while (held.leaving) ::pause();
  remove_file();
  close();
}

TALUS_INLINE void run_lock::remove_file() const {
  if (id_ >= 0 && owns_file_ && process_ == ::getpid() && is_named()) ::unlink(name_.c_str());
}

TALUS_INLINE void run_lock::remove_left_over(const std::string& file, std::string_view end) const {
  if (locked_) remove_parts_of(file, end);
}

TALUS_INLINE bool run_lock::is_of(const std::string& file) const {
  struct stat theirs {
  }, mine{};
  return ::stat((file + ".lock").c_str(), &theirs) == 0 && ::fstat(id_, &mine) == 0 &&
         theirs.st_dev == mine.st_dev && theirs.st_ino == mine.st_ino;
}

TALUS_INLINE void run_lock::open(const std::string& file) {
  for (int attempt = 0; id_ < 0 && attempt < 100; ++attempt) {
    id_ = ::open(name_.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    owns_file_ = id_ < 0 && errno == ENOENT && make(file);
    if (id_ < 0 && errno != EEXIST && errno != ENOENT) break;
  }
  if (id_ < 0)
    fail<std::runtime_error>(
        "cannot be written: {}: {}; name a file in a folder that exists, is writable and has "
        "room",
        name_, system_words());
  struct stat found {};
  const bool regular = ::fstat(id_, &found) == 0 && S_ISREG(found.st_mode);
  if (owns_file_ ||
      (regular && (found.st_size == 0 || text_of_lock(id_).starts_with(lock_holder::mark))))
    return;
  close();
  fail<std::runtime_error>(
      "needs {} for its lock, and something else is there: move that away, or name another file",
      name_);
}

TALUS_INLINE bool run_lock::make(const std::string& file) {
  const std::string mine = lock_holder::this_process().text();
  // (A full disk has no room for the text; the lock holds without it.)
  const auto write = [&](int id) {
    if (!write_text(id, mine)) (void)::ftruncate(id, 0);
    (void)::flock(id, LOCK_EX | LOCK_NB);
  };
  part_file part(file);
  if (part.good()) {
    write(part.id());
    id_ = part.link_and_keep(name_);
    if (id_ >= 0 || errno == EEXIST || errno == ENOENT) return id_ >= 0;
  }
  // The file system cannot give a file a second name.
  id_ = ::open(name_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (id_ >= 0) write(id_);
  return id_ >= 0;
}

TALUS_INLINE void run_lock::close() {
  if (id_ >= 0) ::close(id_);
  id_ = -1;
}

TALUS_INLINE bool run_lock::is_named() const {
  struct stat named {
  }, mine{};
  return ::lstat(name_.c_str(), &named) == 0 && ::fstat(id_, &mine) == 0 &&
         named.st_dev == mine.st_dev && named.st_ino == mine.st_ino;
}

TALUS_INLINE void run_lock::refuse() {
  const std::string who = text_of_lock(id_);
  close();
  throw std::runtime_error(words_of_other_run(lock_holder::from_text(who)));
}

TALUS_INLINE locks_end_with_signals::locks_end_with_signals() {
  run_lock::prepare_to_leave();
  for (std::size_t k = 0; k < signals.size(); ++k) {
    struct sigaction action {};
    sigemptyset(&action.sa_mask);
    action.sa_handler = [](int signal) {
      run_lock::leave_all();
      (void)std::signal(signal, SIG_DFL);
      (void)::raise(signal);  // ends the process when this returns
    };
    sigaction(signals[k], nullptr, &before_[k]);
    if (before_[k].sa_handler == SIG_DFL) sigaction(signals[k], &action, nullptr);
  }
}

TALUS_INLINE locks_end_with_signals::~locks_end_with_signals() {
  for (std::size_t k = 0; k < signals.size(); ++k) sigaction(signals[k], &before_[k], nullptr);
}

}  // namespace talus::detail
