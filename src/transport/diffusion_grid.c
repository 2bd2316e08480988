/* SPDX-License-Identifier: Apache-2.0 */
/* Grids of the diffusion equation. With the names of diffusion_correction.c: cells with extinction and their links
 * c = A / (3/2·Σ t + ε), ε = 0.05; beyond the cloud lies vacuum, by Marshak's condition: c = A / (3/2·t + 2). Coarser
 * grids have aggregates of 2×2×2 cells, whose links are the sums of the cells', halved, as aggregates are stiffer than
 * what they represent.
 */
#include <string.h>

#include "core/alloc.h"
#include "core/math.h"
#include "core/parallel.h"
#include "transport/diffusion_system.h"

enum { COARSEST = 200, UNKNOWNS_PER_PIECE = 4096 };

static const float link_least = 0.05f, coarse_link_share = 0.5f;

/* Optical depth of a cell above which a correction is smoothed twice: after one smoothing, the iteration still
 * diverges. */
static const float twice_smoothed_depth = 10.0f;

/* ---- Grids ---- */

static neph_result allocate_level(neph_context *context, int32_t count, np_diffusion_level *out) {
  const size_t n = (size_t)count;
  out->count = count;
  out->cell = np_alloc(context, n, sizeof *out->cell);
  out->neighbour = np_alloc(context, n, NP_DIFFUSION_FACES * sizeof *out->neighbour);
  out->link = np_alloc(context, n, NP_DIFFUSION_FACES * sizeof *out->link);
  out->inverse = np_alloc(context, n, sizeof *out->inverse);
  out->x = np_alloc(context, n + 1, sizeof *out->x);
  out->right = np_alloc(context, n + 1, sizeof *out->right);
  const bool is_whole = out->cell && out->neighbour && out->link && out->inverse && out->x && out->right;
  return is_whole ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void clear_level(neph_context *context, np_diffusion_level *l) {
  np_alloc_free(context, l->cell);
  np_alloc_free(context, l->neighbour);
  np_alloc_free(context, l->child);
  np_alloc_free(context, l->link);
  np_alloc_free(context, l->inverse);
  np_alloc_free(context, l->x);
  np_alloc_free(context, l->right);
}

static void split(const int32_t size[3], int32_t cell, int32_t out_at[3]) {
  out_at[0] = cell % size[0];
  out_at[1] = cell / size[0] % size[1];
  out_at[2] = cell / size[0] / size[1];
}

/* Numbers the cells of one colour that `number` marks by 0. */
static int32_t number_colour(np_diffusion_level *l, int32_t *number, int32_t colour, int32_t count) {
  int32_t cell = 0;
  for (int32_t k = 0; k < l->size[2]; k++)
    for (int32_t j = 0; j < l->size[1]; j++, cell += l->size[0])
      for (int32_t i = (j + k + colour) & 1; i < l->size[0]; i += 2) {
        if (number[cell + i] < 0) continue;
        l->cell[count] = cell + i;
        number[cell + i] = count++;
      }
  return count;
}

/* Numbers the cells that `number` marks by 0, red ones first, and lists them; the others stay −1. */
static void number_cells(np_diffusion_level *l, int32_t *number) {
  l->red_count = number_colour(l, number, 0, 0);
  (void)number_colour(l, number, 1, l->red_count);
}

static void choose_colouring(const np_transport_grid *grid, np_diffusion_level *l) {
  l->is_coloured = true;
  for (int a = 0; a < 3; a++)
    if (grid->is_wrapped[a] && l->size[a] > 1 && l->size[a] % 2) l->is_coloured = false;
}

/* ---- The finest level ---- */

static float get_ratio(const np_transport_grid *g, int32_t active, unsigned degree) {
  return g->ratio[(size_t)active * (g->degree + 1) + degree];
}

/* Transport depth of a cell beyond which the diffusion equation corrects more than diamond differences carry, and
 * grows: with links that no longer fall it converges, in more sweeps. */
static const float link_depth_max = 3.0f;

/* Transport optical depth of a cell along an axis, limited to link_depth_max. */
static float compute_depth(const np_transport_grid *g, int32_t active, int axis, int32_t at) {
  const float width = (float)np_transport_grid_width(g, axis, at);
  return fminf((1.0f - get_ratio(g, active, 1)) * g->extinction[active] * width, link_depth_max);
}

/* One face of an unknown; `number` maps active cells to unknowns. */
static void link_face(np_diffusion *d, const int32_t *number, int32_t unknown, const int32_t at[3], float area,
                      unsigned face) {
  const np_transport_grid *g = d->grid;
  np_diffusion_level *l = &d->levels[0];
  const int axis = (int)face / 2;
  const int32_t active = d->active[unknown], other = np_transport_grid_neighbour(g, at, axis, face & 1u ? 1 : -1);
  const float own = compute_depth(g, active, axis, at[axis]);
  int32_t *neighbour = &l->neighbour[NP_DIFFUSION_FACES * unknown + (int32_t)face];
  float *link = &l->link[NP_DIFFUSION_FACES * unknown + (int32_t)face];
  *neighbour = other < 0 || number[other] < 0 ? l->count : number[other];
  if (*neighbour == unknown) { /* a period of one cell */
    *neighbour = l->count;
  } else if (*neighbour == l->count) {
    *link = area / (1.5f * own + 2.0f);
  } else {
    int32_t there[3];
    np_transport_grid_split(g, g->cell[other], there);
    *link = area / (1.5f * (own + compute_depth(g, other, axis, there[axis])) + link_least);
  }
}

static void link_unknown(np_diffusion *d, const int32_t *number, int32_t unknown) {
  const np_transport_grid *g = d->grid;
  const int32_t active = d->active[unknown];
  int32_t at[3];
  np_transport_grid_split(g, g->cell[active], at);
  float width[3], diagonal = (1.0f - get_ratio(g, active, 0)) * g->extinction[active];
  for (int a = 0; a < 3; a++) diagonal *= width[a] = (float)np_transport_grid_width(g, a, at[a]);
  for (unsigned face = 0; face < NP_DIFFUSION_FACES; face++) {
    const float area = width[(face / 2 + 1) % 3] * width[(face / 2 + 2) % 3];
    link_face(d, number, unknown, at, area, face);
    diagonal += d->levels[0].link[NP_DIFFUSION_FACES * unknown + (int32_t)face];
  }
  d->levels[0].inverse[unknown] = diagonal > 0.0f ? 1.0f / diagonal : 0.0f;
}

typedef struct link_job {
  np_diffusion *diffusion;
  const int32_t *number;
} link_job;

static neph_result link_unknowns(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const link_job *job = user;
  for (size_t u = begin; u < end; u++) link_unknown(job->diffusion, job->number, (int32_t)u);
  return NEPH_OK;
}

static float compute_deepest(const np_transport_grid *g) {
  float deepest = 0.0f, widest = 0.0f;
  for (int a = 0; a < 3; a++)
    for (int32_t n = 0; n < g->size[a]; n++) widest = np_maxf(widest, (float)np_transport_grid_width(g, a, n));
  for (size_t i = 0; i < g->active_count; i++) {
    if (!(g->extinction[i] * widest > deepest)) continue;
    int32_t at[3];
    np_transport_grid_split(g, g->cell[i], at);
    for (int a = 0; a < 3; a++)
      deepest = fmaxf(deepest, g->extinction[i] * (float)np_transport_grid_width(g, a, at[a]));
  }
  return deepest;
}

/* `number` and `cell_number` are scratch, of the active cells and of all. */
static void fill_finest(np_diffusion *d, int32_t *number, int32_t *cell_number) {
  const np_transport_grid *g = d->grid;
  np_diffusion_level *l = &d->levels[0];
  memcpy(l->size, g->size, sizeof l->size);
  for (size_t c = 0; c < np_transport_grid_count(g); c++)
    cell_number[c] = g->active[c] >= 0 && g->extinction[g->active[c]] > 0.0f ? 0 : -1;
  number_cells(l, cell_number);
  choose_colouring(g, l);
  for (size_t i = 0; i < g->active_count; i++) number[i] = cell_number[g->cell[i]];
  for (int32_t u = 0; u < l->count; u++) d->active[u] = g->active[l->cell[u]];
  link_job job = {d, number};
  (void)np_parallel_for(g->context, NULL, (size_t)l->count, UNKNOWNS_PER_PIECE, link_unknowns, &job);
}

/* ---- Coarser levels ---- */

static int32_t get_parent_cell(const np_diffusion_level *fine, const np_diffusion_level *coarse, int32_t unknown) {
  int32_t at[3];
  split(fine->size, fine->cell[unknown], at);
  return (at[2] / 2 * coarse->size[1] + at[1] / 2) * coarse->size[0] + at[0] / 2;
}

/* Counts the coarse cells that hold unknowns, marked by 0. */
static int32_t mark_parents(const np_diffusion_level *fine, const np_diffusion_level *coarse, int32_t *number,
                            size_t cells) {
  int32_t count = 0;
  for (size_t c = 0; c < cells; c++) number[c] = -1;
  for (int32_t u = 0; u < fine->count; u++) {
    int32_t *mark = &number[get_parent_cell(fine, coarse, u)];
    count += *mark < 0;
    *mark = 0;
  }
  return count;
}

/* A level, and the coarser one whose links are sums of its links. */
typedef struct link_sums {
  const np_diffusion_level *fine;
  const int32_t *number; /* unknowns of the coarser level, by cell */
  np_diffusion_level *coarse;
} link_sums;

/* Sums an aggregate's links to others, and the parts of its cells' diagonals that are not links within it. */
static void sum_links(const link_sums *c, int32_t parent) {
  const np_diffusion_level *fine = c->fine, *coarse = c->coarse;
  int32_t *neighbour = coarse->neighbour + NP_DIFFUSION_FACES * parent;
  float *link = coarse->link + NP_DIFFUSION_FACES * parent, diagonal = 0.0f;
  for (int32_t face = 0; face < NP_DIFFUSION_FACES; face++) neighbour[face] = coarse->count;
  for (int32_t i = 0; i < NP_DIFFUSION_CHILDREN; i++) {
    const int32_t u = coarse->child[NP_DIFFUSION_CHILDREN * parent + i];
    if (u == fine->count) break;
    float rest = fine->inverse[u] > 0.0f ? 1.0f / fine->inverse[u] : 0.0f;
    for (int32_t face = 0; face < NP_DIFFUSION_FACES; face++) {
      const int32_t other = fine->neighbour[NP_DIFFUSION_FACES * u + face];
      if (other == fine->count) continue;
      const float own = fine->link[NP_DIFFUSION_FACES * u + face];
      const int32_t next = c->number[get_parent_cell(fine, coarse, other)];
      rest -= own;
      if (next == parent) continue;
      neighbour[face] = next;
      link[face] += coarse_link_share * own;
    }
    diagonal += np_maxf(rest, 0.0f);
  }
  for (int32_t face = 0; face < NP_DIFFUSION_FACES; face++) diagonal += link[face];
  coarse->inverse[parent] = diagonal > 0.0f ? 1.0f / diagonal : 0.0f;
}

static neph_result sum_all_links(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const link_sums *c = user;
  for (size_t parent = begin; parent < end; parent++) sum_links(c, (int32_t)parent);
  return NEPH_OK;
}

static void list_children(const link_sums *c) {
  const np_diffusion_level *fine = c->fine, *coarse = c->coarse;
  for (int32_t i = 0; i < NP_DIFFUSION_CHILDREN * coarse->count; i++) coarse->child[i] = fine->count;
  for (int32_t u = 0; u < fine->count; u++) {
    int32_t *child = coarse->child + NP_DIFFUSION_CHILDREN * c->number[get_parent_cell(fine, coarse, u)];
    while (*child != fine->count) child++;
    *child = u;
  }
}

/* Adds a level with half as many cells along each axis, unless it would not be worth it. `number` is scratch. */
static neph_result coarsen(np_diffusion *d, int32_t *number, bool *out_is_added) {
  const np_diffusion_level *fine = &d->levels[d->level_count - 1];
  np_diffusion_level *coarse = &d->levels[d->level_count];
  *out_is_added = false;
  for (int a = 0; a < 3; a++) coarse->size[a] = (fine->size[a] + 1) / 2;
  const size_t cells = (size_t)coarse->size[0] * (size_t)coarse->size[1] * (size_t)coarse->size[2];
  const int32_t count = mark_parents(fine, coarse, number, cells);
  if (10 * (int64_t)count > 9 * (int64_t)fine->count) return NEPH_OK;
  neph_result result = allocate_level(d->grid->context, count, coarse);
  coarse->child = np_alloc(d->grid->context, (size_t)count, NP_DIFFUSION_CHILDREN * sizeof *coarse->child);
  d->level_count++;
  if (result || !coarse->child) return NEPH_ERROR_OUT_OF_MEMORY;
  number_cells(coarse, number);
  choose_colouring(d->grid, coarse);
  link_sums c = {fine, number, coarse};
  list_children(&c);
  (void)np_parallel_for(d->grid->context, NULL, (size_t)count, UNKNOWNS_PER_PIECE, sum_all_links, &c);
  *out_is_added = true;
  return NEPH_OK;
}

/* ---- Making ---- */

static neph_result allocate(np_diffusion *d, int32_t count) {
  neph_context *context = d->grid->context;
  const size_t n = (size_t)count;
  d->level_count = 1;
  neph_result result = allocate_level(context, count, &d->levels[0]);
  d->active = np_alloc(context, n, sizeof *d->active);
  float **const vectors[] = {&d->correction, &d->residual, &d->step, &d->image};
  for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++) {
    *vectors[i] = np_alloc(context, n + 1, sizeof(float));
    if (!*vectors[i]) result = NEPH_ERROR_OUT_OF_MEMORY;
  }
  d->sums = np_alloc(context, n / NP_DIFFUSION_CHUNK + 1, sizeof *d->sums);
  return d->active && d->sums ? result : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result fill(np_diffusion *d) {
  neph_context *context = d->grid->context;
  int32_t *number = np_alloc(context, d->grid->active_count, sizeof *number);
  int32_t *cells = np_alloc(context, np_transport_grid_count(d->grid), sizeof *cells);
  neph_result result = number && cells ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) fill_finest(d, number, cells);
  bool is_added = true;
  while (!result && is_added && d->level_count < NP_DIFFUSION_LEVELS_MAX &&
         d->levels[d->level_count - 1].count > COARSEST)
    result = coarsen(d, cells, &is_added);
  np_alloc_free(context, cells);
  np_alloc_free(context, number);
  return result;
}

neph_result np_diffusion_init(const np_transport_grid *grid, np_diffusion *out) {
  int32_t count = 0;
  for (size_t i = 0; i < grid->active_count; i++) count += grid->extinction[i] > 0.0f;
  *out = (np_diffusion){.grid = grid, .smoothings = compute_deepest(grid) > twice_smoothed_depth ? 2 : 1};
  if (count == 0) return NEPH_OK;
  neph_result result = allocate(out, count);
  if (!result) result = fill(out);
  if (result) np_diffusion_clear(out);
  return result;
}

void np_diffusion_clear(np_diffusion *d) {
  neph_context *context = d->grid ? d->grid->context : NULL;
  if (!context) return;
  for (unsigned n = 0; n < d->level_count; n++) clear_level(context, &d->levels[n]);
  np_alloc_free(context, d->active);
  np_alloc_free(context, d->correction);
  np_alloc_free(context, d->residual);
  np_alloc_free(context, d->step);
  np_alloc_free(context, d->image);
  np_alloc_free(context, d->sums);
  *d = (np_diffusion){0};
}
