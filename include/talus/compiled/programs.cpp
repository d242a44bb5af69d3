// The compiled part: command lines, progress, summaries and files.
#include "talus/core/output_file_definitions.hpp"
#include "talus/observe/progress_definitions.hpp"
#include "talus/observe/summary_json_definitions.hpp"
#include "talus/observe/summary_text_definitions.hpp"
#include "talus/observe/time_series_definitions.hpp"
#include "talus/scene/detail/command_line.hpp"
#include "talus/scene/detail/run_guard_definitions.hpp"
#include "talus/scene/options_definitions.hpp"
