/* SPDX-License-Identifier: Apache-2.0 */
/* The spread of light over a picture by a pyramid of levels, each of half the size of the one before.
 *
 * A level is the mean over its cells, blurred by (1 4 6 4 1)/16 in both directions; coarser levels are interpolated
 * between the middles of cells. In pixels of the picture, the variances of the three, of boxes (4^j − 1)/12, of the
 * blur 4^j and of tents (4^j − 1)/4, come to σ² = (4^(j+1) − 1)/3.
 */
#include "image/glare.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/math.h"
#include "core/units.h"

enum { LEVELS_MAX = 18, MARGIN = 2, COLOURS = 3 };

typedef struct level {
  size_t width, height;
  float *light; /* means over cells */
  float *veil;  /* weighted sum of this level and the coarser ones */
  float weight;
} level;

typedef struct glare {
  const neph_image *image;
  const np_preview_planes *planes;
  bool is_parallel;
  unsigned count;
  level levels[LEVELS_MAX];
  unsigned at; /* level of the pass */
  float *scratch;
  size_t scratch_size; /* floats of a thread */
} glare;

/* ---- Weights ---- */

/* Light in an octave of σ in radians, to a factor. */
static double weigh_octave(double sigma) {
  static const double core = 0.03 * NP_DEGREE, reach = 20.0 * NP_DEGREE;
  const double below = core / sigma, above = sigma / reach;
  return pow(sigma, -0.2) * exp(-0.5 * (below * below + above * above));
}

/* Octaves that hold light: from far below the core of the smallest pixel to far above the reach. */
enum { OCTAVE_FIRST = -40, OCTAVE_LAST = 40 };

/* Weights of the levels, which are scaled to `share` in all with the Gaussians below the pixel. The coarsest level has
 * all that is wider. Returns the share below the pixel. */
static double fill_weights(glare *g, double share, double pixel_rad) {
  double sum = 0.0, below = 0.0, weights[LEVELS_MAX] = {0};
  for (int j = OCTAVE_FIRST; j <= OCTAVE_LAST; j++) {
    const double pixels = j < 0 ? exp2(j) * sqrt(4.0 / 3.0) : sqrt((exp2(2 * (j + 1)) - 1.0) / 3.0);
    const double weight = weigh_octave(pixels * pixel_rad);
    const unsigned at = j < 0 ? 0u : (unsigned)j < g->count ? (unsigned)j : g->count - 1;
    sum += weight;
    *(j < 0 ? &below : &weights[at]) += weight;
  }
  for (unsigned j = 0; j < g->count; j++) g->levels[j].weight = (float)(share * weights[j] / sum);
  return share * below / sum;
}

/* ---- Rows ---- */

static float *get_row(float *rgb, const level *l, size_t y) { return rgb + COLOURS * l->width * y; }

static void add_row(float *out, const float *row, float weight, size_t count) {
  for (size_t i = 0; i < count; i++) out[i] += weight * row[i];
}

/* Place i of a line of `count`, mirrored at its ends. */
static size_t mirror(ptrdiff_t i, ptrdiff_t count) {
  while (i < 0 || i >= count) i = i < 0 ? -1 - i : 2 * count - 1 - i;
  return (size_t)i;
}

static float *get_scratch(const glare *g, unsigned thread) { return g->scratch + g->scratch_size * thread; }

/* Pixels of the picture that scatter. */
static neph_result fill_first(void *user, size_t begin, size_t end, unsigned thread) {
  glare *g = user;
  const level *l = &g->levels[0];
  (void)thread;
  for (size_t i = begin * l->width; i < end * l->width; i++) {
    float *out = l->light + COLOURS * i;
    np_preview_get_pixel(g->planes, i, out);
    const bool is_finite = isfinite(out[0]) && isfinite(out[1]) && isfinite(out[2]);
    for (int c = 0; c < COLOURS; c++) out[c] = is_finite ? np_maxf(out[c], 0.0f) : 0.0f;
  }
  return NEPH_OK;
}

/* Shares of the fine cells in a coarse one. */
typedef struct overlap {
  size_t first, count;
  float weight[4];
} overlap;

static overlap get_overlap(size_t coarse, size_t fine_count, size_t coarse_count) {
  const double ratio = (double)fine_count / (double)coarse_count, begin = ratio * (double)coarse, end = begin + ratio;
  overlap o = {.first = (size_t)begin};
  for (size_t i = o.first; i < fine_count && (double)i < end - 1e-9 && o.count < 4; i++)
    o.weight[o.count++] = (float)((fmin(end, (double)i + 1.0) - fmax(begin, (double)i)) / ratio);
  return o;
}

/* Rows of the level `at` from the level before it. */
static neph_result reduce_rows(void *user, size_t begin, size_t end, unsigned thread) {
  glare *g = user;
  const level *fine = &g->levels[g->at - 1], *coarse = &g->levels[g->at];
  float *sums = get_scratch(g, thread);
  for (size_t y = begin; y < end; y++) {
    const overlap rows = get_overlap(y, fine->height, coarse->height);
    memset(sums, 0, COLOURS * fine->width * sizeof *sums);
    for (size_t k = 0; k < rows.count; k++)
      add_row(sums, get_row(fine->light, fine, rows.first + k), rows.weight[k], COLOURS * fine->width);
    for (size_t x = 0; x < coarse->width; x++) {
      const overlap columns = get_overlap(x, fine->width, coarse->width);
      float *out = get_row(coarse->light, coarse, y) + COLOURS * x;
      for (int c = 0; c < COLOURS; c++) out[c] = 0.0f;
      for (size_t k = 0; k < columns.count; k++)
        add_row(out, sums + COLOURS * (columns.first + k), columns.weight[k], COLOURS);
    }
  }
  return NEPH_OK;
}

/* Blurs a row of a level and stores it times the level's weight. */
static void blur_row(const level *l, size_t y, float *scratch) {
  static const float taps[5] = {1 / 16.0f, 4 / 16.0f, 6 / 16.0f, 4 / 16.0f, 1 / 16.0f};
  const size_t count = COLOURS * l->width;
  float *middle = scratch + COLOURS * MARGIN, *out = get_row(l->veil, l, y);
  memset(middle, 0, count * sizeof *middle);
  for (int k = -MARGIN; k <= MARGIN; k++)
    add_row(middle, get_row(l->light, l, mirror((ptrdiff_t)y + k, (ptrdiff_t)l->height)), taps[k + MARGIN], count);
  for (ptrdiff_t k = 1; k <= MARGIN; k++) {
    const ptrdiff_t width = (ptrdiff_t)l->width;
    memcpy(middle - COLOURS * k, middle + COLOURS * mirror(-k, width), COLOURS * sizeof *middle);
    memcpy(middle + COLOURS * (width - 1 + k), middle + COLOURS * mirror(width - 1 + k, width),
           COLOURS * sizeof *middle);
  }
  memset(out, 0, count * sizeof *out);
  for (size_t k = 0; k < 5; k++) add_row(out, scratch + COLOURS * k, l->weight * taps[k], count);
}

/* Place between two cells of a coarser line. */
typedef struct between {
  size_t low, high;
  float share; /* weight of `high`; `low` has 1 − share */
} between;

static between get_between(size_t fine, size_t fine_count, size_t coarse_count) {
  const float place = ((float)fine + 0.5f) * (float)coarse_count / (float)fine_count - 0.5f;
  const float inside = np_clampf(place, 0.0f, (float)(coarse_count - 1));
  const size_t low = (size_t)inside;
  return (between){low, low + 1 < coarse_count ? low + 1 : low, inside - (float)low};
}

/* Adds the veil of the coarser levels to a row. */
static void add_coarser(const level *fine, const level *coarse, size_t y, float *scratch) {
  const between rows = get_between(y, fine->height, coarse->height);
  const size_t count = COLOURS * coarse->width;
  float *out = get_row(fine->veil, fine, y);
  memset(scratch, 0, count * sizeof *scratch);
  add_row(scratch, get_row(coarse->veil, coarse, rows.low), 1.0f - rows.share, count);
  add_row(scratch, get_row(coarse->veil, coarse, rows.high), rows.share, count);
  for (size_t x = 0; x < fine->width; x++) {
    const between columns = get_between(x, fine->width, coarse->width);
    add_row(out + COLOURS * x, scratch + COLOURS * columns.low, 1.0f - columns.share, COLOURS);
    add_row(out + COLOURS * x, scratch + COLOURS * columns.high, columns.share, COLOURS);
  }
}

/* Rows of the veil of the level `at`. */
static neph_result spread_rows(void *user, size_t begin, size_t end, unsigned thread) {
  glare *g = user;
  for (size_t y = begin; y < end; y++) {
    blur_row(&g->levels[g->at], y, get_scratch(g, thread));
    if (g->at + 1 < g->count) add_coarser(&g->levels[g->at], &g->levels[g->at + 1], y, get_scratch(g, thread));
  }
  return NEPH_OK;
}

/* ---- The pyramid ---- */

static neph_result run_pass(glare *g, unsigned at, np_parallel_fn work) {
  g->at = at;
  const size_t height = g->levels[at].height;
  return g->is_parallel ? np_parallel_for(g->image->context, NULL, height, 8, work, g) : work(g, 0, height, 0);
}

/* Levels down to a single cell. */
static neph_result allocate(glare *g) {
  neph_context *context = g->image->context;
  size_t width = g->image->width, height = g->image->height;
  g->scratch_size = COLOURS * (width + 2 * MARGIN);
  g->scratch = np_alloc(context, g->is_parallel ? context->thread_count : 1, g->scratch_size * sizeof(float));
  bool is_complete = g->scratch;
  for (bool is_last = false; is_complete && !is_last && g->count < LEVELS_MAX;) {
    level *l = &g->levels[g->count++];
    *l = (level){.width = width, .height = height};
    l->light = np_alloc(context, width * height, COLOURS * sizeof(float));
    l->veil = l->light ? np_alloc(context, width * height, COLOURS * sizeof(float)) : NULL;
    is_complete = l->veil;
    is_last = width == 1 && height == 1;
    width = (width + 1) / 2, height = (height + 1) / 2;
  }
  return is_complete ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void release(glare *g) {
  for (unsigned j = 0; j < g->count; j++) {
    np_alloc_free(g->image->context, g->levels[j].light);
    np_alloc_free(g->image->context, g->levels[j].veil);
  }
  np_alloc_free(g->image->context, g->scratch);
}

neph_result np_glare_create(const neph_image *image, double share, double pixel_rad, bool is_parallel,
                            np_preview_planes *planes) {
  glare g = {.image = image, .planes = planes, .is_parallel = is_parallel};
  neph_result result = allocate(&g);
  if (!result) result = run_pass(&g, 0, fill_first);
  const double below = result ? 0.0 : fill_weights(&g, share, pixel_rad);
  for (unsigned j = 1; j < g.count && !result; j++) result = run_pass(&g, j, reduce_rows);
  for (unsigned j = g.count; j-- > 0 && !result;) result = run_pass(&g, j, spread_rows);
  if (!result) {
    planes->veil = g.levels[0].veil;
    planes->kept_share = (float)(1.0 - share + below);
    g.levels[0].veil = NULL;
  }
  release(&g);
  return result;
}

void np_glare_destroy(const neph_image *image, np_preview_planes *planes) {
  np_alloc_free(image->context, planes->veil);
  planes->veil = NULL;
}

/* The first column of worldToNDC gives x · w, the last w, the depth of a perspective picture: without its share of w,
 * the first is as long as 1/(2 tan(fov/2)). */
double np_glare_get_pixel_rad(const neph_image *image) {
  const np_image_header *h = &image->header;
  const float *m = h->world_to_ndc;
  const double across[3] = {(double)m[0], (double)m[4], (double)m[8]},
               depth[3] = {(double)m[3], (double)m[7], (double)m[11]};
  const double width = h->has_window ? h->display_max[0] - h->display_min[0] + 1.0 : (double)image->width;
  double along = 0.0, squared = 0.0, length = 0.0;
  for (int i = 0; i < 3; i++) along += across[i] * depth[i], length += depth[i] * depth[i];
  if (!h->has_ndc || !(fabs(length - 1.0) < 1e-3) || !(width >= 1.0)) return 0.0;
  for (int i = 0; i < 3; i++) squared += (across[i] - along * depth[i]) * (across[i] - along * depth[i]);
  const double angle = 1.0 / (sqrt(squared) * width);
  return isfinite(angle) && angle < 1.0 ? angle : 0.0;
}
