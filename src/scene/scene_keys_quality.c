/* SPDX-License-Identifier: Apache-2.0 */
/* Keys of the accuracy of a picture, and the qualities that choose them. */
#include "scene/quality.h"
#include "scene/scene_key_rows.h"

static const np_choice qualities[] = {{"draft", NP_QUALITY_DRAFT},
                                      {"preview", NP_QUALITY_PREVIEW},
                                      {"final", NP_QUALITY_FINAL},
                                      {"reference", NP_QUALITY_REFERENCE},
                                      {NULL, 0}};
static const np_choice degrees[] = {{"3", 3}, {"7", 7}, {"11", 11}, {NULL, 0}};

/* clang-format off */
static const np_key keys[] = {
    {.path = "render.quality", .type = NP_KEY_CHOICE, .choices = qualities, .field = SCENE(render.quality),
     .fallback = "final", .is_quality = true,
     .meaning = "values of the keys that trade error for time, unless they are given: integrator, samples, tolerance, "
                "transmittance_end, detail and light_*; the defaults are those of final"},
    {.path = "render.detail", .type = NP_KEY_REAL, .field = SCENE(render.detail_px), .range = WITHIN(0, 100),
     .fallback = "0",
     .meaning = "pixels that a voxel of a baked cloud, or two heights of made mountains, cover at least: "
                "finer ones are left out; 0: none are"},
    {.path = "render.light_detail", .type = NP_KEY_REAL, .field = SCENE(render.light_detail_px),
     .range = WITHIN(0, 100), .fallback = "0",
     .meaning = "pixels that a cell of multiple scattering covers at least, at the clouds' nearest; 0: cells go by the "
                "clouds alone"},
    {.path = "render.light_depth", .type = NP_KEY_REAL, .field = SCENE(render.light_depth), .range = WITHIN(0.01, 100),
     .fallback = "0.35",
     .meaning = "(1-g) times the optical depth across a cell of multiple scattering, at the clouds' densest point; "
                "cells have two voxels at least"},
    {.path = "render.light_reuse", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(render.light_reuse_rad),
     .range = WITHIN(0, 30), .fallback = "1 deg",
     .meaning = "turn of a moving sun or moon over which multiple scattering is interpolated between two solutions of "
                "a sequence; 0 deg solves for each frame"},
    {.path = "render.light_degree", .type = NP_KEY_CHOICE, .choices = degrees, .field = SCENE(render.light_degree),
     .fallback = "11",
     .meaning = "highest degree of the harmonics that multiple scattering is resolved into; large clouds take 3 or 7"},
    {.path = "render.light_residual", .type = NP_KEY_REAL, .field = SCENE(render.light_residual),
     .range = WITHIN(1e-6, 0.5),
     .fallback = "0.0003", .meaning = "relative residual at which the iteration of multiple scattering ends"},
};
/* clang-format on */

np_key_table np_keys_get_quality(void) { return (np_key_table){keys, sizeof keys / sizeof *keys}; }
