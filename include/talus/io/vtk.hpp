#pragma once
// Bodies, contacts and joints for ParaView, VTK and Python: docs/output.md.
#include <sys/stat.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "talus/core/run_lock.hpp"
#include "talus/io/detail/series_index.hpp"
#include "talus/io/detail/vtk_bodies.hpp"
#include "talus/io/detail/vtk_contacts.hpp"
#include "talus/io/detail/vtk_file.hpp"
#include "talus/io/detail/vtk_joints.hpp"
#include "talus/io/detail/vtk_surfaces.hpp"
#include "talus/io/output_kinds.hpp"
#include "talus/io/output_series.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// Options of an output besides bodies and contacts.
struct vtk_content {
  bool surfaces = false;  ///< faces of all bodies but spheres and planes, NAME_surfaces.hdf
  bool force = false;     ///< replaces files of these names that talus did not write
};

namespace detail {

template <class Scenario>
void write_vtk_bodies(world<Scenario>& w, checkpoint_team& team, const std::string& file,
                      bool force) {
  vtk_bodies<Scenario> rows;
  rows.add_all(view_of(w));
  write_vtk_file(team, file, vtk_cells::in_a_row(vtk_cell::vertex, rows.points.rows(), 1),
                 std::move(rows.points), std::move(rows.data), w.steps(), w.time(), force,
                 rows.shapes.others());
}
template <class Scenario>
void write_vtk_contacts(world<Scenario>& w, checkpoint_team& team, const std::string& file,
                        bool force) {
  vtk_contacts rows;
  rows.add_all(w);
  write_vtk_file(team, file, vtk_cells::in_a_row(vtk_cell::line, rows.points.rows(), 2),
                 std::move(rows.points), std::move(rows.data), w.steps(), w.time(), force);
}
template <class Scenario>
void write_vtk_joints(world<Scenario>& w, checkpoint_team& team, const std::string& file,
                      bool force) {
  vtk_joints rows;
  rows.add_all(w);
  write_vtk_file(
      team, file,
      vtk_cells::in_a_row(vtk_cell::poly_line, rows.points.rows(), vtk_joints::points_of_each),
      std::move(rows.points), std::move(rows.data), w.steps(), w.time(), force);
}
template <class Scenario>
void write_vtk_surfaces(world<Scenario>& w, checkpoint_team& team, const std::string& file,
                        bool force) {
  vtk_surfaces<Scenario> rows;
  rows.add_all(view_of(w));
  write_vtk_file(team, file, rows.cells(), std::move(rows.points), std::move(rows.data), w.steps(),
                 w.time(), force, rows.shapes.others());
}

/// One of the files of an output.
template <class Scenario>
struct vtk_block {
  const char* end_of_name;
  void (*write)(world<Scenario>&, checkpoint_team&, const std::string&, bool force);
};
template <class Scenario>
[[nodiscard, gnu::cold]] std::vector<vtk_block<Scenario>> vtk_blocks(const vtk_content& content) {
  const auto& [bodies, contacts, joints, surfaces] = ends_of_output;
  std::vector<vtk_block<Scenario>> all{{bodies, write_vtk_bodies<Scenario>},
                                       {contacts, write_vtk_contacts<Scenario>}};
  if constexpr (Scenario::joints::size > 0) all.push_back({joints, write_vtk_joints<Scenario>});
  if constexpr (has_surfaces<Scenario>) {
    if (content.surfaces) all.push_back({surfaces, write_vtk_surfaces<Scenario>});
  } else if (content.surfaces) {
    throw std::invalid_argument(
        "an output has no surfaces where all bodies are spheres or planes: leave surfaces out, and "
        "draw the points of the output as spheres of their radius");
  }
  return all;
}

}  // namespace detail

/// Collective: the present state of bodies and contacts as NAME.hdf and NAME_contacts.hdf, which
/// replace files of that name when they are complete. Bodies are points: those that ranks own, and
/// the finite global ones, in the order of their ids within each rank; of a union each part. A
/// contact that carries a force is a line from centre to centre, or to the contact point with
/// something immovable. Joints are lines, too, in NAME_joints.hdf, if the scenario names any. All
/// columns, and programs that read them: docs/output.md. Throws
/// runtime_error alike on all ranks if a file cannot be written, and invalid_argument for surfaces
/// if no shape has any.
template <class Scenario>
[[gnu::cold]] void write_vtk(world<Scenario>& w, const std::string& name,
                             const vtk_content& content = {}) {
  w.require_all_ranks("write_vtk");
  detail::team_over team(w.link());
  const std::string base = detail::output_name(name);
  for (const auto& block : detail::vtk_blocks<Scenario>(content))
    block.write(w, team, base + block.end_of_name + detail::vtk_extension, content.force);
}

/// A series of such files, NAME_0000001200.hdf after step 1,200 and so on, with NAME.hdf.series and
/// NAME_contacts.hdf.series, which list them and their times. A file is added to a series when it
/// is complete: the files of a killed run can be read.
template <class Scenario>
class vtk_series {
 public:
  using content = vtk_content;

  /// With `goes_on` the series of that name continues at the step of the run, see go_on().
  /// Otherwise it is replaced, by the first write(): until then it stays, since what follows may
  /// refuse the run. Collective; throws as write_vtk does.
  explicit vtk_series(world<Scenario>& w, const std::string& name, bool goes_on = false,
                      const content& what = {})
      : w_(w),
        name_(detail::output_name(name)),
        goes_on_(goes_on),
        begins_(!goes_on),
        force_(what.force),
        with_surfaces_(what.surfaces) {
    w.require_all_ranks("vtk_series", false);
    for (const auto& block : detail::vtk_blocks<Scenario>(what))
      parts_.push_back(
          {block, detail::series_index(detail::index_of_output(name_, block.end_of_name), force_)});
    detail::team_over team(w.link());
    team.together([&] {
      if (w.rank() != 0) return;
      if (name_.empty() || name_.back() == '/')
        detail::fail<std::runtime_error>(
            "the output {} has no name: give the beginning of the names of its files", name);
      if (!detail::is_utf8(name_))
        detail::fail<std::runtime_error>(
            "the output {} cannot be listed in its index: its name is not UTF-8", name);
      for (const part& p : parts_) {
        replaces_ |= p.index.require_writable();
        p.index.each_name([&](const std::string& file) { listed_.push_back(file); });
        (void)detail::inspect_series("the output", name_ + p.block.end_of_name + "_",
                                     detail::vtk_extension, detail::vtk_output_file, force_,
                                     [&](const std::string& file) { return lists(file); });
      }
      for (const part& p : parts_) lock(p.block.end_of_name);
      if (!with_surfaces_) lock(detail::ends_of_output[3]);
    });
  }

  /// Whether a series of this name existed. On rank 0 alone.
  [[nodiscard]] bool replaces() const { return replaces_ && !goes_on_; }
  /// Collective: of a continued series, removes the files of later steps than the present one, or
  /// that of the present one too. Does so once; write() does so by itself.
  [[gnu::cold]] void go_on(bool keep_present = true) {
    if (!std::exchange(goes_on_, false)) return;
    detail::team_over team(w_.link());
    std::uint64_t has_now = 0;
    team.together([&] {
      if (w_.rank() != 0) return;
      // All files of the present step exist, or they are written again.
      const std::uint64_t end = w_.steps() + 1;
      has_now = keep_present && std::all_of(parts_.begin(), parts_.end(), [&](const part& p) {
                  return p.index.last_before(end) == w_.steps();
                });
      remove_surfaces();
      for (part& p : parts_) p.index.go_on(has_now != 0 ? end : w_.steps());
    });
    team.most(std::span(&has_now, 1));
    if (has_now != 0) last_ = w_.steps();
  }
  /// Collective: adds the present state, unless the series has this step already.
  [[gnu::cold]] void write() {
    w_.require_all_ranks("vtk_series::write");
    go_on();
    if (last_ == w_.steps()) return;
    detail::team_over team(w_.link());
    if (std::exchange(begins_, false))
      team.together([&] {
        if (w_.rank() != 0) return;
        remove_surfaces();
        for (part& p : parts_) p.index.begin();
      });
    last_ = w_.steps();
    std::string digits = std::to_string(w_.steps());
    if (digits.size() < 10) digits.insert(0, 10 - digits.size(), '0');
    const auto file = [&](const part& p) {
      return name_ + p.block.end_of_name + "_" + digits + detail::vtk_extension;
    };
    for (const part& p : parts_)
      p.block.write(w_, team, file(p), force_ || lists(without_folder(file(p))));
    team.together([&] {
      if (w_.rank() != 0) return;
      for (part& p : parts_) p.index.add(without_folder(file(p)), w_.time());
    });
  }

 private:
  struct part {
    detail::vtk_block<Scenario> block;
    detail::series_index index;
  };
  /// Locks one index: that of the contacts, say, may be that of another run's bodies.
  void lock(const char* end_of_name) {
    const std::string index = detail::index_of_output(name_, end_of_name);
    locks_->emplace_back(index, "the output " + index)
        .remove_left_over(name_ + end_of_name + "_", detail::vtk_extension);
  }
  /// Without surfaces, their index would list files of another run, or beyond the present step.
  void remove_surfaces() const {
    const std::string surfaces = detail::index_of_output(name_, detail::ends_of_output[3]);
    if (!with_surfaces_ && detail::inspect_target(surfaces, detail::series_output, false).replaces)
      std::remove(surfaces.c_str());
  }
  [[nodiscard]] static std::string without_folder(const std::string& file) {
    return file.substr(file.find_last_of('/') + 1);
  }
  /// Whether the existing index lists a file: it is of an earlier run then, whatever its content.
  [[nodiscard]] bool lists(const std::string& file) const {
    struct stat found {};
    const std::string path = name_.substr(0, name_.find_last_of('/') + 1) + file;
    return std::find(listed_.begin(), listed_.end(), detail::quoted_text(file)) != listed_.end() &&
           ::lstat(path.c_str(), &found) == 0 && S_ISREG(found.st_mode);
  }
  world<Scenario>& w_;
  std::string name_;
  std::shared_ptr<std::list<detail::run_lock>> locks_ =
      std::make_shared<std::list<detail::run_lock>>();  ///< on rank 0; copies share them
  std::vector<std::string> listed_;                     ///< on rank 0
  std::vector<part> parts_;
  bool goes_on_, begins_, force_, with_surfaces_, replaces_ = false;
  std::optional<std::uint64_t> last_;
};

}  // namespace talus
