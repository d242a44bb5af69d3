#pragma once
// Bodies and contacts for ParaView, VTK and Python: docs/output.md.
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "talus/io/detail/series_index.hpp"
#include "talus/io/detail/vtk_bodies.hpp"
#include "talus/io/detail/vtk_contacts.hpp"
#include "talus/io/detail/vtk_file.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/world.hpp"

namespace talus {

namespace detail {

inline constexpr const char* vtk_extension = ".hdf";

template <class Scenario>
void write_vtk_bodies(world<Scenario>& w, checkpoint_team& team, const std::string& file) {
  vtk_bodies<Scenario> rows;
  rows.add_all(w.state());
  write_vtk_file(team, file, vtk_cell::vertex, std::move(rows.points), std::move(rows.data),
                 w.steps(), w.time());
}
template <class Scenario>
void write_vtk_contacts(world<Scenario>& w, checkpoint_team& team, const std::string& file) {
  vtk_contacts rows;
  rows.add_all(w);
  write_vtk_file(team, file, vtk_cell::line, std::move(rows.points), std::move(rows.data),
                 w.steps(), w.time());
}

/// The name without what says that it is an output.
[[nodiscard, gnu::cold]] inline std::string output_name(std::string name) {
  for (const std::string_view end : {".series", vtk_extension})
    if (name.size() > end.size() && std::string_view(name).substr(name.size() - end.size()) == end)
      name.resize(name.size() - end.size());
  return name;
}

}  // namespace detail

/// Collective: the present state of bodies and contacts as NAME.hdf and NAME_contacts.hdf,
/// which replace files of that name when they are whole. Bodies are points: those that ranks own,
/// and the global ones that have an end, in the order of their ids within each rank; of a union
/// each part. A contact that carries a force is a line from centre to centre, or to the point where
/// something immovable is touched. All columns, and what reads them: docs/output.md. Throws
/// runtime_error alike on all ranks if a file cannot be written.
template <class Scenario>
[[gnu::cold]] void write_vtk(world<Scenario>& w, const std::string& name) {
  w.require_all_ranks("write_vtk");
  detail::team_over team(w.link());
  const std::string base = detail::output_name(name);
  detail::write_vtk_bodies(w, team, base + detail::vtk_extension);
  detail::write_vtk_contacts(w, team, base + "_contacts" + detail::vtk_extension);
}

/// A series of such files, NAME_0000001200.hdf after step 1,200 and so on, with
/// NAME.hdf.series and NAME_contacts.hdf.series, which name them and their times. A file is in
/// a series when it is whole: what a killed run leaves can be read.
template <class Scenario>
class vtk_series {
 public:
  /// With `goes_on` the series of that name goes on where the run does, see go_on(). Else it is
  /// replaced. Collective; throws runtime_error alike on all ranks if it cannot be written.
  explicit vtk_series(world<Scenario>& w, const std::string& name, bool goes_on = false)
      : w_(w),
        name_(detail::output_name(name)),
        bodies_(name_ + detail::vtk_extension + ".series"),
        contacts_(name_ + "_contacts" + detail::vtk_extension + ".series"),
        goes_on_(goes_on) {
    w.require_all_ranks("vtk_series");
    detail::team_over team(w.link());
    team.together([&] {
      if (w.rank() != 0) return;
      if (name_.empty() || name_.back() == '/')
        detail::fail<std::runtime_error>(
            "the output {} has no name: give the beginning of the names of its files", name);
      bodies_.require_writable(), contacts_.require_writable();
      if (!goes_on) bodies_.begin(), contacts_.begin();
    });
  }

  /// Collective: of a series that goes on, the files of later steps than the present one leave it.
  /// Does so once; write() does so by itself.
  [[gnu::cold]] void go_on() {
    if (!std::exchange(goes_on_, false)) return;
    detail::team_over team(w_.link());
    std::uint64_t has_now = 0;
    team.together([&] {
      if (w_.rank() != 0) return;
      // Of the present step there are both files, or they are written again.
      const std::uint64_t end = w_.steps() + 1;
      has_now = bodies_.last_before(end) == w_.steps() && contacts_.last_before(end) == w_.steps();
      for (detail::series_index* index : {&bodies_, &contacts_})
        index->go_on(has_now != 0 ? end : w_.steps());
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
    last_ = w_.steps();
    std::string digits = std::to_string(w_.steps());
    if (digits.size() < 10) digits.insert(0, 10 - digits.size(), '0');
    const std::string bodies = name_ + "_" + digits + detail::vtk_extension,
                      contacts = name_ + "_contacts_" + digits + detail::vtk_extension;
    detail::write_vtk_bodies(w_, team, bodies);
    detail::write_vtk_contacts(w_, team, contacts);
    team.together([&] {
      if (w_.rank() != 0) return;
      bodies_.add(without_folder(bodies), w_.time());
      contacts_.add(without_folder(contacts), w_.time());
    });
  }

 private:
  [[nodiscard]] static std::string without_folder(const std::string& file) {
    return file.substr(file.find_last_of('/') + 1);
  }
  world<Scenario>& w_;
  std::string name_;
  detail::series_index bodies_, contacts_;
  bool goes_on_;
  std::optional<std::uint64_t> last_;
};

}  // namespace talus
