#pragma once
// Pages of --view as a reader sees them: their heads, and the blocks of their frames.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <talus/core/math.hpp>
#include <vector>

namespace talus::view_pages {

/// Files of this process, removed at the end, and a three.js that is small.
struct scratch {
  std::string folder = "/tmp/talus_view_" + std::to_string(getpid());
  scratch() {
    REQUIRE(std::system(("mkdir -p " + folder).c_str()) == 0);
    std::ofstream((*this)("three.js")) << "var THREE = {};";
    setenv("TALUS_THREE", (*this)("three.js").c_str(), 1);
  }
  ~scratch() {
    unsetenv("TALUS_THREE");
    (void)!std::system(("rm -r " + folder).c_str());
  }
  std::string operator()(const std::string& name) const { return folder + "/" + name; }
};

inline std::string content(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

inline std::vector<std::string> elements(const std::string& page, const std::string& name) {
  std::vector<std::string> all;
  const std::string begin = "class=\"talus-" + name + "\">";
  for (auto at = page.find(begin); at != page.npos; at = page.find(begin, at)) {
    at += begin.size();
    all.push_back(page.substr(at, page.find("</script>", at) - at));
  }
  return all;
}

inline std::string decoded(const std::string& base64) {
  std::string out;
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : base64) {
    const std::string_view digits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    if (c == '=') break;
    REQUIRE(digits.find(c) != digits.npos);
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c)), held += 6;
    if (held >= 8) held -= 8, out += static_cast<char>(bits >> held & 255);
  }
  return out;
}

/// One frame as a reader sees it.
struct frame {
  std::string head, bytes;

  [[nodiscard]] bool has(const std::string& block) const {
    return head.find("\"" + block + "\":[\"") != head.npos;
  }
  template <class T>
  [[nodiscard]] std::vector<T> block(const std::string& name) const {
    const auto at = head.find("\"" + name + "\":[\"");
    REQUIRE(at != head.npos);
    std::size_t offset = 0, count = 0;
    REQUIRE(std::sscanf(head.c_str() + head.find(',', at), ",%zu,%zu", &offset, &count) == 2);
    std::vector<T> values(count);
    REQUIRE(offset % 8 == 0);
    REQUIRE(offset + count * sizeof(T) <= bytes.size());
    std::memcpy(values.data(), bytes.data() + offset, count * sizeof(T));
    return values;
  }
  /// All bytes of a block.
  [[nodiscard]] std::string raw(const std::string& name) const {
    const auto at = head.find("\"" + name + "\":[\"");
    char kind = 0;
    std::size_t bits = 0, offset = 0, count = 0;
    REQUIRE(std::sscanf(head.c_str() + at + name.size() + 5, "%c%zu\",%zu,%zu", &kind, &bits,
                        &offset, &count) == 4);
    return bytes.substr(offset, count * bits / 8);
  }
  /// A number of the head; some are there only in frames with contacts.
  [[nodiscard]] std::optional<double> found(const std::string& name) const {
    const auto at = head.find("\"" + name + "\":");
    if (at == std::string::npos) return {};
    return std::atof(head.c_str() + at + name.size() + 3);
  }
  [[nodiscard]] double number(const std::string& name) const {
    const auto value = found(name);
    REQUIRE(value.has_value());
    return *value;
  }
  [[nodiscard]] vec3 vector(const std::string& name) const {
    double x = 0, y = 0, z = 0;
    const auto at = head.find("\"" + name + "\":[");
    REQUIRE(std::sscanf(head.c_str() + at + name.size() + 4, "%lf,%lf,%lf", &x, &y, &z) == 3);
    return {x, y, z};
  }
};

inline std::vector<frame> frames_of(const std::string& file) {
  const std::string page = content(file);
  CHECK(page.ends_with("</html>\n"));
  const auto heads = elements(page, "head"), data = elements(page, "data");
  REQUIRE(heads.size() == data.size());
  std::vector<frame> all;
  for (std::size_t k = 0; k < heads.size(); ++k) all.push_back({heads[k], decoded(data[k])});
  return all;
}

}  // namespace talus::view_pages
