/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/cloud_places.h"

#include <math.h>

#include "core/alloc.h"
#include "core/csv.h"
#include "core/file.h"
#include "core/units.h"

enum { X, Y, Z, ROTATION, SCALE, COLUMNS, PLACES_MAX = 1000000 };

static const char *const names[COLUMNS] = {"x_m", "y_m", "z_m", "rotation_deg", "scale"};

/* Least and greatest value of each column, and the value where it is left out. */
static const struct {
  double min, max, fallback;
} columns[COLUMNS] = {{-1e9, 1e9, 0.0}, {-1e9, 1e9, 0.0}, {-1e9, 1e9, 0.0}, {-360.0, 360.0, 0.0}, {1e-6, 1e6, 1.0}};

static neph_result read_place(const np_csv *csv, size_t row, const int column[COLUMNS], np_cloud_place *out) {
  double v[COLUMNS];
  neph_result result = NEPH_OK;
  for (int i = 0; i < COLUMNS && !result; i++) {
    v[i] = columns[i].fallback;
    if (column[i] != NP_CSV_NO_COLUMN)
      result = np_csv_get_real(csv, row, column[i], columns[i].min, columns[i].max, &v[i]);
  }
  if (!result) *out = (np_cloud_place){{v[X], v[Y], v[Z]}, NP_DEGREE * v[ROTATION], v[SCALE]};
  return result;
}

static neph_result read_rows(neph_context *context, const np_csv *csv, np_scene_cloud *cloud) {
  int column[COLUMNS];
  neph_result result = np_csv_search_columns(csv, names, COLUMNS, 1u << X | 1u << Y | 1u << Z, column);
  if (result) return result;
  if (csv->row_count == 0 || csv->row_count > PLACES_MAX)
    return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: has %zu places of cloud %s, must have from 1 to %d", csv->path,
                   csv->row_count, cloud->name, PLACES_MAX);
  cloud->place = np_alloc(context, csv->row_count, sizeof *cloud->place);
  if (!cloud->place) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t row = 0; row < csv->row_count && !result; row++)
    result = read_place(csv, row, column, &cloud->place[cloud->place_count++]);
  return result;
}

neph_result np_cloud_places_read(neph_context *context, np_scene_cloud *cloud) {
  const char *reason;
  np_csv csv;
  if (!cloud->places) return NEPH_OK;
  cloud->has_position = true;
  for (int a = 0; a < 3; a++) cloud->position_m[a] = 0.0;
  if (np_file_probe(cloud->places, &reason)) return NEPH_OK; /* neph_scene_check_files tells */
  neph_result result = np_csv_load(context, cloud->places, &csv);
  if (result) return result;
  result = read_rows(context, &csv, cloud);
  np_csv_clear(&csv);
  return result;
}

neph_result np_cloud_places_check(const neph_scene *scene) {
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const char *path = scene->clouds[i].places, *reason;
    const neph_result result = path ? np_file_probe(path, &reason) : NEPH_OK;
    if (result)
      return np_fail(scene->context, result, "clouds[%u].places is %s, which cannot be read: %s", i, path, reason);
  }
  return NEPH_OK;
}

void np_cloud_places_clear(neph_context *context, np_scene_cloud *cloud) {
  np_alloc_free(context, cloud->place);
  cloud->place = NULL;
  cloud->place_count = 0;
}

np_affine np_cloud_place_get_affine(const np_cloud_place *place) {
  const double c = place->scale * cos(place->rotation_rad), s = place->scale * sin(place->rotation_rad);
  const double *at = place->position_m;
  return (np_affine){{{c, -s, 0, at[0]}, {s, c, 0, at[1]}, {0, 0, place->scale, at[2]}}};
}

void np_cloud_place_move_box(const np_cloud_place *place, np_dvec3 low, np_dvec3 high, np_dvec3 *out_low,
                             np_dvec3 *out_high) {
  const np_affine way = np_cloud_place_get_affine(place);
  *out_low = np_dvec3_make(HUGE_VAL, HUGE_VAL, HUGE_VAL);
  *out_high = np_dvec3_make(-HUGE_VAL, -HUGE_VAL, -HUGE_VAL);
  for (int corner = 0; corner < 8; corner++) {
    const np_dvec3 p = np_affine_point(
        &way, np_dvec3_make(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z));
    *out_low = np_dvec3_make(fmin(out_low->x, p.x), fmin(out_low->y, p.y), fmin(out_low->z, p.z));
    *out_high = np_dvec3_make(fmax(out_high->x, p.x), fmax(out_high->y, p.y), fmax(out_high->z, p.z));
  }
}
