#pragma once
// The definitions of vtk_file.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/vtk_file.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE void vtk_kind::describe_file(hid_t file) {
  const std::int64_t version[] = {1, 0};
  write_attribute(file, "/VTKHDF", "Version", version);
  write_attribute(file, "/VTKHDF", "Type", "UnstructuredGrid");
}

TALUS_HDF5_INLINE vtk_cells vtk_cells::in_a_row(vtk_cell kind, std::size_t points,
                                                std::size_t of_each) {
  vtk_cells all{kind, std::vector<std::int64_t>(points), {}};
  for (std::size_t k = 0; k < points; ++k) all.points[k] = static_cast<std::int64_t>(k);
  for (std::size_t end = of_each; end <= points; end += of_each)
    all.ends.push_back(static_cast<std::int64_t>(end));
  return all;
}

TALUS_HDF5_INLINE std::vector<table_part> tables_of(const vtk_cells& cells,
                                                    const vtk_counts& before, bool first_rank) {
  std::vector<table_part> tables;
  const auto add = [&](const char* name, number_type type, std::size_t rows, auto&& value) {
    table_part& t = tables.emplace_back();
    t.path = "/VTKHDF";
    t.rows = rows;
    byte_buffer bytes;
    bytes.reserve(t.rows * bytes_of(type));
    byte_writer out(bytes);
    for (std::size_t i = 0; i < rows; ++i) out.put(value(i));
    t.memory.push_back(std::move(bytes));
    t.columns.push_back({name, type, 1, t.memory.back().data()});
  };
  add("Connectivity", number_type::i64, cells.points.size(),
      [&](std::size_t i) { return before.points + cells.points[i]; });
  add("Types", number_type::u8, cells.ends.size(), [&](std::size_t) { return cells.kind; });
  const std::size_t begin = first_rank ? 1 : 0;
  add("Offsets", number_type::i64, cells.ends.size() + begin, [&](std::size_t i) {
    return before.corners + (i < begin ? std::int64_t{0} : cells.ends[i - begin]);
  });
  return tables;
}

TALUS_HDF5_INLINE void write_vtk_file(checkpoint_team& team, const std::string& file,
                                      const vtk_cells& cells, row_table&& points, row_table&& data,
                                      std::uint64_t step, double time, bool force,
                                      const std::string& own_shapes) {
  byte_buffer mine;
  byte_writer(mine).put(vtk_counts{static_cast<std::int64_t>(points.rows()),
                                   static_cast<std::int64_t>(cells.ends.size()),
                                   static_cast<std::int64_t>(cells.points.size())});
  vtk_counts before, all;
  int rank = 0;
  const auto add = [](vtk_counts& sum, const vtk_counts& n) {
    sum.points += n.points, sum.cells += n.cells, sum.corners += n.corners;
  };
  for (const byte_buffer& each : team.gather_all(mine)) {
    const auto n = byte_reader(each).get<vtk_counts>();
    if (rank++ < team.rank()) add(before, n);
    add(all, n);
  }
  std::vector<table_part> tables = tables_of(cells, before, team.rank() == 0);
  tables.push_back(points.take());
  tables.push_back(data.take());
  const auto whole = [](const char* name, std::int64_t value) {
    return numbers_dataset<std::int64_t>(std::string("/VTKHDF/") + name, std::span(&value, 1));
  };
  std::vector<small_dataset> small{
      whole("NumberOfPoints", all.points), whole("NumberOfCells", all.cells),
      whole("NumberOfConnectivityIds", all.corners),
      whole("FieldData/step", static_cast<std::int64_t>(step)),
      numbers_dataset<double>("/VTKHDF/FieldData/time", std::span(&time, 1))};
  if (!own_shapes.empty())
    small.push_back(text_dataset("/VTKHDF/FieldData/own_shapes", own_shapes));
  vtk_kind how;
  team_writer(team, how, file, force).write(tables, small);
}

}  // namespace talus::detail
