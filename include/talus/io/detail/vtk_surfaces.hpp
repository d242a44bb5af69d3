#pragma once
// Surfaces of bodies as faces of an output: of all shapes but spheres and planes.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "talus/core/type_list.hpp"
#include "talus/io/detail/row_table.hpp"
#include "talus/io/detail/shape_surface.hpp"
#include "talus/io/detail/vtk_bodies.hpp"
#include "talus/io/detail/vtk_file.hpp"
#include "talus/shape/frame.hpp"
#include "talus/shape/union_of.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

template <class Shape>
struct shows_faces : std::bool_constant<has_surface<Shape>> {};
template <class... Shapes>
struct shows_faces<union_of<Shapes...>> : std::bool_constant<(has_surface<Shapes> || ...)> {};

/// The scenario has a shape with a surface of faces.
template <class Scenario>
inline constexpr bool has_surfaces = filter_types<typename Scenario::shapes, shows_faces>::size > 0;

/// The corners of faces, the data of faces, and the corners of each face.
template <class Scenario>
class vtk_surfaces {
 public:
  vtk_surfaces() {
    points.column("Points", number_type::f64, 3);
    data.column("id", number_type::u64)
        .column("rank", number_type::u32)
        .column("shape", number_type::u8)
        .column("fixed", number_type::u8)
        .column("material", number_type::u16)
        .column("velocity", number_type::f64, 3);
  }

  /// Adds the surfaces of the bodies that this rank owns, and on rank 0 of the global ones.
  void add_all(const population<Scenario>& s) {
    s.each_finite_shape([&](auto& b) {
      using shape = typename std::decay_t<decltype(b.movable)>::shape_type;
      if constexpr (shows_faces<shape>::value) {
        const auto rank = static_cast<std::uint32_t>(s.link->rank());
        for (std::size_t i = 0; i < b.movable.locals; ++i) add(b.movable, i, rank);
        if (rank == 0)
          for (std::size_t i = 0; i < b.global.size(); ++i) add(b.global, i, rank);
      }
    });
  }
  /// The faces, in the order of the rows.
  [[nodiscard, gnu::cold]] vtk_cells cells() {
    std::stable_sort(pieces_.begin(), pieces_.end(),
                     [](const piece& a, const piece& b) { return a.key < b.key; });
    vtk_cells all{vtk_cell::polygon, {}, {}};
    std::int64_t first = 0;
    for (const piece& p : pieces_) {
      std::uint32_t corner = 0;
      for (std::uint32_t face = 0; face < p.faces; ++face) {
        const std::uint32_t end = ends_[p.first_face + face];
        for (; corner < end; ++corner)
          all.points.push_back(first + corners_[p.first_corner + corner]);
        all.ends.push_back(static_cast<std::int64_t>(all.points.size()));
      }
      first += p.points;
    }
    return all;
  }

  row_table points{"/VTKHDF"}, data{"/VTKHDF/CellData"};
  shape_numbers shapes{typename Scenario::shapes{}};

 private:
  /// The faces of a body, or of a part of a union, among those added.
  struct piece {
    row_table::key key;
    std::size_t first_corner, first_face;
    std::uint32_t faces, points;
  };

  template <class Store>
  void add(const Store& store, std::size_t i, std::uint32_t rank) {
    each_part_of(store, i, [&](const auto& shape, const pose& at, std::uint32_t part) {
      add_one(store, i, rank, shape, at, part);
    });
  }
  template <class Store, class Shape>
  void add_one(const Store& store, std::size_t i, std::uint32_t rank, const Shape& shape,
               const pose& at, std::uint32_t part) {
    if constexpr (has_surface<Shape>) {
      surface_.clear();
      add_surface(surface_, shape);
      const row_table::key key{value_of(store.id[i]), part, 0};
      pieces_.push_back({key, corners_.size(), ends_.size(),
                         static_cast<std::uint32_t>(surface_.ends.size()),
                         static_cast<std::uint32_t>(surface_.points.size())});
      corners_.insert(corners_.end(), surface_.corners.begin(), surface_.corners.end());
      ends_.insert(ends_.end(), surface_.ends.begin(), surface_.ends.end());
      for (const vec3& p : surface_.points) {
        points.begin_row(key);
        points.put(vec3(at.position + rotated(at.orientation, p)));
      }
      for (std::size_t face = 0; face < surface_.ends.size(); ++face) {
        data.begin_row(key);
        data.put(value_of(store.id[i]));
        data.put(rank);
        data.put(shapes.number(Shape::name));
        data.put(static_cast<std::uint8_t>(store.fixed(i)));
        data.put(static_cast<std::uint16_t>(store.material[i]));
        data.put(store.velocity[i]);
      }
    }
  }

  surface_faces surface_;  ///< of one body, in its frame
  std::vector<piece> pieces_;
  std::vector<std::uint32_t> corners_, ends_;
};

}  // namespace talus::detail
