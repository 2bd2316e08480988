/* SPDX-License-Identifier: Apache-2.0 */
/* Keys of accuracy, of qualities, and of previews. */
#include "scene/quality.h"
#include "scene/scene_key_rows.h"

static const np_choice qualities[] = {{"draft", NP_QUALITY_DRAFT},
                                      {"preview", NP_QUALITY_PREVIEW},
                                      {"final", NP_QUALITY_FINAL},
                                      {"reference", NP_QUALITY_REFERENCE},
                                      {NULL, 0}};
static const np_choice histories[] = {{"none", NP_HISTORY_NONE}, {"reproject", NP_HISTORY_REPROJECT}, {NULL, 0}};
static const np_choice updates[] = {{"1", 1}, {"4", 4}, {"16", 16}, {NULL, 0}};
static const np_choice upsamplings[] = {{"1", 1}, {"2", 2}, {"4", 4}, {NULL, 0}};
static const np_choice degrees[] = {{"3", 3}, {"7", 7}, {"11", 11}, {NULL, 0}};

/* clang-format off */
static const np_key keys[] = {
    {.path = "render.quality", .type = NP_KEY_CHOICE, .choices = qualities, .field = SCENE(render.quality),
     .fallback = "final", .is_quality = true,
     .meaning = "preset of the keys that trade error for time, except for keys that are set: integrator, samples, "
                "tolerance, transmittance_end, detail and light_*; the defaults are those of final"},
    {.path = "render.detail", .type = NP_KEY_REAL, .field = SCENE(render.detail_px), .range = WITHIN(0, 100),
     .fallback = "0",
     .meaning = "least size in pixels of a voxel of a baked cloud, or of two heights of ridges: finer ones are left "
                "out; 0: no limit"},
    {.path = "render.light_detail", .type = NP_KEY_REAL, .field = SCENE(render.light_detail_px),
     .range = WITHIN(0, 100), .fallback = "0",
     .meaning = "least size in pixels of a cell of multiple scattering, at the nearest point of the clouds; 0: no "
                "limit"},
    {.path = "render.light_depth", .type = NP_KEY_REAL, .field = SCENE(render.light_depth), .range = WITHIN(0.01, 100),
     .fallback = "0.35",
     .meaning = "(1-g) times the optical depth across a cell of multiple scattering, at the clouds' densest point; "
                "cells have at least two voxels"},
    {.path = "render.light_reuse", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(render.light_reuse_rad),
     .range = WITHIN(0, 30), .fallback = "1 deg",
     .meaning = "rotation of a moving sun or moon over which multiple scattering is interpolated between two "
                "solutions of a sequence; 0 deg solves for each frame"},
    {.path = "render.light_degree", .type = NP_KEY_CHOICE, .choices = degrees, .field = SCENE(render.light_degree),
     .fallback = "11",
     .meaning = "highest degree of the spherical harmonics for multiple scattering; large clouds use 3 or 7"},
    {.path = "render.light_residual", .type = NP_KEY_REAL, .field = SCENE(render.light_residual),
     .range = WITHIN(1e-6, 0.5),
     .fallback = "0.0003", .meaning = "relative residual at which the iteration of multiple scattering ends"},
    {.path = "render.history", .type = NP_KEY_CHOICE, .choices = histories, .field = SCENE(render.history),
     .fallback = "none",
     .meaning = "reuse of the previous frame of a sequence: none, or, for previews, reprojection of most pixels by "
                "their depth"},
    {.path = "render.history_update", .type = NP_KEY_CHOICE, .choices = updates, .field = SCENE(render.history_update),
     .fallback = "16", .meaning = "a frame with history renders one pixel of this many"},
    {.path = "render.history_weight", .type = NP_KEY_REAL, .field = SCENE(render.history_weight), .range = WITHIN(0, 1),
     .fallback = "0.25",
     .meaning = "least weight of a rendered pixel against its history, in an exponential average; 1 ignores history "
                "wherever there is a new value"},
    {.path = "render.history_frames", .type = NP_KEY_INTEGER, .field = SCENE(render.history_frames),
     .range = WITHIN(2, 4096), .fallback = "32",
     .meaning = "frames per block, counted from frame 1; history restarts with each block, and a single frame renders "
                "the earlier ones of its block first"},
    {.path = "render.upsample", .type = NP_KEY_CHOICE, .choices = upsamplings, .field = SCENE(render.upsample),
     .fallback = "1",
     .meaning = "edge in pixels of the squares in which one pixel is rendered; the others are interpolated by depth: "
                "1 renders all, 2 and 4 are half and quarter resolution, for previews"},
};
/* clang-format on */

const np_key_table np_keys_quality = {keys, sizeof keys / sizeof *keys};
