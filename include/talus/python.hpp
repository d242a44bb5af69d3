#pragma once
// Python drives a compiled scenario: docs/python.md. Needs pybind11 and the headers of Python.
#if !__has_include(<pybind11/pybind11.h>)
#error \
    "<talus/python.hpp> needs pybind11 and the headers of Python: in Debian pybind11-dev and python3-dev"
#else
#include "talus/python/scenario.hpp"
#endif
