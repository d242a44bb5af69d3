#pragma once
// The definitions of view_part.hpp, in the compiled part or in each program.
#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "talus/core/linkage.hpp"
#include "talus/core/shared_data.hpp"
#include "talus/io/detail/view_part.hpp"

namespace talus::detail {

template <class T>
void put_view_list(byte_buffer& out, std::span<const T> values) {
  byte_writer(out).put(std::uint64_t{values.size()});
  const std::size_t at = out.size();
  out.resize(at + values.size_bytes());
  if (!values.empty()) std::memcpy(out.data() + at, values.data(), values.size_bytes());
}
template <class List>
void get_view_list(std::span<const std::byte>& in, List& values) {
  using value = typename List::value_type;
  byte_reader head(in);
  const auto count = head.get<std::uint64_t>();
  in = in.subspan(sizeof(std::uint64_t));
  if (count > in.size() / sizeof(value))
    throw std::runtime_error("a message for --view ended before its content");
  values.resize(count);
  if (count > 0) std::memcpy(static_cast<void*>(values.data()), in.data(), count * sizeof(value));
  in = in.subspan(count * sizeof(value));
}

TALUS_INLINE byte_buffer view_part::packed() const {
  byte_buffer out;
  put_view_list(out, std::span<const double>(seconds));
  put_view_list(out, std::span(std::as_const(bodies).data(), bodies.size()));
  put_view_list(out, std::span(std::as_const(contacts).data(), contacts.size()));
  put_view_list(out, std::span(std::as_const(joints).data(), joints.size()));
  put_view_list(out, std::span(std::as_const(domain).data(), domain.size()));
  byte_writer(out).put(std::uint64_t{forms.size()});
  for (const view_form& f : forms) {
    byte_writer(out).put(f.id);
    put_view_list(out, std::span(std::as_const(f.points).data(), f.points.size()));
    put_view_list(out, std::span(std::as_const(f.corners).data(), f.corners.size()));
  }
  return out;
}

TALUS_INLINE view_part view_part::unpacked(std::span<const std::byte> bytes) {
  view_part p;
  plain_vector<double> times;
  get_view_list(bytes, times);
  std::copy_n(times.begin(), std::min(times.size(), p.seconds.size()), p.seconds.begin());
  get_view_list(bytes, p.bodies), get_view_list(bytes, p.contacts);
  get_view_list(bytes, p.joints), get_view_list(bytes, p.domain);
  const auto number = [&] {
    const auto n = byte_reader(bytes).get<std::uint64_t>();
    bytes = bytes.subspan(sizeof n);
    return n;
  };
  for (std::uint64_t left = number(); left > 0; --left) {
    view_form& f = p.forms.emplace_back();
    f.id = number();
    get_view_list(bytes, f.points), get_view_list(bytes, f.corners);
  }
  return p;
}

TALUS_INLINE std::uint64_t add_form(view_part& to, plain_vector<std::uint64_t>& sent,
                                    std::span<const vec3> points,
                                    std::span<const std::uint32_t> corners,
                                    std::span<const std::uint32_t> ends) {
  const content_id p = id_of_content(std::as_bytes(points)),
                   c = id_of_content(std::as_bytes(corners));
  const std::uint64_t id = mix(p.low ^ mix(p.high ^ mix(c.low ^ mix(c.high)))) | 1;
  std::uint64_t* const at = std::lower_bound(sent.begin(), sent.end(), id);
  if (at != sent.end() && *at == id) return id;
  sent.insert(at, id);
  view_form& f = to.forms.emplace_back();
  f.id = id;
  for (const vec3& x : points)
    for (int k = 0; k < 3; ++k) f.points.push_back(static_cast<float>(x[k]));
  std::uint32_t first = 0;
  for (const std::uint32_t end : ends) {
    for (std::uint32_t k = first + 1; k + 1 < end; ++k)
      for (const std::uint32_t at : {first, k, k + 1}) f.corners.push_back(corners[at]);
    first = end;
  }
  return id;
}

}  // namespace talus::detail
