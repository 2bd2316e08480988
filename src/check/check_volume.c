/* SPDX-License-Identifier: Apache-2.0 */
#include "check/check_volume.h"

#include <string.h>
#include <strings.h>

/* ---- Values of a grid ---- */

typedef np_grid_facts facts;
typedef np_finding_draft draft;

static bool is_light(const facts *f) { return f->role == NP_GRID_DENSITY || f->role == NP_GRID_FIELD; }

static bool is_used(const facts *f) { return f->role != NP_GRID_OTHER; }

static void set_place(draft *out, const np_value_place *at) {
  np_draft_set_place(out, "voxel (%d, %d, %d), (%.6g, %.6g, %.6g)", at->voxel[0], at->voxel[1], at->voxel[2],
                     at->world_m[0], at->world_m[1], at->world_m[2]);
}

/* Sets a finding with the number of such values and the first one's position; false: there are no such values. */
static bool set_values(draft *out, const np_value_count *values, const char *what) {
  if (!values->count) return false;
  set_place(out, &values->first);
  return np_draft_set(out, "%llu value%s %s, the first %g", (unsigned long long)values->count,
                      values->count == 1 ? " is" : "s are", what, values->first_value);
}

/* Whether a grid is a level set by its class. */
static bool holds_distances(const facts *f) {
  return f->role == NP_GRID_DENSITY && f->has_values && np_values_are_distances(f->background, f->value_min);
}

static bool has_nan(const facts *f, draft *out) {
  return is_used(f) && set_values(out, &f->kinds[NP_VALUE_NAN], "NaN");
}

static bool has_infinite(const facts *f, draft *out) {
  return is_used(f) && !f->is_half_on_disk && set_values(out, &f->kinds[NP_VALUE_INFINITE], "infinite");
}

static bool has_half_overflow(const facts *f, draft *out) {
  return is_used(f) && f->is_half_on_disk &&
         set_values(out, &f->kinds[NP_VALUE_INFINITE],
                    "infinite in a file of halves, which end at 65504: they were above that when it was written");
}

static bool has_negative(const facts *f, draft *out) {
  return is_light(f) && !holds_distances(f) && set_values(out, &f->kinds[NP_VALUE_NEGATIVE], "negative");
}

static bool has_rounding(const facts *f, draft *out) {
  return is_light(f) && set_values(out, &f->kinds[NP_VALUE_ROUNDING], "negative, and next to 0: taken as 0");
}

static bool has_subnormal(const facts *f, draft *out) {
  return is_light(f) && set_values(out, &f->kinds[NP_VALUE_SUBNORMAL], "subnormal: taken as 0");
}

static bool is_beyond_half(const facts *f, draft *out) {
  return is_light(f) && set_values(out, &f->beyond_half, "above 65504, which a file of halves cannot hold");
}

/* Whether the largest value is too large for any unit of a cloud's density, or too far above the mean of the other
 * values. */
static bool is_absurd(const facts *f, draft *out) {
  static const double value_max = 1e6, ratio_max = 1e5;
  if (!is_light(f) || !f->has_values || f->active_count < 2 || !isfinite(f->value_max)) return false;
  const double largest = (double)f->value_max, mean = f->sum_of_others / ((double)f->active_count - 1.0);
  if (largest < value_max && !(mean > 0.0 && largest > ratio_max * mean)) return false;
  set_place(out, &f->largest);
  return np_draft_set(out, "the largest value is %g, and the mean of the others %.3g", largest, mean);
}

static bool has_no_density(const facts *f, draft *out) {
  return f->role == NP_GRID_DENSITY && f->has_values && f->active_count && !(f->value_max > 0.0f) &&
         np_draft_set(out, "no value is above 0, the largest is %g: it draws nothing", (double)f->value_max);
}

static bool has_background(const facts *f, draft *out) {
  if (f->role != NP_GRID_DENSITY || !f->has_values || f->background == 0.0f || holds_distances(f)) return false;
  return np_draft_set(out, "its background is %g: a cloud has 0 where it ends", (double)f->background);
}

static bool has_field_background(const facts *f, draft *out) {
  if (!is_used(f) || f->role == NP_GRID_DENSITY || isfinite(f->background)) return false;
  return np_draft_set(out, "its background is %g, must be finite", (double)f->background);
}

/* ---- The grid as a whole ---- */

static bool is_empty(const facts *f, draft *out) {
  return f->role == NP_GRID_DENSITY && !f->active_count && np_draft_set(out, "it is empty: it has no active voxels");
}

static bool is_empty_field(const facts *f, draft *out) {
  return f->role != NP_GRID_DENSITY && !f->is_unread && !f->active_count &&
         np_draft_set(out, "it is empty: it has no active voxels");
}

static bool is_level_set(const facts *f, draft *out) {
  return f->is_level_set && f->role != NP_GRID_DENSITY &&
         np_draft_set(out, "it is a level set, which holds distances, not a density");
}

static bool is_unmarked_level_set(const facts *f, draft *out) {
  return holds_distances(f) && np_draft_set(out,
                                            "it is a level set whose class is not set: its values reach from %g to a "
                                            "background of %g",
                                            (double)f->value_min, (double)f->background);
}

static bool has_wrong_class(const facts *f, draft *out) {
  return f->role == NP_GRID_DENSITY && f->is_scalar && !f->is_level_set && strcmp(f->grid_class, "fog volume") != 0 &&
         np_draft_set(out, "its class is %s, not fog volume: other programs may draw it as something else",
                      f->grid_class[0] ? f->grid_class : "unknown");
}

static bool is_points(const facts *f, draft *out) {
  return strstr(f->value_type, "ptdataidx") && np_draft_set(out, "it holds points, which are not read");
}

static bool is_degenerate(const facts *f, draft *out) {
  return f->is_affine && !f->is_invertible &&
         np_draft_set(out, "its transform has no inverse: its voxels are %g × %g × %g", f->voxel_m[0], f->voxel_m[1],
                      f->voxel_m[2]);
}

static bool is_frustum(const facts *f, draft *out) {
  const np_frustum_facts *own = &f->frustum;
  if (!f->is_frustum) return !f->is_affine && is_light(f) && np_draft_set(out, "its voxels are those of a frustum");
  return own->fits &&
         np_draft_set(
             out,
             "its voxels are those of a frustum, from %.3g × %.3g × %.3g to %.3g × %.3g × %.3g: it is resampled "
             "to %u level%s of regular voxels no larger, with at most %.3g MB",
             own->edges[0][0], own->edges[0][1], own->edges[0][2], own->edges[1][0], own->edges[1][1], own->edges[1][2],
             own->level_count, own->level_count > 1 ? "s" : "", 1e-6 * own->bytes);
}

static bool is_frustum_too_large(const facts *f, draft *out) {
  const np_frustum_facts *own = &f->frustum;
  return f->is_frustum && f->active_count && own->is_sound && !own->fits &&
         np_draft_set(
             out,
             "regular voxels no larger than its frustum's would take %.3g MB, more than the %.3g MB allowed for a file "
             "of its size",
             1e-6 * own->bytes, 1e-6 * own->bytes_max);
}

static bool is_frustum_a_point(const facts *f, draft *out) {
  return f->is_frustum && f->active_count && !f->frustum.is_sound &&
         np_draft_set(out, "the voxels of its frustum narrow to a point, or widen more than a million times, within "
                           "what it holds");
}

static bool is_mirrored(const facts *f, draft *out) {
  const double(*m)[4] = f->index_to_world;
  const double volume = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                        m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                        m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  return f->is_affine && volume < 0.0 && np_draft_set(out, "its transform mirrors it: left is right");
}

/* Whether a few voxels lie far from all others: they cost memory, and enlarge the box, by which the cloud is placed. */
static bool has_stray(const facts *f, draft *out) {
  static const double ratio_max = 4.0, size_min = 200.0; /* voxels */
  double size = 0.0;
  for (int a = 0; a < 3; a++) size = fmax(size, (double)f->active_max[a] - f->active_min[a]);
  if (!is_light(f) || f->stray_ratio < ratio_max || size < size_min) return false;
  set_place(out, &f->stray);
  return np_draft_set(out, "its box is %.3g times that of all but a thousandth of its voxels, for a few far away",
                      f->stray_ratio);
}

static bool has_voxel_size(const facts *f, double size_min, double size_max, draft *out) {
  if (f->role != NP_GRID_DENSITY || !f->is_affine || !f->active_count) return false;
  double size = 0.0;
  for (int a = 0; a < 3; a++) size = fmax(size, f->world_max[a] - f->world_min[a]);
  return size >= size_min && size < size_max &&
         np_draft_set(out, "it is %.4g m across where a unit of the file is a metre", size);
}

static bool is_small(const facts *f, draft *out) { return has_voxel_size(f, 0.0, 10.0, out); }

static bool is_large(const facts *f, draft *out) { return has_voxel_size(f, 1e6, HUGE_VAL, out); }

/* Whether a program wrote the file whose scenes have y up. */
static bool is_y_up(const facts *f, draft *out) {
  static const char *const programs[] = {"Houdini", "Maya", "Bifrost"};
  for (size_t i = 0; i < sizeof programs / sizeof *programs; i++)
    if (f->role == NP_GRID_DENSITY && strcasestr(f->creator, programs[i]))
      return np_draft_set(out, "it was written by %s, whose scenes have y up, and z is taken as up", programs[i]);
  return false;
}

/* ---- Rules ---- */

#define MENDED_COPY "nephos check --fix -o COPY, with the ending of the file"
#define MEND "clouds[].import: repair, or " MENDED_COPY
#define FRUSTUM "clip the part nearest to its camera, or resample it to a regular grid first"
#define SIZE "clouds[].voxel, the edge of a voxel in metres, or clouds[].scale"

/* Conditions on the scene under which a rule does not apply. */
typedef enum rule_kind {
  PLAIN,
  OF_SIZE,   /* the scene states the size of the cloud */
  OF_UP,     /* the scene may state the up axis */
  REPAIRABLE /* the scene may repair the values */
} rule_kind;

typedef struct grid_rule {
  np_rule rule;
  bool (*is_broken)(const facts *f, draft *out);
  rule_kind kind;
} grid_rule;

static const grid_rule grid_rules[] = {
    {{"grid.empty", NEPH_SEVERITY_WARNING, "clouds[].grid names another grid"}, is_empty, PLAIN},
    {{"grid.empty_field", NEPH_SEVERITY_NOTE, NULL}, is_empty_field, PLAIN},
    {{"grid.level_set", NEPH_SEVERITY_NOTE, "clouds[].level_set makes it fog"}, is_level_set, PLAIN},
    {{"grid.unmarked_level_set", NEPH_SEVERITY_ERROR, "clouds[].level_set makes it fog"}, is_unmarked_level_set, PLAIN},
    {{"grid.class", NEPH_SEVERITY_NOTE, MENDED_COPY}, has_wrong_class, PLAIN},
    {{"grid.points", NEPH_SEVERITY_NOTE, NULL}, is_points, PLAIN},
    {{"transform.degenerate", NEPH_SEVERITY_ERROR, "export it anew, with voxels that have a volume"},
     is_degenerate,
     PLAIN},
    {{"transform.frustum", NEPH_SEVERITY_NOTE, NULL}, is_frustum, PLAIN},
    {{"transform.frustum_large", NEPH_SEVERITY_ERROR, FRUSTUM}, is_frustum_too_large, PLAIN},
    {{"transform.frustum_point", NEPH_SEVERITY_ERROR, FRUSTUM}, is_frustum_a_point, PLAIN},
    {{"transform.mirrored", NEPH_SEVERITY_NOTE, "clouds[].scale takes negative numbers by axis"}, is_mirrored, PLAIN},
    {{"transform.y_up", NEPH_SEVERITY_NOTE, "clouds[].up: y; or up: z, if the cloud stands as it should"},
     is_y_up,
     OF_UP},
    {{"size.small", NEPH_SEVERITY_WARNING, SIZE}, is_small, OF_SIZE},
    {{"size.large", NEPH_SEVERITY_WARNING, SIZE}, is_large, OF_SIZE},
    {{"grid.stray", NEPH_SEVERITY_WARNING, "clip or prune it before; clouds[].pivot places it by another point"},
     has_stray,
     PLAIN},
    {{"values.nan", NEPH_SEVERITY_ERROR, MEND}, has_nan, REPAIRABLE},
    {{"values.infinite", NEPH_SEVERITY_ERROR, MEND}, has_infinite, REPAIRABLE},
    {{"values.half_overflow", NEPH_SEVERITY_ERROR, "export floats; or " MEND}, has_half_overflow, REPAIRABLE},
    {{"values.negative", NEPH_SEVERITY_ERROR, MEND}, has_negative, REPAIRABLE},
    {{"values.rounding", NEPH_SEVERITY_NOTE, NULL}, has_rounding, PLAIN},
    {{"values.subnormal", NEPH_SEVERITY_NOTE, NULL}, has_subnormal, PLAIN},
    {{"values.beyond_half", NEPH_SEVERITY_NOTE, "keep floats on disk"}, is_beyond_half, PLAIN},
    {{"values.absurd", NEPH_SEVERITY_WARNING, "clouds[].ramp; or export without the outliers"}, is_absurd, PLAIN},
    {{"values.none", NEPH_SEVERITY_WARNING, "clouds[].grid names another grid"}, has_no_density, PLAIN},
    {{"values.background", NEPH_SEVERITY_ERROR, MEND}, has_background, REPAIRABLE},
    {{"values.field_background", NEPH_SEVERITY_ERROR, MEND}, has_field_background, REPAIRABLE},
};

static const np_rule openvdb_rule = {"openvdb", NEPH_SEVERITY_NOTE, NULL};

/* Adds a diagnosis of OpenVDB without its list of values. */
static void add_diagnosis(neph_check *check, const char *text) {
  draft out = {{0}, {0}};
  np_draft_set(&out, "OpenVDB's check of fog volumes: %.*s", (int)strcspn(text, "\n"), text);
  np_check_add(check, &openvdb_rule, &out);
}

static void put_to_rule(neph_check *check, const grid_rule *row, const facts *f, const np_file_use *use) {
  draft out = {{0}, {0}};
  np_rule rule = row->rule;
  const bool is_said = use && (row->kind == OF_SIZE || (row->kind == OF_UP && use->has_up));
  if (is_said || !row->is_broken(f, &out)) return;
  if (use && row->kind == REPAIRABLE && use->load.policy == NEPH_IMPORT_REPAIR) {
    rule.severity = NEPH_SEVERITY_NOTE;
    rule.remedy = "mended by the scene's import: repair";
  }
  np_check_add(check, &rule, &out);
}

/* Checks a grid. Files of a sequence after the first skip rules about the whole sequence. */
static void check_grid(neph_check *check, const facts *f, bool is_first, const np_file_use *use) {
  check->grid = f->name;
  for (size_t i = 0; i < sizeof grid_rules / sizeof *grid_rules; i++) put_to_rule(check, &grid_rules[i], f, use);
  for (unsigned d = 0; is_first && d < f->diagnosis_count; d++) add_diagnosis(check, f->diagnoses[d]);
  check->grid = NULL;
}

/* ---- The file as a whole ---- */

static bool has_no_grid(const np_file_facts *file, draft *out) {
  return !file->count && !file->absence && np_draft_set(out, "it holds no grid");
}

static bool lacks_density(const np_file_facts *file, draft *out) {
  return file->count && file->refusal && np_draft_set(out, "%s", file->refusal);
}

static bool lacks_density_of_sequence(const np_file_facts *file, draft *out) {
  return file->absence && np_draft_set(out, "%s", file->absence);
}

static bool has_twins(const np_file_facts *file, draft *out) {
  for (size_t i = 0; i < file->count; i++)
    for (size_t j = 0; j < i; j++)
      if (!strcmp(file->grids[i].name, file->grids[j].name))
        return np_draft_set(out, "several grids are called '%s'", file->grids[i].name);
  return false;
}

static const struct {
  np_rule rule;
  bool (*is_broken)(const np_file_facts *file, draft *out);
  bool is_refused; /* whether a scene that needs its density refuses it */
} file_rules[] = {
    {{"file.no_grid", NEPH_SEVERITY_WARNING, NULL}, has_no_grid, true},
    {{"file.no_density", NEPH_SEVERITY_WARNING, NULL}, lacks_density, true},
    {{"sequence.no_density", NEPH_SEVERITY_WARNING,
      "export it in each frame; or clouds[].grid, where another is meant"},
     lacks_density_of_sequence,
     false},
    {{"file.same_names", NEPH_SEVERITY_NOTE, "clouds[].grid: \"name[0]\" names the first"}, has_twins, false},
};

static void check_facts(neph_check *check, const np_file_facts *file, bool is_first, const np_file_use *use) {
  for (size_t i = 0; i < sizeof file_rules / sizeof *file_rules; i++) {
    draft out = {{0}, {0}};
    np_rule rule = file_rules[i].rule;
    if (use && file_rules[i].is_refused) rule.severity = NEPH_SEVERITY_ERROR;
    if (file_rules[i].is_broken(file, &out)) np_check_add(check, &rule, &out);
  }
  for (size_t i = 0; i < file->count; i++) check_grid(check, &file->grids[i], is_first, use);
}

neph_result np_check_volume(neph_check *check, const char *path, bool is_first, const np_file_use *use,
                            np_file_facts *out_facts) {
  np_file_facts file = {.context = check->context};
  np_monitor monitor;
  neph_result result = neph_check_set_file(check, path);
  np_check_start_monitor(check, &monitor);
  if (!result) result = np_file_facts_measure(check->context, path, use, &monitor, &file);
  if (!result) check_facts(check, &file, is_first, use);
  if (out_facts)
    *out_facts = file;
  else
    np_file_facts_clear(&file);
  return np_check_pass(result);
}
