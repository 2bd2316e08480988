/* SPDX-License-Identifier: Apache-2.0 */
/* Quality presets: values of the keys that trade error for time. Keys that a scene sets override them. */
#ifndef NP_SCENE_QUALITY_H
#define NP_SCENE_QUALITY_H

#include <stddef.h>

typedef enum np_quality { NP_QUALITY_DRAFT, NP_QUALITY_PREVIEW, NP_QUALITY_FINAL, NP_QUALITY_REFERENCE } np_quality;

enum { NP_QUALITY_COUNT = NP_QUALITY_REFERENCE + 1 };

/* A key and its value in each quality, in scene syntax. */
typedef struct np_quality_knob {
  const char *key;
  const char *value[NP_QUALITY_COUNT];
} np_quality_knob;

size_t np_quality_knob_count(void);
const np_quality_knob *np_quality_knob_at(size_t index);

#endif
