/* SPDX-License-Identifier: Apache-2.0 */
/* The border of a height field, and the ground beyond it: a fade to the sphere, a wall down to it, or land that goes
 * on.
 *
 * Land goes on over a margin of samples whose spacing grows with the distance. Its elevation is that of the smoothed
 * border, s, and near the border the relief of the field reflected there, h:
 *
 *     e = (s + (h − s)·(1 − S(d/a)))·(1 − S((d − b)/(c − b)))
 *
 * with d the distance from the border, S a smoothstep, a a fifth of the field's shorter side, and b to c the distances
 * over which it descends to the sphere, some 0.4° steep for a plateau of 1500 m and behind the horizon.
 */
#include <math.h>

#include "core/alloc.h"
#include "core/units.h"
#include "terrain/heightfield.h"

/* Share of the width, on each side, over which elevations fade to the sphere. */
static const double blend_share = 0.05;

/* A border within this height, or this share of the highest elevation, is at sea level. */
static const float sea_level_m = 2.0f, sea_level_share = 0.005f;

/* The margin's extent and widest cell, for the Earth's radius, and the growth from one cell to the next. A facet of
 * 8 km dips 1.3 m below the sphere. */
static const double reach_m = 250e3, reach_radii = 0.04, widest_share = 1.0 / 31.0, growth_least = 1.1;
static const double relief_share = 0.2, descent_share = 0.2;
enum { GROWING_CELLS = 88 };

/* Width of a wall, in cells. */
static const double wall_share = 1.0 / 64.0;

/* ---- Fade ---- */

static float compute_rim_weight(unsigned index, unsigned count, double band) {
  const unsigned from_edge = index < count - 1 - index ? index : count - 1 - index;
  return np_smoothstepf((float)(from_edge / band));
}

static void fade(np_heightfield *field) {
  const double band = fmax(blend_share * (field->width - 1), 1.0);
  for (unsigned row = 0; row < field->height; row++) {
    const float row_weight = compute_rim_weight(row, field->height, band);
    float *elevations = field->elevation_m + (size_t)row * field->width;
    for (unsigned column = 0; column < field->width; column++)
      elevations[column] *= row_weight * compute_rim_weight(column, field->width, band);
  }
}

/* ---- Border ---- */

/* The samples along the border, counter-clockwise from the south-western corner. */
static size_t count_border(const np_heightfield *field) { return 2 * ((size_t)field->width + field->height - 2); }

static size_t get_border_index(const np_heightfield *field, unsigned column, unsigned row) {
  const size_t east = field->width - 1, north = field->height - 1;
  if (row == 0) return column;
  if (column == east) return east + row;
  if (row == north) return east + north + (east - column);
  return 2 * east + north + (north - row);
}

static void copy_border(const np_heightfield *field, float *out) {
  const unsigned last_column = field->width - 1, last_row = field->height - 1;
  for (unsigned column = 0; column <= last_column; column++) {
    out[get_border_index(field, column, 0)] = field->elevation_m[column];
    out[get_border_index(field, column, last_row)] = field->elevation_m[(size_t)last_row * field->width + column];
  }
  for (unsigned row = 0; row <= last_row; row++) {
    const float *elevations = field->elevation_m + (size_t)row * field->width;
    out[get_border_index(field, 0, row)] = elevations[0];
    out[get_border_index(field, last_column, row)] = elevations[last_column];
  }
}

/* Mean over a window around each sample of a ring, three times over, which is nearly a Gaussian. */
static void smooth_ring(float *ring, float *scratch, size_t count, size_t radius) {
  for (int pass = 0; pass < 3; pass++) {
    double sum = 0;
    for (size_t k = 0; k < 2 * radius + 1; k++) sum += (double)ring[(k + count - radius) % count];
    for (size_t i = 0; i < count; i++) {
      scratch[i] = (float)(sum / (double)(2 * radius + 1));
      sum += (double)ring[(i + radius + 1) % count] - (double)ring[(i + count - radius) % count];
    }
    for (size_t i = 0; i < count; i++) ring[i] = scratch[i];
  }
}

static bool is_at_sea_level(const np_heightfield *field, const float *border) {
  const float most = fmaxf(sea_level_m, sea_level_share * fmaxf(field->elevation_max_m, -field->elevation_min_m));
  for (size_t i = 0; i < count_border(field); i++)
    if (fabsf(border[i]) > most) return false;
  return true;
}

/* ---- Margin ---- */

static void set_cells(np_heightfield *field, double radius_m) {
  const bool is_tilted = field->has_place && !field->has_chart;
  const double latitude = is_tilted ? np_heightfield_get_middle(field).latitude_rad : 0.0;
  field->margin.cell_east_m = field->step_east_rad * radius_m * cos(latitude);
  field->margin.cell_north_m = field->step_north_rad * radius_m;
}

/* Distance to which a margin can go: on a graticule not over a pole, nor around the planet to the other side. */
static double get_reach_m(const np_heightfield *field, double radius_m) {
  const double reach = fmin(reach_m, reach_radii * radius_m);
  if (field->has_chart) return reach;
  const double north = field->south_rad + field->step_north_rad * (field->height - 1);
  const double to_pole = 0.5 * NP_PI - fmax(fabs(field->south_rad), fabs(north));
  const double around = NP_PI - 0.5 * field->step_east_rad * (field->width - 1);
  const double east_m = around / field->step_east_rad * field->margin.cell_east_m;
  return fmin(reach, 0.9 * fmin(to_pole * radius_m, east_m));
}

static void set_growing_offsets(np_field_margin *margin, double reach) {
  double cell = fmin(margin->cell_east_m, margin->cell_north_m);
  const double widest = fmax(widest_share * reach, cell),
               growth = fmax(growth_least, pow(widest / cell, 1.0 / GROWING_CELLS));
  double offset = 0.0;
  margin->count = 0;
  while (offset < reach && margin->count < NP_FIELD_MARGIN_MAX) {
    offset += cell;
    margin->offset_m[++margin->count] = offset;
    cell = fmin(cell * growth, widest);
  }
}

/* Sets offsets of a wall: a row of the border's height, and one on the sphere. */
static void set_wall_offsets(np_field_margin *margin) {
  const double width = wall_share * fmin(margin->cell_east_m, margin->cell_north_m);
  margin->count = 2;
  margin->offset_m[1] = width;
  margin->offset_m[2] = 2.0 * width;
}

typedef struct margin_job {
  const np_heightfield *file; /* the field without a margin */
  np_heightfield *field;
  neph_terrain_edge edge;
  const float *border; /* smoothed border */
  double reach_m;
} margin_job;

static float get_wall_height(const margin_job *job, np_field_position core, unsigned column, unsigned row) {
  const np_heightfield *field = job->field;
  const bool is_outer = column == 0 || row == 0 || column == field->width - 1 || row == field->height - 1;
  return is_outer ? 0.0f : (float)np_heightfield_get_elevation(job->file, core);
}

/* A position reflected at the border: as far inside as it was outside. */
static double reflect(double position, double last) {
  return np_clamp(position < 0.0 ? -position : position > last ? 2.0 * last - position : position, 0.0, last);
}

static float get_land_height(const margin_job *job, np_field_position core) {
  const np_heightfield *file = job->file;
  const double columns = file->width - 1, rows = file->height - 1;
  const np_field_position border = {np_clamp(core.column, 0.0, columns), np_clamp(core.row, 0.0, rows)};
  const double east = (core.column - border.column) * job->field->margin.cell_east_m;
  const double north = (core.row - border.row) * job->field->margin.cell_north_m;
  const double distance = hypot(east, north);
  const double side = fmin(columns * job->field->margin.cell_east_m, rows * job->field->margin.cell_north_m);
  const np_field_position inside = {reflect(core.column, columns), reflect(core.row, rows)};
  const double relief = np_heightfield_get_elevation(file, inside);
  const size_t index = get_border_index(file, (unsigned)lround(border.column), (unsigned)lround(border.row));
  const double land = (double)job->border[index], begin = descent_share * job->reach_m;
  const double near = 1.0 - (double)np_smoothstepf((float)(distance / (relief_share * side)));
  const double descent = (double)np_smoothstepf((float)((distance - begin) / (job->reach_m - begin)));
  return (float)((land + (relief - land) * near) * (1.0 - descent));
}

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const margin_job *job = user;
  np_heightfield *field = job->field;
  const unsigned count = field->margin.count, width = job->file->width;
  for (unsigned row = (unsigned)begin; row < end; row++)
    for (unsigned column = 0; column < field->width; column++) {
      const bool is_core = row - count < job->file->height && column - count < width;
      float *out = field->elevation_m + (size_t)row * field->width + column;
      const np_field_position core = np_heightfield_get_core_position(field, (np_field_position){column, row});
      if (is_core)
        *out = job->file->elevation_m[(size_t)(row - count) * width + (column - count)];
      else
        *out =
            job->edge == NEPH_TERRAIN_EDGE_WALL ? get_wall_height(job, core, column, row) : get_land_height(job, core);
    }
  return NEPH_OK;
}

static neph_result add_margin(neph_context *context, neph_terrain_edge edge, const float *border, double reach,
                              np_heightfield *field) {
  np_heightfield file = *field;
  file.margin.count = 0;
  field->width += 2 * field->margin.count;
  field->height += 2 * field->margin.count;
  field->elevation_m = np_alloc(context, (size_t)field->width * field->height, sizeof(float));
  if (!field->elevation_m) {
    *field = file;
    return NEPH_ERROR_OUT_OF_MEMORY;
  }
  margin_job job = {&file, field, edge, border, reach};
  const neph_result result = np_parallel_for(context, NULL, field->height, 16, fill_rows, &job);
  np_heightfield_destroy(context, &file);
  return result;
}

static neph_result join(neph_context *context, neph_terrain_edge edge, double radius_m, float *border, float *scratch,
                        np_heightfield *field) {
  const unsigned side = field->width < field->height ? field->width : field->height;
  copy_border(field, border);
  set_cells(field, radius_m);
  const double reach = get_reach_m(field, radius_m);
  const bool has_room = reach > 8.0 * fmax(field->margin.cell_east_m, field->margin.cell_north_m);
  if (edge == NEPH_TERRAIN_EDGE_INFINITE && (!has_room || is_at_sea_level(field, border))) {
    fade(field);
    return NEPH_OK;
  }
  smooth_ring(border, scratch, count_border(field), (size_t)(0.5 * relief_share * side));
  if (edge == NEPH_TERRAIN_EDGE_WALL)
    set_wall_offsets(&field->margin);
  else
    set_growing_offsets(&field->margin, reach);
  return add_margin(context, edge, border, reach, field);
}

neph_result np_heightfield_join_sphere(neph_context *context, neph_terrain_edge edge, double planet_radius_m,
                                       np_heightfield *field) {
  if (edge == NEPH_TERRAIN_EDGE_FADE) {
    fade(field);
    return NEPH_OK;
  }
  float *border = np_alloc(context, 2 * count_border(field), sizeof *border);
  if (!border) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = join(context, edge, planet_radius_m, border, border + count_border(field), field);
  np_alloc_free(context, border);
  return result;
}
