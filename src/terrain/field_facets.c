/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain/field_facets.h"

#include <math.h>

static np_dvec3 get_vertex(const np_field_facets *facets, size_t column, size_t row) {
  const float *vertex = facets->vertices + 3 * (row * facets->field->width + column);
  return np_dvec3_make((double)vertex[0], (double)vertex[1], (double)vertex[2]);
}

static size_t clamp_cell(double cell, unsigned samples) { return (size_t)np_clamp(cell, 0, samples - 2); }

/* Normal of one sample by central differences, one-sided at the rim. */
static np_vec3 get_sample_normal(const np_field_facets *facets, size_t column, size_t row) {
  const size_t width = facets->field->width, height = facets->field->height;
  const size_t west = column ? column - 1 : 0, east = column + 1 < width ? column + 1 : column;
  const size_t south = row ? row - 1 : 0, north = row + 1 < height ? row + 1 : row;
  const np_dvec3 eastward = np_dvec3_subtract(get_vertex(facets, east, row), get_vertex(facets, west, row));
  const np_dvec3 northward = np_dvec3_subtract(get_vertex(facets, column, north), get_vertex(facets, column, south));
  return np_dvec3_to_float(np_dvec3_normalize(np_dvec3_cross(eastward, northward)));
}

static np_vec3 mix_normals(np_vec3 a, np_vec3 b, float t) {
  return np_vec3_add(np_vec3_scale(a, 1.0f - t), np_vec3_scale(b, t));
}

np_vec3 np_field_facets_get_normal(const np_field_facets *facets, np_field_position position) {
  const size_t column = clamp_cell(position.column, facets->field->width);
  const size_t row = clamp_cell(position.row, facets->field->height);
  const float east = np_clampf((float)(position.column - (double)column), 0, 1);
  const float north = np_clampf((float)(position.row - (double)row), 0, 1);
  const np_vec3 south_side =
      mix_normals(get_sample_normal(facets, column, row), get_sample_normal(facets, column + 1, row), east);
  const np_vec3 north_side =
      mix_normals(get_sample_normal(facets, column, row + 1), get_sample_normal(facets, column + 1, row + 1), east);
  return np_vec3_normalize(mix_normals(south_side, north_side, north));
}

/* Intersection of a ray with the plane of one triangle: the lower one of a cell has its right angle in the south-west,
 * the upper one in the north-east. The position is east and north in the cell, [0, 1] inside. */
typedef struct facet_hit {
  double distance, east, north;
  np_dvec3 normal; /* points up, not of unit length */
} facet_hit;

static bool intersect_facet(const np_field_facets *facets, size_t column, size_t row, bool is_upper, np_dvec3 origin,
                            np_dvec3 direction, facet_hit *out) {
  const np_dvec3 corner = get_vertex(facets, column + is_upper, row + is_upper);
  const np_dvec3 along_row = np_dvec3_subtract(get_vertex(facets, column + !is_upper, row + is_upper), corner);
  const np_dvec3 along_column = np_dvec3_subtract(get_vertex(facets, column + is_upper, row + !is_upper), corner);
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
static bool refine_hit(const np_field_facets *facets, np_dvec3 origin, np_vec3 direction, np_field_position guess,
                       facet_hit *out, np_field_position *out_position) {
  const np_heightfield *field = facets->field;
  const np_dvec3 along = np_vec3_to_double(direction);
  size_t column = clamp_cell(guess.column, field->width), row = clamp_cell(guess.row, field->height);
  bool is_upper = guess.column - (double)column + guess.row - (double)row > 1.0;
  bool is_met = false;
  for (int step = 0; step < 4; step++) {
    facet_hit meeting;
    if (!intersect_facet(facets, column, row, is_upper, origin, along, &meeting)) break;
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
 * facets are. Light is computed on the curved surface instead, the mean of the planes through the facet's vertices
 * that lie above it (Hanika 2021, "Hacking the Shadow Terminator", in Ray Tracing Gems II). */
static np_vec3 compute_rise(const np_field_facets *facets, np_field_position position, np_dvec3 local) {
  const size_t column = clamp_cell(position.column, facets->field->width);
  const size_t row = clamp_cell(position.row, facets->field->height);
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
    const np_vec3 normal = get_sample_normal(facets, corners[k].column, corners[k].row);
    const np_dvec3 offset = np_dvec3_subtract(local, get_vertex(facets, corners[k].column, corners[k].row));
    const float below = np_minf(np_vec3_dot(np_dvec3_to_float(offset), normal), 0.0f);
    rise = np_vec3_subtract(rise, np_vec3_scale(normal, (float)corners[k].weight * below));
  }
  return rise;
}

bool np_field_facets_intersect(const np_field_facets *facets, np_dvec3 origin, np_vec3 direction, double distance_max,
                               np_field_position guess, np_terrain_hit *out_hit) {
  facet_hit meeting = {0};
  np_field_position position;
  /* A ray within its facet's plane misses it in double; the next sample's ray will hit. */
  if (!refine_hit(facets, origin, direction, guess, &meeting, &position)) return false;
  *out_hit = (np_terrain_hit){.distance = np_clamp(meeting.distance, 0, distance_max),
                              .normal = np_field_facets_get_normal(facets, position),
                              .facet = np_dvec3_to_float(np_dvec3_normalize(meeting.normal)),
                              .position = position};
  out_hit->rise = compute_rise(facets, position, np_dvec3_along(origin, direction, out_hit->distance));
  return true;
}
