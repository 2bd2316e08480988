/* SPDX-License-Identifier: Apache-2.0 */
/* Arbitrary output variables: channels of a picture beyond R, G, B, A and Z, one row each. Rows of
 * frame/channel_table.c fill them. */
#ifndef NP_IMAGE_AOV_H
#define NP_IMAGE_AOV_H

#include <stdbool.h>

#include <nephos/image.h>

/* ROW(id, name, parts, needs_light, samples_min, pixel_type, other_layer). `name` is the word of a scene file and the
 * layer of the channels, before the dot; `parts` are the letters after the dot ("": no dot, one channel; "*": a channel
 * for each cloud and the ground; "+": three for each group of lights). `needs_light` is false for geometry alone,
 * `samples_min` the least number of samples a pixel. `pixel_type` is FLOAT where halves are insufficient, HALF where
 * output.pixel_type decides. `other_layer` is another name of the layer ("": none; a "*" at its end represents any
 * letters). */
#define NP_AOV_ROWS(ROW)                                                                                               \
  ROW(BACKGROUND, "background", "RGB", true, 1, HALF, "")                                                              \
  ROW(TERRAIN, "terrain", "RGB", true, 1, HALF, "")                                                                    \
  ROW(AIR, "air", "RGB", true, 1, HALF, "")                                                                            \
  ROW(SUN, "sun", "RGB", true, 1, HALF, "")                                                                            \
  ROW(SKY, "sky", "RGB", true, 1, HALF, "")                                                                            \
  ROW(GROUND, "ground", "RGB", true, 1, HALF, "")                                                                      \
  ROW(MULTIPLE, "multiple", "RGB", true, 1, HALF, "")                                                                  \
  ROW(TRANSMITTANCE, "transmittance", "", false, 1, HALF, "")                                                          \
  ROW(DISTANCE, "distance", "", false, 1, FLOAT, "")                                                                   \
  ROW(DEPTH, "depth", "", false, 1, FLOAT, "Z") /* always present; may be listed too */                                \
  ROW(STANDARD_ERROR, "standard_error", "RGB", true, 2, HALF, "")                                                      \
  ROW(VARIANCE, "variance", "RGB", true, 2, FLOAT, "")                                                                 \
  ROW(SAMPLE_COUNT, "sample_count", "", false, 1, FLOAT, "")                                                           \
  ROW(ALBEDO, "albedo", "RGB", false, 1, HALF, "")                                                                     \
  ROW(MEAN_DISTANCE, "mean_distance", "", false, 1, FLOAT, "")                                                         \
  ROW(POSITION, "position", "XYZ", false, 1, FLOAT, "P")                                                               \
  ROW(EMISSION, "emission", "RGB", true, 1, HALF, "")                                                                  \
  ROW(NORMAL, "normal", "XYZ", false, 1, HALF, "")                                                                     \
  ROW(SHADOW, "shadow", "", false, 1, HALF, "")                                                                        \
  ROW(CLOUDS, "clouds", "RGBA", true, 1, HALF, "") /* composited over black */                                         \
  ROW(CLOUD_AIR, "cloud_air", "RGB", true, 1, HALF, "")                                                                \
  ROW(GROUND_AIR, "ground_air", "RGB", true, 1, HALF, "")                                                              \
  ROW(OPTICAL_DEPTH, "optical_depth", "", false, 1, HALF, "")                                                          \
  ROW(LIGHTS, "lights", "+", true, 1, HALF, "")                                                                        \
  ROW(MATTES, "mattes", "*", false, 1, HALF, "")                                                                       \
  ROW(CRYPTOMATTE, "cryptomatte", "RGBARGBARGBA", false, 1, FLOAT, "Crypto*")                                          \
  ROW(MOTION, "motion", "uvuv", false, 1, HALF, "") /* forward.u, forward.v, backward.u, backward.v */

#define NP_AOV_INDEX(id, ...) NP_AOV_INDEX_##id,
typedef enum np_aov_index { NP_AOV_ROWS(NP_AOV_INDEX) NP_AOV_COUNT } np_aov_index;
#undef NP_AOV_INDEX

/* Bits of a set of AOVs. */
#define NP_AOV_BIT(id, ...) NP_AOV_##id = 1 << NP_AOV_INDEX_##id,
typedef enum np_aov { NP_AOV_ROWS(NP_AOV_BIT) NP_AOV_NONE = 0 } np_aov;
#undef NP_AOV_BIT

typedef struct np_aov_row {
  const char *name, *parts;
  bool needs_light;
  unsigned samples_min;
  neph_pixel_type pixel_type;
  const char *other_layer;
} np_aov_row;

extern const np_aov_row np_aov_rows[NP_AOV_COUNT];

/* Number of channels that a set adds to a picture. */
unsigned np_aovs_count_channels(unsigned aovs, unsigned cloud_count);

/* The row of a channel by the name of the channel; NULL: it belongs to no AOV. */
const np_aov_row *np_aov_search_channel(const char *channel);

/* Whether any AOV of a set needs light. */
bool np_aovs_need_light(unsigned aovs);

/* The first AOV of a set that needs more than `samples` a pixel; NULL: none. */
const np_aov_row *np_aovs_search_short(unsigned aovs, unsigned samples);

#endif
