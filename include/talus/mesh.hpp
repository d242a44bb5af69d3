#pragma once
// Surfaces of triangles as walls, for scenarios that name triangle_mesh.
#include "talus/detect/pairs/mesh_any.hpp"
#include "talus/io/stl.hpp"
#include "talus/shape/surfaces.hpp"
#include "talus/shape/triangle_mesh.hpp"
