/* SPDX-License-Identifier: Apache-2.0 */
/* Import of invalid values: refused or repaired, by the caller's policy. */
#include "volume/value_tally.h"
#include "volume/volume_file.h"

static void report(neph_context *context, neph_log_level level, const char *path, const np_sparse_grid *grid,
                   const np_value_tally *t, np_value_kind k, const char *consequence) {
  np_value_place at;
  np_value_tally_locate(grid, t->first[k], &at);
  np_log(context, level,
         "%s: grid '%s': %llu value%s %s, the first (%g) at voxel (%d, %d, %d), (%.6g, %.6g, %.6g) in the file's "
         "units; %s",
         path, grid->name, (unsigned long long)t->counts[k], t->counts[k] == 1 ? " is" : "s are",
         np_value_kind_names[k], (double)t->first_value[k], at.voxel[0], at.voxel[1], at.voxel[2], at.world_m[0],
         at.world_m[1], at.world_m[2], consequence);
}

/* Endings of messages about refused values, and about repaired infinities. */
static const struct {
  const char *refusal, *infinite;
} words[] = {
    [NP_VALUES_OF_CLOUD] = {"must be finite and not negative: clouds[].import: repair mends them",
                            "those above 0 are taken as the largest finite value"},
    [NP_VALUES_OF_VECTOR] = {"must be finite: clouds[].import: repair takes them as 0", "taken as 0"},
};

/* Logs one error for the first refused kind, or one warning for each repaired kind. */
static neph_result decide(neph_context *context, const char *path, const np_sparse_grid *grid, np_value_rule rule,
                          const np_value_tally *t, neph_import_policy policy) {
  for (np_value_kind k = NP_VALUE_NAN; k <= NP_VALUE_NEGATIVE; k++)
    if (t->counts[k] && policy == NEPH_IMPORT_REFUSE) {
      report(context, NEPH_LOG_ERROR, path, grid, t, k, words[rule].refusal);
      return NEPH_ERROR_BAD_FILE;
    }
  for (np_value_kind k = NP_VALUE_NAN; k < NP_VALUE_KINDS; k++)
    if (t->counts[k])
      report(context, NEPH_LOG_WARNING, path, grid, t, k, k == NP_VALUE_INFINITE ? words[rule].infinite : "taken as 0");
  return NEPH_OK;
}

neph_result np_volume_import_values(neph_context *context, const char *path, np_sparse_grid *grid, np_value_rule rule,
                                    neph_import_policy policy, np_monitor *monitor) {
  np_value_tally tally;
  const neph_result result = np_value_tally_count(grid, rule, true, monitor, &tally);
  return result ? result : decide(context, path, grid, rule, &tally, policy);
}

/* ---- Background ---- */

static bool is_same(float a, float b) { return a == b || (a != a && b != b); }

/* Sets inactive voxels with the value of the background to 0: they are outside of the cloud as well. */
static void clear_background(np_sparse_grid *grid) {
  const float background = grid->background;
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const bool is_active = grid->leaves[i].active[n / 64] >> (n % 64) & 1u;
      if (!is_active && is_same(grid->leaves[i].values[n], background)) grid->leaves[i].values[n] = 0.0f;
    }
  grid->background = 0.0f;
}

/* Refuses unmarked signed distances: the band outside of the surface, with 0 inside, would render as a shell. */
static neph_result check_distances(neph_context *context, const char *path, const np_sparse_grid *grid) {
  np_grid_extent extent;
  if (!np_sparse_grid_measure(grid, &extent) || !np_values_are_distances(grid->background, extent.value_min))
    return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE,
                 "%s: grid '%s' holds distances, from %g to a background of %g, without the class of a level set: "
                 "clouds[].level_set says how many voxels below its surface it is 1",
                 path, grid->name, (double)extent.value_min, (double)grid->background);
}

/* Warns only if values change: inactive tiles of 0 are already correct. */
neph_result np_volume_import_background(neph_context *context, const char *path, np_sparse_grid *grid,
                                        neph_import_policy policy) {
  if (grid->background == 0.0f) return NEPH_OK;
  const neph_result result = check_distances(context, path, grid);
  if (result) return result;
  if (policy == NEPH_IMPORT_REFUSE)
    return np_fail(
        context, NEPH_ERROR_BAD_FILE,
        "%s: grid '%s' has background %g, must be 0, where a cloud ends: clouds[].import: repair takes it as 0", path,
        grid->name, (double)grid->background);
  np_log(context, NEPH_LOG_WARNING, "%s: grid '%s' has background %g, taken as 0", path, grid->name,
         (double)grid->background);
  clear_background(grid);
  return NEPH_OK;
}

neph_result np_volume_import_finite_background(neph_context *context, const char *path, np_sparse_grid *grid,
                                               neph_import_policy policy) {
  if (isfinite(grid->background)) return NEPH_OK;
  if (policy == NEPH_IMPORT_REPAIR) return np_volume_import_background(context, path, grid, policy);
  return np_fail(context, NEPH_ERROR_BAD_FILE,
                 "%s: grid '%s' has background %g, must be finite: clouds[].import: repair takes it as 0", path,
                 grid->name, (double)grid->background);
}
