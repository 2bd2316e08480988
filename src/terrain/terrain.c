/* SPDX-License-Identifier: Apache-2.0 */
/* The ray door: a height field on the curved planet as one Embree grid, meshes as triangles, and the rays that meet
 * them. Where the field comes from is a row of terrain_source.c.
 *
 * Vertices are floats about the middle of the field, or of a mesh without one (the anchor); those of the field are
 * exact points of the sphere raised by their elevation. */
#include "terrain/terrain_private.h"

#include <math.h>
#include <string.h>

#include <embree3/rtcore.h>

#include "core/alloc.h"
#include "core/parallel.h"
#include "core/text.h"
#include "core/text_copy.h"
#include "core/units.h"
#include "terrain/field_facets.h"
#include "terrain/ground_cover.h"
#include "terrain/heightfield.h"
#include "terrain/land_cover.h"
#include "terrain/mesh_ground.h"
#include "terrain/terrain_cover.h"
#include "terrain/terrain_surroundings.h"

/* Places along each side of a field that its rectangle is taken from: sides are bent on the planet. */
enum { CORE_STEPS = 16 };

struct neph_terrain {
  neph_context *context;
  atomic_size_t references;
  np_heightfield field; /* field joined to the sphere; without samples: none */
  np_mesh_ground mesh;  /* mesh; without places: none */
  np_globe globe;
  bool has_place;
  double latitude_rad,
      longitude_rad; /* position of the world's origin, in the globe's frame where the field has a position */
  np_dvec3 anchor;
  float *vertices; /* x, y, z of each sample relative to the anchor; Embree reads this array in place */
  np_dvec3 bounds_min, bounds_max;
  double elevation_min_m, elevation_max_m;
  double planet_radius_m, ground_albedo[3]; /* values of the description */
  np_ground_cover cover;
  char cover_name[33];
  double mean_albedo[3], air_albedo[3];
  RTCDevice device;
  RTCScene scene;
};

static bool has_field(const neph_terrain *terrain) { return terrain->field.width > 0; }

static bool has_mesh(const neph_terrain *terrain) { return terrain->mesh.file.place_count > 0; }

static np_field_facets get_facets(const neph_terrain *terrain) {
  return (np_field_facets){&terrain->field, terrain->vertices};
}

/* ---- making ---- */

static neph_result fail_embree(neph_context *context, enum RTCError error) {
  if (error == RTC_ERROR_CANCELLED) return NEPH_ERROR_CANCELLED;
  if (error == RTC_ERROR_OUT_OF_MEMORY)
    return np_fail(context, NEPH_ERROR_OUT_OF_MEMORY, "terrain: Embree found no memory for its tree");
  return np_fail(context, NEPH_ERROR_INTERNAL, "terrain: Embree failed with error %d", (int)error);
}

/* Warns of ground beyond the horizon, which indicates another place or coordinate system. */
static void warn_of_distance(const neph_terrain *terrain, const neph_terrain_desc *desc, double distance_m) {
  static const double far_m = 300e3;
  const np_heightfield *field = &terrain->field;
  const double across_rad = hypot(field->step_east_rad * field->width, field->step_north_rad * field->height);
  if (distance_m - 0.5 * across_rad * desc->planet_radius_m <= far_m) return;
  np_log(terrain->context, NEPH_LOG_WARNING,
         "the middle of the height field lies %.0f km from the place (latitude %g, longitude %g deg), and nothing of "
         "it is seen from there: check place%s",
         distance_m / NP_KILOMETRE, desc->latitude_rad / NP_DEGREE, desc->longitude_rad / NP_DEGREE,
         desc->crs ? " and terrain.crs" : "");
}

/* Sets the position. Height fields on their own graticule have the world's origin in their middle. */
static neph_result set_place(neph_terrain *terrain, const neph_terrain_desc *desc) {
  const np_heightfield *field = &terrain->field;
  const np_geographic middle = has_field(terrain) ? np_heightfield_get_middle(field) : (np_geographic){0.0, 0.0};
  const bool is_moved = desc->has_place && (field->has_place || !has_field(terrain));
  terrain->planet_radius_m = desc->planet_radius_m;
  for (int b = 0; b < 3; b++) terrain->ground_albedo[b] = desc->ground_albedo[b];
  terrain->has_place = field->has_place || desc->has_place;
  terrain->globe = np_globe_make(desc->planet_radius_m, is_moved ? desc->latitude_rad : middle.latitude_rad,
                                 is_moved ? desc->longitude_rad : middle.longitude_rad);
  terrain->latitude_rad = desc->has_place ? desc->latitude_rad : middle.latitude_rad;
  terrain->longitude_rad = desc->has_place ? desc->longitude_rad : middle.longitude_rad;
  if (!has_field(terrain)) return NEPH_OK;
  terrain->anchor = np_heightfield_to_world(
      field, &terrain->globe, (np_field_position){0.5 * (field->width - 1), 0.5 * (field->height - 1)}, 0);
  const double distance_m = np_dvec3_length(terrain->anchor);
  neph_result result = np_heightfield_check_distance(terrain->context, desc, distance_m);
  if (!result) warn_of_distance(terrain, desc, distance_m);
  return result;
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

static void compute_field_bounds(neph_terrain *terrain) {
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

/* Includes the altitudes of a mesh's box, at its corners and in the middle of its bottom, the lowest point on a
 * sphere. */
static void include_mesh(neph_terrain *terrain) {
  const np_dvec3 low = terrain->mesh.bounds_min, high = terrain->mesh.bounds_max;
  const double radius = terrain->planet_radius_m;
  const np_dvec3 nearest = np_dvec3_make(np_clamp(0.0, low.x, high.x), np_clamp(0.0, low.y, high.y), low.z);
  double lowest = np_altitude(nearest, radius), highest = -INFINITY;
  for (int corner = 0; corner < 4; corner++) {
    const double x = corner & 1 ? high.x : low.x, y = corner & 2 ? high.y : low.y;
    lowest = fmin(lowest, np_altitude(np_dvec3_make(x, y, low.z), radius));
    highest = fmax(highest, np_altitude(np_dvec3_make(x, y, high.z), radius));
  }
  const bool is_first = !has_field(terrain);
  terrain->bounds_min = is_first ? low : np_dvec3_min(terrain->bounds_min, low);
  terrain->bounds_max = is_first ? high : np_dvec3_max(terrain->bounds_max, high);
  terrain->elevation_min_m = is_first ? lowest : fmin(lowest, terrain->elevation_min_m);
  terrain->elevation_max_m = is_first ? highest : fmax(highest, terrain->elevation_max_m);
}

/* ---- ground ---- */

static void eval_field_albedo(const neph_terrain *terrain, np_field_position position, np_vec3 normal,
                              float footprint_m, float out[3]) {
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
                                .slope_rad = acosf(np_clampf(up, -1.0f, 1.0f)),
                                .north_face = normal.y,
                                .footprint_m = footprint_m};
  np_ground_cover_eval(&terrain->cover, &place, out);
}

/* Albedo of a mesh. A picture of the albedo spreads over the box of all ground. */
static void eval_mesh_albedo(const neph_terrain *terrain, np_dvec3 point, np_vec3 normal, float footprint_m,
                             float out[3]) {
  const np_dvec3 low = terrain->bounds_min, high = terrain->bounds_max;
  const float up = np_vec3_dot(normal, np_zenith(point, terrain->planet_radius_m));
  const np_cover_place place = {.east = (float)np_clamp((point.x - low.x) / (high.x - low.x), 0.0, 1.0),
                                .north = (float)np_clamp((point.y - low.y) / (high.y - low.y), 0.0, 1.0),
                                .east_m = point.x - low.x,
                                .north_m = point.y - low.y,
                                .elevation_m = (float)np_altitude(point, terrain->planet_radius_m),
                                .slope_rad = acosf(np_clampf(up, -1.0f, 1.0f)),
                                .north_face = normal.y,
                                .footprint_m = footprint_m};
  np_ground_cover_eval(&terrain->cover, &place, out);
}

void np_terrain_eval_albedo(const neph_terrain *terrain, const np_terrain_hit *hit, float footprint_m,
                            float out_albedo[3]) {
  if (hit->is_of_mesh)
    eval_mesh_albedo(terrain, hit->point, hit->normal, footprint_m, out_albedo);
  else
    eval_field_albedo(terrain, hit->position, hit->normal, footprint_m, out_albedo);
}

float np_terrain_get_roughness(const neph_terrain *terrain) {
  return np_land_cover_get_roughness(terrain->cover.climate);
}

enum { MEAN_PLACES = 128, MEAN_COUNT = MEAN_PLACES * MEAN_PLACES }; /* places of the mean albedo, on a side and all */

static bool hit_from_above(const neph_terrain *terrain, double x_m, double y_m, np_terrain_hit *out_hit) {
  const np_dvec3 above = np_dvec3_make(x_m, y_m, terrain->bounds_max.z + 1.0);
  return np_terrain_intersect(terrain, above, np_vec3_make(0.0f, 0.0f, -1.0f), INFINITY, out_hit);
}

/* Albedo at a position in the field, or in a lone mesh's box; false: no ground is there. */
static bool sample_albedo(const neph_terrain *terrain, double east, double north, float out[3]) {
  if (!has_field(terrain)) {
    const np_dvec3 low = terrain->bounds_min, high = terrain->bounds_max;
    np_terrain_hit hit;
    if (!hit_from_above(terrain, low.x + east * (high.x - low.x), low.y + north * (high.y - low.y), &hit)) return false;
    return np_terrain_eval_albedo(terrain, &hit, NP_TERRAIN_WIDE, out), true;
  }
  const np_heightfield *field = &terrain->field;
  const np_field_position position = {field->margin.count + east * (np_heightfield_get_core_width(field) - 1),
                                      field->margin.count + north * (np_heightfield_get_core_height(field) - 1)};
  const np_field_facets facets = get_facets(terrain);
  eval_field_albedo(terrain, position, np_field_facets_get_normal(&facets, position), NP_TERRAIN_WIDE, out);
  return true;
}

typedef struct mean_job {
  const neph_terrain *terrain;
  float (*albedo)[3]; /* negative where no ground is */
} mean_job;

static neph_result sample_places(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const mean_job *job = user;
  for (size_t n = begin; n < end; n++) {
    const double east = (double)(n % MEAN_PLACES) + 0.5, north = (double)(n / MEAN_PLACES) + 0.5;
    float *albedo = job->albedo[n];
    if (!sample_albedo(job->terrain, east / MEAN_PLACES, north / MEAN_PLACES, albedo)) albedo[0] = -1.0f;
  }
  return NEPH_OK;
}

/* Land beyond the field's own samples counts as it is, those as in the mean. */
static neph_result sample_surroundings(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const mean_job *job = user;
  const neph_terrain *terrain = job->terrain;
  const np_heightfield *field = &terrain->field;
  const np_field_facets facets = get_facets(terrain);
  double low[2], high[2];
  np_terrain_get_core(terrain, low, high);
  for (size_t n = begin; n < end; n++) {
    np_field_position at;
    float *albedo = job->albedo[n];
    albedo[0] = -1.0f;
    const np_terrain_spot spot = np_terrain_choose_spot(low, high, (double)(n / MEAN_PLACES) / MEAN_PLACES,
                                                        (double)(n % MEAN_PLACES) / MEAN_PLACES);
    if (!np_heightfield_locate(field, &terrain->globe, spot.x_m, spot.y_m, &at)) continue;
    const np_field_position core = np_heightfield_get_core_position(field, at);
    if (core.column >= 0.0 && core.row >= 0.0 && core.column <= np_heightfield_get_core_width(field) - 1 &&
        core.row <= np_heightfield_get_core_height(field) - 1)
      for (int b = 0; b < 3; b++) albedo[b] = (float)terrain->mean_albedo[b];
    else
      eval_field_albedo(terrain, at, np_field_facets_get_normal(&facets, at), NP_TERRAIN_WIDE, albedo);
  }
  return NEPH_OK;
}

/* Averages places where there is ground; without any, `out` stays. */
static neph_result average_places(mean_job *job, np_parallel_fn sample, np_monitor *monitor, double out[3]) {
  double sum[3] = {0.0};
  unsigned count = 0;
  const neph_result result = np_parallel_for(job->terrain->context, monitor, MEAN_COUNT, MEAN_PLACES, sample, job);
  for (int n = 0; n < MEAN_COUNT && !result; n++) {
    for (int b = 0; b < 3 && job->albedo[n][0] >= 0.0f; b++) sum[b] += (double)job->albedo[n][b];
    count += job->albedo[n][0] >= 0.0f;
  }
  for (int b = 0; b < 3 && count; b++) out[b] = sum[b] / count;
  return result;
}

static neph_result compute_mean_albedo(neph_terrain *terrain, np_monitor *monitor) {
  memcpy(terrain->mean_albedo, terrain->ground_albedo, sizeof terrain->mean_albedo);
  memcpy(terrain->air_albedo, terrain->ground_albedo, sizeof terrain->air_albedo);
  if (!np_ground_cover_varies(&terrain->cover)) return NEPH_OK;
  mean_job job = {terrain, np_alloc(terrain->context, MEAN_COUNT, sizeof *job.albedo)};
  if (!job.albedo) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = average_places(&job, sample_places, monitor, terrain->mean_albedo);
  memcpy(terrain->air_albedo, terrain->mean_albedo, sizeof terrain->air_albedo);
  if (!result && has_field(terrain) && terrain->field.margin.count > 0)
    result = average_places(&job, sample_surroundings, monitor, terrain->air_albedo);
  np_alloc_free(terrain->context, job.albedo);
  return result;
}

/* Progress callback of Embree's build. Its threads join in a way that ThreadSanitizer does not see: it would report the
 * next use of this stack as a race. */
__attribute__((no_sanitize("thread"))) static bool continue_build(void *user, double fraction) {
  (void)fraction;
  const np_monitor *monitor = user;
  return !atomic_load(&monitor->is_cancelled);
}

typedef struct build_job {
  neph_terrain *terrain;
  np_monitor *monitor;
} build_job;

static void attach_grid(const neph_terrain *terrain) {
  const np_heightfield *field = &terrain->field;
  RTCGeometry geometry = rtcNewGeometry(terrain->device, RTC_GEOMETRY_TYPE_GRID);
  if (!geometry) return;
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, terrain->vertices, 0,
                             3 * sizeof(float), count_samples(field));
  struct RTCGrid *grid =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(struct RTCGrid), 1);
  if (grid) {
    *grid = (struct RTCGrid){0, field->width, (unsigned short)field->width, (unsigned short)field->height};
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(terrain->scene, geometry, 0);
  }
  rtcReleaseGeometry(geometry);
}

/* Identifier of a place. Geometry 0 of a scene is the height field; 1 and above are the places of meshes. */
static unsigned get_place_id(size_t place) { return (unsigned)place + 1u; }

static void attach_triangles(RTCDevice device, RTCScene scene, unsigned id, const np_mesh *mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  if (!geometry) return;
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->positions, 0,
                             3 * sizeof(float), mesh->vertex_count);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->triangles, 0,
                             3 * sizeof(uint32_t), mesh->triangle_count);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

static RTCScene create_scene(const build_job *job) {
  RTCScene scene = rtcNewScene(job->terrain->device);
  if (!scene) return NULL;
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneProgressMonitorFunction(scene, continue_build, job->monitor);
  return scene;
}

static void commit_scene(RTCScene scene) {
  rtcCommitScene(scene);
  rtcSetSceneProgressMonitorFunction(scene, NULL, NULL);
}

static void attach_instance(const neph_terrain *terrain, size_t index, RTCScene shared) {
  const np_affine *to_anchor = &terrain->mesh.file.places[index].to_file;
  float rows[12];
  RTCGeometry geometry = rtcNewGeometry(terrain->device, RTC_GEOMETRY_TYPE_INSTANCE);
  if (!geometry) return;
  for (int i = 0; i < 12; i++) rows[i] = (float)to_anchor->m[i / 4][i % 4];
  rtcSetGeometryInstancedScene(geometry, shared);
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(terrain->scene, geometry, get_place_id(index));
  rtcReleaseGeometry(geometry);
}

/* Attaches the meshes. A mesh with several places has a scene of its own, which Embree retains for its instances. */
static neph_result attach_meshes(const build_job *job) {
  const neph_terrain *terrain = job->terrain;
  const np_mesh_file *file = &terrain->mesh.file;
  RTCScene *shared = np_alloc(terrain->context, file->mesh_count + 1, sizeof *shared);
  if (!shared) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < file->place_count; i++) {
    const uint32_t m = file->places[i].mesh;
    const bool is_shared = np_mesh_ground_is_shared(&file->meshes[m]);
    if (!is_shared) attach_triangles(terrain->device, terrain->scene, get_place_id(i), &file->meshes[m]);
    if (is_shared && !shared[m] && (shared[m] = create_scene(job))) {
      attach_triangles(terrain->device, shared[m], 0, &file->meshes[m]);
      commit_scene(shared[m]);
    }
    if (shared[m]) attach_instance(terrain, i, shared[m]);
  }
  for (size_t m = 0; m < file->mesh_count; m++)
    if (shared[m]) rtcReleaseScene(shared[m]);
  np_alloc_free(terrain->context, shared);
  return NEPH_OK;
}

/* Builds the scene. Embree stores its first error, so that one check at the end covers every call. */
static neph_result build_scene(void *user) {
  build_job *job = user;
  neph_terrain *terrain = job->terrain;
  neph_result result = NEPH_OK;
  char config[32];
  np_print(config, sizeof config, "threads=%u", np_foreign_thread_count(terrain->context));
  terrain->device = rtcNewDevice(config);
  if (!terrain->device) return fail_embree(terrain->context, rtcGetDeviceError(NULL));
  terrain->scene = create_scene(job);
  if (terrain->scene) {
    if (has_field(terrain)) attach_grid(terrain);
    if (has_mesh(terrain)) result = attach_meshes(job);
    if (!result) commit_scene(terrain->scene);
  }
  enum RTCError error = rtcGetDeviceError(terrain->device);
  return error == RTC_ERROR_NONE || result ? result : fail_embree(terrain->context, error);
}

static void destroy_terrain(neph_terrain *terrain) {
  neph_context *context = terrain->context;
  if (terrain->scene) rtcReleaseScene(terrain->scene);
  if (terrain->device) rtcReleaseDevice(terrain->device);
  np_alloc_free(context, terrain->vertices);
  np_ground_cover_destroy(&terrain->cover);
  np_mesh_ground_clear(&terrain->mesh);
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
  terrain->mesh.file.context = context;
  atomic_init(&terrain->references, 1);
  return terrain;
}

static neph_result place_field(neph_terrain *terrain, const neph_terrain_desc *desc, bool is_joined,
                               np_monitor *monitor) {
  neph_context *context = terrain->context;
  neph_result result = NEPH_OK;
  if (!is_joined) result = np_heightfield_join_sphere(context, desc->edge, desc->planet_radius_m, &terrain->field);
  if (result) return result;
  /* one additional float, since Embree reads each vertex as four */
  terrain->vertices = np_alloc(context, 3 * count_samples(&terrain->field) + 1, sizeof(float));
  if (!terrain->vertices) return NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_part(monitor, np_monitor_whole, 0.6, 0.7);
  np_monitor_set_stage(monitor, "placing terrain");
  result = raise_vertices(terrain, monitor);
  if (!result) compute_field_bounds(terrain);
  return result;
}

static neph_result place_mesh(neph_terrain *terrain, const neph_terrain_desc *desc, np_monitor *monitor) {
  np_mesh_ground *mesh = &terrain->mesh;
  neph_result result = np_mesh_ground_load(terrain->context, desc, monitor, mesh);
  if (result) return result;
  if (!has_field(terrain)) terrain->anchor = np_dvec3_scale(np_dvec3_add(mesh->bounds_min, mesh->bounds_max), 0.5);
  np_mesh_ground_set_anchor(mesh, terrain->anchor);
  include_mesh(terrain);
  if (!has_field(terrain) && terrain->elevation_min_m < -0.5)
    np_log(terrain->context, NEPH_LOG_WARNING,
           "%s: its lowest point is %.3g m below sea level, where the planet's sphere hides it: raise it by "
           "terrain.mesh.position, or set environment.planet to none",
           desc->mesh_file, -terrain->elevation_min_m);
  return NEPH_OK;
}

static neph_result build_terrain(neph_terrain *terrain, const neph_terrain_desc *desc, bool is_joined,
                                 np_monitor *monitor) {
  neph_context *context = terrain->context;
  neph_result result = set_place(terrain, desc);
  if (!result) result = np_ground_cover_create(context, desc, monitor, &terrain->cover);
  if (!result && has_field(terrain)) result = place_field(terrain, desc, is_joined, monitor);
  if (!result && desc->mesh_file) result = place_mesh(terrain, desc, monitor);
  if (result) return result;
  np_monitor_set_part(monitor, np_monitor_whole, 0.7, 1.0);
  np_monitor_set_stage(monitor, "building terrain");
  build_job job = {terrain, monitor};
  result = np_parallel_run(context, monitor, build_scene, &job);
  if (!result) result = compute_mean_albedo(terrain, monitor);
  return result;
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

neph_result np_terrain_set_cover(neph_terrain *terrain, const neph_terrain_desc *desc, np_monitor *monitor,
                                 const char *name) {
  np_ground_cover cover;
  const neph_result result = np_ground_cover_create(terrain->context, desc, monitor, &cover);
  if (result) return result;
  np_ground_cover_destroy(&terrain->cover);
  terrain->cover = cover;
  for (int b = 0; b < 3; b++) terrain->ground_albedo[b] = desc->ground_albedo[b];
  const neph_result measured = compute_mean_albedo(terrain, monitor);
  np_terrain_name_cover(terrain, measured ? "" : name);
  return measured;
}

void np_terrain_name_cover(neph_terrain *terrain, const char *name) {
  np_text_copy_short(terrain->cover_name, sizeof terrain->cover_name, name);
}

const char *np_terrain_get_cover_name(const neph_terrain *terrain) { return terrain->cover_name; }

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

double np_terrain_get_cell_m(const neph_terrain *terrain) {
  return has_field(terrain) ? terrain->field.step_north_rad * terrain->planet_radius_m : 0.0;
}

const np_heightfield *np_terrain_get_field(const neph_terrain *terrain) { return &terrain->field; }

double np_terrain_get_planet_radius_m(const neph_terrain *terrain) { return terrain->planet_radius_m; }

const double *np_terrain_get_ground_albedo(const neph_terrain *terrain) { return terrain->ground_albedo; }

void np_terrain_get_bounds(const neph_terrain *terrain, np_dvec3 *out_min, np_dvec3 *out_max) {
  *out_min = terrain->bounds_min;
  *out_max = terrain->bounds_max;
}

void np_terrain_get_core(const neph_terrain *terrain, double out_low[2], double out_high[2]) {
  const np_heightfield *field = &terrain->field;
  np_dvec3 low = {INFINITY, INFINITY, 0.0}, high = {-INFINITY, -INFINITY, 0.0};
  if (has_mesh(terrain)) low = terrain->mesh.bounds_min, high = terrain->mesh.bounds_max;
  const unsigned margin = field->margin.count;
  for (unsigned k = 0; has_field(terrain) && k <= CORE_STEPS; k++)
    for (unsigned side = 0; side < 4; side++) {
      const double along = (double)k / CORE_STEPS, across = side & 1u, x = side & 2u ? along : across,
                   y = side & 2u ? across : along;
      const np_field_position position = {margin + x * (np_heightfield_get_core_width(field) - 1),
                                          margin + y * (np_heightfield_get_core_height(field) - 1)};
      const np_dvec3 point = np_heightfield_to_world(field, &terrain->globe, position, 0.0);
      low = np_dvec3_min(low, point);
      high = np_dvec3_max(high, point);
    }
  out_low[0] = low.x, out_low[1] = low.y;
  out_high[0] = high.x, out_high[1] = high.y;
}

bool np_terrain_has_cover(const neph_terrain *terrain) { return np_ground_cover_varies(&terrain->cover); }

const double *np_terrain_get_mean_albedo(const neph_terrain *terrain) { return terrain->mean_albedo; }

const double *np_terrain_get_air_albedo(const neph_terrain *terrain) { return terrain->air_albedo; }

bool np_terrain_covers(const neph_terrain *terrain, double x_m, double y_m) {
  np_field_position position;
  return has_field(terrain) && np_heightfield_locate(&terrain->field, &terrain->globe, x_m, y_m, &position);
}

bool np_terrain_get_place(const neph_terrain *terrain, double *out_latitude_rad, double *out_longitude_rad) {
  *out_latitude_rad = terrain->latitude_rad;
  *out_longitude_rad = terrain->longitude_rad;
  return terrain->has_place;
}

double np_terrain_get_elevation_min_m(const neph_terrain *terrain) { return terrain->elevation_min_m; }

double np_terrain_get_elevation_max_m(const neph_terrain *terrain) { return terrain->elevation_max_m; }

double neph_terrain_get_elevation_m(const neph_terrain *terrain, double x_m, double y_m) {
  if (!terrain) return 0.0;
  np_field_position position;
  np_terrain_hit hit;
  const bool is_on_mesh = has_mesh(terrain) && hit_from_above(terrain, x_m, y_m, &hit) && hit.is_of_mesh;
  if (is_on_mesh) return np_altitude(hit.point, terrain->planet_radius_m);
  if (!has_field(terrain) || !np_heightfield_locate(&terrain->field, &terrain->globe, x_m, y_m, &position)) return 0.0;
  return np_heightfield_get_elevation(&terrain->field, position);
}

/* ---- rays ---- */

typedef struct ray_span {
  double begin, end;
} ray_span;

/* Clips a ray to the ground's box, enlarged by a metre. For an axis along which the ray does not move only the origin
 * is compared with the planes, since 0 · ∞ is not a number. */
static bool clip_to_bounds(const neph_terrain *terrain, np_dvec3 origin, np_vec3 direction, double distance_max,
                           ray_span *out) {
  const double from[3] = {origin.x, origin.y, origin.z};
  const double along[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
  const double low[3] = {terrain->bounds_min.x - 1, terrain->bounds_min.y - 1, terrain->bounds_min.z - 1};
  const double high[3] = {terrain->bounds_max.x + 1, terrain->bounds_max.y + 1, terrain->bounds_max.z + 1};
  *out = (ray_span){0, distance_max};
  for (int axis = 0; axis < 3; axis++) {
    if (!isfinite(from[axis] + along[axis])) return false; /* Embree asserts that rays are finite */
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

static bool refine_hit(const neph_terrain *terrain, np_dvec3 origin, np_vec3 direction, double distance_max,
                       double distance, const struct RTCHit *hit, np_terrain_hit *out) {
  const unsigned id = hit->instID[0] == RTC_INVALID_GEOMETRY_ID ? hit->geomID : hit->instID[0];
  const np_dvec3 local = np_dvec3_subtract(origin, terrain->anchor);
  if (id == 0) {
    const np_field_facets facets = get_facets(terrain);
    const np_field_position guess = {(double)hit->u * (terrain->field.width - 1),
                                     (double)hit->v * (terrain->field.height - 1)};
    return np_field_facets_intersect(&facets, local, direction, distance_max, guess, out);
  }
  np_mesh_ground_intersect(&terrain->mesh, id - 1u, hit->primID, local, direction, distance, out);
  out->distance = np_clamp(out->distance, 0.0, distance_max);
  out->point = np_dvec3_along(origin, direction, out->distance);
  return true;
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
  return refine_hit(terrain, origin, direction, distance_max, span.begin + (double)ray.ray.tfar, &ray.hit, out_hit);
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
