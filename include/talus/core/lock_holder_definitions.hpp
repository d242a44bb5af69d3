#pragma once
// The definitions of lock_holder.hpp, in the compiled part or in each program.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/core/lock_holder.hpp"

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

TALUS_INLINE lock_holder& lock_holder::joined() {
  static lock_holder of_run;
  return of_run;
}

TALUS_INLINE void lock_holder::join(const lock_holder& of_run) {
  if (!(of_run == this_process())) joined() = of_run;  // ranks may be threads of one process
}

TALUS_INLINE bool lock_holder::is_of_this_run() const {
  return *this == this_process() || *this == joined();
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

TALUS_INLINE std::string text_of_lock(int id) {
  std::string all(1024, '\0');
  const ssize_t length = ::pread(id, all.data(), all.size(), 0);
  all.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
  return all;
}

/// The file "NAME<end>.series" for "NAME_<digits><end>", a file of a series; empty for others.
[[nodiscard, gnu::cold]] inline std::string series_of(const std::string& file) {
  const auto end = file.find_last_of('.');
  const auto before = file.find_last_not_of("0123456789", end - 1);
  if (end == file.npos || file.find('/', end) != file.npos || before == file.npos ||
      before + 1 >= end || file[before] != '_')
    return {};
  return file.substr(0, before) + file.substr(end) + ".series";
}

TALUS_INLINE std::string words_of_other_run(const lock_holder& holder) {
  return compose(
      "is being written by another run ({}): wait for its end or stop it, or name another file",
      holder.words());
}

/// Whether another process holds the lock of a file; gives its words then.
[[nodiscard, gnu::cold]] inline std::string words_of_lock(const std::string& file) {
  const std::string name = file + ".lock";
  const int id = ::open(name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (id < 0) return errno == EACCES ? words_of_other_run({}) : "";  // of another user
  const std::string text = text_of_lock(id);
  const lock_holder holder = lock_holder::from_text(text);
  // (A process that was killed may still be listed while it holds no lock any more.)
  const bool held = text.starts_with(lock_holder::mark) && !holder.is_of_this_run() &&
                    ::flock(id, LOCK_SH | LOCK_NB) != 0 &&
                    (errno == EWOULDBLOCK || holder.lives_here());
  ::close(id);
  return held ? words_of_other_run(holder) : "";
}

TALUS_INLINE std::string objection_of_other_run(const std::string& path) {
  const std::string series = series_of(path), words = words_of_lock(path);
  if (!words.empty() || series.empty()) return words;
  const std::string of_series = words_of_lock(series);
  return of_series.empty() ? "" : compose("belongs to the series {}, which {}", series, of_series);
}

}  // namespace talus::detail
