#include <talus/core/bytes.hpp>
#include <talus/core/error.hpp>

int main() {
  talus::detail::byte_buffer buffer;
  talus::detail::byte_writer(buffer).put(talus::vec3(1, 2, 3));
  const auto copy = talus::detail::byte_reader(buffer).get<talus::vec3>();
  fmt::print("{}\n", talus::detail::text(copy));
  return copy == talus::vec3(1, 2, 3) ? 0 : 1;
}
