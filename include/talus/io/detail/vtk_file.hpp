#pragma once
// The layout of VTKHDF files (VTK file formats, "VTKHDF", version 1.0: UnstructuredGrid), which VTK
// reads from 9.1 on: points and cells of all ranks in one piece, and what they carry.
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
  /// A series survives that its run is killed, not that the power fails.
  [[nodiscard]] bool durable() const override { return false; }
  [[gnu::cold]] void describe_file(hid_t file) override {
    const std::int64_t version[] = {1, 0};
    write_attribute(file, "/VTKHDF", "Version", version);
    write_attribute(file, "/VTKHDF", "Type", "UnstructuredGrid");
  }
};

/// Kinds of cells, as VTK numbers them.
enum class vtk_cell : std::uint8_t { vertex = 1, line = 3 };

/// Cells of this rank: each takes the next points, one of a vertex, two of a line.
struct vtk_cells {
  /// `first` cells are those of the ranks before; the first rank adds the place where all begin.
  [[gnu::cold]] vtk_cells(vtk_cell kind, std::uint64_t first, std::uint64_t cells,
                          bool first_rank) {
    const auto corners = kind == vtk_cell::vertex ? 1u : 2u;
    const auto add = [&](const char* name, number_type type, std::uint64_t rows, auto&& value) {
      table_part& t = tables.emplace_back();
      t.path = "/VTKHDF";
      t.rows = rows;
      byte_buffer bytes;
      bytes.reserve(t.rows * bytes_of(type));
      byte_writer out(bytes);
      for (std::uint64_t i = 0; i < t.rows; ++i) out.put(value(i));
      t.memory.push_back(std::move(bytes));
      t.columns.push_back({name, type, 1, t.memory.back().data()});
    };
    add("Connectivity", number_type::i64, cells * corners,
        [&](std::uint64_t i) { return static_cast<std::int64_t>(first * corners + i); });
    add("Types", number_type::u8, cells, [&](std::uint64_t) { return kind; });
    add("Offsets", number_type::i64, cells + first_rank, [&](std::uint64_t i) {
      return static_cast<std::int64_t>((first + i + !first_rank) * corners);
    });
  }
  std::vector<table_part> tables;
};

/// Collective: writes points, in the order of their cells, and data, of points or of cells.
[[gnu::cold]] inline void write_vtk_file(checkpoint_team& team, const std::string& file,
                                         vtk_cell kind, row_table&& points, row_table&& data,
                                         std::uint64_t step, double time) {
  const std::uint64_t own = kind == vtk_cell::vertex ? points.rows() : points.rows() / 2;
  byte_buffer mine;
  byte_writer(mine).put(own);
  std::uint64_t first = 0, all = 0;
  int rank = 0;
  for (const byte_buffer& each : team.gather_all(mine)) {
    const auto cells = byte_reader(each).get<std::uint64_t>();
    if (rank++ < team.rank()) first += cells;
    all += cells;
  }
  std::vector<table_part> tables = std::move(vtk_cells(kind, first, own, team.rank() == 0).tables);
  tables.push_back(points.take());
  tables.push_back(data.take());
  const auto corners = kind == vtk_cell::vertex ? 1u : 2u;
  const auto whole = [](const char* name, std::uint64_t n) {
    const auto value = static_cast<std::int64_t>(n);
    return numbers_dataset<std::int64_t>(std::string("/VTKHDF/") + name, std::span(&value, 1));
  };
  const std::vector<small_dataset> small{
      whole("NumberOfPoints", all * corners), whole("NumberOfCells", all),
      whole("NumberOfConnectivityIds", all * corners), whole("FieldData/step", step),
      numbers_dataset<double>("/VTKHDF/FieldData/time", std::span(&time, 1))};
  vtk_kind how;
  team_writer(team, how, file).write(tables, small);
}

}  // namespace talus::detail
