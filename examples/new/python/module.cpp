// The scene as a module of Python: drive.py imports it.
#include <talus/python.hpp>

#include "scene.hpp"

PYBIND11_MODULE(NAME, module) { python::scenario<scene, scene_options>(module, set_up); }
