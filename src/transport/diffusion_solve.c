/* SPDX-License-Identifier: Apache-2.0 */
/* Conjugate gradients for the diffusion equation, preconditioned by a V-cycle of red-black Gauss-Seidel. */
#include <string.h>

#include "transport/diffusion_system.h"

enum { COARSEST_CYCLES = 8, STEPS_MAX = 20 };

/* Most chunks for which threads are not woken, which takes some 50 us. */
enum { SERIAL_CHUNKS = 2 };

static const float solve_tolerance = 0.1f;

/* ---- Loops ---- */

void np_diffusion_run(np_diffusion_loop *loop, size_t first, size_t end, np_parallel_fn body) {
  neph_context *context = loop->diffusion->grid->context;
  loop->first = first;
  if (end - first <= SERIAL_CHUNKS * NP_DIFFUSION_CHUNK)
    (void)body(loop, 0, end - first, 0);
  else
    (void)np_parallel_for(context, NULL, end - first, NP_DIFFUSION_CHUNK, body, loop);
}

/* Σ c·x of the neighbours. */
static inline float sum_neighbours(const np_diffusion_level *l, size_t unknown, const float *x) {
  const int32_t *neighbour = l->neighbour + NP_DIFFUSION_FACES * unknown;
  const float *link = l->link + NP_DIFFUSION_FACES * unknown;
  float sum = 0.0f;
  for (int face = 0; face < NP_DIFFUSION_FACES; face++) sum += link[face] * x[neighbour[face]];
  return sum;
}

static neph_result relax(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion_loop *loop = user;
  const np_diffusion_level *l = loop->level;
  for (size_t u = loop->first + begin; u < loop->first + end; u++)
    l->x[u] = l->inverse[u] * (l->right[u] + sum_neighbours(l, u, l->x));
  return NEPH_OK;
}

/* Red-black Gauss-Seidel, red cells first or last. The two orders are adjoint, as conjugate gradients require. */
static void relax_level(np_diffusion *d, np_diffusion_level *l, bool is_red_first) {
  np_diffusion_loop loop = {.diffusion = d, .level = l};
  const size_t red = (size_t)l->red_count, count = (size_t)l->count;
  if (!l->is_coloured) {
    for (size_t i = 0; i < count; i++) {
      loop.first = is_red_first ? i : count - 1 - i;
      (void)relax(&loop, 0, 1, 0);
    }
    return;
  }
  np_diffusion_run(&loop, is_red_first ? 0 : red, is_red_first ? red : count, relax);
  np_diffusion_run(&loop, is_red_first ? red : 0, is_red_first ? count : red, relax);
}

/* The residual of the finer level, by unknowns of the coarser. */
static neph_result restrict_residual(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion_loop *loop = user;
  const np_diffusion_level *fine = loop->finer, *coarse = loop->level;
  for (size_t u = begin; u < end; u++) {
    float sum = 0.0f;
    for (int c = 0; c < NP_DIFFUSION_CHILDREN; c++) {
      const int32_t child = coarse->child[NP_DIFFUSION_CHILDREN * u + (size_t)c];
      if (child == fine->count) break;
      sum += fine->right[child] - fine->x[child] / fine->inverse[child] + sum_neighbours(fine, (size_t)child, fine->x);
    }
    coarse->right[u] = sum;
    coarse->x[u] = 0.0f;
  }
  return NEPH_OK;
}

static neph_result prolong(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion_loop *loop = user;
  const np_diffusion_level *fine = loop->finer, *coarse = loop->level;
  for (size_t u = begin; u < end; u++)
    for (int c = 0; c < NP_DIFFUSION_CHILDREN; c++) {
      const int32_t child = coarse->child[NP_DIFFUSION_CHILDREN * u + (size_t)c];
      if (child == fine->count) break;
      fine->x[child] += coarse->x[u];
    }
  return NEPH_OK;
}

/* Improves the levels' x, 0 at the start, for the `right` of the finest. */
static void run_cycle(np_diffusion *d) {
  for (unsigned n = 0; n + 1 < d->level_count; n++) {
    relax_level(d, &d->levels[n], true);
    np_diffusion_loop loop = {.diffusion = d, .level = &d->levels[n + 1], .finer = &d->levels[n]};
    np_diffusion_run(&loop, 0, (size_t)loop.level->count, restrict_residual);
  }
  for (int i = 0; i < COARSEST_CYCLES; i++)
    for (int way = 0; way < 2; way++) relax_level(d, &d->levels[d->level_count - 1], way == 0);
  for (unsigned n = d->level_count - 1; n-- > 0;) {
    np_diffusion_loop loop = {.diffusion = d, .level = &d->levels[n + 1], .finer = &d->levels[n]};
    np_diffusion_run(&loop, 0, (size_t)loop.level->count, prolong);
    relax_level(d, &d->levels[n], false);
  }
}

/* ---- Conjugate gradients ---- */

/* Unknowns of the finest level that one sum is over. */
typedef struct chunk_range {
  size_t begin, end;
} chunk_range;

static chunk_range get_range(const np_diffusion *d, size_t chunk) {
  const size_t count = (size_t)d->levels[0].count, begin = chunk * NP_DIFFUSION_CHUNK;
  return (chunk_range){begin, begin + NP_DIFFUSION_CHUNK < count ? begin + NP_DIFFUSION_CHUNK : count};
}

/* The sum of what `body` puts into `sums` for each chunk. Chunks are of fixed size, so that the bits do not depend on
 * the number of threads. */
static double sum_chunks(np_diffusion_loop *loop, np_parallel_fn body) {
  const np_diffusion *d = loop->diffusion;
  const size_t chunks = ((size_t)d->levels[0].count + NP_DIFFUSION_CHUNK - 1) / NP_DIFFUSION_CHUNK;
  double sum = 0.0;
  if (chunks <= SERIAL_CHUNKS)
    (void)body(loop, 0, chunks, 0);
  else
    (void)np_parallel_for(d->grid->context, NULL, chunks, 1, body, loop);
  for (size_t c = 0; c < chunks; c++) sum += d->sums[c];
  return sum;
}

static neph_result multiply_chunks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion_loop *loop = user;
  for (size_t chunk = begin; chunk < end; chunk++) {
    const chunk_range r = get_range(loop->diffusion, chunk);
    double sum = 0.0;
    for (size_t i = r.begin; i < r.end; i++) sum += (double)loop->a[i] * (double)loop->b[i];
    loop->diffusion->sums[chunk] = sum;
  }
  return NEPH_OK;
}

static double multiply(np_diffusion *d, const float *a, const float *b) {
  np_diffusion_loop loop = {.diffusion = d, .a = a, .b = b};
  return sum_chunks(&loop, multiply_chunks);
}

/* The image of the step, and their product. */
static neph_result apply_system(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion *d = ((const np_diffusion_loop *)user)->diffusion;
  const np_diffusion_level *l = &d->levels[0];
  for (size_t chunk = begin; chunk < end; chunk++) {
    const chunk_range r = get_range(d, chunk);
    double sum = 0.0;
    for (size_t u = r.begin; u < r.end; u++) {
      d->image[u] = d->step[u] / l->inverse[u] - sum_neighbours(l, u, d->step);
      sum += (double)d->step[u] * (double)d->image[u];
    }
    d->sums[chunk] = sum;
  }
  return NEPH_OK;
}

/* Moves the correction by `factor` steps, and the residual with it; the sum is the residual's square. */
static neph_result take_step(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion_loop *loop = user;
  const np_diffusion *d = loop->diffusion;
  for (size_t chunk = begin; chunk < end; chunk++) {
    const chunk_range r = get_range(d, chunk);
    double sum = 0.0;
    for (size_t u = r.begin; u < r.end; u++) {
      d->correction[u] += loop->factor * d->step[u];
      d->residual[u] -= loop->factor * d->image[u];
      sum += (double)d->residual[u] * (double)d->residual[u];
    }
    d->sums[chunk] = sum;
  }
  return NEPH_OK;
}

/* The next step: a + factor·step. */
static neph_result turn_step(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_diffusion_loop *loop = user;
  float *step = loop->diffusion->step;
  for (size_t u = begin; u < end; u++) step[u] = loop->a[u] + loop->factor * step[u];
  return NEPH_OK;
}

/* The preconditioned residual, in the finest level's x. */
static const float *precondition(np_diffusion *d) {
  np_diffusion_level *l = &d->levels[0];
  memcpy(l->right, d->residual, (size_t)l->count * sizeof *l->right);
  memset(l->x, 0, (size_t)l->count * sizeof *l->x);
  run_cycle(d);
  return l->x;
}

void np_diffusion_solve(np_diffusion *d) {
  const np_diffusion_level *l = &d->levels[0];
  memset(d->correction, 0, (size_t)l->count * sizeof *d->correction);
  const double start = multiply(d, d->residual, d->residual);
  double before = 0.0;
  for (int n = 0; n < STEPS_MAX && start > 0.0; n++) {
    np_diffusion_loop loop = {.diffusion = d, .a = precondition(d)};
    const double rz = multiply(d, d->residual, loop.a);
    loop.factor = n ? (float)(rz / before) : 0.0f;
    np_diffusion_run(&loop, 0, (size_t)l->count, turn_step);
    before = rz;
    const double curvature = sum_chunks(&loop, apply_system);
    if (!(curvature > 0.0)) break;
    loop.factor = (float)(rz / curvature);
    if (sum_chunks(&loop, take_step) <= (double)(solve_tolerance * solve_tolerance) * start) break;
  }
}
