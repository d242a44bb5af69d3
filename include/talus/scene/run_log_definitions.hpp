#pragma once
// The definitions of run_log.hpp, in the compiled part or in each program.
#include <fcntl.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "talus/core/linkage.hpp"
#include "talus/core/shown_text.hpp"
#include "talus/core/version.hpp"
#include "talus/io/output_kinds.hpp"
#include "talus/scene/run_log.hpp"
#include "talus/scene/run_outputs.hpp"

namespace talus::detail {

TALUS_INLINE run_log::~run_log() {
  if (id_ >= 0) ::close(id_);
}

TALUS_INLINE void run_log::open(const options& o, int argc, const char* const* argv,
                                const std::string& build) {
  if (o.log.empty()) return;
  if (!is_stream(o.log)) {
    (void)inspect_output("--log", o.log, log_output, o.force);
    lock_.emplace(o.log, "--log " + o.log);
  }
  std::string text = std::string(log_mark) + program_ + '\n';
  const auto line = [&](const char* name, const std::string& value) {
    text += std::string(name) + "  " + value + '\n';
  };
  char date[32] = "";
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  if (::gmtime_r(&now, &utc) != nullptr)
    (void)std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%SZ", &utc);
  utsname machine{};
  (void)::uname(&machine);
  line("date       ", date);
  line("version    ", std::string("talus ") + version);
  line("program    ", build);
#ifdef TALUS_BUILD_FLAGS
  line("library    ", "compiled with " TALUS_BUILD_FLAGS);
#elif defined(TALUS_COMPILED)
  line("library    ", "compiled as part of another project");
#else
  line("library    ", "headers alone");
#endif
  line("host       ", compose("{}, {} {} {}, {} processors", machine.nodename, machine.sysname,
                              machine.release, machine.machine, ::sysconf(_SC_NPROCESSORS_ONLN)));
  std::string command;
  for (int i = 0; i < argc; ++i) command += (i == 0 ? "" : " ") + std::string(argv[i]);
  line("command    ", command);
  line("seed       ", std::to_string(o.seed));
  text += "options\n";
  std::string_view rest = o.configuration;
  while (!rest.empty()) {
    const auto end = rest.find('\n');
    text += "  " + std::string(rest.substr(0, end)) + '\n';
    rest.remove_prefix(end == rest.npos ? rest.size() : end + 1);
  }
  text = printable(text);
  try {
    if (!o.restart.empty() && !is_stream(o.log) &&
        inspect_target(o.log, log_output, o.force).replaces) {
      // A longer copy replaces the file: another name of it keeps what it has.
      std::ostringstream earlier;
      earlier << std::ifstream(o.log, std::ios::binary).rdbuf();
      if (!earlier) fail<std::runtime_error>("cannot be read: {}", system_words());
      text.insert(0, earlier.str());
    }
    id_ = begin_output(o.log, text, log_output, o.force);
  } catch (const std::exception& e) {
    fail<std::runtime_error>("--log {} {}", o.log, e.what());
  }
  name_ = o.log;
}

TALUS_INLINE void run_log::write(std::string_view text) {
  if (id_ < 0 && file_.empty()) return;
  const std::lock_guard lock(mutex_);
  if (id_ < 0) {
    name_ = std::exchange(file_, "");
    id_ = ::open(name_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
    if (id_ < 0) return;
  }
  if (!write_text(id_, printable(text))) lose_line(errno);
}

TALUS_INLINE void run_log::lose_line(int error) {
  if (!std::exchange(line_lost_, true))
    std::fputs(printable(compose("{}: the log {} cannot be written: {}; lines of it are lost: make "
                                 "room for it, or name another file\n",
                                 program_, name_, system_words(error)))
                   .c_str(),
               stderr);
}

TALUS_INLINE void run_log::say(const std::string& text, bool quiet) {
  if (!quiet) {
    std::fputs(printable(text).c_str(), stderr);
    std::fflush(stderr);
  }
  write(text);
}

TALUS_INLINE void run_log::print(const std::string& text, bool quiet) {
  if (!quiet && (std::fputs(printable(text).c_str(), stdout) < 0 || std::fflush(stdout) != 0))
    lose_print(errno);
  write(text);
}

TALUS_INLINE int run_log::finish(int code) {
  if (std::fflush(stdout) != 0) lose_print(errno);
  if (std::ferror(stdout) != 0) lose_print(EIO);  // of the set-up
  if (const int copy = id_ >= 0 ? ::dup(id_) : -1; copy >= 0 && ::close(copy) != 0)
    lose_line(errno);
  try {
    if (id_ >= 0) require_own_output(id_, name_);
  } catch (const std::exception& e) {
    if (!std::exchange(line_lost_, true))
      std::fputs(printable(compose("{}: the log {} {}\n", program_, name_, e.what())).c_str(),
                 stderr);
  }
  return code == 0 && (print_lost_ || line_lost_) ? 1 : code;
}

TALUS_INLINE void run_log::lose_print(int error) {
  if (std::exchange(print_lost_, true)) return;
  say(compose(
      "{}: standard output cannot be written: {}; some of it is lost: let it go where there "
      "is room and a reader, or add --quiet, with --json FILE for the results\n",
      program_, system_words(error)));
}

}  // namespace talus::detail
