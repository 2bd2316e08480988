/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/scattering_moments.h"

#include "core/alloc.h"

float np_sun_scale_cosine(const np_sun_scale *sun, double fraction) {
  const float y = sun->first + (float)(fraction * (sun->columns - 1)) / sun->columns_per_unit;
  return np_clampf(sun->center + sun->spread * y / (1.0f - fabsf(y)), sun->lowest, 1.0f);
}

void np_moment_table_free(neph_context *context, np_moment_table *table) {
  np_alloc_free(context, table->moments);
  np_alloc_free(context, table->irradiance);
  *table = (np_moment_table){0};
}

np_bands np_moment_table_irradiance(const np_moment_table *table, float sun_cosine) {
  float f;
  const int i = np_sun_scale_split(&table->sun, np_sun_scale_column(&table->sun, sun_cosine), &f);
  return np_bands_mix(table->irradiance[i], table->irradiance[i + 1], f);
}
