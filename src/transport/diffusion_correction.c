/* SPDX-License-Identifier: Apache-2.0 */
/* A sweep answers for light that scatters once more where it is. Light that is still missing from a thick cloud is
 * diffuse, spreads over many cells, and shows in a sweep's residual f = g(x) − x late and faintly. It is estimated by
 * the diffusion equation with f as source (Alcouffe 1977, "Diffusion synthetic acceleration methods for the
 * diamond-differenced discrete-ordinates equations"; reviewed by Adams and Larsen 2002, "Fast iterative methods for
 * discrete-ordinates particle transport calculations"), and added to the mean radiance.
 *
 * With σ′ and r_l as in scattering_solver.c, u and j the integral over directions and the flux of f, F the correction,
 * and of each cell its volume V, faces A and widths h, cell-centred:
 *
 *     Σ c·(F − F_neighbour) + V·(1−r₀)·σ′·F = V·r₀·σ′·u − Σ ±c·w
 *     c = A / (3/2·Σ t + ε),  t = (1−r₁)·σ′·h,  w = 3/2·Σ r₁·σ′·h·j      sums over the two cells of a face
 *
 * The system is solved to a tenth. F is then smoothed by (¼, ½, ¼) along each axis, as diamond differences cannot carry
 * what alternates from cell to cell.
 */
#include "transport/diffusion_correction.h"

#include <string.h>

#include "core/units.h"

/* Harmonics (1, ·) that are the flux along x, y and z. */
static const unsigned char flux_harmonic[3] = {3, 1, 2};

/* A cell's share of the drives w along the axes, and V·r₀·σ′·u. */
static neph_result fill_drives(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion_loop *loop = user;
  const np_diffusion *d = loop->diffusion;
  const np_transport_grid *g = d->grid;
  const size_t harmonics = np_harmonics_count(g->degree), degrees = g->degree + 1;
  float *const drive[3] = {d->residual, d->step, d->image};
  for (size_t u = begin; u < end; u++) {
    const size_t active = (size_t)d->active[u];
    const float *x = loop->x + active * harmonics, *image = loop->image + active * harmonics;
    const float extinction = g->extinction[active];
    float source = sqrtf(4.0f * NP_PI_F) * extinction * g->ratio[active * degrees] * (image[0] - x[0]);
    int32_t at[3];
    np_transport_grid_split(g, g->cell[active], at);
    for (int a = 0; a < 3; a++) {
      const float width = (float)np_transport_grid_width(g, a, at[a]);
      const float flux = sqrtf(4.0f / 3.0f * NP_PI_F) * (image[flux_harmonic[a]] - x[flux_harmonic[a]]);
      drive[a][u] = 1.5f * g->ratio[active * degrees + 1] * extinction * width * flux;
      source *= width;
    }
    d->levels[0].right[u] = source;
  }
  return NEPH_OK;
}

static neph_result add_drives(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion_loop *loop = user;
  const np_diffusion *d = loop->diffusion;
  const np_diffusion_level *l = &d->levels[0];
  const float *const drive[3] = {d->residual, d->step, d->image};
  for (size_t u = begin; u < end; u++)
    for (int face = 0; face < NP_DIFFUSION_FACES; face++) {
      const size_t at = NP_DIFFUSION_FACES * u + (size_t)face;
      const float w = drive[face / 2][u] + drive[face / 2][l->neighbour[at]];
      l->right[u] -= (face & 1 ? 1.0f : -1.0f) * l->link[at] * w;
    }
  return NEPH_OK;
}

/* Smooths by (1, 2, 1)/4 along the axis `factor`; a cell without a neighbour counts twice. */
static neph_result smooth(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion_loop *loop = user;
  const np_diffusion_level *l = loop->level;
  const int axis = (int)loop->factor;
  for (size_t u = begin; u < end; u++) {
    const int32_t *pair = l->neighbour + NP_DIFFUSION_FACES * u + 2 * (size_t)axis;
    float sum = 2.0f * loop->a[u];
    for (int end_of = 0; end_of < 2; end_of++) sum += loop->a[pair[end_of] == l->count ? (int32_t)u : pair[end_of]];
    loop->out[u] = 0.25f * sum;
  }
  return NEPH_OK;
}

static void smooth_correction(np_diffusion *d) {
  for (unsigned n = 0; n < 3 * d->smoothings; n++) {
    np_diffusion_loop loop = {.diffusion = d, .level = &d->levels[0], .factor = (float)(n % 3)};
    loop.a = d->correction;
    loop.out = d->step;
    np_diffusion_run(&loop, 0, (size_t)loop.level->count, smooth);
    d->step = d->correction;
    d->correction = loop.out;
  }
}

static neph_result add_correction(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion_loop *loop = user;
  const np_diffusion *d = loop->diffusion;
  const size_t harmonics = np_harmonics_count(d->grid->degree);
  for (size_t u = begin; u < end; u++)
    loop->image[(size_t)d->active[u] * harmonics] += d->correction[u] / sqrtf(4.0f * NP_PI_F);
  return NEPH_OK;
}

void np_diffusion_correct(np_diffusion *d, const float *x, float *image) {
  if (!d->level_count) return;
  np_diffusion_level *l = &d->levels[0];
  np_diffusion_loop loop = {.diffusion = d, .level = l, .x = x, .image = image};
  np_diffusion_run(&loop, 0, (size_t)l->count, fill_drives);
  np_diffusion_run(&loop, 0, (size_t)l->count, add_drives);
  memcpy(d->residual, l->right, (size_t)l->count * sizeof *d->residual);
  np_diffusion_solve(d);
  smooth_correction(d);
  np_diffusion_run(&loop, 0, (size_t)l->count, add_correction);
}
