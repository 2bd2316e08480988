/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/weather_map.h"

#include <math.h>

#include "cloud/repeat.h"
#include "core/alloc.h"
#include "core/math.h"

void np_weather_map_clear(np_weather_map *map) {
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT && map->context; q++) np_alloc_free(map->context, map->planes[q]);
  if (map->context) {
    np_alloc_free(map->context, map->levels);
    np_alloc_free(map->context, map->ground_m);
    np_alloc_free(map->context, map->anvils);
    np_alloc_free(map->context, map->values);
  }
  *map = (np_weather_map){0};
}

double np_weather_map_count_bytes(const np_weather_map *map) {
  int count = 1 + (map->anvils != NULL) + (map->levels != NULL) + (map->ground_m != NULL);
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT; q++) count += map->planes[q] != NULL;
  return (double)map->size[0] * map->size[1] * sizeof(float) * count;
}

/* Texel coordinate, clamped to the map or wrapped into it. */
static float compute_texel(const np_weather_map *map, int axis, float position_m) {
  if (map->is_periodic) {
    const float scaled = (position_m - map->origin_m[axis]) / map->step_m, count = (float)map->size[axis];
    const float wrapped = scaled - count * floorf(scaled / count);
    return wrapped < count ? wrapped : 0.0f;
  }
  return np_clampf((position_m - map->origin_m[axis]) / map->step_m, 0.0f, (float)(map->size[axis] - 1));
}

float np_weather_map_sample(const np_weather_map *map, const float *values, float x_m, float y_m) {
  float x = compute_texel(map, 0, x_m), y = compute_texel(map, 1, y_m);
  int32_t i = (int32_t)x, j = (int32_t)y;
  const int32_t back = map->is_periodic ? 1 : 0; /* wraps to the first texel */
  int32_t right = i + 1 < map->size[0] ? 1 : -i * back;
  int32_t up = j + 1 < map->size[1] ? map->size[0] : -j * map->size[0] * back;
  const float *texel = values + (size_t)j * (size_t)map->size[0] + (size_t)i;
  float u = x - (float)i, v = y - (float)j;
  float low = texel[0] + u * (texel[right] - texel[0]), high = texel[up] + u * (texel[up + right] - texel[up]);
  return low + v * (high - low);
}

np_interval np_weather_map_get_range(const np_weather_map *map, const float *values, const float min_m[2],
                                     const float max_m[2]) {
  int32_t begin[2], end[2];
  for (int a = 0; a < 2 && map->is_periodic; a++) {
    begin[a] = (int32_t)floorf((min_m[a] - map->origin_m[a]) / map->step_m);
    end[a] = (int32_t)floorf((max_m[a] - map->origin_m[a]) / map->step_m) + 1;
    if (end[a] - begin[a] >= map->size[a]) end[a] = begin[a] + map->size[a] - 1;
  }
  for (int a = 0; a < 2 && !map->is_periodic; a++) {
    begin[a] = (int32_t)compute_texel(map, a, min_m[a]);
    end[a] = (int32_t)compute_texel(map, a, max_m[a]) + 1;
    if (end[a] > map->size[a] - 1) end[a] = map->size[a] - 1;
  }
  np_interval range = {INFINITY, -INFINITY};
  for (int32_t j = begin[1]; j <= end[1]; j++)
    for (int32_t i = begin[0]; i <= end[0]; i++) {
      const int32_t row = map->is_periodic ? np_repeat_wrap(j, map->size[1]) : j;
      const int32_t column = map->is_periodic ? np_repeat_wrap(i, map->size[0]) : i;
      const float value = values[(size_t)row * (size_t)map->size[0] + (size_t)column];
      range.low = fminf(range.low, value);
      range.high = fmaxf(range.high, value);
    }
  return range;
}
