/* SPDX-License-Identifier: Apache-2.0 */
/* Mountain waves: lift of the air above ground by wind across it.
 *
 * Linear theory of trapped lee waves (Scorer 1949, "Theory of waves in the lee of mountains"): the ground along the
 * wind, convolved with a wave that starts at the ridge and decays behind it. `cell_m` is the wavelength; ground
 * features below a fifth of it are smoothed out. Without ground, a chain of hills lies across the wind in the middle.
 */
#include "cloud/mountain_wave.h"

#include <math.h>
#include <string.h>

#include "cloud/cloud_streams.h"
#include "cloud/landscape.h"
#include "core/alloc.h"
#include "core/math.h"
#include "core/random.h"

enum { STEPS_PER_WAVE = 20, WAVES = 3, SMOOTHINGS = 3 };

static const float lead = 0.25f;      /* wavelengths ahead of the ridge */
static const float decay = 0.75f;     /* decay of the amplitude after n wavelengths: 1/(1 + decay·n²) */
static const float smoothing = 0.11f; /* half width of each of SMOOTHINGS means, in wavelengths */

typedef struct wave_job {
  const np_weather_map *map;
  const float *from;
  float *to;
  float step_m[2]; /* step of the sum along the wind */
  float weights[STEPS_PER_WAVE * (WAVES + 1)];
  int first, count, axis, half;
} wave_job;

/* Cosine of an angle in turns, by parabolas between its zeros, within 6 %. */
static float compute_cosine(float turns) {
  const float t = turns + 0.25f - floorf(turns + 0.25f), half = t < 0.5f ? t : t - 0.5f;
  const float arc = 16.0f * half * (0.5f - half);
  return t < 0.5f ? arc : -arc;
}

static float get_texel(const np_weather_map *map, const float *values, int32_t i, int32_t j) {
  i = i < 0 ? 0 : i < map->size[0] ? i : map->size[0] - 1;
  j = j < 0 ? 0 : j < map->size[1] ? j : map->size[1] - 1;
  return values[(size_t)j * (size_t)map->size[0] + (size_t)i];
}

/* Smooths the texels along an axis. */
static neph_result smooth_rows(void *user, size_t begin, size_t end, unsigned thread) {
  const wave_job *job = user;
  (void)thread;
  for (size_t row = begin; row < end; row++)
    for (int32_t i = 0; i < job->map->size[0]; i++) {
      float sum = 0.0f;
      for (int32_t k = -job->half; k <= job->half; k++)
        sum += get_texel(job->map, job->from, i + (job->axis ? 0 : k), (int32_t)row + (job->axis ? k : 0));
      job->to[row * (size_t)job->map->size[0] + (size_t)i] = sum / (float)(2 * job->half + 1);
    }
  return NEPH_OK;
}

static neph_result sum_rows(void *user, size_t begin, size_t end, unsigned thread) {
  const wave_job *job = user;
  const np_weather_map *map = job->map;
  (void)thread;
  for (size_t row = begin; row < end; row++)
    for (int32_t i = 0; i < map->size[0]; i++) {
      const float x_m = map->origin_m[0] + (float)i * map->step_m, y_m = map->origin_m[1] + (float)row * map->step_m;
      float sum = 0.0f;
      for (int k = 0; k < job->count; k++) {
        const float n = (float)(job->first + k);
        sum +=
            job->weights[k] * np_weather_map_sample(map, job->from, x_m - n * job->step_m[0], y_m - n * job->step_m[1]);
      }
      job->to[row * (size_t)map->size[0] + (size_t)i] = sum;
    }
  return NEPH_OK;
}

/* Procedural ridge: a chain of hills across the wind with individual sizes, heights and positions, the highest in the
 * middle. In wavelengths. */
enum { MOUNTS = 7 };

static const float mount_spacing = 0.36f,
                   mount_stray = 0.12f; /* across the wind; the stray along it is three times as large */
static const float mount_width = 0.2f;  /* half width along the wind */
static const float mount_length_min = 0.26f, mount_length_max = 0.75f; /* half width across the wind */
static const float mount_height_min = 0.4f;                            /* relative to the highest */

typedef struct mount {
  float along, across, length, height;
} mount;

static float draw(uint64_t seed, int number, unsigned what) {
  const uint64_t bits = np_random_absorb(np_random_absorb(seed, (uint64_t)number), what);
  return (float)(bits >> 40) * 0x1p-24f;
}

static mount draw_mount(const neph_cloud_desc *desc, int number) {
  const uint64_t seed = np_random_absorb(desc->seed, NP_CLOUD_STREAM_SHEET);
  const bool is_highest = number == MOUNTS / 2;
  return (mount){.along = 3.0f * mount_stray * (2.0f * draw(seed, number, 0) - 1.0f) - 0.1f,
                 .across =
                     mount_spacing * (float)(number - MOUNTS / 2) + mount_stray * (2.0f * draw(seed, number, 1) - 1.0f),
                 .length = np_mixf(mount_length_min, mount_length_max, is_highest ? 0.8f : draw(seed, number, 2)),
                 .height = is_highest ? 1.0f : np_mixf(mount_height_min, 1.0f, draw(seed, number, 3))};
}

/* Height of the ridge: the maximum where two hills overlap, because their sum would be a third hill. */
static float compute_ridge(const mount mounts[MOUNTS], float along, float across) {
  float highest = 0.0f;
  for (int i = 0; i < MOUNTS; i++) {
    const float x = (along - mounts[i].along) / mount_width, y = (across - mounts[i].across) / mounts[i].length;
    const float left = np_maxf(1.0f - x * x - y * y, 0.0f);
    highest = np_maxf(highest, mounts[i].height * left * left);
  }
  return highest;
}

static void fill_ridge(const neph_cloud_desc *desc, const np_weather_map *map, float *out) {
  float heading[2];
  mount mounts[MOUNTS];
  np_cloud_desc_compute_heading(desc, heading);
  for (int i = 0; i < MOUNTS; i++) mounts[i] = draw_mount(desc, i);
  for (int32_t j = 0; j < map->size[1]; j++)
    for (int32_t i = 0; i < map->size[0]; i++) {
      const float x = (map->origin_m[0] + (float)i * map->step_m) / (float)desc->cell_m;
      const float y = (map->origin_m[1] + (float)j * map->step_m) / (float)desc->cell_m;
      out[(size_t)j * (size_t)map->size[0] + (size_t)i] =
          compute_ridge(mounts, x * heading[0] + y * heading[1], y * heading[0] - x * heading[1]);
    }
}

static neph_result smooth(neph_context *context, np_monitor *monitor, wave_job *job, float *values, float *scratch) {
  neph_result result = NEPH_OK;
  for (int pass = 0; pass < 2 * SMOOTHINGS && !result; pass++) {
    job->axis = pass & 1;
    job->from = pass & 1 ? scratch : values;
    job->to = pass & 1 ? values : scratch;
    result = np_parallel_for(context, monitor, (size_t)job->map->size[1], 4, smooth_rows, job);
  }
  return result;
}

/* Scales values to [0, 1], so that a waterline is relative to the highest crest. */
static void normalize(const np_weather_map *map, float *values) {
  const size_t count = (size_t)map->size[0] * (size_t)map->size[1];
  float lowest = INFINITY, highest = -INFINITY;
  for (size_t i = 0; i < count; i++) {
    lowest = fminf(lowest, values[i]);
    highest = fmaxf(highest, values[i]);
  }
  const float scale = highest > lowest ? 1.0f / (highest - lowest) : 0.0f;
  for (size_t i = 0; i < count; i++) values[i] = (values[i] - lowest) * scale;
}

static void set_wave(const neph_cloud_desc *desc, wave_job *job) {
  float heading[2];
  np_cloud_desc_compute_heading(desc, heading);
  for (int a = 0; a < 2; a++) job->step_m[a] = heading[a] * (float)desc->cell_m / STEPS_PER_WAVE;
  job->first = -(int)(lead * STEPS_PER_WAVE);
  job->count = WAVES * STEPS_PER_WAVE - job->first;
  for (int k = 0; k < job->count; k++) {
    const float waves = (float)(job->first + k) / STEPS_PER_WAVE;
    job->weights[k] = compute_cosine(waves) / (1.0f + decay * waves * waves);
  }
}

neph_result np_mountain_wave_fill(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                                  np_weather_map *map) {
  const size_t count = (size_t)map->size[0] * (size_t)map->size[1];
  float *ridge = np_alloc(context, count, sizeof *ridge);
  if (!ridge) return NEPH_ERROR_OUT_OF_MEMORY;
  wave_job job = {.map = map, .half = (int)(smoothing * (float)desc->cell_m / map->step_m)};
  if (map->ground_m)
    memcpy(ridge, map->ground_m, count * sizeof *ridge);
  else
    fill_ridge(desc, map, ridge);
  for (size_t i = 0; i < count && map->ground_m; i++) ridge[i] -= map->ground_low_m;
  neph_result result = map->ground_m ? smooth(context, monitor, &job, ridge, map->values) : NEPH_OK;
  set_wave(desc, &job);
  job.from = ridge;
  job.to = map->values;
  if (!result) result = np_parallel_for(context, monitor, (size_t)map->size[1], 4, sum_rows, &job);
  normalize(map, map->values);
  np_alloc_free(context, ridge);
  return result;
}
