#include "talus/core/output_file.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

using namespace talus;
using detail::inspect_target;

namespace {

const detail::output_kind any{"such a file", [](std::string_view) { return false; }};

/// A folder of its own, which is the working folder in the meantime.
class scratch {
 public:
  scratch() : before_(std::filesystem::current_path()) {
    std::string name = std::filesystem::temp_directory_path() / "talus_output_file_XXXXXX";
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    std::filesystem::current_path(here_ = name);
  }
  scratch(const scratch&) = delete;
  scratch& operator=(const scratch&) = delete;
  ~scratch() {
    std::filesystem::current_path(before_);
    std::filesystem::remove_all(here_);
  }

 private:
  std::filesystem::path before_, here_;
};

bool objects(const std::string& path, const char* words) {
  return inspect_target(path, any, true).objection.find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("what is no file is never replaced, nor a link that leads to it") {
  const scratch here;
  std::filesystem::create_directory("folder");
  REQUIRE(::mkfifo("pipe", 0600) == 0);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un name{.sun_family = AF_UNIX, .sun_path = "socket"};
  REQUIRE(::bind(socket, reinterpret_cast<sockaddr*>(&name), sizeof name) == 0);
  ::close(socket);
  std::ofstream("text") << "a diary";
  for (const char* what : {"folder", "pipe", "socket", "text", "nothing"}) {
    std::filesystem::create_symlink(what, std::string("to_") + what);
    std::filesystem::create_symlink(std::string("to_") + what, std::string("to_to_") + what);
  }
  for (const std::string to : {"", "to_", "to_to_"}) {
    CAPTURE(to);
    CHECK(objects(to + "folder", "is a folder"));
    CHECK(objects(to + "pipe", "is a device, a pipe or a socket"));
    CHECK(objects(to + "socket", "is a device, a pipe or a socket"));
    CHECK(inspect_target(to + "text", any, true).objection.empty());
    CHECK(inspect_target(to + "nothing", any, true).objection.empty());
  }
}

TEST_CASE("streams of the program are never replaced, in any form of their names") {
  for (const char* name : {"/dev/stdin", "/dev/stdout", "//dev/./stderr", "/dev/fd/1",
                           "/proc/self/fd/2", "/proc/thread-self/fd/1"}) {
    CAPTURE(name);
    CHECK(detail::is_stream(name));
    CHECK(objects(name, "is a stream of this program"));
  }
  const scratch here;
  std::filesystem::create_directory_symlink("/dev", "devices");
  CHECK(objects("devices/stdout", "is a stream of this program"));
  CHECK_FALSE(detail::is_stream("stdout"));
  CHECK_FALSE(detail::is_stream("/dev/stdout.txt"));
}

TEST_CASE("the rest of a killed run is removed, and no file of another name") {
  const scratch here;
  const auto leave = [](const std::string& path) {  // as a process that is killed does
    detail::part_file part(path);
    REQUIRE(part.good());
    const std::string name = part.name();
    REQUIRE(part.rename_to("moved"));
    std::filesystem::rename("moved", name);
    return name;
  };
  std::vector<std::string> rests{leave("k"), leave("./k")},
      others{"k.part-backup", "k.part-abc123def456"};
  std::string altered = rests[0];
  altered.back() = altered.back() == 'a' ? 'b' : 'a';
  others.push_back(altered);
  others.push_back("j" + rests[0].substr(1));
  others.push_back(leave("j"));
  for (const std::string& name : others) std::ofstream(name) << "mine";
  detail::remove_parts_of("k");
  for (const std::string& name : rests) CHECK_FALSE(std::filesystem::exists(name));
  for (const std::string& name : others) CHECK(std::filesystem::exists(name));

  rests = {leave("k_0000000700.hdf"), leave("k_3.hdf")};
  others = {leave("k_.hdfs"), "k_3.hdf.part-backup"};
  std::ofstream(others[1]) << "mine";
  detail::remove_parts_of(std::filesystem::current_path() / "k_", ".hdf");
  for (const std::string& name : rests) CHECK_FALSE(std::filesystem::exists(name));
  for (const std::string& name : others) CHECK(std::filesystem::exists(name));
}

TEST_CASE("a killed process leaves no unfinished output where files may have no names") {
  const scratch here;
  const std::string folder = "parts";
  std::filesystem::create_directory(folder);
  const auto entries = [&] {
    return std::distance(std::filesystem::directory_iterator(folder), {});
  };
  const int probe = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  const bool nameless = probe >= 0;
  if (nameless) ::close(probe);
  {
    detail::part_file part(folder + "/a");
    REQUIRE(part.good());
    REQUIRE(detail::write_text(part.id(), "text"));
    CHECK(entries() == (nameless ? 0 : 1));
    REQUIRE(part.rename_to(folder + "/a"));
    CHECK(entries() == 1);
    detail::part_file lost(folder + "/b");
    detail::part_file named(folder + "/c", true);
    CHECK(std::filesystem::exists(named.name()));
    detail::part_file replaced(folder + "/a");
    REQUIRE(detail::write_text(replaced.id(), "other"));
    REQUIRE(replaced.rename_to(folder + "/a"));
  }
  CHECK(entries() == 1);
  CHECK(std::filesystem::file_size(folder + "/a") == 5);
}
