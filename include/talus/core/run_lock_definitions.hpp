#pragma once
// The definitions of run_lock.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/core/run_lock.hpp"

namespace talus::detail {

TALUS_INLINE lock_holder lock_holder::this_process() {
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  char when[64] = "";
  const std::time_t now = std::time(nullptr);
  struct tm date {};
  if (::localtime_r(&now, &date) != nullptr)
    std::strftime(when, sizeof when, "%Y-%m-%d %H:%M:%S", &date);
  const std::string pid = std::to_string(::getpid());
  return {host, pid, when, start_of(pid)};
}

TALUS_INLINE lock_holder lock_holder::from_text(const std::string& text) {
  return {line(text, "host "), line(text, "process "), line(text, "since "),
          line(text, "started ")};
}

TALUS_INLINE std::string lock_holder::text() const {
  return std::string(mark) + "host " + host + "\nprocess " + pid + "\nsince " + since +
         "\nstarted " + started + "\n";
}

TALUS_INLINE std::string lock_holder::words() const {
  if (pid.empty()) return "another process";
  return compose("process {} on {}, since {}", pid, host, since);
}

TALUS_INLINE bool lock_holder::lives_here() const {
  const auto number = static_cast<pid_t>(std::strtol(pid.c_str(), nullptr, 10));
  if (number <= 0 || host != this_process().host) return false;
  if (::kill(number, 0) != 0 && errno != EPERM) return false;
  return start_of(pid) == started;
}

TALUS_INLINE std::string lock_holder::line(const std::string& text, const char* key) {
  const auto at = text.find('\n' + std::string(key));
  if (at == text.npos) return {};
  const auto begin = at + 1 + std::string_view(key).size();
  return text.substr(begin, text.find('\n', begin) - begin);
}

TALUS_INLINE std::string lock_holder::start_of(const std::string& pid) {
  const int id = ::open(("/proc/" + pid + "/stat").c_str(), O_RDONLY | O_CLOEXEC);
  if (id < 0) return {};
  std::string text(1024, '\0');
  const ssize_t length = ::read(id, text.data(), text.size());
  ::close(id);
  text.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
  std::size_t at = text.rfind(')');
  for (int field = 2; field < 22 && at != text.npos; ++field) at = text.find(' ', at + 1);
  if (at == text.npos) return {};
  return text.substr(at + 1, text.find(' ', at + 1) - at - 1);
}

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
    open();
    const bool locked = ::flock(id_, LOCK_EX | LOCK_NB) == 0;
    const int error = errno;
    if (!locked && error == EWOULDBLOCK) refuse();
    if (!locked && error != EINTR && lock_holder::from_text(text()).lives_here()) refuse();
    // (Without locks of the file system, only the text counts; that of another machine is
    // ignored: a run that was killed there would block all others.)
    if (error == EINTR && !locked) {
      close();
      continue;
    }
    if (!is_named()) {  // its holder has meanwhile removed it
      close();
      continue;
    }
    // (A full disk has no room for the text; the lock holds without it. The new text replaces that
    // of a killed run in place: an empty file would count as a file of somebody else from then on.)
    const std::string mine = lock_holder::this_process().text();
    if (owns_file_ && write_text(id_, mine)) (void)::ftruncate(id_, std::ssize(mine));
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

TALUS_INLINE void run_lock::open() {
  struct stat found {};
  constexpr int how = O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  id_ = ::open(name_.c_str(), how | O_EXCL, 0666);
  owns_file_ = id_ >= 0;
  if (id_ < 0 && errno == EEXIST) id_ = ::open(name_.c_str(), how, 0666);
  if (id_ < 0)
    fail<std::runtime_error>(
        "cannot be written: {}: {}; name a file in a folder that exists, is writable and has "
        "room",
        name_, system_words());
  const bool regular = ::fstat(id_, &found) == 0 && S_ISREG(found.st_mode);
  owns_file_ = owns_file_ || (regular && text().starts_with(lock_holder::mark));
  if (owns_file_ || (regular && found.st_size == 0)) return;
  close();
  fail<std::runtime_error>(
      "needs {} for its lock, and something else is there: move that away, or name another file",
      name_);
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

TALUS_INLINE std::string run_lock::text() const {
  std::string all(1024, '\0');
  const ssize_t length = ::pread(id_, all.data(), all.size(), 0);
  all.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
  return all;
}

TALUS_INLINE void run_lock::refuse() {
  std::string who = text();
  for (int wait = 0; wait < 20 && who.empty(); ++wait) {  // the lock was just taken
    ::usleep(10000);
    who = text();
  }
  close();
  fail<std::runtime_error>(
      "is being written by another run ({}): wait for its end or stop it, or name another file",
      lock_holder::from_text(who).words());
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
