// The compiled part: files of options, with toml++ behind them.
#include "talus/scene/settings_file_definitions.hpp"
