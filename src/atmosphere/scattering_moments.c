/* SPDX-License-Identifier: Apache-2.0 */
/* Look-ups in the table of scattering moments, and the scale of its suns. */
#include "atmosphere/scattering_moments.h"

#include "core/alloc.h"

np_sun_scale np_sun_scale_make(const np_medium *medium, int columns) {
  /* Suns for the Earth's twilight, 0.1753, reach down to −0.4, with center −0.04 and spread 0.3. */
  const float scale = (float)(np_twilight_scale(medium) / 0.1753);
  np_sun_scale sun = {np_maxf(-1.0f, -0.4f * scale), -0.04f * scale, 0.3f * scale, 0.0f, columns, 0.0f};
  const float low = sun.lowest - sun.center, high = 1.0f - sun.center;
  sun.first = low / (fabsf(low) + sun.spread);
  sun.columns_per_unit = (float)(columns - 1) / (high / (fabsf(high) + sun.spread) - sun.first);
  return sun;
}

float np_sun_scale_cosine(const np_sun_scale *sun, double fraction) {
  const float y = sun->first + (float)(fraction * (sun->columns - 1)) / sun->columns_per_unit;
  return np_clampf(sun->center + sun->spread * y / (1.0f - fabsf(y)), sun->lowest, 1.0f);
}

void np_moment_table_free(neph_context *context, np_moment_table *table) {
  np_alloc_free(context, table->moments);
  np_alloc_free(context, table->irradiance);
  *table = (np_moment_table){0};
}

np_bands np_moment_table_irradiance(const np_moment_table *table, double altitude_m, float sun_cosine) {
  float upper, f;
  const np_bands *low = table->irradiance + np_moment_table_row(table, altitude_m, &upper) * table->sun.columns;
  low += np_sun_scale_split(&table->sun, np_sun_scale_column(&table->sun, sun_cosine), &f);
  const np_bands *high = low + table->sun.columns;
  return np_bands_mix(np_bands_mix(low[0], low[1], f), np_bands_mix(high[0], high[1], f), upper);
}
