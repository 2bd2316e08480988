/* SPDX-License-Identifier: Apache-2.0 */
/* Positions of a height field's samples on the globe, and the inverse. */
#include <math.h>

#include "core/units.h"
#include "terrain/heightfield.h"

/* The globe. With λ the longitude from the origin's meridian, φ the latitude and φ₀ the origin's, a unit vector is
 *
 *     east  cosφ·sinλ
 *     north cosφ₀·sinφ − sinφ₀·cosφ·cosλ
 *     up    sinφ₀·sinφ + cosφ₀·cosφ·cosλ
 */

np_globe np_globe_make(double radius_m, double latitude_rad, double longitude_rad) {
  return (np_globe){radius_m, latitude_rad, longitude_rad, sin(latitude_rad), cos(latitude_rad)};
}

np_dvec3 np_globe_to_world(const np_globe *globe, double latitude_rad, double longitude_rad, double elevation_m) {
  return np_globe_place(globe, np_globe_angle_make(latitude_rad),
                        np_globe_angle_make(longitude_rad - globe->longitude_rad), elevation_m);
}

/* ---- The description's place ---- */

neph_result np_heightfield_check_distance(neph_context *context, const neph_terrain_desc *desc, double distance_m) {
  static const double distance_max_m = 1e6; /* a position beyond it is a mistake */
  if (distance_m <= distance_max_m) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                 "the place (latitude %g, longitude %g deg) is %.0f km from the middle of the height field, must be "
                 "within %.0f km",
                 desc->latitude_rad / NP_DEGREE, desc->longitude_rad / NP_DEGREE, distance_m / NP_KILOMETRE,
                 distance_max_m / NP_KILOMETRE);
}

neph_result np_heightfield_check_middle(neph_context *context, const neph_terrain_desc *desc, np_geographic middle) {
  if (!desc->has_place) return NEPH_OK;
  const np_globe globe = np_globe_make(desc->planet_radius_m, desc->latitude_rad, desc->longitude_rad);
  const np_dvec3 at = np_globe_to_world(&globe, middle.latitude_rad, middle.longitude_rad, 0.0);
  return np_heightfield_check_distance(context, desc, np_dvec3_length(at));
}

/* ---- Margins ---- */

static double get_offset_m(const np_field_margin *margin, double index) {
  const size_t k = (size_t)np_clamp(index, 0.0, margin->count - 1);
  return margin->offset_m[k] + (index - (double)k) * (margin->offset_m[k + 1] - margin->offset_m[k]);
}

static double get_offset_index(const np_field_margin *margin, double offset_m) {
  unsigned low = 0, high = margin->count - 1;
  while (low < high) {
    const unsigned middle = (low + high + 1) / 2;
    if (margin->offset_m[middle] <= offset_m)
      low = middle;
    else
      high = middle - 1;
  }
  return low + (offset_m - margin->offset_m[low]) / (margin->offset_m[low + 1] - margin->offset_m[low]);
}

/* Position among the file's samples, from 0 to `last`, for an index that counts the margin's samples too; beyond them
 * by the margin's distances. */
static double get_core(const np_field_margin *margin, double index, double last, double cell_m) {
  if (margin->count == 0) return index;
  const double core = index - margin->count;
  if (core < 0.0) return -get_offset_m(margin, -core) / cell_m;
  return core > last ? last + get_offset_m(margin, core - last) / cell_m : core;
}

static double get_index(const np_field_margin *margin, double core, double last, double cell_m) {
  if (margin->count == 0) return core;
  if (core < 0.0) return margin->count - get_offset_index(margin, -core * cell_m);
  return margin->count + (core > last ? last + get_offset_index(margin, (core - last) * cell_m) : core);
}

unsigned np_heightfield_get_core_width(const np_heightfield *field) { return field->width - 2 * field->margin.count; }

unsigned np_heightfield_get_core_height(const np_heightfield *field) { return field->height - 2 * field->margin.count; }

static double get_core_column(const np_heightfield *field, double column) {
  return get_core(&field->margin, column, np_heightfield_get_core_width(field) - 1, field->margin.cell_east_m);
}

static double get_core_row(const np_heightfield *field, double row) {
  return get_core(&field->margin, row, np_heightfield_get_core_height(field) - 1, field->margin.cell_north_m);
}

np_field_position np_heightfield_get_core_position(const np_heightfield *field, np_field_position position) {
  return (np_field_position){get_core_column(field, position.column), get_core_row(field, position.row)};
}

/* ---- World positions ---- */

np_field_column np_heightfield_get_column(const np_heightfield *field, const np_globe *globe, double column) {
  const double core = get_core_column(field, column);
  if (field->has_chart) return (np_field_column){.basis = np_field_chart_get_basis(core, field->chart.columns)};
  return (np_field_column){
      .meridian = np_globe_angle_make(field->west_rad + core * field->step_east_rad - globe->longitude_rad)};
}

np_field_row np_heightfield_get_row(const np_heightfield *field, double row) {
  const double core = get_core_row(field, row);
  if (field->has_chart) return (np_field_row){.chart = np_field_chart_get_row(&field->chart, core)};
  return (np_field_row){.parallel = np_globe_angle_make(field->south_rad + core * field->step_north_rad)};
}

np_dvec3 np_heightfield_place(const np_heightfield *field, const np_globe *globe, const np_field_row *row,
                              const np_field_column *column, double elevation_m) {
  if (!field->has_chart) return np_globe_place(globe, row->parallel, column->meridian, elevation_m);
  const np_chart_direction d = np_chart_row_eval(&row->chart, &column->basis);
  const double radius = globe->radius_m + elevation_m, across2 = d.east * d.east + d.north * d.north;
  const double up = sqrt(fmax(1.0 - across2, 0.0));
  /* R·(1 − up), without cancellation. */
  return np_dvec3_make(radius * d.east, radius * d.north, elevation_m * up - globe->radius_m * across2 / (1.0 + up));
}

np_dvec3 np_heightfield_to_world(const np_heightfield *field, const np_globe *globe, np_field_position position,
                                 double elevation_m) {
  const np_field_row row = np_heightfield_get_row(field, position.row);
  const np_field_column column = np_heightfield_get_column(field, globe, position.column);
  return np_heightfield_place(field, globe, &row, &column, elevation_m);
}

np_geographic np_heightfield_get_middle(const np_heightfield *field) {
  if (field->has_chart) return field->origin;
  return (np_geographic){field->south_rad + 0.5 * field->step_north_rad * (np_heightfield_get_core_height(field) - 1),
                         field->west_rad + 0.5 * field->step_east_rad * (np_heightfield_get_core_width(field) - 1)};
}

/* ---- Positions in the field ---- */

/* Position among the file's samples on a graticule, for a direction on the world's unit sphere. */
static np_field_position project_to_graticule(const np_heightfield *field, const np_globe *globe, double east,
                                              double north, double up) {
  const double to_meridian = globe->cos_latitude * up - globe->sin_latitude * north;
  const double latitude = asin(np_clamp(globe->sin_latitude * up + globe->cos_latitude * north, -1.0, 1.0));
  const double last = np_heightfield_get_core_width(field) - 1;
  const double middle = field->west_rad + 0.5 * field->step_east_rad * last;
  const double from_middle = remainder(atan2(east, to_meridian) + globe->longitude_rad - middle, 2.0 * NP_PI);
  return (np_field_position){from_middle / field->step_east_rad + 0.5 * last,
                             (latitude - field->south_rad) / field->step_north_rad};
}

/* Intersection of the vertical line through (x, y) with the sphere of a radius, in samples; false when it misses. */
static bool project(const np_heightfield *field, const np_globe *globe, double x_m, double y_m, double radius_m,
                    np_field_position *out) {
  const double east = x_m / radius_m, north = y_m / radius_m, up2 = 1.0 - east * east - north * north;
  if (!(up2 > 0.0)) return false;
  np_field_position core;
  if (!field->has_chart)
    core = project_to_graticule(field, globe, east, north, sqrt(up2));
  else if (!np_field_chart_locate(&field->chart, (np_chart_direction){east, north}, &core))
    return false;
  const np_field_margin *margin = &field->margin;
  out->column = get_index(margin, core.column, np_heightfield_get_core_width(field) - 1, margin->cell_east_m);
  out->row = get_index(margin, core.row, np_heightfield_get_core_height(field) - 1, margin->cell_north_m);
  return true;
}

static bool is_inside(const np_heightfield *field, np_field_position position) {
  return position.column >= 0 && position.column <= field->width - 1 && position.row >= 0 &&
         position.row <= field->height - 1;
}

/* The ground at (x, y) stands a little nearer to the origin in angle than the point of the sphere below it, by
 * elevation / radius: each round gains three digits or so. At the rim the elevation is 0 and nothing moves. */
bool np_heightfield_locate(const np_heightfield *field, const np_globe *globe, double x_m, double y_m,
                           np_field_position *out_position) {
  if (!project(field, globe, x_m, y_m, globe->radius_m, out_position) || !is_inside(field, *out_position)) return false;
  for (int round = 0; round < 3; round++) {
    const double radius_m = globe->radius_m + np_heightfield_get_elevation(field, *out_position);
    if (!project(field, globe, x_m, y_m, radius_m, out_position)) return false;
  }
  return true;
}
