/* SPDX-License-Identifier: Apache-2.0 */
/* Anderson acceleration (Anderson 1965; in the form of Walker and Ni 2011, "Anderson Acceleration for Fixed-Point
 * Iterations", algorithm AA): the next x is that combination Σ α_j·g_j, Σ α_j = 1, of the last images whose residuals
 * f_j = g(x_j) − x_j cancel best. Where the residual grows the past is forgotten, and where it stalls for good, plain
 * iteration goes on from there.
 */
#include "transport/fixed_point.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"

enum { DEPTH = NP_FIXED_POINT_DEPTH_MAX, CHUNK = 1 << 13, BLOCK = 512, LANES = 32, STALL = 12 };

typedef np_fixed_point_history history;

typedef struct pass {
  const np_fixed_point *problem;
  const history *past;
  float *x;
  double weight[DEPTH];
  double (*sums)[DEPTH + 1]; /* sums of each chunk: products of the newest residual with all, and the image's square */
} pass;

static size_t count_chunks(const np_fixed_point *p) { return (p->count + CHUNK - 1) / CHUNK; }

/* Scalar product: in float over blocks of at most CHUNK values, in double over the blocks. */
static double multiply(const float *a, const float *b, size_t count) {
  double sum = 0.0;
  for (size_t begin = 0; begin < count; begin += BLOCK) {
    const size_t end = begin + BLOCK < count ? begin + BLOCK : count;
    float part[LANES] = {0};
    size_t i = begin;
    for (; i + LANES <= end; i += LANES)
      for (size_t l = 0; l < LANES; l++) part[l] += a[i + l] * b[i + l];
    for (; i < end; i++) part[0] += a[i] * b[i];
    for (size_t l = 0; l < LANES; l++) sum += (double)part[l];
  }
  return sum;
}

/* The newest residual, and its products. */
static neph_result measure_chunks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const pass *p = user;
  const unsigned newest = p->past->count - 1;
  for (size_t chunk = begin; chunk < end; chunk++) {
    const size_t first = chunk * CHUNK, rest = p->problem->count - first, count = rest < CHUNK ? rest : CHUNK;
    const float *x = p->x + first, *image = p->past->image[newest] + first;
    float *residual = p->past->residual[newest] + first;
    for (size_t i = 0; i < count; i++) residual[i] = image[i] - x[i];
    for (unsigned j = 0; j <= newest; j++) p->sums[chunk][j] = multiply(residual, p->past->residual[j] + first, count);
    p->sums[chunk][DEPTH] = multiply(image, image, count);
  }
  return NEPH_OK;
}

static neph_result combine_chunks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const pass *p = user;
  for (size_t chunk = begin; chunk < end; chunk++) {
    const size_t first = chunk * CHUNK, rest = p->problem->count - first, count = rest < CHUNK ? rest : CHUNK;
    float *x = p->x + first;
    for (size_t i = 0; i < count; i++) x[i] = (float)p->weight[0] * p->past->image[0][first + i];
    for (unsigned j = 1; j < p->past->count; j++) {
      const float *image = p->past->image[j] + first, weight = (float)p->weight[j];
      for (size_t i = 0; i < count; i++) x[i] += weight * image[i];
    }
  }
  return NEPH_OK;
}

/* Solves the n×n system in place by elimination with pivots on the diagonal, which the small ridge keeps positive. */
static void solve_small(unsigned n, double a[DEPTH][DEPTH], double b[DEPTH]) {
  for (unsigned i = 0; i < n; i++)
    for (unsigned r = i + 1; r < n; r++) {
      assert(a[i][i] > 0.0);
      const double factor = a[r][i] / a[i][i];
      for (unsigned c = i; c < n; c++) a[r][c] -= factor * a[i][c];
      b[r] -= factor * b[i];
    }
  for (unsigned i = n; i-- > 0;) {
    for (unsigned c = i + 1; c < n; c++) b[i] -= a[i][c] * b[c];
    b[i] /= a[i][i];
  }
}

/* Weights that minimise ‖Σ α_j·f_j‖: α for the older ones from the normal equations of f_j − f_newest. */
static void compute_weights(const history *past, double weight[DEPTH]) {
  assert(past->count >= 1 && past->count <= DEPTH);
  const unsigned n = past->count - 1;
  double a[DEPTH][DEPTH], b[DEPTH], trace = 0.0;
  for (unsigned i = 0; i < n; i++) {
    for (unsigned j = 0; j < n; j++)
      a[i][j] = past->gram[i][j] - past->gram[i][n] - past->gram[n][j] + past->gram[n][n];
    b[i] = past->gram[n][n] - past->gram[i][n];
    trace += a[i][i];
  }
  for (unsigned i = 0; i < n; i++) a[i][i] += 1e-9 * trace + 1e-300;
  solve_small(n, a, b);
  weight[n] = 1.0;
  for (unsigned i = 0; i < n; i++) {
    weight[i] = b[i];
    weight[n] -= b[i];
  }
}

/* Makes the last slot of the history free. */
static void shift(history *past) {
  if (past->count < past->depth) return;
  float *image = past->image[0], *residual = past->residual[0];
  for (unsigned j = 0; j + 1 < past->depth; j++) {
    past->image[j] = past->image[j + 1];
    past->residual[j] = past->residual[j + 1];
    past->relative[j] = past->relative[j + 1];
    for (unsigned i = 0; i + 1 < past->depth; i++) past->gram[j][i] = past->gram[j + 1][i + 1];
  }
  past->image[past->depth - 1] = image;
  past->residual[past->depth - 1] = residual;
  past->count--;
}

static void clear_history(history *past) {
  const unsigned newest = past->count - 1;
  float *image = past->image[newest], *residual = past->residual[newest];
  past->image[newest] = past->image[0];
  past->residual[newest] = past->residual[0];
  past->image[0] = image;
  past->residual[0] = residual;
  past->gram[0][0] = past->gram[newest][newest];
  past->relative[0] = past->relative[newest];
  past->count = 1;
}

static neph_result measure(pass *p, history *past) {
  const np_fixed_point *problem = p->problem;
  neph_result result = np_parallel_for(problem->context, problem->monitor, count_chunks(problem), 1, measure_chunks, p);
  if (result) return result;
  const unsigned newest = past->count - 1;
  double image = 0.0;
  for (unsigned j = 0; j <= newest; j++) {
    double sum = 0.0;
    for (size_t c = 0; c < count_chunks(problem); c++) sum += p->sums[c][j];
    past->gram[newest][j] = past->gram[j][newest] = sum;
  }
  for (size_t c = 0; c < count_chunks(problem); c++) image += p->sums[c][DEPTH];
  const double square = past->gram[newest][newest];
  past->relative[newest] = isfinite(square) && isfinite(image) ? sqrt(square / fmax(image, 1e-300)) : HUGE_VAL;
  return NEPH_OK;
}

/* Counts the calls that have not brought the residual down, and after too many keeps but the newest image. */
static void watch_for_stall(np_fixed_point *problem, history *past) {
  past->idle = problem->residual < 0.9 * past->best ? 0 : past->idle + 1;
  past->best = fmin(past->best, problem->residual);
  if (past->idle < STALL || problem->is_stalled) return;
  problem->is_stalled = true;
  clear_history(past);
  past->depth = 1;
}

/* One more image, and its distance from its argument; without it where the budget ends. */
static neph_result add_image(np_fixed_point *problem, history *past, pass *p) {
  shift(past);
  const unsigned newest = past->count++;
  neph_result result = problem->map(problem->user, p->x, past->residual[newest], past->image[newest]);
  if (!result) result = measure(p, past);
  if (result) {
    past->count--;
    return result;
  }
  problem->calls++;
  problem->residual = past->relative[past->count - 1];
  return NEPH_OK;
}

static void store_image(np_fixed_point *problem, const history *past, unsigned index, float *x) {
  memcpy(x, past->image[index], problem->count * sizeof *x);
  problem->residual = past->relative[index];
}

/* Stores the best image in x; without a history x stays the last image, or the start. */
static void store_best(np_fixed_point *problem, const history *past, float *x) {
  unsigned best = 0;
  for (unsigned j = 1; j < past->count; j++)
    if (past->relative[j] < past->relative[best]) best = j;
  if (past->count > 0) store_image(problem, past, best, x);
}

/* Estimated fraction of the work that is done, if the residual falls as it did since the first call. */
static double estimate_done(const np_fixed_point *problem, double first_residual) {
  const double done = problem->calls, at_least = done / problem->calls_max;
  const double fallen = log(first_residual / problem->residual), needed = log(first_residual / problem->tolerance);
  return isfinite(fallen) && needed > 0.0 ? fmin(fmax(fallen / needed, at_least), done / (done + 1.0)) : at_least;
}

/* Restarts after an overflow, with plain iteration from the best image before it, or from zero. */
static void restart(np_fixed_point *problem, history *past, float *x) {
  past->count--;
  memset(x, 0, problem->count * sizeof *x);
  problem->residual = 1.0;
  if (past->count > 0) store_best(problem, past, x);
  past->count = 0;
  past->depth = 1;
  problem->is_stalled = true;
}

/* The next x from a history that has a new image. A loop that is cut short would leave no x to keep: it is quick, and
 * is not stopped where x is kept. */
static neph_result combine(np_fixed_point *problem, history *past, pass *p) {
  if (problem->calls == 1) past->first = problem->residual;
  const double done = estimate_done(problem, past->first);
  np_monitor_set_range(problem->monitor, done, done);
  if (!(problem->residual < 2.0 * past->before)) clear_history(past);
  past->before = problem->residual;
  watch_for_stall(problem, past);
  compute_weights(past, p->weight);
  np_monitor *monitor = problem->keeper ? NULL : problem->monitor;
  return np_parallel_for(problem->context, monitor, count_chunks(problem), 1, combine_chunks, p);
}

static void save(const np_fixed_point *problem, const history *past, bool is_last) {
  if (problem->keeper) problem->keeper->save(problem->keeper->user, problem, past, is_last);
}

/* Up to the tolerance, or to the last call. */
static neph_result approach(np_fixed_point *problem, history *past, pass *p) {
  for (;;) {
    neph_result result = add_image(problem, past, p);
    if (result == NEPH_ERROR_CANCELLED) save(problem, past, true);
    if (result) return result;
    if (!isfinite(problem->residual)) {
      restart(problem, past, p->x);
      if (problem->calls >= problem->calls_max) return NEPH_OK;
      continue;
    }
    if (problem->residual <= problem->tolerance || problem->calls >= problem->calls_max) {
      store_image(problem, past, past->count - 1, p->x);
      return NEPH_OK;
    }
    result = combine(problem, past, p);
    if (result) return result;
    save(problem, past, false);
  }
}

static neph_result iterate(np_fixed_point *problem, history *past, pass *p) {
  problem->calls = 0;
  problem->residual = 1.0;
  problem->is_cut = problem->is_stalled = false;
  past->before = past->best = INFINITY;
  if (problem->keeper) (void)problem->keeper->load(problem->keeper->user, problem, past);
  np_monitor_set_range(problem->monitor, 0.0, 0.0);
  const neph_result result = approach(problem, past, p);
  if (result != NEPH_ERROR_CANCELLED || !np_monitor_is_cut(problem->monitor)) return result;
  store_best(problem, past, p->x);
  problem->is_cut = true;
  return NEPH_OK;
}

neph_result np_fixed_point_solve(np_fixed_point *problem, float *x) {
  neph_context *context = problem->context;
  history past = {.depth = problem->depth};
  pass p = {.problem = problem, .past = &past, .x = x};
  float *own = problem->vectors ? NULL : np_alloc(context, problem->count, 2 * past.depth * sizeof *own);
  float *vectors = own ? own : problem->vectors;
  p.sums = np_alloc(context, count_chunks(problem), sizeof *p.sums);
  neph_result result = vectors && p.sums ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned j = 0; j < past.depth && !result; j++) {
    past.image[j] = vectors + 2 * j * problem->count;
    past.residual[j] = past.image[j] + problem->count;
  }
  if (!result) result = iterate(problem, &past, &p);
  np_alloc_free(context, p.sums);
  np_alloc_free(context, own);
  return result;
}
