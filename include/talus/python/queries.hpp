#pragma once
// Questions about the bodies of a world, in Python: rays, the nearest body, regions, overlaps.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/observe/queries.hpp"
#include "talus/python/changes.hpp"
#include "talus/python/module.hpp"
#include "talus/scene/region.hpp"

namespace talus::detail {

/// What was asked about, in rows of three numbers.
using places_of_python =
    pybind11::array_t<real, pybind11::array::c_style | pybind11::array::forcecast>;

/// Throws invalid_argument, with the name of the argument, unless the array has rows of three
/// numbers.
[[nodiscard]] inline std::vector<vec3> rows_of(const places_of_python& array, const char* name) {
  if (array.ndim() != 2 || array.shape(1) != 3)
    fail<std::invalid_argument>("{} needs rows of three numbers, as an array of shape (n, 3)",
                                name);
  std::vector<vec3> rows;
  for (pybind11::ssize_t i = 0; i < array.shape(0); ++i)
    rows.emplace_back(array.at(i, 0), array.at(i, 1), array.at(i, 2));
  return rows;
}

/// Hits as a dictionary of arrays with a row for each question.
[[nodiscard]] inline pybind11::dict arrays_of_hits(const std::vector<query_hit>& hits) {
  namespace py = pybind11;
  const auto n = static_cast<py::ssize_t>(hits.size());
  py::array_t<bool> found(n);
  py::array_t<std::uint64_t> id(n);
  py::array_t<real> distance(n), point({n, py::ssize_t{3}}), normal({n, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < n; ++i) {
    const query_hit& hit = hits[static_cast<std::size_t>(i)];
    found.mutable_at(i) = static_cast<bool>(hit);
    id.mutable_at(i) = hit ? value_of(hit.id) : 0;
    distance.mutable_at(i) = hit.distance;
    for (int k = 0; k < 3; ++k)
      point.mutable_at(i, k) = hit.point[k], normal.mutable_at(i, k) = hit.normal[k];
  }
  py::dict all;
  all["found"] = found, all["id"] = id, all["distance"] = distance;
  all["point"] = point, all["normal"] = normal;
  return all;
}

[[nodiscard]] inline pybind11::array_t<std::uint64_t> ids_of(const std::vector<query_hit>& hits) {
  pybind11::array_t<std::uint64_t> ids(static_cast<pybind11::ssize_t>(hits.size()));
  for (std::size_t i = 0; i < hits.size(); ++i)
    ids.mutable_at(static_cast<pybind11::ssize_t>(i)) = value_of(hits[i].id);
  return ids;
}

template <class Session, class Class>
void bind_queries(Class& world_class) {
  namespace py = pybind11;
  using driven = driven_world<Session>;
  using world_type = typename Session::world_type;
  world_class
      .def(
          "cast_rays",
          [](driven& d, const places_of_python& from, const places_of_python& direction,
             real length) {
            const std::vector<vec3> starts = rows_of(from, "cast_rays(origins=...)"),
                                    ways = rows_of(direction, "cast_rays(directions=...)");
            if (starts.size() != ways.size())
              fail<std::invalid_argument>(
                  "cast_rays has {} origins and {} directions: give as many", starts.size(),
                  ways.size());
            std::vector<ray> rays;
            for (std::size_t i = 0; i < starts.size(); ++i)
              rays.push_back({.from = starts[i], .direction = ways[i], .length = length});
            return arrays_of_hits(
                d.session->read([&](world_type& w) { return talus::cast_rays(w, rays); }));
          },
          py::arg("origins"), py::arg("directions"), py::arg("length") = endless,
          "The first body on each ray: a dictionary of arrays found, id, distance, point, normal, "
          "with a row for each ray.")
      .def(
          "nearest_bodies",
          [](driven& d, const places_of_python& points, real within) {
            const std::vector<vec3> places = rows_of(points, "nearest_bodies(points=...)");
            return arrays_of_hits(d.session->read(
                [&](world_type& w) { return talus::nearest_bodies(w, places, within); }));
          },
          py::arg("points"), py::arg("within") = endless,
          "The body whose surface is nearest to each point, likewise; distance 0 within a body.")
      .def(
          "bodies_within",
          [](driven& d, const std::array<real, 3>& lower, const std::array<real, 3>& upper) {
            const box_region region{{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
            return ids_of(
                d.session->read([&](world_type& w) { return talus::bodies_within(w, region); }));
          },
          py::arg("lower"), py::arg("upper"),
          "The ids of the bodies whose centres are in a box, in ascending order.");
}

/// Adds the questions about overlaps to the class of the bodies of one shape.
template <class Session, class Class>
void bind_overlaps(Class& bodies_class) {
  namespace py = pybind11;
  using bodies = bodies_of_one_shape<Session>;
  using world_type = typename Session::world_type;
  bodies_class.def(
      "find_overlaps",
      [](const bodies& b, const py::args& sizes, const std::array<real, 3>& position,
         const py::object& orientation) {
        const auto numbers = value_from<std::vector<real>>(sizes, sizes_are_numbers);
        // After *args, pybind11 2.10 does not convert the last argument.
        const auto q = value_from<std::array<real, 4>>(
            orientation, "an orientation needs four numbers: x, y, z, w");
        const pose at{{position[0], position[1], position[2]}, {q[3], q[0], q[1], q[2]}};
        std::vector<query_hit> hits;
        b.session->read([&](world_type& w) {
          on_shape(w, b.shape, [&]<class Shape>(std::type_identity<Shape>) {
            if constexpr (movable_query<Shape>)
              hits = talus::find_overlaps(w, shape_from<Shape>(numbers), std::span(&at, 1)).front();
          });
          return true;
        });
        return ids_of(hits);
      },
      py::arg("position"), py::arg("orientation") = py::make_tuple(0, 0, 0, 1),
      "The ids of the bodies that one more would overlap: find_overlaps(radius, position=...), "
      "with "
      "the numbers of add.");
}

}  // namespace talus::detail
