#pragma once
// Observers that a program calls directly: the contact network (for_each_contact),
// measure_coordination, measure_fields, flow_meter, body_table, contact_table. docs/output.md.
#include "talus/observe/coordination.hpp"
#include "talus/observe/fields.hpp"
#include "talus/observe/flow.hpp"
#include "talus/observe/tables.hpp"
#include "talus/world/each_contact.hpp"
