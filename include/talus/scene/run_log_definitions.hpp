#pragma once
// The definitions of run_log.hpp, in the compiled part or in each program.
#include <fcntl.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <ctime>
#include <string>
#include <utility>

#include "talus/core/linkage.hpp"
#include "talus/core/version.hpp"
#include "talus/io/output_kinds.hpp"
#include "talus/scene/run_log.hpp"

namespace talus::detail {

TALUS_INLINE run_log::~run_log() {
  if (id_ >= 0) ::close(id_);
}

TALUS_INLINE void run_log::open(const options& o, const std::string& program, int argc,
                                const char* const* argv, const std::string& build) {
  if (o.log.empty()) return;
  const bool goes_on = !o.restart.empty();
  if (!is_stream(o.log)) {
    const output_target target = inspect_target(o.log, log_output, o.force);
    if (!target.objection.empty()) fail<std::runtime_error>("--log {} {}", o.log, target.objection);
  }
  id_ = ::open(o.log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | (goes_on ? 0 : O_TRUNC),
               0666);
  if (id_ < 0)
    fail<std::runtime_error>(
        "the file {} cannot be written: {}: give --log a file in a folder that exists and is "
        "writable",
        o.log, system_words());
  std::string text = std::string(log_mark) + program + '\n';
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
  write(text);
}

TALUS_INLINE void run_log::write(std::string_view text) {
  if (id_ < 0 && file_.empty()) return;
  const std::lock_guard lock(mutex_);
  if (id_ < 0) id_ = ::open(std::exchange(file_, "").c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (id_ < 0) return;
  (void)write_text(id_, text);
}

TALUS_INLINE void run_log::say(const std::string& text, bool quiet) {
  if (!quiet) {
    std::fputs(text.c_str(), stderr);
    std::fflush(stderr);
  }
  write(text);
}

TALUS_INLINE void run_log::print(const std::string& text, bool quiet) {
  if (!quiet) std::fputs(text.c_str(), stdout);
  write(text);
}

}  // namespace talus::detail
