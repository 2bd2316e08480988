/* SPDX-License-Identifier: Apache-2.0 */
/* Arbitrary output variables: channels of a picture beyond R, G, B, A and Z, one row each. Rows of
 * render/channel_table.c fill them. */
#ifndef NP_IMAGE_AOV_H
#define NP_IMAGE_AOV_H

#include <stdbool.h>

/* ROW(id, name, parts, needs_light, samples_min): in a scene file and before the dot of its channels' names it is
 * `name`, after the dot a letter of `parts` ("": no dot, one channel; "*": one for each cloud and the ground; "+":
 * three for each group of lights); `needs_light` where it is not geometry alone; `samples_min` a pixel. */
#define NP_AOV_ROWS(ROW)                                                                                               \
  ROW(BACKGROUND, "background", "RGB", true, 1)                                                                        \
  ROW(TERRAIN, "terrain", "RGB", true, 1)                                                                              \
  ROW(AIR, "air", "RGB", true, 1)                                                                                      \
  ROW(SUN, "sun", "RGB", true, 1)                                                                                      \
  ROW(SKY, "sky", "RGB", true, 1)                                                                                      \
  ROW(GROUND, "ground", "RGB", true, 1)                                                                                \
  ROW(MULTIPLE, "multiple", "RGB", true, 1)                                                                            \
  ROW(TRANSMITTANCE, "transmittance", "", false, 1)                                                                    \
  ROW(DISTANCE, "distance", "", false, 1)                                                                              \
  ROW(DEPTH, "depth", "", false, 1) /* Z: always present, may be listed all the same */                                \
  ROW(STANDARD_ERROR, "standard_error", "RGB", true, 2)                                                                \
  ROW(VARIANCE, "variance", "RGB", true, 2)                                                                            \
  ROW(SAMPLE_COUNT, "sample_count", "", false, 1)                                                                      \
  ROW(ALBEDO, "albedo", "RGB", false, 1)                                                                               \
  ROW(MEAN_DISTANCE, "mean_distance", "", false, 1)                                                                    \
  ROW(POSITION, "position", "XYZ", false, 1)                                                                           \
  ROW(EMISSION, "emission", "RGB", true, 1)                                                                            \
  ROW(NORMAL, "normal", "XYZ", false, 1)                                                                               \
  ROW(SHADOW, "shadow", "", false, 1)                                                                                  \
  ROW(CLOUDS, "clouds", "RGBA", true, 1) /* composited over black */                                                   \
  ROW(CLOUD_AIR, "cloud_air", "RGB", true, 1)                                                                          \
  ROW(GROUND_AIR, "ground_air", "RGB", true, 1)                                                                        \
  ROW(OPTICAL_DEPTH, "optical_depth", "", false, 1)                                                                    \
  ROW(LIGHTS, "lights", "+", true, 1)                                                                                  \
  ROW(MATTES, "mattes", "*", false, 1)                                                                                 \
  ROW(CRYPTOMATTE, "cryptomatte", "RGBARGBARGBA", false, 1)                                                            \
  ROW(MOTION, "motion", "uvuv", false, 1) /* forward.u, forward.v, backward.u, backward.v */

#define NP_AOV_INDEX(id, name, parts, needs_light, samples_min) NP_AOV_INDEX_##id,
typedef enum np_aov_index { NP_AOV_ROWS(NP_AOV_INDEX) NP_AOV_COUNT } np_aov_index;
#undef NP_AOV_INDEX

/* Bits of a set of AOVs. */
#define NP_AOV_BIT(id, name, parts, needs_light, samples_min) NP_AOV_##id = 1 << NP_AOV_INDEX_##id,
typedef enum np_aov { NP_AOV_ROWS(NP_AOV_BIT) NP_AOV_NONE = 0 } np_aov;
#undef NP_AOV_BIT

typedef struct np_aov_row {
  const char *name, *parts;
  bool needs_light;
  unsigned samples_min;
} np_aov_row;

extern const np_aov_row np_aov_rows[NP_AOV_COUNT];

/* Number of channels that a set adds to a picture. */
unsigned np_aovs_count_channels(unsigned aovs, unsigned cloud_count);

/* Whether any AOV of a set needs light. */
bool np_aovs_need_light(unsigned aovs);

/* The first AOV of a set that needs more than `samples` a pixel; NULL: none. */
const np_aov_row *np_aovs_search_short(unsigned aovs, unsigned samples);

#endif
