/* SPDX-License-Identifier: Apache-2.0 */
/* The ray door: a height field on the curved planet as one Embree grid, and the rays that meet it. Where the field
 * comes from is a row of terrain_source.c.
 *
 * Vertices are floats about the field's middle (the anchor), exact points of the sphere raised by their elevation. */
#include "terrain/terrain_private.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include <embree3/rtcore.h>

#include "core/alloc.h"
#include "core/parallel.h"
#include "core/units.h"
#include "terrain/ground_cover.h"
#include "terrain/heightfield.h"

/* A place farther than this from its height field is a mistake: nothing would be seen of it. */
static const double place_distance_max_m = 1e6;

struct neph_terrain {
  neph_context *context;
  atomic_size_t references;
  np_heightfield field; /* joined to the sphere */
  np_globe globe;
  bool has_place;
  double latitude_rad,
      longitude_rad; /* of the world's origin; those of the globe's frame where the field has a place */
  np_dvec3 anchor;
  float *vertices; /* x, y, z of each sample, from the anchor; Embree reads them in place */
  np_dvec3 bounds_min, bounds_max;
  double elevation_min_m, elevation_max_m;
  double planet_radius_m, ground_albedo[3]; /* as described */
  np_ground_cover cover;
  double mean_albedo[3];
  RTCDevice device;
  RTCScene scene;
};

/* ---- making ---- */

static neph_result fail_embree(neph_context *context, enum RTCError error) {
  if (error == RTC_ERROR_CANCELLED) return NEPH_ERROR_CANCELLED;
  if (error == RTC_ERROR_OUT_OF_MEMORY)
    return np_fail(context, NEPH_ERROR_OUT_OF_MEMORY, "terrain: Embree found no memory for its tree");
  return np_fail(context, NEPH_ERROR_INTERNAL, "terrain: Embree failed with error %d", (int)error);
}

/* Height fields on their own graticule have the world's origin in its middle, wherever the scene takes place. */
static neph_result set_place(neph_terrain *terrain, const neph_terrain_desc *desc) {
  const np_heightfield *field = &terrain->field;
  const np_geographic middle = np_heightfield_get_middle(field);
  const bool is_moved = field->has_place && desc->has_place;
  terrain->planet_radius_m = desc->planet_radius_m;
  for (int b = 0; b < 3; b++) terrain->ground_albedo[b] = desc->ground_albedo[b];
  terrain->has_place = field->has_place || desc->has_place;
  terrain->globe = np_globe_make(desc->planet_radius_m, is_moved ? desc->latitude_rad : middle.latitude_rad,
                                 is_moved ? desc->longitude_rad : middle.longitude_rad);
  terrain->latitude_rad = desc->has_place ? desc->latitude_rad : middle.latitude_rad;
  terrain->longitude_rad = desc->has_place ? desc->longitude_rad : middle.longitude_rad;
  terrain->anchor = np_heightfield_to_world(
      field, &terrain->globe, (np_field_position){0.5 * (field->width - 1), 0.5 * (field->height - 1)}, 0);
  const double distance_m = np_dvec3_length(terrain->anchor);
  if (distance_m <= place_distance_max_m) return NEPH_OK;
  return np_fail(terrain->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "the place (latitude %g, longitude %g deg) is %.0f km from the middle of the height field, must be "
                 "within %.0f km",
                 desc->latitude_rad / NP_DEGREE, desc->longitude_rad / NP_DEGREE, distance_m / NP_KILOMETRE,
                 place_distance_max_m / NP_KILOMETRE);
}

typedef struct raise_job {
  neph_terrain *terrain;
  np_field_column *columns;
} raise_job;

static neph_result raise_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const raise_job *job = user;
  const neph_terrain *terrain = job->terrain;
  const np_heightfield *field = &terrain->field;
  float *vertex = terrain->vertices + 3 * begin * field->width;
  const float *elevation = field->elevation_m + begin * field->width;
  for (size_t row = begin; row < end; row++) {
    const np_field_row along = np_heightfield_get_row(field, (double)row);
    for (unsigned column = 0; column < field->width; column++, vertex += 3, elevation++) {
      const np_dvec3 point =
          np_heightfield_place(field, &terrain->globe, &along, &job->columns[column], (double)*elevation);
      const np_vec3 local = np_dvec3_to_float(np_dvec3_subtract(point, terrain->anchor));
      vertex[0] = local.x;
      vertex[1] = local.y;
      vertex[2] = local.z;
    }
  }
  return NEPH_OK;
}

static neph_result raise_vertices(neph_terrain *terrain, np_monitor *monitor) {
  const np_heightfield *field = &terrain->field;
  raise_job job = {terrain, np_alloc(terrain->context, field->width, sizeof *job.columns)};
  if (!job.columns) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned column = 0; column < field->width; column++)
    job.columns[column] = np_heightfield_get_column(field, &terrain->globe, column);
  const neph_result result = np_parallel_for(terrain->context, monitor, field->height, 16, raise_rows, &job);
  np_alloc_free(terrain->context, job.columns);
  return result;
}

static size_t count_samples(const np_heightfield *field) { return (size_t)field->width * field->height; }

static void compute_bounds(neph_terrain *terrain) {
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  float elevation_min = INFINITY, elevation_max = -INFINITY;
  for (size_t i = 0; i < count_samples(&terrain->field); i++) {
    for (int axis = 0; axis < 3; axis++) {
      low[axis] = np_minf(low[axis], terrain->vertices[3 * i + axis]);
      high[axis] = np_maxf(high[axis], terrain->vertices[3 * i + axis]);
    }
    elevation_min = np_minf(elevation_min, terrain->field.elevation_m[i]);
    elevation_max = np_maxf(elevation_max, terrain->field.elevation_m[i]);
  }
  terrain->bounds_min = np_dvec3_add(terrain->anchor, np_vec3_to_double(np_vec3_make(low[0], low[1], low[2])));
  terrain->bounds_max = np_dvec3_add(terrain->anchor, np_vec3_to_double(np_vec3_make(high[0], high[1], high[2])));
  terrain->elevation_min_m = (double)elevation_min;
  terrain->elevation_max_m = (double)elevation_max;
}

static np_dvec3 get_vertex(const neph_terrain *terrain, size_t column, size_t row) {
  const float *vertex = terrain->vertices + 3 * (row * terrain->field.width + column);
  return np_dvec3_make((double)vertex[0], (double)vertex[1], (double)vertex[2]);
}

static size_t clamp_cell(double cell, unsigned samples) { return (size_t)np_clamp(cell, 0, samples - 2); }

/* Normal of one sample by central differences, one-sided at the rim. */
static np_vec3 get_sample_normal(const neph_terrain *terrain, size_t column, size_t row) {
  const size_t width = terrain->field.width, height = terrain->field.height;
  const size_t west = column ? column - 1 : 0, east = column + 1 < width ? column + 1 : column;
  const size_t south = row ? row - 1 : 0, north = row + 1 < height ? row + 1 : row;
  const np_dvec3 eastward = np_dvec3_subtract(get_vertex(terrain, east, row), get_vertex(terrain, west, row));
  const np_dvec3 northward = np_dvec3_subtract(get_vertex(terrain, column, north), get_vertex(terrain, column, south));
  return np_dvec3_to_float(np_dvec3_normalize(np_dvec3_cross(eastward, northward)));
}

static np_vec3 mix_normals(np_vec3 a, np_vec3 b, float t) {
  return np_vec3_add(np_vec3_scale(a, 1.0f - t), np_vec3_scale(b, t));
}

/* Bilinear in the normals of a cell's four samples. */
static np_vec3 get_smooth_normal(const neph_terrain *terrain, np_field_position position) {
  const size_t column = clamp_cell(position.column, terrain->field.width);
  const size_t row = clamp_cell(position.row, terrain->field.height);
  const float east = np_clampf((float)(position.column - (double)column), 0, 1);
  const float north = np_clampf((float)(position.row - (double)row), 0, 1);
  const np_vec3 south_side =
      mix_normals(get_sample_normal(terrain, column, row), get_sample_normal(terrain, column + 1, row), east);
  const np_vec3 north_side =
      mix_normals(get_sample_normal(terrain, column, row + 1), get_sample_normal(terrain, column + 1, row + 1), east);
  return np_vec3_normalize(mix_normals(south_side, north_side, north));
}

/* ---- ground ---- */

static void eval_albedo(const neph_terrain *terrain, np_field_position position, np_vec3 normal, float out[3]) {
  const np_heightfield *field = &terrain->field;
  const np_field_position core = np_heightfield_get_core_position(field, position);
  const double radius = terrain->planet_radius_m;
  const double latitude = field->has_chart ? 0.0 : field->south_rad + core.row * field->step_north_rad;
  const np_dvec3 sea_level = np_heightfield_to_world(field, &terrain->globe, position, 0.0);
  const float up = np_vec3_dot(normal, np_zenith(sea_level, radius));
  const np_cover_place place = {.east = (float)(core.column / (np_heightfield_get_core_width(field) - 1)),
                                .north = (float)(core.row / (np_heightfield_get_core_height(field) - 1)),
                                .east_m = core.column * field->step_east_rad * radius *
                                          cos(field->has_place ? latitude : 0.0),
                                .north_m = core.row * field->step_north_rad * radius,
                                .elevation_m = (float)np_heightfield_get_elevation(field, position),
                                .slope_rad = acosf(np_clampf(up, -1.0f, 1.0f))};
  np_ground_cover_eval(&terrain->cover, &place, out);
}

/* Places along each side at which the mean albedo is taken. */
enum { MEAN_PLACES = 128 };

static void compute_mean_albedo(neph_terrain *terrain) {
  double sum[3] = {0.0};
  memcpy(terrain->mean_albedo, terrain->ground_albedo, sizeof sum);
  if (!np_ground_cover_varies(&terrain->cover)) return;
  const unsigned margin = terrain->field.margin.count;
  const unsigned last_column = np_heightfield_get_core_width(&terrain->field) - 1;
  const unsigned last_row = np_heightfield_get_core_height(&terrain->field) - 1;
  for (int n = 0; n < MEAN_PLACES * MEAN_PLACES; n++) {
    const np_field_position position = {margin + (n % MEAN_PLACES + 0.5) / MEAN_PLACES * last_column,
                                        margin + (n / MEAN_PLACES + 0.5) / MEAN_PLACES * last_row};
    float albedo[3];
    eval_albedo(terrain, position, get_smooth_normal(terrain, position), albedo);
    for (int b = 0; b < 3; b++) sum[b] += (double)albedo[b];
  }
  for (int b = 0; b < 3; b++) terrain->mean_albedo[b] = sum[b] / (MEAN_PLACES * MEAN_PLACES);
}

/* Embree asks from threads whose joining ThreadSanitizer cannot see: it would report our stack's next use as a race. */
__attribute__((no_sanitize("thread"))) static bool continue_build(void *user, double fraction) {
  (void)fraction;
  const np_monitor *monitor = user;
  return !atomic_load(&monitor->is_cancelled);
}

typedef struct build_job {
  neph_terrain *terrain;
  np_monitor *monitor;
} build_job;

static void attach_grid(const neph_terrain *terrain, RTCGeometry geometry) {
  const np_heightfield *field = &terrain->field;
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, terrain->vertices, 0,
                             3 * sizeof(float), count_samples(field));
  struct RTCGrid *grid =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(struct RTCGrid), 1);
  if (!grid) return;
  *grid = (struct RTCGrid){0, field->width, (unsigned short)field->width, (unsigned short)field->height};
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(terrain->scene, geometry);
}

/* Embree keeps the first error until asked, so one question at the end covers every call. */
static neph_result build_scene(void *user) {
  build_job *job = user;
  neph_terrain *terrain = job->terrain;
  char config[32];
  snprintf(config, sizeof config, "threads=%u", terrain->context->thread_count);
  terrain->device = rtcNewDevice(config);
  if (!terrain->device) return fail_embree(terrain->context, rtcGetDeviceError(NULL));
  terrain->scene = rtcNewScene(terrain->device);
  RTCGeometry geometry = rtcNewGeometry(terrain->device, RTC_GEOMETRY_TYPE_GRID);
  if (terrain->scene && geometry) {
    rtcSetSceneFlags(terrain->scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneProgressMonitorFunction(terrain->scene, continue_build, job->monitor);
    attach_grid(terrain, geometry);
    rtcCommitScene(terrain->scene);
    rtcSetSceneProgressMonitorFunction(terrain->scene, NULL, NULL);
  }
  if (geometry) rtcReleaseGeometry(geometry);
  enum RTCError error = rtcGetDeviceError(terrain->device);
  return error == RTC_ERROR_NONE ? NEPH_OK : fail_embree(terrain->context, error);
}

static void destroy_terrain(neph_terrain *terrain) {
  neph_context *context = terrain->context;
  if (terrain->scene) rtcReleaseScene(terrain->scene);
  if (terrain->device) rtcReleaseDevice(terrain->device);
  np_alloc_free(context, terrain->vertices);
  np_ground_cover_destroy(&terrain->cover);
  np_heightfield_destroy(context, &terrain->field);
  np_alloc_free(context, terrain);
  np_context_release(context);
}

/* A terrain that owns the field; NULL, with the field freed, when there is no memory. */
static neph_terrain *adopt_field(neph_context *context, np_heightfield *field) {
  neph_terrain *terrain = np_alloc(context, 1, sizeof *terrain);
  if (!terrain) {
    np_heightfield_destroy(context, field);
    return NULL;
  }
  np_context_retain(context);
  terrain->context = context;
  terrain->field = *field;
  atomic_init(&terrain->references, 1);
  return terrain;
}

static neph_result build_terrain(neph_terrain *terrain, const neph_terrain_desc *desc, bool is_joined,
                                 np_monitor *monitor) {
  neph_context *context = terrain->context;
  neph_result result = set_place(terrain, desc);
  if (!result) result = np_ground_cover_create(context, desc, monitor, &terrain->cover);
  if (result) return result;
  if (!is_joined) result = np_heightfield_join_sphere(context, desc->edge, desc->planet_radius_m, &terrain->field);
  if (result) return result;
  /* One float more, since Embree reads each vertex as four. */
  terrain->vertices = np_alloc(context, 3 * count_samples(&terrain->field) + 1, sizeof(float));
  if (!terrain->vertices) return NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_part(monitor, np_monitor_whole, 0.6, 0.7);
  np_monitor_set_stage(monitor, "placing terrain");
  result = raise_vertices(terrain, monitor);
  if (result) return result;
  compute_bounds(terrain);
  compute_mean_albedo(terrain);
  np_monitor_set_part(monitor, np_monitor_whole, 0.7, 1.0);
  np_monitor_set_stage(monitor, "building terrain");
  build_job job = {terrain, monitor};
  return np_parallel_run(context, monitor, build_scene, &job);
}

neph_result np_terrain_create_from_field(neph_context *context, np_heightfield *field, const neph_terrain_desc *desc,
                                         bool is_joined, np_monitor *monitor, neph_terrain **out_terrain) {
  neph_terrain *terrain = adopt_field(context, field);
  if (!terrain) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = build_terrain(terrain, desc, is_joined, monitor);
  if (result)
    destroy_terrain(terrain);
  else
    *out_terrain = terrain;
  return result;
}

neph_terrain *neph_terrain_retain(neph_terrain *terrain) {
  if (terrain) atomic_fetch_add_explicit(&terrain->references, 1, memory_order_relaxed);
  return terrain;
}

void neph_terrain_release(neph_terrain *terrain) {
  if (terrain && atomic_fetch_sub_explicit(&terrain->references, 1, memory_order_acq_rel) == 1)
    destroy_terrain(terrain);
}

/* ---- asking ---- */

neph_context *np_terrain_get_context(const neph_terrain *terrain) { return terrain->context; }

const np_heightfield *np_terrain_get_field(const neph_terrain *terrain) { return &terrain->field; }

double np_terrain_get_planet_radius_m(const neph_terrain *terrain) { return terrain->planet_radius_m; }

const double *np_terrain_get_ground_albedo(const neph_terrain *terrain) { return terrain->ground_albedo; }

void np_terrain_get_bounds(const neph_terrain *terrain, np_dvec3 *out_min, np_dvec3 *out_max) {
  *out_min = terrain->bounds_min;
  *out_max = terrain->bounds_max;
}

bool np_terrain_has_cover(const neph_terrain *terrain) { return np_ground_cover_varies(&terrain->cover); }

const double *np_terrain_get_mean_albedo(const neph_terrain *terrain) { return terrain->mean_albedo; }

bool np_terrain_covers(const neph_terrain *terrain, double x_m, double y_m) {
  np_field_position position;
  return np_heightfield_locate(&terrain->field, &terrain->globe, x_m, y_m, &position);
}

bool np_terrain_get_place(const neph_terrain *terrain, double *out_latitude_rad, double *out_longitude_rad) {
  *out_latitude_rad = terrain->latitude_rad;
  *out_longitude_rad = terrain->longitude_rad;
  return terrain->has_place;
}

double np_terrain_get_elevation_min_m(const neph_terrain *terrain) { return terrain->elevation_min_m; }

double np_terrain_get_elevation_max_m(const neph_terrain *terrain) { return terrain->elevation_max_m; }

double neph_terrain_get_elevation_m(const neph_terrain *terrain, double x_m, double y_m) {
  np_field_position position;
  if (!np_heightfield_locate(&terrain->field, &terrain->globe, x_m, y_m, &position)) return 0.0;
  return np_heightfield_get_elevation(&terrain->field, position);
}

/* ---- rays ---- */

typedef struct ray_span {
  double begin, end;
} ray_span;

/* The part of a ray inside the ground's box, a metre wider than it. An axis along which the ray does not move only
 * asks whether the origin lies between its planes, since 0 · ∞ would answer nothing. */
static bool clip_to_bounds(const neph_terrain *terrain, np_dvec3 origin, np_vec3 direction, double distance_max,
                           ray_span *out) {
  const double from[3] = {origin.x, origin.y, origin.z};
  const double along[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
  const double low[3] = {terrain->bounds_min.x - 1, terrain->bounds_min.y - 1, terrain->bounds_min.z - 1};
  const double high[3] = {terrain->bounds_max.x + 1, terrain->bounds_max.y + 1, terrain->bounds_max.z + 1};
  *out = (ray_span){0, distance_max};
  for (int axis = 0; axis < 3; axis++) {
    if (!isfinite(from[axis] + along[axis])) return false; /* Embree takes such a ray for a fault of ours */
    if (along[axis] == 0) {
      if (!(from[axis] >= low[axis] && from[axis] <= high[axis])) return false;
      continue;
    }
    const double a = (low[axis] - from[axis]) / along[axis], b = (high[axis] - from[axis]) / along[axis];
    out->begin = fmax(out->begin, fmin(a, b));
    out->end = fmin(out->end, fmax(a, b));
  }
  return out->begin <= out->end && isfinite(out->end);
}

static struct RTCRay make_embree_ray(const neph_terrain *terrain, np_dvec3 origin, np_vec3 direction, ray_span span) {
  const np_dvec3 entry = np_dvec3_along(origin, direction, span.begin);
  const np_vec3 local = np_dvec3_to_float(np_dvec3_subtract(entry, terrain->anchor));
  return (struct RTCRay){.org_x = local.x,
                         .org_y = local.y,
                         .org_z = local.z,
                         .tnear = 0,
                         .dir_x = direction.x,
                         .dir_y = direction.y,
                         .dir_z = direction.z,
                         .tfar = (float)(span.end - span.begin),
                         .mask = 0xffffffffu};
}

/* Intersection of a ray with the plane of one triangle: the lower one of a cell has its right angle in the south-west,
 * the upper one in the north-east. Position east and north in the cell, [0, 1] inside. */
typedef struct facet_meeting {
  double distance, east, north;
  np_dvec3 normal; /* up, not of unit length */
} facet_meeting;

static bool meet_facet(const neph_terrain *terrain, size_t column, size_t row, bool is_upper, np_dvec3 origin,
                       np_dvec3 direction, facet_meeting *out) {
  const np_dvec3 corner = get_vertex(terrain, column + is_upper, row + is_upper);
  const np_dvec3 along_row = np_dvec3_subtract(get_vertex(terrain, column + !is_upper, row + is_upper), corner);
  const np_dvec3 along_column = np_dvec3_subtract(get_vertex(terrain, column + is_upper, row + !is_upper), corner);
  out->normal = np_dvec3_cross(along_row, along_column);
  const double descent = np_dvec3_dot(out->normal, direction);
  out->distance = np_dvec3_dot(out->normal, np_dvec3_subtract(corner, origin)) / descent;
  if (!isfinite(out->distance)) return false;
  const np_dvec3 hit = np_dvec3_add(origin, np_dvec3_scale(direction, out->distance));
  const np_dvec3 offset = np_dvec3_subtract(hit, corner);
  const double area2 = np_dvec3_dot(out->normal, out->normal);
  const double a = np_dvec3_dot(np_dvec3_cross(offset, along_column), out->normal) / area2;
  const double b = np_dvec3_dot(np_dvec3_cross(along_row, offset), out->normal) / area2;
  out->east = is_upper ? 1.0 - a : a;
  out->north = is_upper ? 1.0 - b : b;
  return true;
}

/* Embree's u and v locate a hit to a few ten-thousandths of a cell, so near an edge they may name its neighbour: from
 * there the exact ray walks to the triangle that holds its meeting with the plane, two steps at most on any but a
 * needle's point of ground. Falls back on the last triangle tried. */
static bool refine_hit(const neph_terrain *terrain, np_dvec3 origin, np_vec3 direction, np_field_position guess,
                       facet_meeting *out, np_field_position *out_position) {
  const np_heightfield *field = &terrain->field;
  const np_dvec3 local = np_dvec3_subtract(origin, terrain->anchor), along = np_vec3_to_double(direction);
  size_t column = clamp_cell(guess.column, field->width), row = clamp_cell(guess.row, field->height);
  bool is_upper = guess.column - (double)column + guess.row - (double)row > 1.0;
  bool is_met = false;
  for (int step = 0; step < 4; step++) {
    facet_meeting meeting;
    if (!meet_facet(terrain, column, row, is_upper, local, along, &meeting)) break;
    is_met = true;
    *out = meeting;
    *out_position = (np_field_position){(double)column + meeting.east, (double)row + meeting.north};
    const size_t next_column = clamp_cell(out_position->column, field->width);
    const size_t next_row = clamp_cell(out_position->row, field->height);
    const bool next_upper = out_position->column - (double)next_column + out_position->row - (double)next_row > 1.0;
    if (next_column == column && next_row == row && next_upper == is_upper) break;
    column = next_column;
    row = next_row;
    is_upper = next_upper;
  }
  return is_met;
}

/* A facet hides the sun from itself before its smooth normals turn from it: the shadow's edge would be as jagged as the
 * facets are. Light is asked for on the curved surface instead, the mean of the planes through the facet's vertices
 * that lie above it (Hanika 2021, "Hacking the Shadow Terminator", in Ray Tracing Gems II). */
static np_vec3 compute_rise(const neph_terrain *terrain, np_field_position position, np_dvec3 local) {
  const size_t column = clamp_cell(position.column, terrain->field.width);
  const size_t row = clamp_cell(position.row, terrain->field.height);
  const double east = np_clamp(position.column - (double)column, 0, 1);
  const double north = np_clamp(position.row - (double)row, 0, 1);
  const bool is_upper = east + north > 1.0;
  const double u = is_upper ? 1.0 - east : east, v = is_upper ? 1.0 - north : north;
  const struct {
    size_t column, row;
    double weight;
  } corners[3] = {{column + is_upper, row + is_upper, fmax(1.0 - u - v, 0.0)},
                  {column + !is_upper, row + is_upper, u},
                  {column + is_upper, row + !is_upper, v}};
  np_vec3 rise = {0.0f, 0.0f, 0.0f};
  for (int k = 0; k < 3; k++) {
    const np_vec3 normal = get_sample_normal(terrain, corners[k].column, corners[k].row);
    const np_dvec3 offset = np_dvec3_subtract(local, get_vertex(terrain, corners[k].column, corners[k].row));
    const float below = np_minf(np_vec3_dot(np_dvec3_to_float(offset), normal), 0.0f);
    rise = np_vec3_subtract(rise, np_vec3_scale(normal, (float)corners[k].weight * below));
  }
  return rise;
}

bool np_terrain_intersect(const neph_terrain *terrain, np_dvec3 origin, np_vec3 direction, double distance_max,
                          np_terrain_hit *out_hit) {
  ray_span span;
  if (!clip_to_bounds(terrain, origin, direction, distance_max, &span)) return false;
  struct RTCRayHit ray = {.ray = make_embree_ray(terrain, origin, direction, span),
                          .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(terrain->scene, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  const np_field_position guess = {(double)ray.hit.u * (terrain->field.width - 1),
                                   (double)ray.hit.v * (terrain->field.height - 1)};
  facet_meeting meeting = {0};
  np_field_position position;
  /* A ray within its facet's plane meets nothing in double; the next sample's ray will. */
  if (!refine_hit(terrain, origin, direction, guess, &meeting, &position)) return false;
  *out_hit = (np_terrain_hit){.distance = np_clamp(meeting.distance, 0, distance_max),
                              .normal = get_smooth_normal(terrain, position),
                              .facet = np_dvec3_to_float(np_dvec3_normalize(meeting.normal)),
                              .position = position};
  const np_dvec3 local = np_dvec3_subtract(origin, terrain->anchor);
  out_hit->rise = compute_rise(terrain, position, np_dvec3_along(local, direction, out_hit->distance));
  return true;
}

void np_terrain_eval_albedo(const neph_terrain *terrain, const np_terrain_hit *hit, float out_albedo[3]) {
  eval_albedo(terrain, hit->position, hit->normal, out_albedo);
}

bool np_terrain_is_occluded(const neph_terrain *terrain, np_dvec3 origin, np_vec3 direction, double distance_max) {
  ray_span span;
  if (!clip_to_bounds(terrain, origin, direction, distance_max, &span)) return false;
  struct RTCRay ray = make_embree_ray(terrain, origin, direction, span);
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(terrain->scene, &context, &ray);
  return ray.tfar < 0;
}
