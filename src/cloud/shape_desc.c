/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/shape_desc.h"

#include <math.h>
#include <string.h>

#include "cloud/cloud_kinds.h"
#include "cloud/cloud_name.h"
#include "cloud/weather_picture.h"
#include "core/alloc.h"
#include "core/json.h"
#include "core/text.h"

/* ---- Checks ---- */

static neph_result check_points(neph_context *context, const char *name, const char *key,
                                const neph_cloud_points *points) {
  if (points->count > NEPH_CLOUD_POINTS_MAX)
    return np_fail(context, NEPH_ERROR_LIMIT, "%s.shape.%s has %zu points, must be at most %d: thin them out", name,
                   key, points->count, (int)NEPH_CLOUD_POINTS_MAX);
  for (size_t i = 0; i < points->count; i++) {
    const neph_cloud_point *p = &points->points[i];
    const double at_m[3] = {p->x_m, p->y_m, p->z_m};
    for (int a = 0; a < 3; a++)
      if (!(fabs(at_m[a]) <= 1e6))
        return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                       "%s.shape.%s: coordinate %d of point %zu is %g m, must be within 1e6 m", name, key, a, i,
                       at_m[a]);
    if (!(p->radius_m > 0 && p->radius_m <= 1e6))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "%s.shape.%s: the radius of point %zu is %g m, must be in (0, 1e+06] m", name, key, i,
                     p->radius_m);
  }
  return NEPH_OK;
}

static neph_result check_curves(neph_context *context, const char *name, const neph_cloud_points *curves) {
  size_t before = 0;
  for (size_t c = 0; c < curves->curve_count; c++) {
    if (curves->ends[c] < before + 2 || curves->ends[c] > curves->count)
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "%s.shape.curves[%zu] ends at point %zu of %zu, must have at least 2 points: give one point among "
                     "the spheres",
                     name, c, curves->ends[c], curves->count);
    before = curves->ends[c];
  }
  if (before == curves->count) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s.shape.curves end at point %zu, must end at the last, %zu",
                 name, before, curves->count);
}

static neph_result check_number(neph_context *context, const char *name, const char *key, double value, double low,
                                double high) {
  if (value > low && value <= high) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s.shape.%s is %g, must be in (%g, %g]", name, key, value, low,
                 high);
}

static neph_result check_files(neph_context *context, const char *name, const neph_cloud_shape *shape) {
  neph_result result = check_number(context, name, "mesh.unit", shape->mesh_unit_m, 0, 1e9);
  if (!result) result = check_number(context, name, "mesh.rotation", shape->mesh_rotation_rad, -100, 100);
  for (int a = 0; a < 3 && !result; a++)
    result = check_number(context, name, "mesh.position", shape->mesh_position_m[a], -1e6, 1e6);
  for (int a = 0; a < 2 && !result; a++)
    result = check_number(context, name, "height_map.size", shape->height_size_m[a], 0, 1e7);
  if (!result) result = check_number(context, name, "height_map.height", shape->height_m, 0, 1e5);
  if (result || (unsigned)shape->mesh_up <= NEPH_MESH_UP_Z) return result;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s.shape.mesh.up is %u, must be one of neph_mesh_up", name,
                 (unsigned)shape->mesh_up);
}

neph_result np_shape_check(neph_context *context, const neph_cloud_desc *desc) {
  const char *name = np_cloud_desc_name(desc);
  if (!np_cloud_desc_has_shape(desc)) return NEPH_OK;
  if (!np_cloud_kind_get(desc->model)->has_thermals)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s.shape goes with model thermals or hero, whose billows stand on it: set model", name);
  if (desc->shape.mesh_file && desc->shape.height_map)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s.shape has both mesh and height_map, must have one of them: put the other into another cloud",
                   name);
  neph_result result = check_points(context, name, "spheres", &desc->shape.spheres);
  if (!result) result = check_points(context, name, "curves", &desc->shape.curves);
  if (!result) result = check_curves(context, name, &desc->shape.curves);
  return result ? result : check_files(context, name, &desc->shape);
}

/* ---- JSON ---- */

static void put_points(np_json *json, const char *key, const neph_cloud_points *points) {
  char name[32];
  np_print(name, sizeof name, "shape_%s_count", key);
  np_json_put_integer(json, name, (int64_t)points->count);
  np_print(name, sizeof name, "shape_%s_m", key);
  np_json_put_reals(json, name, points->count ? &points->points->x_m : NULL, 4 * points->count);
}

static void put_ends(np_json *json, const neph_cloud_points *curves) {
  np_json_put_integer(json, "shape_curve_count", (int64_t)curves->curve_count);
  np_json_begin_array(json, "shape_curve_ends");
  for (size_t c = 0; c < curves->curve_count; c++) np_json_put_integer(json, NULL, (int64_t)curves->ends[c]);
  np_json_end(json);
}

/* Writes a file's name and the hash of its contents. */
static neph_result put_file(neph_context *context, np_json *json, const char *key, const char *file) {
  char hash[33], name[40];
  if (!file) return NEPH_OK;
  neph_result result = np_cloud_map_hash(context, file, hash);
  if (result) return result;
  np_json_put_text(json, key, file);
  np_print(name, sizeof name, "%s_hash", key);
  np_json_put_text(json, name, hash);
  return NEPH_OK;
}

neph_result np_shape_put_json(neph_context *context, np_json *json, const neph_cloud_desc *desc) {
  const neph_cloud_shape *shape = &desc->shape;
  if (!np_cloud_desc_has_shape(desc)) return NEPH_OK;
  put_points(json, "spheres", &shape->spheres);
  put_points(json, "curves", &shape->curves);
  put_ends(json, &shape->curves);
  np_json_put_integer(json, "shape_mesh_up", shape->mesh_up);
  np_json_put_bool(json, "shape_has_mesh_unit", shape->has_mesh_unit);
  np_json_put_real(json, "shape_mesh_unit_m", shape->mesh_unit_m);
  np_json_put_real(json, "shape_mesh_rotation_rad", shape->mesh_rotation_rad);
  np_json_put_reals(json, "shape_mesh_position_m", shape->mesh_position_m, 3);
  np_json_put_bool(json, "shape_has_height_size", shape->has_height_size);
  np_json_put_reals(json, "shape_height_size_m", shape->height_size_m, 2);
  np_json_put_bool(json, "shape_has_height", shape->has_height);
  np_json_put_real(json, "shape_height_m", shape->height_m);
  if (shape->height_channel) np_json_put_text(json, "shape_height_channel", shape->height_channel);
  neph_result result = put_file(context, json, "shape_mesh_file", shape->mesh_file);
  return result ? result : put_file(context, json, "shape_height_map", shape->height_map);
}

static bool read_count(const np_json_value *json, const char *key, size_t *out_count) {
  double number;
  if (!np_json_get_reals(json, key, &number, 1) || !(number >= 0 && number <= NEPH_CLOUD_POINTS_MAX)) return false;
  *out_count = (size_t)number;
  return true;
}

static bool read_points(neph_context *context, const np_json_value *json, const char *key, neph_cloud_points *points) {
  char name[32];
  size_t count = 0;
  np_print(name, sizeof name, "shape_%s_count", key);
  if (!read_count(json, name, &count)) return false;
  neph_cloud_point *values = np_alloc(context, count + 1, sizeof *values);
  points->points = values;
  np_print(name, sizeof name, "shape_%s_m", key);
  if (!values || !np_json_get_reals(json, name, &values->x_m, 4 * count)) return false;
  points->count = count;
  return true;
}

static bool read_ends(neph_context *context, const np_json_value *json, neph_cloud_points *curves) {
  size_t count = 0;
  if (!read_count(json, "shape_curve_count", &count)) return false;
  size_t *ends = np_alloc(context, count + 1, sizeof *ends);
  double *numbers = np_alloc(context, count + 1, sizeof *numbers);
  curves->ends = ends;
  const bool is_read = ends && numbers && np_json_get_reals(json, "shape_curve_ends", numbers, count);
  for (size_t c = 0; c < count && is_read; c++) ends[c] = numbers[c] >= 0 ? (size_t)numbers[c] : 0;
  if (is_read) curves->curve_count = count;
  np_alloc_free(context, numbers);
  return is_read;
}

static bool read_text(neph_context *context, const np_json_value *json, const char *key, const char **out_text) {
  const char *text = np_json_get_text(json, key);
  return !text || (*out_text = np_alloc_text(context, text)) != NULL;
}

static bool read_numbers(const np_json_value *json, neph_cloud_shape *shape) {
  double up;
  if (!np_json_get_reals(json, "shape_mesh_up", &up, 1)) return false;
  shape->mesh_up = (neph_mesh_up)(int)up;
  return np_json_get_bool(json, "shape_has_mesh_unit", &shape->has_mesh_unit) &&
         np_json_get_reals(json, "shape_mesh_unit_m", &shape->mesh_unit_m, 1) &&
         np_json_get_reals(json, "shape_mesh_rotation_rad", &shape->mesh_rotation_rad, 1) &&
         np_json_get_reals(json, "shape_mesh_position_m", shape->mesh_position_m, 3) &&
         np_json_get_bool(json, "shape_has_height_size", &shape->has_height_size) &&
         np_json_get_reals(json, "shape_height_size_m", shape->height_size_m, 2) &&
         np_json_get_bool(json, "shape_has_height", &shape->has_height) &&
         np_json_get_reals(json, "shape_height_m", &shape->height_m, 1);
}

neph_result np_shape_read_json(neph_context *context, const np_json_value *json, neph_cloud_desc *desc) {
  neph_cloud_shape *shape = &desc->shape;
  size_t count;
  if (!read_count(json, "shape_spheres_count", &count)) return NEPH_OK;
  const bool is_read = read_points(context, json, "spheres", &shape->spheres) &&
                       read_points(context, json, "curves", &shape->curves) &&
                       read_ends(context, json, &shape->curves) && read_numbers(json, shape) &&
                       read_text(context, json, "shape_mesh_file", &shape->mesh_file) &&
                       read_text(context, json, "shape_height_map", &shape->height_map) &&
                       read_text(context, json, "shape_height_channel", &shape->height_channel);
  if (is_read) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE, "nephos:params has a shape that this version of nephos does not write");
}

void np_shape_add_hash(np_hash *hash, neph_cloud_shape *shape) {
  const neph_cloud_points *points[] = {&shape->spheres, &shape->curves};
  for (int i = 0; i < 2; i++) {
    NP_HASH_ADD(hash, points[i]->count);
    np_hash_add(hash, points[i]->points, points[i]->count * sizeof *points[i]->points);
  }
  np_hash_add(hash, shape->curves.ends, shape->curves.curve_count * sizeof *shape->curves.ends);
  np_hash_add_file(hash, shape->mesh_file);
  np_hash_add_file(hash, shape->height_map);
  np_hash_add_text(hash, shape->height_channel);
  shape->spheres = shape->curves = (neph_cloud_points){.count = 0};
  shape->mesh_file = shape->height_map = shape->height_channel = NULL;
}

static void free_field(neph_context *context, const void *field) {
  void *block;
  memcpy(&block, field, sizeof block);
  np_alloc_free(context, block);
}

void np_shape_clear_desc(neph_context *context, neph_cloud_desc *desc) {
  neph_cloud_shape *shape = &desc->shape;
  const void *const fields[] = {&shape->spheres.points, &shape->curves.points, &shape->curves.ends,
                                &shape->mesh_file,      &shape->height_map,    &shape->height_channel};
  for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) free_field(context, fields[i]);
  *shape = (neph_cloud_shape){0};
}
