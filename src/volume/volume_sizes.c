/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_sizes.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/brick_periods.h"
#include "volume/grid_reader.h"
#include "volume/volume_split.h"

/* Diameters of the fit to Mie theory (optics/phase.h). */
static const double diameter_min_m = 5e-6, diameter_max_m = 50e-6;

/* Neighbouring nodes differ by no larger a factor, unless there would be too many of them. */
static const double factor_max = 1.25;

/* Share of the extinction whose droplets may be smaller than all nodes, and larger than all. */
static const double tail = 0.005;

/* Share of a node below which its neighbour takes it. */
static const float least_share = 0x1p-11f;

enum { BINS = 512 };

/* Extinction by diameter. Weights are whole numbers, so that their sums do not depend on the number of threads. */
typedef struct size_tally {
  uint64_t voxels, missing, limited; /* limited: beyond the fit */
  double low_m, high_m;
  uint64_t weight[BINS];
} size_tally;

/* Diameters of a block of 8³ voxels; 0 where the density is 0. */
typedef struct size_block {
  float diameter_m[NP_LEAF_SIZE];
} size_block;

typedef struct size_build {
  neph_context *context;
  const np_sizes_source *source;
  np_split split;
  np_sparse_grid radius;
  np_affine to_radius; /* maps from index positions of the density */
  size_block *blocks;  /* one for each of the split's */
  size_tally *tallies; /* one for each thread */
  size_tally all;
  unsigned count;
  double nodes_m[NP_SIZE_NODES_MAX];
} size_build;

/* ---- Nodes ---- */

static double get_place(double diameter_m) { return 1.0 / sqrt(diameter_m); }

unsigned np_size_nodes_place(double low_m, double high_m, double out_m[NP_SIZE_NODES_MAX]) {
  const double first = get_place(low_m), last = get_place(high_m);
  unsigned count = high_m > low_m ? 2 : 1;
  while (count > 1 && count < NP_SIZE_NODES_MAX && log(high_m / low_m) > (count - 1) * log(factor_max)) count++;
  for (unsigned k = 0; k < count; k++) {
    const double place = count > 1 ? first + (last - first) * k / (count - 1) : first;
    out_m[k] = 1.0 / (place * place);
  }
  out_m[0] = low_m;
  out_m[count - 1] = high_m;
  return count;
}

void np_size_nodes_share(const double nodes_m[], unsigned count, double diameter_m, float out[NP_TINT_PARTS_MAX]) {
  memset(out, 0, NP_TINT_PARTS_MAX * sizeof *out);
  unsigned k = 0;
  while (k + 2 < count && diameter_m >= nodes_m[k + 1]) k++;
  if (count == 1 || diameter_m <= nodes_m[0]) {
    out[0] = 1.0f;
    return;
  }
  const double low = get_place(nodes_m[k]), high = get_place(nodes_m[k + 1]);
  const float share = np_clampf((float)((get_place(diameter_m) - low) / (high - low)), 0.0f, 1.0f);
  const float upper = share < least_share ? 0.0f : share > 1.0f - least_share ? 1.0f : share;
  out[k] = 1.0f - upper;
  out[k + 1] = upper;
}

/* ---- Sizes ---- */

/* Position in the grid of radii; copies of a period have the sizes of the first. */
static np_dvec3 locate(const size_build *b, size_t i, int n) {
  const double *period = b->source->density->bricks.field_period;
  np_dvec3 index = np_split_get_index(&b->split, i, n);
  if (period[0] > 0.0) index.x = np_brick_wrap_position(index.x, period[0]);
  if (period[1] > 0.0) index.y = np_brick_wrap_position(index.y, period[1]);
  return np_affine_point(&b->to_radius, index);
}

static unsigned get_bin(double diameter_m) {
  const double low = get_place(diameter_min_m), high = get_place(diameter_max_m);
  const int bin = (int)(BINS * (get_place(diameter_m) - low) / (high - low));
  return (unsigned)(bin < 0 ? 0 : bin >= BINS ? BINS - 1 : bin);
}

static void read_size(const size_build *b, np_grid_reader *reader, size_t i, int n, size_tally *tally) {
  const float density = np_split_get_density(&b->split, i, n);
  float radius_um;
  if (!(density > 0.0f)) return;
  const bool is_known = np_grid_read_between(reader, locate(b, i, n), &radius_um) && radius_um > 0.0f;
  const double own_m = is_known ? 2e-6 * (double)radius_um : b->source->diameter_m;
  const double diameter_m = fmin(fmax(own_m, diameter_min_m), diameter_max_m);
  b->blocks[i].diameter_m[n] = (float)diameter_m;
  tally->voxels++;
  tally->missing += !is_known;
  tally->limited += diameter_m != own_m;
  tally->low_m = fmin(tally->low_m, diameter_m);
  tally->high_m = fmax(tally->high_m, diameter_m);
  tally->weight[get_bin(diameter_m)] += (uint64_t)(0x1p24f * (density / b->source->density->bricks.value_max));
}

static neph_result read_blocks(void *user, size_t begin, size_t end, unsigned thread) {
  const size_build *b = user;
  np_grid_reader reader = {.grid = &b->radius};
  for (size_t i = begin; i < end; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) read_size(b, &reader, i, n, &b->tallies[thread]);
  return NEPH_OK;
}

static void unite_tallies(size_build *b) {
  size_tally *all = &b->all;
  for (unsigned i = 0; i < b->context->thread_count; i++) {
    const size_tally *t = &b->tallies[i];
    all->voxels += t->voxels, all->missing += t->missing, all->limited += t->limited;
    all->low_m = fmin(all->low_m, t->low_m);
    all->high_m = fmax(all->high_m, t->high_m);
    for (int k = 0; k < BINS; k++) all->weight[k] += t->weight[k];
  }
}

/* Nodes hold all of the sizes but the tails of the extinction: a few odd voxels at an edge widen no interval. */
static void place_nodes(size_build *b) {
  const double first = get_place(diameter_min_m), last = get_place(diameter_max_m);
  uint64_t sum = 0, below = 0, above = 0;
  int low = 0, high = BINS - 1;
  for (int k = 0; k < BINS; k++) sum += b->all.weight[k];
  while (low < high && (double)(below + b->all.weight[low]) <= tail * (double)sum) below += b->all.weight[low++];
  while (high > low && (double)(above + b->all.weight[high]) <= tail * (double)sum) above += b->all.weight[high--];
  const double from = first + (last - first) * low / BINS, to = first + (last - first) * (high + 1) / BINS;
  b->count =
      np_size_nodes_place(fmax(b->all.low_m, 1.0 / (from * from)), fmin(b->all.high_m, 1.0 / (to * to)), b->nodes_m);
}

static void report(const size_build *b) {
  const size_tally *t = &b->all;
  const char *path = b->source->path, *name = b->radius.name;
  np_log(b->context, NEPH_LOG_INFO, "%s: grid '%s': droplets of %.3g to %.3g um in diameter, as %u %s", path, name,
         1e6 * t->low_m, 1e6 * t->high_m, b->count, b->count == 1 ? "phase function" : "phase functions");
  if (t->missing)
    np_log(b->context, NEPH_LOG_WARNING,
           "%s: grid '%s': %" PRIu64 " of %" PRIu64 " voxels of the cloud have no radius above 0: their droplets are "
           "%.3g um in diameter",
           path, name, t->missing, t->voxels, 1e6 * b->source->diameter_m);
  if (t->limited)
    np_log(b->context, NEPH_LOG_WARNING,
           "%s: grid '%s': %" PRIu64 " of %" PRIu64 " voxels of the cloud have droplets beyond the 5 to 50 um of the "
           "phase functions, whose nearest they get",
           path, name, t->limited, t->voxels);
}

static neph_result read_sizes(size_build *b) {
  np_affine to_index;
  const size_tally none = {.low_m = diameter_max_m, .high_m = diameter_min_m};
  if (!np_affine_invert(&b->radius.index_to_world, &to_index))
    return np_fail(b->context, NEPH_ERROR_BAD_FILE, "%s: grid '%s': its transform cannot be inverted", b->source->path,
                   b->radius.name);
  b->to_radius = np_affine_compose(&to_index, &b->source->density->index_to_world);
  b->tallies = np_alloc(b->context, b->context->thread_count, sizeof *b->tallies);
  if (!b->tallies) return NEPH_ERROR_OUT_OF_MEMORY;
  b->all = none;
  for (unsigned i = 0; i < b->context->thread_count; i++) b->tallies[i] = none;
  const neph_result result = np_parallel_for(b->context, b->split.monitor, b->split.block_count, 16, read_blocks, b);
  unite_tallies(b);
  return result;
}

/* ---- Parts ---- */

static void compute_shares(const void *user, size_t block, int n, float out[NP_TINT_PARTS_MAX]) {
  const size_build *b = user;
  np_size_nodes_share(b->nodes_m, b->count, (double)b->blocks[block].diameter_m[n], out);
}

/* Builds the parts by droplet size; a cloud of one size is its own single part. */
static neph_result build_parts(size_build *b, np_tint *out) {
  neph_result result = NEPH_OK;
  for (unsigned k = 0; k < b->count && !result; k++) {
    np_tint_part part = {.color = {1.0, 1.0, 1.0}, .diameter_m = b->nodes_m[k]};
    if (b->count > 1) result = np_split_make_part(&b->split, k, &part.volume);
    if (!result && (part.volume || b->count == 1)) out->parts[out->count++] = part;
  }
  return result;
}

static neph_result build(size_build *b, np_tint *out) {
  neph_result result = np_split_start(&b->split, b->source->path, "phase.droplets.sizes");
  if (!result) b->blocks = np_alloc(b->context, b->split.block_count, sizeof *b->blocks);
  if (!result) result = b->blocks ? read_sizes(b) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result && b->all.voxels > 0) {
    place_nodes(b);
    report(b);
    result = build_parts(b, out);
  }
  np_alloc_free(b->context, b->tallies);
  np_alloc_free(b->context, b->blocks);
  np_split_clear(&b->split);
  return result;
}

static neph_result create(size_build *b, np_tint **out_tint) {
  np_tint *tint = np_alloc(b->context, 1, sizeof *tint);
  if (!tint) return NEPH_ERROR_OUT_OF_MEMORY;
  tint->context = b->context;
  tint->kind = NP_PARTS_OF_SIZES;
  const neph_result result = build(b, tint);
  if (!result && tint->count > 0)
    *out_tint = tint;
  else
    np_tint_destroy(tint);
  return result;
}

/* ---- Entry ---- */

/* Radii in metres, and values of another kind, would all be too small. */
static neph_result check_unit(const size_build *b) {
  static const double least_um = 1.0;
  np_grid_extent extent;
  if (!np_sparse_grid_measure(&b->radius, &extent) || !(extent.value_max > 0.0f)) return NEPH_OK;
  if ((double)extent.value_max >= least_um) return NEPH_OK;
  return np_fail(b->context, NEPH_ERROR_BAD_FILE,
                 "%s: grid '%s' reaches %.3g, must hold effective radii in um; clouds[].phase.droplets.sizes: none "
                 "leaves it out",
                 b->source->path, b->radius.name, (double)extent.value_max);
}

neph_result np_tint_create_sizes(neph_context *context, const np_sizes_source *source, np_monitor *monitor,
                                 np_tint **out_tint) {
  size_build b = {.context = context, .source = source};
  b.split = (np_split){.context = context,
                       .density = source->density,
                       .precision = source->load->precision,
                       .monitor = monitor,
                       .compute_shares = compute_shares,
                       .user = &b};
  neph_volume_load_desc load = *source->load;
  bool has_content = false;
  load.grid = source->grid ? source->grid : NP_SIZES_USUAL_NAME;
  *out_tint = NULL;
  neph_result result = np_volume_load_field_grid(context, source->path, &load, source->grid ? NP_SIZES_KEY : NULL,
                                                 &b.radius, &has_content);
  if (!result && has_content) result = check_unit(&b);
  if (!result && has_content) result = create(&b, out_tint);
  np_sparse_grid_clear(&b.radius);
  return result;
}
