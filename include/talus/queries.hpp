#pragma once
// Questions about the bodies of all ranks: rays, moving shapes, the nearest body, overlaps before a
// body is placed, regions. docs/output.md.
#include "talus/observe/queries.hpp"
