/* SPDX-License-Identifier: Apache-2.0 */
#include "image/aov.h"

#include <string.h>

#define ROW(id, name, parts, needs_light, samples_min, pixel_type, other_layer)                                        \
  {name, parts, needs_light, samples_min, NEPH_PIXEL_##pixel_type, other_layer},
const np_aov_row np_aov_rows[NP_AOV_COUNT] = {NP_AOV_ROWS(ROW)};
#undef ROW

static unsigned count_parts(const char *parts, unsigned cloud_count) {
  if (*parts == '*') return cloud_count + 1;
  if (*parts == '+') return 3 * (cloud_count + 3);
  return *parts ? (unsigned)strlen(parts) : 1;
}

unsigned np_aovs_count_channels(unsigned aovs, unsigned cloud_count) {
  unsigned count = 0;
  for (unsigned i = 0; i < NP_AOV_COUNT; i++)
    if (aovs & ~(unsigned)NP_AOV_DEPTH & 1u << i) count += count_parts(np_aov_rows[i].parts, cloud_count);
  return count;
}

/* Whether the layer of a channel, the first `length` letters of its name, is `layer`. */
static bool is_layer(const char *channel, size_t length, const char *layer) {
  const size_t fixed = strcspn(layer, "*");
  return fixed > 0 && (layer[fixed] ? length >= fixed : length == fixed) && !strncmp(channel, layer, fixed);
}

const np_aov_row *np_aov_search_channel(const char *channel) {
  const size_t length = strcspn(channel, ".");
  for (unsigned i = 0; i < NP_AOV_COUNT; i++)
    if (is_layer(channel, length, np_aov_rows[i].name) || is_layer(channel, length, np_aov_rows[i].other_layer))
      return &np_aov_rows[i];
  return NULL;
}

bool np_aovs_need_light(unsigned aovs) {
  for (unsigned i = 0; i < NP_AOV_COUNT; i++)
    if (aovs & 1u << i && np_aov_rows[i].needs_light) return true;
  return false;
}

const np_aov_row *np_aovs_search_short(unsigned aovs, unsigned samples) {
  for (unsigned i = 0; i < NP_AOV_COUNT; i++)
    if (aovs & 1u << i && np_aov_rows[i].samples_min > samples) return &np_aov_rows[i];
  return NULL;
}
