#pragma once
// How the files written by runs are recognised, by their first bytes.
#include <string_view>

#include "talus/core/output_file.hpp"

namespace talus::detail {

inline constexpr std::string_view checkpoint_mark = "talus checkpoint, HDF5 follows\n";
inline constexpr std::string_view hdf5_mark = "\x89HDF\r\n\x1a\n";
inline constexpr std::string_view picture_mark =
    "#version 3.7;\nglobal_settings{assumed_gamma 1.0 max_trace_level 12}\n";

inline constexpr std::string_view configuration_mark_line = "# configuration of a run of talus: ";

inline constexpr std::string_view log_mark = "# log of a run of talus: ";

inline constexpr output_kind log_output{
    "the log of a run of talus", [](std::string_view head) { return head.starts_with(log_mark); }};
inline constexpr output_kind configuration_output{
    "the configuration of a run of talus",
    [](std::string_view head) { return head.starts_with(configuration_mark_line); }};
inline constexpr output_kind checkpoint_output{"a checkpoint of talus", [](std::string_view head) {
                                                 return head.starts_with(checkpoint_mark);
                                               }};
inline constexpr output_kind vtk_output_file{"an output of talus", [](std::string_view head) {
                                               return head.starts_with(hdf5_mark) &&
                                                      head.find("VTKHDF") != head.npos;
                                             }};
inline constexpr output_kind series_output{
    "an index of such files",
    [](std::string_view head) { return head.find("\"file-series-version\"") != head.npos; }};
inline constexpr output_kind results_output{
    "the results of a run of talus", [](std::string_view head) {
      return head.starts_with("{\n  \"ended_early\":") ||
             (head.starts_with('{') && head.find("\"scenario\":") != head.npos &&
              head.find("\"policies\":") != head.npos);
    }};
inline constexpr output_kind table_output{"a time series of talus", [](std::string_view head) {
                                            return head.starts_with("step [1],time [");
                                          }};
inline constexpr output_kind view_output{"a page of talus", [](std::string_view head) {
                                           return head.find("<!-- talus view 1") != head.npos;
                                         }};
inline constexpr output_kind picture_output{
    "a picture of talus", [](std::string_view head) { return head.starts_with(picture_mark); }};

}  // namespace talus::detail
