/* SPDX-License-Identifier: Apache-2.0 */
/* Frames of a sequence, each compared with the one before: a jump of a slowly changing quantity indicates a frame of
 * another simulation, another scale, or a truncated one. */
#include <string.h>

#include "check/check_volume.h"
#include "core/alloc.h"
#include "core/frame_name.h"

typedef np_finding_draft draft;

/* A frame and the one before it. */
typedef struct frame_pair {
  double number, number_before;
  np_file_facts now, before;
} frame_pair;

/* Grids of one name in both. */
typedef struct grid_pair {
  const np_grid_facts *now, *before;
  double number, number_before;
} grid_pair;

/* ---- Grids ---- */

static bool has_both(const grid_pair *p) {
  return p->now->active_count && p->before->active_count && p->now->is_affine && p->before->is_affine;
}

static bool has_other_voxels(const grid_pair *p, draft *out) {
  if (!p->now->is_affine || !p->before->is_affine) return false;
  for (int a = 0; a < 3; a++)
    if (fabs(p->now->voxel_m[a] - p->before->voxel_m[a]) > 1e-4 * p->before->voxel_m[a])
      return np_draft_set(out, "its voxels are %g × %g × %g, those of number %g %g × %g × %g", p->now->voxel_m[0],
                          p->now->voxel_m[1], p->now->voxel_m[2], p->number_before, p->before->voxel_m[0],
                          p->before->voxel_m[1], p->before->voxel_m[2]);
  return false;
}

static double get_size(const np_grid_facts *f) {
  double size = 0.0;
  for (int a = 0; a < 3; a++) size = fmax(size, f->world_max[a] - f->world_min[a]);
  return size;
}

/* Whether the box moves by more than half its size between two frames, or its size changes by a large factor. */
static bool has_jumping_box(const grid_pair *p, draft *out) {
  static const double factor = 2.0;
  if (!has_both(p) || p->now->role == NP_GRID_VECTOR) return false;
  const double now = get_size(p->now), before = get_size(p->before);
  double way = 0.0;
  for (int a = 0; a < 3; a++)
    way = fmax(way, 0.5 * fabs(p->now->world_min[a] + p->now->world_max[a] - p->before->world_min[a] -
                               p->before->world_max[a]));
  if (now > factor * before || before > factor * now)
    return np_draft_set(out, "its box is %.4g across, that of number %g %.4g", now, p->number_before, before);
  return way > 0.5 * fmax(now, before) &&
         np_draft_set(out, "its box has moved by %.4g since number %g, and is %.4g across", way, p->number_before, now);
}

static bool is_jump(double now, double before) {
  static const double factor = 4.0;
  return now > 0.0 && before > 0.0 && (now > factor * before || before > factor * now);
}

static bool has_jumping_sum(const grid_pair *p, draft *out) {
  return p->now->role == NP_GRID_DENSITY && is_jump(p->now->sum, p->before->sum) &&
         np_draft_set(out, "its values add up to %.4g, those of number %g to %.4g", p->now->sum, p->number_before,
                      p->before->sum);
}

static bool has_jumping_maximum(const grid_pair *p, draft *out) {
  const double now = (double)p->now->value_max, before = (double)p->before->value_max;
  return (p->now->role == NP_GRID_DENSITY || p->now->role == NP_GRID_FIELD) && is_jump(now, before) &&
         np_draft_set(out, "its largest value is %.4g, that of number %g %.4g", now, p->number_before, before);
}

static const struct {
  np_rule rule;
  bool (*is_broken)(const grid_pair *pair, draft *out);
} pair_rules[] = {
    {{"sequence.voxels", NEPH_SEVERITY_WARNING, "clouds[].reference_frame gives one scale to all frames"},
     has_other_voxels},
    {{"sequence.box", NEPH_SEVERITY_WARNING, "look at both frames; clouds[].reference_frame places all of them alike"},
     has_jumping_box},
    {{"sequence.sum", NEPH_SEVERITY_WARNING, "look at both frames: one may be of another simulation, or cut off"},
     has_jumping_sum},
    {{"sequence.maximum", NEPH_SEVERITY_WARNING, "look at both frames: one may be of another simulation, or scale"},
     has_jumping_maximum},
};

static const np_grid_facts *search_grid(const np_file_facts *file, const char *name) {
  for (size_t i = 0; i < file->count; i++)
    if (!strcmp(file->grids[i].name, name)) return &file->grids[i];
  return NULL;
}

static void compare_grids(neph_check *check, const frame_pair *frames) {
  static const np_rule comes = {"sequence.grid_comes", NEPH_SEVERITY_WARNING, "export the same grids in each frame"};
  for (size_t i = 0; i < frames->now.count; i++) {
    const np_grid_facts *now = &frames->now.grids[i];
    const grid_pair pair = {now, search_grid(&frames->before, now->name), frames->number, frames->number_before};
    draft out = {{0}, {0}};
    check->grid = now->name;
    if (!pair.before && np_draft_set(&out, "number %g has no such grid", frames->number_before))
      np_check_add(check, &comes, &out);
    for (size_t r = 0; pair.before && r < sizeof pair_rules / sizeof *pair_rules; r++)
      if (pair_rules[r].is_broken(&pair, &out)) np_check_add(check, &pair_rules[r].rule, &out);
  }
  check->grid = NULL;
}

static void search_gone(neph_check *check, const frame_pair *frames) {
  static const np_rule goes = {"sequence.grid_goes", NEPH_SEVERITY_WARNING, "export the same grids in each frame"};
  for (size_t i = 0; i < frames->before.count; i++) {
    draft out = {{0}, {0}};
    check->grid = frames->before.grids[i].name;
    if (search_grid(&frames->now, check->grid)) continue;
    np_draft_set(&out, "number %g had it, this file has not", frames->number_before);
    np_check_add(check, &goes, &out);
  }
  check->grid = NULL;
}

/* ---- Numbers ---- */

/* Interval between frames: the least distance of two. */
static double get_step(const np_frame_numbers *there) {
  double step = HUGE_VAL;
  for (size_t i = 1; i < there->count; i++) step = fmin(step, there->numbers[i] - there->numbers[i - 1]);
  return step;
}

static void check_gaps(neph_check *check, const np_frame_numbers *there) {
  static const np_rule rule = {"sequence.gap", NEPH_SEVERITY_WARNING,
                               "clouds[].missing: hold or loop shows another frame there"};
  const double step = get_step(there);
  for (size_t i = 1; i < there->count; i++) {
    const double first = there->numbers[i - 1] + step, last = there->numbers[i] - step;
    draft out = {{0}, {0}};
    if (last < first - 0.5 * step) continue;
    if (last > first)
      np_draft_set(&out, "numbers %g to %g are missing", first, last);
    else
      np_draft_set(&out, "number %g is missing", first);
    np_check_add(check, &rule, &out);
  }
}

/* ---- The sequence ---- */

typedef struct sequence {
  neph_check *check;
  const char *pattern;
  const np_file_use *use;
} sequence;

static neph_result check_frame(const sequence *of, bool is_first, frame_pair *frames) {
  neph_check *check = of->check;
  char *path = np_frame_name_make(check->context, of->pattern, frames->number);
  neph_result result = path ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_check_volume(check, path, is_first, of->use, &frames->now);
  np_alloc_free(check->context, path);
  if (result || is_first || !frames->now.count || !frames->before.count) return result;
  compare_grids(check, frames);
  search_gone(check, frames);
  return NEPH_OK;
}

static neph_result check_frames(const sequence *of, const np_frame_numbers *there) {
  frame_pair frames = {.number = 0.0};
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < there->count; i++) {
    frames.number_before = frames.number;
    frames.number = there->numbers[i];
    result = check_frame(of, i == 0, &frames);
    np_file_facts_clear(&frames.before);
    frames.before = frames.now;
  }
  np_file_facts_clear(&frames.before);
  return result;
}

/* Adds the number of files as a note, which reveals a wrong pattern. */
static void add_count(neph_check *check, const np_frame_numbers *there) {
  static const np_rule rule = {"sequence.files", NEPH_SEVERITY_NOTE, NULL};
  draft out = {{0}, {0}};
  np_draft_set(&out, "%zu files, numbers %g to %g", there->count, there->numbers[0], there->numbers[there->count - 1]);
  np_check_add(check, &rule, &out);
}

neph_result np_check_sequence(neph_check *check, const char *pattern, const np_file_use *use) {
  static const np_rule none = {"sequence.none", NEPH_SEVERITY_ERROR,
                               "#### stands for the number, %04d, $F4 and $F too"};
  np_frame_numbers there;
  draft out = {{0}, {0}};
  neph_result result = neph_check_set_file(check, pattern);
  if (!result) result = np_frame_name_list(check->context, pattern, &there);
  if (result) return np_check_pass(result);
  if (!there.count && np_draft_set(&out, "no file has a name of this pattern")) np_check_add(check, &none, &out);
  if (there.count) add_count(check, &there);
  check_gaps(check, &there);
  check->sequence = ++check->sequence_count;
  result = check_frames(&(sequence){check, pattern, use}, &there);
  check->sequence = 0;
  np_alloc_free(check->context, there.numbers);
  return result;
}
