#pragma once
// The layout of VTKHDF files (VTK file formats, "VTKHDF", version 1.0: UnstructuredGrid), which VTK
// reads from 9.1 on: points and cells of all ranks in one piece, and their data.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/io/detail/row_table.hpp"
#include "talus/io/detail/team_writer.hpp"

namespace talus::detail {

class vtk_kind final : public file_kind {
 public:
  [[nodiscard]] const char* name() const override { return "the output"; }
  [[nodiscard]] const output_kind& looks() const override { return vtk_output_file; }
  /// A series survives a kill of its run, but not a power failure.
  [[nodiscard]] bool durable() const override { return false; }
  [[gnu::cold]] void describe_file(hid_t file) override;
};

/// Kinds of cells, as numbered by VTK.
enum class vtk_cell : std::uint8_t { vertex = 1, line = 3, poly_line = 4, polygon = 7 };

/// Cells of one rank: the points of each, one cell after the other, counted from the rank's first;
/// and the end of each cell among them.
struct vtk_cells {
  vtk_cell kind;
  std::vector<std::int64_t> points, ends;

  /// Each takes the next points, so many of them.
  [[nodiscard, gnu::cold]] static vtk_cells in_a_row(vtk_cell kind, std::size_t points,
                                                     std::size_t of_each);
};

/// Numbers of points, of cells, and of points of all cells.
struct vtk_counts {
  std::int64_t points = 0, cells = 0, corners = 0;
};

/// The cells of the file; `before` is the number of those of the ranks before. The first rank adds
/// the start of the first cell.
[[nodiscard, gnu::cold]] std::vector<table_part> tables_of(const vtk_cells& cells,
                                                           const vtk_counts& before,
                                                           bool first_rank);

/// Collective: writes cells, their points, and data, of points or of cells. `own_shapes`: names of
/// shapes whose numbers follow those that all scenarios share, one a line.
[[gnu::cold]] void write_vtk_file(checkpoint_team& team, const std::string& file,
                                  const vtk_cells& cells, row_table&& points, row_table&& data,
                                  std::uint64_t step, double time, bool force,
                                  const std::string& own_shapes = {});

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/vtk_file_definitions.hpp"
#endif
