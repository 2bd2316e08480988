/* SPDX-License-Identifier: Apache-2.0 */
#include "check/check_heights.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/units.h"
#include "terrain/heightfield.h"

typedef np_finding_draft draft;

/* A field, and statistics of its samples. */
typedef struct height_facts {
  np_heightfield field;
  np_raster_summary raster;       /* format "" where GDAL has not read it */
  bool has_unit;                  /* elevations are metres: for pictures the caller states the unit */
  bool is_unit_given;             /* the scene names its unit, or an encoding in metres */
  size_t level_count;             /* number of different elevations; at most LEVELS_MAX */
  double step_m;                  /* largest step between neighbours */
  unsigned step_column, step_row; /* place of the step in the file, whose first row is the northern */
  double cell_m;
} height_facts;

enum { LEVELS_MAX = 257, SLOTS = 2048 };

/* ---- Facts ---- */

/* Counts different values, in a hash table, up to one more than a byte has. */
static size_t count_levels(const np_heightfield *field) {
  float slots[SLOTS];
  bool is_taken[SLOTS] = {false};
  size_t count = 0;
  const size_t samples = (size_t)field->width * field->height;
  for (size_t i = 0; i < samples && count < LEVELS_MAX; i++) {
    uint32_t bits;
    memcpy(&bits, &field->elevation_m[i], sizeof bits);
    uint32_t slot = (bits * 2654435761u) >> 21;
    while (is_taken[slot] && slots[slot] != field->elevation_m[i]) slot = (slot + 1) % SLOTS;
    count += !is_taken[slot];
    is_taken[slot] = true;
    slots[slot] = field->elevation_m[i];
  }
  return count;
}

static void note_step(height_facts *f, unsigned column, unsigned row, float other) {
  const double step = fabs((double)f->field.elevation_m[(size_t)row * f->field.width + column] - (double)other);
  if (step <= f->step_m) return;
  f->step_m = step;
  f->step_column = column;
  f->step_row = f->field.height - 1 - row;
}

static void measure_steps(height_facts *f) {
  const np_heightfield *field = &f->field;
  for (unsigned row = 0; row < field->height; row++)
    for (unsigned column = 0; column < field->width; column++) {
      const float *at = field->elevation_m + (size_t)row * field->width + column;
      if (column > 0) note_step(f, column, row, at[-1]);
      if (row > 0) note_step(f, column, row, *(at - field->width));
    }
}

/* Measures a field. A raster alone need not state its position: a scene places it. */
static neph_result measure(neph_check *check, const char *path, neph_terrain_desc *desc, bool has_desc,
                           height_facts *f) {
  np_monitor monitor;
  neph_result result = NEPH_OK;
  np_check_start_monitor(check, &monitor);
  if (np_heightfield_is_raster(path)) result = np_heightfield_describe_raster(check->context, path, desc, &f->raster);
  desc->has_width = desc->has_width || (!has_desc && !f->raster.has_place);
  if (!result) result = np_heightfield_load(check->context, &monitor, path, desc, &f->field);
  if (result) return result;
  f->is_unit_given = desc->unit != NEPH_HEIGHT_UNIT_FILE || desc->encoding != NEPH_HEIGHT_ENCODING_VALUES;
  f->has_unit = has_desc || !np_file_has_ending(path, ".png");
  f->level_count = count_levels(&f->field);
  f->cell_m = desc->planet_radius_m * f->field.step_north_rad;
  measure_steps(f);
  return NEPH_OK;
}

/* ---- Rules ---- */

static const float lowest_m = -500.0f, highest_m = 9000.0f; /* the Dead Sea, and Mount Everest */

static bool has_voids(const height_facts *f, draft *out) {
  const double share = (double)f->field.void_count / ((double)f->field.width * f->field.height);
  assert(share <= 1.0);
  return share > 0.05 &&
         np_draft_set(out, "%.3g %% of its samples have no value and are filled from those around them", 100.0 * share);
}

static bool has_few_voids(const height_facts *f, draft *out) {
  const size_t count = (size_t)f->field.width * f->field.height;
  return f->field.void_count > 0 && f->field.void_count * 20 <= count &&
         np_draft_set(out, "%zu of %zu samples have no value and are filled from those around them",
                      f->field.void_count, count);
}

static bool is_absurd(const height_facts *f, draft *out) {
  const np_heightfield *field = &f->field;
  return f->has_unit && (field->elevation_min_m < lowest_m || field->elevation_max_m > highest_m) &&
         np_draft_set(out, "it reaches from %.5g to %.5g m, beyond the ground of the earth (%g to %g m)",
                      (double)field->elevation_min_m, (double)field->elevation_max_m, (double)lowest_m,
                      (double)highest_m);
}

static bool is_flat(const height_facts *f, draft *out) {
  return f->field.elevation_max_m == f->field.elevation_min_m &&
         np_draft_set(out, "all of it is at %g", (double)f->field.elevation_min_m);
}

/* Whether a step is higher than 3 km and steeper than 80°. */
static bool has_spike(const height_facts *f, draft *out) {
  if (!f->has_unit || f->step_m < 3000.0 || f->step_m < 5.67 * f->cell_m) return false;
  np_draft_set_place(out, "column %u, row %u", f->step_column, f->step_row);
  return np_draft_set(out, "it rises by %.5g m between neighbours: a void that the file does not mark?", f->step_m);
}

/* Whether elevations form terraces, with several samples at each elevation. A small field has few elevations in any
 * case. */
static bool has_terraces(const height_facts *f, draft *out) {
  const size_t samples_per_level = 8, count = (size_t)f->field.width * f->field.height;
  const double range = (double)f->field.elevation_max_m - (double)f->field.elevation_min_m;
  const bool is_whole =
      strncmp(f->raster.sample_type, "Float", strlen("Float")) != 0 && f->has_unit && range < LEVELS_MAX;
  return f->level_count > 1 && f->level_count < LEVELS_MAX && f->level_count * samples_per_level <= count &&
         !is_whole &&
         np_draft_set(out, "its samples have %zu different heights: 8 bits spread over 16 make terraces",
                      f->level_count);
}

static bool lacks_unit(const height_facts *f, draft *out) {
  return f->raster.format[0] && !f->raster.unit[0] && !f->is_unit_given &&
         np_draft_set(out, "it states no unit: taken for metres");
}

static bool lacks_place(const height_facts *f, draft *out) {
  return !f->field.has_place && np_draft_set(out, "it does not say where it lies: it is laid around the scene's place");
}

static const struct {
  np_rule rule;
  bool (*is_broken)(const height_facts *f, draft *out);
} rules[] = {
    {{"heights.voids", NEPH_SEVERITY_WARNING, "fill them before, or take another source"}, has_voids},
    {{"heights.few_voids", NEPH_SEVERITY_NOTE, NULL}, has_few_voids},
    {{"heights.absurd", NEPH_SEVERITY_WARNING, "terrain.vertical_unit; of a .png, terrain.height_min and height_max"},
     is_absurd},
    {{"heights.flat", NEPH_SEVERITY_WARNING, NULL}, is_flat},
    {{"heights.spike", NEPH_SEVERITY_WARNING, "mark voids (gdal_translate -a_nodata VALUE)"}, has_spike},
    {{"heights.terraces", NEPH_SEVERITY_WARNING, "export 16 bits or floats from the source"}, has_terraces},
    {{"heights.unit", NEPH_SEVERITY_NOTE, "terrain.vertical_unit"}, lacks_unit},
    {{"heights.place", NEPH_SEVERITY_NOTE, "terrain.width, and place"}, lacks_place},
};

neph_result np_check_heights(neph_check *check, const char *path, const neph_terrain_desc *desc) {
  neph_terrain_desc given = NEPH_TERRAIN_DESC_DEFAULT;
  height_facts f = {.raster = {.file_count = 0}};
  neph_result result = neph_check_set_file(check, path);
  if (desc) given = *desc;
  if (!result) result = measure(check, path, &given, desc != NULL, &f);
  for (size_t i = 0; !result && i < sizeof rules / sizeof *rules; i++) {
    draft out = {{0}, {0}};
    if (rules[i].is_broken(&f, &out)) np_check_add(check, &rules[i].rule, &out);
  }
  np_heightfield_destroy(check->context, &f.field);
  return np_check_pass(result);
}
