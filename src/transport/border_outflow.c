/* SPDX-License-Identifier: Apache-2.0 */
/* Light that leaves a solution: it spreads over ground and air below and over air above, and changes the radiance at
 * the border. */
#include <string.h>

#include "transport/border.h"

#include "core/math.h"
#include "core/parallel.h"
#include "core/units.h"

enum {
  NODES = NP_BORDER_NODES,
  FACES = 6,
  MARGIN = (NP_BORDER_WIDE - NP_BORDER_PLAN) / 2,
  SPAN = 2 * NP_BORDER_WIDE + 1, /* distances between squares */
  PLAN_SQUARES = NP_BORDER_PLAN * NP_BORDER_PLAN,
  WIDE_SQUARES = NP_BORDER_WIDE * NP_BORDER_WIDE
};

/* Height of the highest level above the box, a scale height of the Earth's air. Light from higher air is counted at
 * this level. */
static const double rise_m = 8e3;

float np_border_compute_excess(const np_border *border, unsigned band, np_border_way way, int v, int u,
                               float irradiance) {
  const float clear = border->way[way].clear.band[band];
  const float entering = border->way[way].entering.band[band] + border->way[way].air.band[band];
  const float open = entering > 0.0f ? np_clampf(irradiance / entering, 0.0f, border->open[v][u]) : 1.0f;
  return irradiance + (clear - entering) * open - clear;
}

void np_border_reset(np_border *border, unsigned band) {
  memcpy(border->faces[band].radiance, border->clear[band].radiance,
         np_border_count_radiances(border->faces[band].block_count) * sizeof(float));
}

/* Irradiance at a depth h below a square of even radiance over that just beneath it, by the distance d from square to
 * square along either axis: h²/(π·(h² + d²)²) times the square's area, Lambert's law. A periodic axis has images. */
static double compute_kernel(const np_border *b, double depth_m, int i, int j) {
  const double h2 = depth_m * depth_m;
  const int images[2] = {b->is_wrapped[0] ? 2 : 0, b->is_wrapped[1] ? 2 : 0};
  double sum = 0.0;
  for (int n = -images[1]; n <= images[1]; n++)
    for (int m = -images[0]; m <= images[0]; m++) {
      const double x = (i + m * NP_BORDER_PLAN) * b->square_m[0], y = (j + n * NP_BORDER_PLAN) * b->square_m[1];
      sum += h2 / (NP_PI * (h2 + x * x + y * y) * (h2 + x * x + y * y)) * b->square_m[0] * b->square_m[1];
    }
  return sum;
}

/* The kernel of all distances, which is symmetric. */
static void fill_kernel(const np_border *b, double depth_m, float *kernel) {
  float *middle = kernel + NP_BORDER_WIDE * SPAN + NP_BORDER_WIDE;
  for (int j = 0; j <= NP_BORDER_WIDE; j++)
    for (int i = 0; i <= NP_BORDER_WIDE; i++)
      middle[j * SPAN + i] = middle[j * SPAN - i] = middle[-j * SPAN + i] = middle[-j * SPAN - i] =
          (float)compute_kernel(b, depth_m, i, j);
}

/* Share of the irradiance from an infinite uniform plane that comes from distances within the kernel; along a periodic
 * axis one period, with its images, is the whole plane. */
static double compute_kernel_share(const np_border *b, double depth_m, const float *kernel) {
  double sum = 0.0, edge = HUGE_VAL;
  for (int j = -NP_BORDER_WIDE; j <= NP_BORDER_WIDE; j++)
    for (int i = -NP_BORDER_WIDE; i <= NP_BORDER_WIDE; i++) {
      const bool is_in_x = !b->is_wrapped[0] || (i >= 0 && i < NP_BORDER_PLAN);
      const bool is_in_y = !b->is_wrapped[1] || (j >= 0 && j < NP_BORDER_PLAN);
      if (is_in_x && is_in_y) sum += (double)kernel[(j + NP_BORDER_WIDE) * SPAN + i + NP_BORDER_WIDE];
    }
  for (int a = 0; a < 2; a++)
    if (!b->is_wrapped[a]) edge = fmin(edge, (NP_BORDER_WIDE + 0.5) * b->square_m[a]);
  return sum / (isfinite(edge) ? edge * edge / (edge * edge + depth_m * depth_m) : 1.0);
}

/* Adds what the plan's squares send to a row of squares. Sums of a row grow side by side, each in the plan's order. */
static void spread_to_row(const float *plan, const float *kernel, int row, float *out) {
  float sums[NP_BORDER_WIDE] = {0};
  for (int n = 0; n < PLAN_SQUARES; n++) {
    const int i = NP_BORDER_WIDE - MARGIN - n % NP_BORDER_PLAN, j = row - MARGIN - n / NP_BORDER_PLAN + NP_BORDER_WIDE;
    const float *gains = kernel + j * SPAN + i;
    for (int x = 0; x < NP_BORDER_WIDE; x++) sums[x] += plan[n] * gains[x];
  }
  memcpy(out, sums, sizeof sums);
}

/* The plan's excess just beneath it, where its edge is sharp. */
static void copy_plan(const float *plan, float *out) {
  memset(out, 0, WIDE_SQUARES * sizeof *out);
  for (int v = 0; v < NP_BORDER_PLAN; v++)
    memcpy(out + (v + MARGIN) * NP_BORDER_WIDE + MARGIN, plan + v * NP_BORDER_PLAN, NP_BORDER_PLAN * sizeof *out);
}

/* Spreads the plan's excess over the squares at a depth, from where it has no edge. */
static void spread_excess(const np_border *b, const float *plan, double depth_m, float *out) {
  float kernel[SPAN * SPAN], scaled[PLAN_SQUARES];
  if (depth_m < 0.5 * fmin(b->square_m[0], b->square_m[1])) {
    copy_plan(plan, out);
    return;
  }
  fill_kernel(b, depth_m, kernel);
  const float scale = (float)(1.0 / compute_kernel_share(b, depth_m, kernel));
  for (int n = 0; n < PLAN_SQUARES; n++) scaled[n] = scale * plan[n];
  for (int row = 0; row < NP_BORDER_WIDE; row++) spread_to_row(scaled, kernel, row, out + row * NP_BORDER_WIDE);
}

double np_border_get_level(const np_border *border, np_border_way way, int level) {
  const double share = (double)level / (NP_BORDER_LEVELS - 1);
  return way == NP_BORDER_DOWN ? border->depth_m * share : rise_m * share * share;
}

int np_border_search_level(const np_border *border, np_border_way way, double distance_m) {
  const double share = way == NP_BORDER_DOWN ? distance_m / border->depth_m : sqrt(fmax(distance_m, 0.0) / rise_m);
  return (int)np_clamp(floor(share * (NP_BORDER_LEVELS - 1) + 0.5), 0.0, NP_BORDER_LEVELS - 1);
}

typedef struct outflow_job {
  np_border *border;
  unsigned band;
  float plan[NP_BORDER_WAYS][PLAN_SQUARES];                       /* excess over the plan */
  float excess[NP_BORDER_WAYS * NP_BORDER_LEVELS * WIDE_SQUARES]; /* [way][level][square] */
} outflow_job;

static neph_result spread_levels(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  outflow_job *job = user;
  for (size_t n = begin; n < end; n++) {
    const np_border_way way = (np_border_way)(n / NP_BORDER_LEVELS);
    spread_excess(job->border, job->plan[way], np_border_get_level(job->border, way, (int)(n % NP_BORDER_LEVELS)),
                  job->excess + n * WIDE_SQUARES);
  }
  return NEPH_OK;
}

/* Adds the responses of nodes, none of which has a radiance of another's. */
static neph_result light_nodes(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const outflow_job *job = user;
  float *faces = job->border->faces[job->band].radiance;
  for (size_t node = begin; node < end; node++)
    for (size_t i = 0; i < job->border->responses[node].count; i++) {
      const np_border_response *r = &job->border->responses[node].at[i];
      faces[r->radiance] += r->gain.band[job->band] * job->excess[r->square];
    }
  return NEPH_OK;
}

void np_border_set_outflow(neph_context *context, np_border *border, unsigned band, const np_outflow *outflow) {
  np_border_reset(border, band);
  outflow_job job = {.border = border, .band = band};
  for (int n = 0; n < NP_BORDER_WAYS * PLAN_SQUARES; n++) {
    const int way = n / PLAN_SQUARES, v = n % PLAN_SQUARES / NP_BORDER_PLAN, u = n % NP_BORDER_PLAN;
    job.plan[way][n % PLAN_SQUARES] =
        np_border_compute_excess(border, band, (np_border_way)way, v, u, outflow->way[way][v][u]);
  }
  (void)np_parallel_for(context, NULL, NP_BORDER_WAYS * NP_BORDER_LEVELS, 1, spread_levels, &job);
  (void)np_parallel_for(context, NULL, FACES * NODES * NODES, 4, light_nodes, &job);
  float *radiance = border->faces[band].radiance;
  const size_t count = np_border_count_radiances(border->faces[band].block_count);
  for (size_t i = 0; i < count; i++) radiance[i] = np_maxf(radiance[i], 0.0f);
}
