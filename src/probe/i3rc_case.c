/* SPDX-License-Identifier: Apache-2.0 */
#include "probe/i3rc_case.h"

#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/text.h"
#include "core/units.h"
#include "plan/integrator_choice.h"
#include "scene/scene_private.h"
#include "volume/volume_private.h"

const np_i3rc_experiment np_i3rc_experiments[NP_I3RC_EXPERIMENTS] = {{0, 1}, {60, 1}, {0, 0.99}, {60, 0.99}};

static const double asymmetry = 0.85;

/* ---- Files ---- */

neph_result np_i3rc_read_numbers(neph_context *context, const char *path, size_t count, double *out) {
  void *bytes;
  size_t size, n = 0;
  neph_result result = np_file_read_text(context, path, &bytes, &size);
  if (result) return result;
  char *at = bytes, *end;
  for (; !result; at = end) {
    const double value = strtod(at, &end);
    if (end == at) break;
    if (!isfinite(value) || value < 0.0)
      result = np_fail(context, NEPH_ERROR_BAD_FILE, "%s: number %zu is %g, must be at least 0", path, n + 1, value);
    if (n < count) out[n] = value;
    n++;
  }
  at += strspn(at, " \t\r\n");
  if (!result && (n != count || at != (char *)bytes + size))
    result = np_fail(context, NEPH_ERROR_BAD_FILE, "%s: holds %zu numbers%s, must hold %zu", path, n,
                     *at ? " and other text" : "", count);
  np_alloc_free(context, bytes);
  return result;
}

/* ---- Fields ---- */

static neph_result allocate(np_i3rc_field *field) {
  field->values =
      np_alloc(field->context, (size_t)field->size[0] * field->size[1] * field->size[2], sizeof *field->values);
  return field->values ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Case 1: 32 columns over 500 m, 250 m thick; half of them have an optical depth of 2, the others of 18. Voxels are a
 * 32nd of the thickness, for the march's solution. */
static neph_result make_step(np_i3rc_field *field) {
  static const double width_m = 500.0, thickness_m = 250.0, depths[2] = {2.0, 18.0};
  enum { COLUMNS = 32, LEVELS = 32 };
  *field = (np_i3rc_field){.context = field->context,
                           .size = {COLUMNS, 1, LEVELS},
                           .voxel_m = {width_m / COLUMNS, width_m, thickness_m / LEVELS},
                           .top_m = thickness_m};
  neph_result result = allocate(field);
  for (unsigned k = 0; k < LEVELS && !result; k++)
    for (unsigned i = 0; i < COLUMNS; i++)
      field->values[k * COLUMNS + i] = (float)(depths[i / (COLUMNS / 2)] / thickness_m);
  return result;
}

enum { LANDSAT_EDGE = 128, LANDSAT_COLUMNS = LANDSAT_EDGE * LANDSAT_EDGE };

typedef struct landsat_scene {
  double depth[LANDSAT_COLUMNS], thickness_km[LANDSAT_COLUMNS];
} landsat_scene;

static neph_result read_column_file(neph_context *context, const char *folder, const char *name, double *out) {
  char *path = np_alloc_printf(context, "%s/%s", folder, name);
  if (!path) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_i3rc_read_numbers(context, path, LANDSAT_COLUMNS, out);
  np_alloc_free(context, path);
  return result;
}

/* Extinction of each voxel of a column, constant up to its top; the voxel of the top holds its share of it. */
static void fill_column(const landsat_scene *scene, np_i3rc_field *field, size_t column) {
  const double thickness_m = 1e3 * scene->thickness_km[column], voxel_m = field->voxel_m[2];
  for (unsigned k = 0; k < field->size[2] && thickness_m > 0.0; k++) {
    const double share = np_clamp(thickness_m / voxel_m - k, 0.0, 1.0);
    field->values[k * (size_t)LANDSAT_COLUMNS + column] = (float)(share * scene->depth[column] / thickness_m);
  }
}

/* Case 3: 128² columns of 30 m; the cloud's base is level, 200 m above the ground. */
static neph_result make_landsat(const char *folder, np_i3rc_field *field) {
  static const double edge_m = 30.0, base_m = 200.0, level_m = 20.0;
  neph_context *context = field->context;
  landsat_scene *scene = np_alloc(context, 1, sizeof *scene);
  if (!scene) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = read_column_file(context, folder, "scene43.tau.128x128", scene->depth);
  if (!result) result = read_column_file(context, folder, "scene43.dz.128x128", scene->thickness_km);
  double thickest_m = level_m;
  for (size_t c = 0; c < LANDSAT_COLUMNS && !result; c++) thickest_m = fmax(thickest_m, 1e3 * scene->thickness_km[c]);
  if (!result && thickest_m > 1e4)
    result = np_fail(context, NEPH_ERROR_BAD_FILE, "%s/scene43.dz.128x128: a column is %g km thick, must be at most 10",
                     folder, 1e-3 * thickest_m);
  const unsigned levels = (unsigned)ceil(fmin(thickest_m, 1e4) / level_m - 1e-9);
  *field = (np_i3rc_field){.context = context,
                           .size = {LANDSAT_EDGE, LANDSAT_EDGE, levels},
                           .voxel_m = {edge_m, edge_m, level_m},
                           .base_m = base_m,
                           .top_m = base_m + levels * level_m};
  if (!result) result = allocate(field);
  for (size_t c = 0; c < LANDSAT_COLUMNS && !result; c++) fill_column(scene, field, c);
  np_alloc_free(context, scene);
  return result;
}

neph_result np_i3rc_field_create(neph_context *context, int number, const char *folder, np_i3rc_field *out) {
  *out = (np_i3rc_field){.context = context};
  return number == 1 ? make_step(out) : make_landsat(folder, out);
}

void np_i3rc_field_clear(np_i3rc_field *field) {
  if (field->context) np_alloc_free(field->context, field->values);
  *field = (np_i3rc_field){0};
}

void np_i3rc_field_get_columns(const np_i3rc_field *field, unsigned out_columns[2]) {
  memcpy(out_columns, field->size, 2 * sizeof *out_columns);
}

/* ---- Worlds ---- */

struct np_i3rc_world {
  neph_context *context;
  neph_volume *volume;
  np_instance placed;
  np_world world;
  np_lighting lighting;
  np_scattering_field *scattering;
  np_plane_view view;
  np_plane_source source;
};

/* Samples sit in the middle of their voxels, which are nearest samples' boxes: steps between columns are sharp. */
static neph_result create_volume(const np_i3rc_field *field, neph_volume **out_volume) {
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  desc.values = field->values;
  desc.is_periodic_x = desc.is_periodic_y = true;
  desc.precision = NEPH_PRECISION_FLOAT;
  desc.interpolation = NEPH_INTERPOLATION_NEAREST;
  for (int a = 0; a < 3; a++) {
    desc.size[a] = field->size[a];
    desc.index_to_world[a][a] = field->voxel_m[a];
    desc.index_to_world[a][3] = 0.5 * field->voxel_m[a] + (a == 2 ? field->base_m : 0.0);
  }
  return neph_volume_create_dense(field->context, &desc, out_volume);
}

/* Light travels towards +x, downward. */
static void fill_world(const np_i3rc_experiment *experiment, np_i3rc_world *w) {
  const double zenith_rad = experiment->zenith_deg * NP_DEGREE;
  w->placed = (np_instance){.bricks = &w->volume->bricks,
                            .world_to_index = w->volume->world_to_index,
                            .extinction_per_value = 1.0f,
                            .albedo = np_spectrum_grey((float)experiment->albedo),
                            .phase = np_phase_henyey_greenstein((float)asymmetry)};
  w->world = (np_world){.clouds.count = 1,
                        .clouds.at = &w->placed,
                        .to_sun = {-(float)sin(zenith_rad), 0.0f, (float)cos(zenith_rad)},
                        .has_no_disks = true,
                        .sun_irradiance = np_spectrum_grey((float)(1.0 / cos(zenith_rad)))};
  w->lighting = (np_lighting){.sun_optical_depths.clouds = &w->world.clouds};
  w->view = (np_plane_view){&w->world, &w->lighting};
}

/* Solves as a scene does at its defaults. */
static neph_result solve(const np_i3rc_field *field, np_i3rc_world *w) {
  np_scattering_desc desc = NP_SCATTERING_DESC_DEFAULT;
  desc.cells.bounds_min = np_dvec3_make(0.0, 0.0, field->base_m);
  desc.cells.bounds_max =
      np_dvec3_make(field->size[0] * field->voxel_m[0], field->size[1] * field->voxel_m[1], field->top_m);
  const np_sun_optical_depth_source depths = np_sun_optical_depths_get_source(&w->lighting.sun_optical_depths);
  const neph_result result = np_scattering_field_build(w->context, &w->world, &depths, &desc, NULL, &w->scattering);
  w->lighting.scattering = w->scattering;
  return result;
}

/* Settings of a scene with all keys at their defaults. */
static neph_result set_source(neph_integrator integrator, uint64_t seed, np_i3rc_world *w) {
  neph_scene *scene;
  const neph_result result = neph_scene_create(w->context, &scene);
  if (result) return result;
  const np_integrator_kernels *kernels = np_integrator_get_kernels(neph_context_get_isa(w->context));
  w->source = (np_plane_source){.context = w->context,
                                .views = &w->view,
                                .view_count = 1,
                                .integrate = integrator == NEPH_INTEGRATOR_PATH ? kernels->path : kernels->march,
                                .seed = seed};
  np_integrator_choice_make(&scene->render, scene->render.multiple_scattering, &w->source.settings);
  neph_scene_destroy(scene);
  return NEPH_OK;
}

neph_result np_i3rc_world_create(const np_i3rc_field *field, const np_i3rc_experiment *experiment,
                                 neph_integrator integrator, uint64_t seed, np_i3rc_world **out_world) {
  np_i3rc_world *w = np_alloc(field->context, 1, sizeof *w);
  *out_world = NULL;
  if (!w) return NEPH_ERROR_OUT_OF_MEMORY;
  w->context = field->context;
  neph_result result = create_volume(field, &w->volume);
  if (!result) fill_world(experiment, w);
  if (!result) result = set_source(integrator, seed, w);
  if (!result && integrator == NEPH_INTEGRATOR_MARCH) result = solve(field, w);
  if (result)
    np_i3rc_world_destroy(w);
  else
    *out_world = w;
  return result;
}

void np_i3rc_world_destroy(np_i3rc_world *w) {
  if (!w) return;
  np_scattering_field_destroy(w->scattering);
  neph_volume_release(w->volume);
  np_alloc_free(w->context, w);
}

const np_plane_source *np_i3rc_world_get_source(const np_i3rc_world *world) { return &world->source; }
