/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/cloud_places.h"

#include <math.h>
#include <string.h>

#include "cloud/repeat.h"
#include "core/alloc.h"
#include "core/csv.h"
#include "core/file.h"
#include "core/units.h"

enum { X, Y, Z, ROTATION, SCALE, COLUMNS, PLACES_MAX = 1000000 };

static const char *const names[COLUMNS] = {"x_m", "y_m", "z_m", "rotation_deg", "scale"};

/* Range of each column, and its default. */
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
  if (!result) *out = (np_cloud_place){{v[X], v[Y], v[Z]}, NP_DEGREE * v[ROTATION], v[SCALE], {0.0, 0.0}};
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
  if (np_file_probe(cloud->places, &reason)) return NEPH_OK; /* neph_scene_check_files reports it */
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

/* ---- Tiles of a repeating field ---- */

/* Rotation by a rotation vector in the plane of x and y. */
static np_affine make_tilt(const double tilt_rad[2]) {
  const double angle = hypot(tilt_rad[0], tilt_rad[1]);
  if (!(angle > 0.0)) return np_affine_identity();
  const double x = tilt_rad[0] / angle, y = tilt_rad[1] / angle, c = cos(angle), s = sin(angle), d = 1.0 - c;
  return (np_affine){
      {{c + d * x * x, d * x * y, s * y, 0}, {d * x * y, c + d * y * y, -s * x, 0}, {-s * y, s * x, c, 0}}};
}

/* Place of a tile at a distance along the axes of the tiles on the sphere: rotated about the planet's centre, which
 * lies below the origin. */
static np_cloud_place make_tile(const neph_cloud_desc *bake, double planet_radius_m, double along_m, double across_m) {
  const double turn_rad = np_repeat_get_turn(bake), c = cos(turn_rad), s = sin(turn_rad);
  const double east_m = c * along_m - s * across_m, north_m = s * along_m + c * across_m;
  const double radius_m = planet_radius_m + bake->base_altitude_m + 0.5 * bake->thickness_m;
  const double far_m = hypot(east_m, north_m), angle = far_m / radius_m;
  np_cloud_place place = {.rotation_rad = turn_rad, .scale = 1.0, .tilt_rad = {-north_m / radius_m, east_m / radius_m}};
  if (!(far_m > 0.0)) return place;
  const double half = sin(0.5 * angle);
  place.position_m[0] = planet_radius_m * sin(angle) * east_m / far_m;
  place.position_m[1] = planet_radius_m * sin(angle) * north_m / far_m;
  place.position_m[2] = -2.0 * planet_radius_m * half * half;
  return place;
}

bool np_cloud_places_repeat_alike(const np_scene_cloud *a, double a_radius_m, const np_scene_cloud *b,
                                  double b_radius_m) {
  const neph_cloud_desc *p = &a->bake, *q = &b->bake;
  const double one[] = {p->extent_m[0], p->repeat_m,           p->base_altitude_m,
                        p->thickness_m, np_repeat_get_turn(p), a_radius_m};
  const double other[] = {q->extent_m[0], q->repeat_m,           q->base_altitude_m,
                          q->thickness_m, np_repeat_get_turn(q), b_radius_m};
  return !memcmp(one, other, sizeof one);
}

neph_result np_cloud_places_repeat(neph_context *context, double planet_radius_m, np_scene_cloud *cloud) {
  const neph_cloud_desc *bake = &cloud->bake;
  const double width_m = bake->extent_m[0], range_m = bake->repeat_m;
  if (!cloud->is_baked || !(range_m > 0.0) || cloud->places) return NEPH_OK;
  const double reach = floor(range_m / width_m), side = 2.0 * reach + 1.0;
  if (!(side * side <= PLACES_MAX))
    return np_fail(context, NEPH_ERROR_BAD_SCENE,
                   "%s.repeat is %g m, must be at most %g m, 499 times extent: reduce it, or enlarge extent",
                   cloud->bake_name, range_m, 499.0 * width_m);
  cloud->place = np_alloc(context, (size_t)(side * side), sizeof *cloud->place);
  if (!cloud->place) return NEPH_ERROR_OUT_OF_MEMORY;
  const int n = (int)reach;
  for (int j = -n; j <= n; j++)
    for (int i = -n; i <= n; i++)
      if (hypot(i, j) * width_m <= range_m)
        cloud->place[cloud->place_count++] = make_tile(bake, planet_radius_m, i * width_m, j * width_m);
  return NEPH_OK;
}

void np_cloud_places_get_box(const np_scene_cloud *cloud, const neph_cloud_desc *bake, double scale, np_dvec3 *out_low,
                             np_dvec3 *out_high) {
  const double half[2] = {0.5 * scale * bake->extent_m[0], 0.5 * scale * bake->extent_m[1]};
  const double low_m =
      cloud->places ? 0.0 : bake->base_altitude_m; /* base of the cloud at its pivot, or where it was baked */
  *out_low = np_dvec3_make(-half[0], -half[1], low_m);
  *out_high = np_dvec3_make(half[0], half[1], low_m + scale * bake->thickness_m);
}

void np_cloud_places_clear(neph_context *context, np_scene_cloud *cloud) {
  np_alloc_free(context, cloud->place);
  cloud->place = NULL;
  cloud->place_count = 0;
}

np_affine np_cloud_place_get_affine(const np_cloud_place *place) {
  const double c = place->scale * cos(place->rotation_rad), s = place->scale * sin(place->rotation_rad);
  const double *at = place->position_m;
  const np_affine turn = {{{c, -s, 0, 0}, {s, c, 0, 0}, {0, 0, place->scale, 0}}}, tilt = make_tilt(place->tilt_rad);
  np_affine way = np_affine_compose(&tilt, &turn);
  for (int a = 0; a < 3; a++) way.m[a][3] = at[a];
  return way;
}

void np_cloud_place_move_box(const np_cloud_place *place, np_dvec3 low, np_dvec3 high, np_dvec3 *out_low,
                             np_dvec3 *out_high) {
  const np_affine way = np_cloud_place_get_affine(place);
  *out_low = np_dvec3_make(HUGE_VAL, HUGE_VAL, HUGE_VAL);
  *out_high = np_dvec3_make(-HUGE_VAL, -HUGE_VAL, -HUGE_VAL);
  for (int corner = 0; corner < 8; corner++) {
    const np_dvec3 p = np_affine_point(
        &way, np_dvec3_make(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z));
    *out_low = np_dvec3_min(*out_low, p);
    *out_high = np_dvec3_max(*out_high, p);
  }
}

void np_cloud_places_bound(const np_scene_cloud *cloud, np_dvec3 low, np_dvec3 high, np_dvec3 *out_low,
                           np_dvec3 *out_high) {
  *out_low = low;
  *out_high = high;
  for (unsigned i = 0; i < cloud->place_count; i++) {
    np_dvec3 own_low, own_high;
    np_cloud_place_move_box(&cloud->place[i], low, high, &own_low, &own_high);
    *out_low = i == 0 ? own_low : np_dvec3_min(*out_low, own_low);
    *out_high = i == 0 ? own_high : np_dvec3_max(*out_high, own_high);
  }
}
