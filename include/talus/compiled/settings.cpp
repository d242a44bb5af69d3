// The compiled part: files of options, with toml++ behind them, and the logs of runs, which say how
// this part was compiled.
#include "talus/scene/run_log_definitions.hpp"
#include "talus/scene/settings_file_definitions.hpp"
