/* SPDX-License-Identifier: Apache-2.0 */
/* Error of a bake relative to direct evaluation of the model, by cause.
 *
 * Result: rms and largest difference of extinction at points, and of optical depth along rays. Method: isotropic
 * uniform random lines through the field's box (a direction uniform on the sphere, an offset uniform in the disk
 * covered by the box's bounding sphere; lines that miss the box are rejected), divided into steps of half a voxel with
 * a random start. Their midpoints are uniform in the box, so that rays and points are one set of samples. Six fields
 * are evaluated at each: the model with all its detail, the model as the bake samples it, and the trilinear grid in
 * floats, in halves, pruned, and as written. Rays are summed in order, so that results do not depend on threads.
 * Source: Santaló 1976, "Integral Geometry and Geometric Probability", ch. 12 (uniform lines intersect volume
 * uniformly). */
#include "cloud/bake_error.h"

#include <math.h>

#include "cloud/bake_field.h"
#include "cloud/bake_lod.h"
#include "cloud/cloud_build.h"
#include "cloud/cloud_grain.h"
#include "core/alloc.h"
#include "core/random.h"
#include "volume/bricks.h"

enum { STEPS_MAX = 1 << 16 };

typedef enum field {
  FIELD_MODEL,   /* model with all its detail */
  FIELD_LIMITED, /* model as the bake samples it */
  FIELD_GRID,
  FIELD_HALF,
  FIELD_PRUNED,
  FIELD_WRITTEN,
  FIELD_COUNT
} field;

/* Each cause is the difference of two fields. */
typedef struct cause {
  field after, before;
  size_t offset; /* offset of its neph_bake_loss */
} cause;

#define LOSS(name) offsetof(neph_bake_error, name)

static const cause causes[] = {
    {FIELD_GRID, FIELD_MODEL, LOSS(voxel)},      {FIELD_LIMITED, FIELD_MODEL, LOSS(detail)},
    {FIELD_GRID, FIELD_LIMITED, LOSS(sampling)}, {FIELD_HALF, FIELD_GRID, LOSS(half)},
    {FIELD_PRUNED, FIELD_GRID, LOSS(pruning)},   {FIELD_WRITTEN, FIELD_MODEL, LOSS(total)},
};

enum { CAUSE_COUNT = sizeof causes / sizeof *causes };

/* Sums over the points of one ray. */
typedef struct np_bake_ray_sums {
  uint64_t point_count;
  double depth[FIELD_COUNT];
  double density2, difference2[CAUSE_COUNT], difference_max[CAUSE_COUNT];
} ray_sums;

typedef struct error_job {
  const np_bake *bake; /* bake of the level */
  const np_bake_meter *meter;
  const np_bricks *bricks;
  double step_m;
  bool is_half;
  float prune_per_m;
  ray_sums *rays;
} error_job;

/* ---- Rays ---- */

typedef struct error_ray {
  double origin_m[3], direction[3], length_m;
} error_ray;

/* Clips the ray to the box; false if it misses. */
static bool clip_ray(const error_job *job, error_ray *r) {
  double begin = -INFINITY, end = INFINITY;
  for (int a = 0; a < 3; a++) {
    if (r->direction[a] == 0) {
      if (r->origin_m[a] < job->meter->low_m[a] || r->origin_m[a] > job->meter->high_m[a]) return false;
      continue;
    }
    const double one = (job->meter->low_m[a] - r->origin_m[a]) / r->direction[a];
    const double other = (job->meter->high_m[a] - r->origin_m[a]) / r->direction[a];
    begin = fmax(begin, fmin(one, other));
    end = fmin(end, fmax(one, other));
  }
  if (!(end > begin)) return false;
  for (int a = 0; a < 3; a++) r->origin_m[a] += begin * r->direction[a];
  r->length_m = end - begin;
  return true;
}

static bool draw_ray(const error_job *job, np_random *random, error_ray *out_ray) {
  const double pi = 3.14159265358979323846;
  const double z = 2 * np_random_double(random) - 1, angle = 2 * pi * np_random_double(random);
  const double across = sqrt(1 - z * z), turn = 2 * pi * np_random_double(random);
  const np_vec3 direction = np_vec3_make((float)(across * cos(angle)), (float)(across * sin(angle)), (float)z);
  np_vec3 tangent, bitangent;
  np_frame_around(direction, &tangent, &bitangent);
  double diagonal2 = 0;
  for (int a = 0; a < 3; a++)
    diagonal2 += (job->meter->high_m[a] - job->meter->low_m[a]) * (job->meter->high_m[a] - job->meter->low_m[a]);
  const double radius = 0.5 * sqrt(diagonal2 * np_random_double(random));
  const np_vec3 offset = np_vec3_add(np_vec3_scale(tangent, (float)(radius * cos(turn))),
                                     np_vec3_scale(bitangent, (float)(radius * sin(turn))));
  *out_ray =
      (error_ray){.origin_m = {offset.x, offset.y, offset.z}, .direction = {direction.x, direction.y, direction.z}};
  for (int a = 0; a < 3; a++) out_ray->origin_m[a] += 0.5 * (job->meter->low_m[a] + job->meter->high_m[a]);
  return clip_ray(job, out_ray);
}

/* ---- The grid's fields ---- */

static float round_to_half(float value) { return np_half_to_float(np_half_from_float(value)); }

/* The eight samples around an index position, x slowest, and the fractional position between them. */
static void get_corners(const np_bricks *bricks, np_dvec3 position, float out_corners[8], float out_place[3]) {
  int32_t cell[3];
  np_vec3 local = {0, 0, 0};
  const bool is_inside = np_bricks_locate(bricks, position, cell, &local);
  uint32_t brick = NP_BRICK_NONE;
  float constant = bricks->background;
  if (is_inside) {
    const np_brick_place place = np_bricks_get_place(bricks, cell);
    brick = np_bricks_get_brick(bricks, &place);
    constant = np_bricks_get_range(bricks, &place, 0).min;
  }
  const float at[3] = {local.x, local.y, local.z};
  size_t first = 0;
  for (int a = 0; a < 3; a++) {
    const int lower = at[a] < NP_BRICK_EDGE ? (int)at[a] : NP_BRICK_EDGE - 1;
    out_place[a] = at[a] - (float)lower;
    first = first * NP_BRICK_SAMPLES + (size_t)lower;
  }
  for (int c = 0; c < 8; c++) {
    const size_t corner = first + (size_t)(c >> 2) * NP_BRICK_X + (size_t)(c >> 1 & 1) * NP_BRICK_Y + (size_t)(c & 1);
    out_corners[c] = brick == NP_BRICK_NONE ? constant : bricks->floats[(size_t)brick * NP_BRICK_STRIDE + corner];
  }
}

static float interpolate(const float corners[8], const float place[3]) {
  float line[4], row[2];
  for (int i = 0; i < 4; i++) line[i] = np_mixf(corners[2 * i], corners[2 * i + 1], place[2]);
  for (int i = 0; i < 2; i++) row[i] = np_mixf(line[2 * i], line[2 * i + 1], place[1]);
  return np_mixf(row[0], row[1], place[0]);
}

static void read_grid(const error_job *job, const double offset_m[3], float out_fields[FIELD_COUNT]) {
  const double voxel_m = job->bake->voxel_m;
  double index[3];
  for (int a = 0; a < 3; a++) index[a] = (offset_m[a] - np_bake_compute_offset_m(job->bake, a, 0)) / voxel_m;
  float corners[8], half[8], pruned[8], written[8], place[3];
  get_corners(job->bricks, np_dvec3_make(index[0], index[1], index[2]), corners, place);
  for (int c = 0; c < 8; c++) {
    half[c] = job->is_half ? round_to_half(corners[c]) : corners[c];
    const bool is_kept = corners[c] > job->prune_per_m;
    pruned[c] = is_kept ? corners[c] : 0.0f;
    written[c] = is_kept ? half[c] : 0.0f;
  }
  out_fields[FIELD_GRID] = interpolate(corners, place);
  out_fields[FIELD_HALF] = interpolate(half, place);
  out_fields[FIELD_PRUNED] = interpolate(pruned, place);
  out_fields[FIELD_WRITTEN] = interpolate(written, place);
}

/* ---- Sums ---- */

static void add_point(const float fields[FIELD_COUNT], double step_m, ray_sums *sums) {
  if (!(fields[FIELD_MODEL] > 0 || fields[FIELD_LIMITED] > 0 || fields[FIELD_GRID] > 0)) return;
  sums->point_count += fields[FIELD_MODEL] > 0;
  sums->density2 += (double)fields[FIELD_MODEL] * (double)fields[FIELD_MODEL];
  for (int f = 0; f < FIELD_COUNT; f++) sums->depth[f] += (double)fields[f] * step_m;
  for (int c = 0; c < CAUSE_COUNT; c++) {
    const double difference = (double)fields[causes[c].after] - (double)fields[causes[c].before];
    sums->difference2[c] += difference * difference;
    sums->difference_max[c] = fmax(sums->difference_max[c], fabs(difference));
  }
}

/* End of the measured region: its outermost samples, so that no cell is cut; a region of one sample has half a voxel
 * around it. */
static double get_region_end_m(const np_bake *bake, int axis, bool is_high) {
  const double pad = bake->region_min[axis] < bake->region_max[axis] ? 0 : 0.5;
  return np_bake_compute_offset_m(bake, axis, is_high ? bake->region_max[axis] + pad : bake->region_min[axis] - pad);
}

/* Whether a point belongs to a level: it is in one of its cells, and in the region between its own samples. */
static bool has_point(const np_bake *bake, const double offset_m[3]) {
  if (bake->lod.count == 1) return true;
  for (int a = 0; a < 3 && bake->desc.has_region; a++)
    if (offset_m[a] < get_region_end_m(bake, a, false) || offset_m[a] > get_region_end_m(bake, a, true)) return false;
  return np_bake_owns_point(bake, offset_m);
}

/* Offsets of the level's points in a block of a ray's points, from number `first` on; returns the count of all. */
static size_t compute_points(const error_job *job, const error_ray *r, double start, double step_m, size_t first,
                             double (*out_offsets_m)[3], np_bake_points *points) {
  size_t n = 0;
  points->count = 0;
  for (; n < NP_CLOUD_BLOCK; n++) {
    const double t = ((double)(first + n) + start) * step_m;
    double *offset_m = out_offsets_m[points->count];
    if (!(t < r->length_m)) break;
    for (int a = 0; a < 3; a++) offset_m[a] = r->origin_m[a] + t * r->direction[a];
    if (has_point(job->bake, offset_m)) np_bake_add_point(job->bake, offset_m, points);
  }
  return n;
}

static void measure_ray(const error_job *job, const error_ray *r, double start, ray_sums *sums) {
  const double step_m = fmax(job->step_m, r->length_m / STEPS_MAX);
  double offsets_m[NP_CLOUD_BLOCK][3];
  float model[NP_CLOUD_BLOCK], limited[NP_CLOUD_BLOCK];
  np_bake_points points;
  size_t first = 0, count;
  while ((count = compute_points(job, r, start, step_m, first, offsets_m, &points))) {
    np_bake_eval(&job->meter->detailed, &points, model);
    np_bake_eval(&job->bake->model, &points, limited);
    for (size_t n = 0; n < points.count; n++) {
      float fields[FIELD_COUNT] = {[FIELD_MODEL] = model[n], [FIELD_LIMITED] = limited[n]};
      read_grid(job, offsets_m[n], fields);
      add_point(fields, step_m, sums);
    }
    first += count;
  }
}

static neph_result measure_rays(void *user, size_t begin, size_t end, unsigned thread) {
  const error_job *job = user;
  (void)thread;
  for (size_t i = begin; i < end; i++) {
    if (np_monitor_is_cancelled(job->bake->monitor)) return NEPH_ERROR_CANCELLED;
    np_random random = np_random_start(job->bake->model.desc.seed, 0, (uint32_t)i, 0, 0);
    error_ray r;
    while (!draw_ray(job, &random, &r)) continue;
    measure_ray(job, &r, np_random_double(&random), &job->rays[i]);
  }
  return NEPH_OK;
}

static void sum_rays(const ray_sums *rays, neph_bake_error *error) {
  *error = (neph_bake_error)NEPH_BAKE_ERROR_DEFAULT;
  for (size_t i = 0; i < NEPH_BAKE_ERROR_RAYS; i++) {
    error->ray_count += rays[i].point_count > 0;
    error->point_count += rays[i].point_count;
    error->density_rms_per_m += rays[i].density2;
    error->depth_rms += rays[i].depth[FIELD_MODEL] * rays[i].depth[FIELD_MODEL];
    for (int c = 0; c < CAUSE_COUNT; c++) {
      neph_bake_loss *loss = (neph_bake_loss *)(void *)((char *)error + causes[c].offset);
      const double difference = rays[i].depth[causes[c].after] - rays[i].depth[causes[c].before];
      loss->density_rms_per_m += rays[i].difference2[c];
      loss->density_max_per_m = fmax(loss->density_max_per_m, rays[i].difference_max[c]);
      loss->depth_rms += difference * difference;
      loss->depth_max = fmax(loss->depth_max, fabs(difference));
    }
  }
}

/* Converts sums of squares to rms. All differences count, but the mean is over samples in the model's cloud: otherwise
 * a grid would seem better the farther it extends beyond the cloud. */
static void compute_roots(neph_bake_error *error) {
  const double points = fmax((double)error->point_count, 1), rays = fmax((double)error->ray_count, 1);
  error->density_rms_per_m = sqrt(error->density_rms_per_m / points);
  error->depth_rms = sqrt(error->depth_rms / rays);
  for (int c = 0; c < CAUSE_COUNT; c++) {
    neph_bake_loss *loss = (neph_bake_loss *)(void *)((char *)error + causes[c].offset);
    loss->density_rms_per_m = sqrt(loss->density_rms_per_m / points);
    loss->depth_rms = sqrt(loss->depth_rms / rays);
  }
}

static void add_rays(const ray_sums *rays, ray_sums *to) {
  for (size_t i = 0; i < NEPH_BAKE_ERROR_RAYS; i++) {
    to[i].point_count += rays[i].point_count;
    to[i].density2 += rays[i].density2;
    for (int f = 0; f < FIELD_COUNT; f++) to[i].depth[f] += rays[i].depth[f];
    for (int c = 0; c < CAUSE_COUNT; c++) {
      to[i].difference2[c] += rays[i].difference2[c];
      to[i].difference_max[c] = fmax(to[i].difference_max[c], rays[i].difference_max[c]);
    }
  }
}

/* ---- The measurement ---- */

/* Sets the box to the field, so that voxels of any size use the same rays; for a region, at most to the extent of the
 * finest level. */
static void set_box(np_bake_meter *meter) {
  const np_bake *bake = meter->bake;
  np_bake_compute_field(bake, meter->low_m, meter->high_m);
  for (int a = 0; a < 3 && bake->desc.has_region; a++) {
    meter->low_m[a] = fmax(meter->low_m[a], get_region_end_m(bake, a, false));
    meter->high_m[a] = fmin(meter->high_m[a], get_region_end_m(bake, a, true));
  }
}

neph_result np_bake_meter_start(const np_bake *bake, np_bake_meter *out_meter) {
  neph_cloud_desc cloud = np_cloud_model_get_desc(&bake->model);
  cloud.voxel_m = fmin(cloud.voxel_m, 1e-3 * cloud.billow_m); /* finer than all of its features */
  *out_meter = (np_bake_meter){.bake = bake, .lod_count = bake->lod.count > 1 ? bake->lod.count : 0};
  set_box(out_meter);
  out_meter->rays = np_alloc(bake->context, NEPH_BAKE_ERROR_RAYS, sizeof *out_meter->rays);
  if (!out_meter->rays) return NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_stage(bake->monitor, "preparing the error");
  const neph_result result =
      np_cloud_model_build(bake->context, &cloud, bake->desc.planet_radius_m, bake->monitor, &out_meter->detailed);
  if (result) np_alloc_free(bake->context, out_meter->rays);
  return result;
}

void np_bake_meter_end(np_bake_meter *meter) {
  np_cloud_model_clear(&meter->detailed);
  np_alloc_free(meter->bake->context, meter->rays);
}

static void add_level(np_bake_meter *meter, const np_bake *level, const ray_sums *rays) {
  neph_bake_error own;
  add_rays(rays, meter->rays);
  sum_rays(rays, &own);
  compute_roots(&own);
  meter->lods[level->lod.level] = (neph_bake_lod_error){.voxel_m = level->voxel_m,
                                                        .ray_count = own.ray_count,
                                                        .point_count = own.point_count,
                                                        .density_rms_per_m = own.density_rms_per_m,
                                                        .depth_rms = own.depth_rms,
                                                        .total = own.total};
}

neph_result np_bake_meter_add(np_bake_meter *meter, const np_bake *level, const np_sparse_grid *grid) {
  neph_context *context = level->context;
  np_bricks bricks;
  const np_monitor_part whole = np_monitor_get_part(level->monitor);
  np_monitor_set_part(level->monitor, whole, 0.0, 0.2);
  neph_result result = np_bricks_build(context, grid, NEPH_PRECISION_FLOAT, NULL, level->monitor, &bricks);
  if (result) return result;
  error_job job = {.bake = level,
                   .meter = meter,
                   .bricks = &bricks,
                   .step_m = 0.5 * np_bake_get_finest_m(level),
                   .is_half = level->desc.file_precision == NEPH_PRECISION_HALF,
                   .prune_per_m = (float)level->desc.prune_per_m,
                   .rays = np_alloc(context, NEPH_BAKE_ERROR_RAYS, sizeof *job.rays)};
  result = job.rays ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_part(level->monitor, whole, 0.2, 1.0);
  np_monitor_set_stage(level->monitor, "measuring the error");
  if (!result) result = np_parallel_for(context, level->monitor, NEPH_BAKE_ERROR_RAYS, 8, measure_rays, &job);
  if (!result) add_level(meter, level, job.rays);
  np_alloc_free(context, job.rays);
  np_bricks_clear(&bricks);
  return result;
}

double np_bake_meter_count_bytes(void) { return 2.0 * NEPH_BAKE_ERROR_RAYS * sizeof(ray_sums); }

neph_result np_bake_meter_get(const np_bake_meter *meter, neph_bake_error *out_error) {
  neph_bake_error error;
  sum_rays(meter->rays, &error);
  compute_roots(&error);
  error.lod_count = meter->lod_count;
  for (size_t k = 0; k < meter->lod_count; k++) error.lods[k] = meter->lods[k];
  return np_desc_write(meter->bake->context, "neph_bake_error", &error, sizeof error, out_error);
}

neph_result np_bake_measure_error(const np_bake *bake, const np_sparse_grid *grid, neph_bake_error *out_error) {
  np_bake_meter meter;
  neph_result result = np_bake_meter_start(bake, &meter);
  if (result) return result;
  result = np_bake_meter_add(&meter, bake, grid);
  if (!result) result = np_bake_meter_get(&meter, out_error);
  np_bake_meter_end(&meter);
  return result;
}
