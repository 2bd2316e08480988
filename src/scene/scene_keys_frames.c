/* SPDX-License-Identifier: Apache-2.0 */
/* Keys of sequences. */
#include "scene/scene_key_rows.h"

/* clang-format off */
static const np_key keys[] = {
    {.path = "frame_rate", .type = NP_KEY_REAL, .field = SCENE(frame_rate), .range = WITHIN(1e-6, 1e6),
     .meaning = "frames a second; it sets the time between frames of baked clouds without a frame_time"},
    {.path = "animate", .type = NP_KEY_TRACKS,
     .meaning = "values by frame of keys that are numbers or times, or of one number of a list, such as "
                "camera.position.0: a list of [frame, value], linear between them, or {interpolation: step, linear or "
                "smooth, keys: that list}; constant before the first and after the last"},
};
/* clang-format on */

const np_key_table np_keys_frames = {keys, sizeof keys / sizeof *keys};
