/* SPDX-License-Identifier: Apache-2.0 */
/* The table of qualities. `final` has the keys' defaults.
 *
 * draft is for visual checks: precomputation follows the picture's size. preview is between draft and final. reference
 * is unbiased. */
#include "scene/quality.h"

/* clang-format off */
static const np_quality_knob knobs[] = {
    /* key                        draft     preview   final     reference */
    {"render.integrator",        {"march",  "march",  "march",  "path"}},
    {"render.samples",           {"2",      "2",      "4",      "256"}},
    {"render.tolerance",         {"0.1",    "0.04",   "0.02",   "0.005"}},
    {"render.transmittance_end", {"0.01",   "0.003",  "0.001",  "0.0001"}},
    {"render.detail",            {"4",      "1",      "0",      "0"}},
    {"render.light_detail",      {"8",      "3",      "0",      "0"}},
    {"render.light_depth",       {"0.65",   "0.6",    "0.35",   "0.35"}},
    {"render.light_degree",      {"3",      "7",      "11",     "11"}},
    {"render.light_residual",    {"0.03",   "0.003",  "0.0003", "0.0003"}},
};
/* clang-format on */

size_t np_quality_knob_count(void) { return sizeof knobs / sizeof *knobs; }

const np_quality_knob *np_quality_knob_at(size_t index) { return &knobs[index]; }
