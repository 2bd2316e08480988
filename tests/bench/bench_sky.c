/* SPDX-License-Identifier: Apache-2.0 */
/* The sky's tables for a sweep of tolerances: evaluations of the medium, time on one core, and error of each.
 *
 * Usage: bench_sky TRACED.csv [ISA]: tests/data/sky_traced.csv; x86-64, x86-64-v3 or x86-64-v4 at the most. The error
 * of the depths is against quadrature; of moments and gather, of radiances marched over them against those over tables
 * five times as fine; of sky view and aerial perspective, of what is read from them against a march over the same
 * sources; of all of it, against the tracer's rows, the reference's own noise taken off. Relative rms in percent, the
 * worst band. Time is CPU time of one thread, the best of several. Not a test: it prints, and the reader judges.
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "atmosphere/medium.h"
#include "atmosphere/moment_builder.h"
#include "atmosphere/sky_query.h"
#include "core/csv.h"

enum { REPEATS = 5, SUNS = 5, HEIGHTS = 3, VIEWS = 24 };

unsigned long bench_sky_evaluations;

static const double suns_deg[SUNS] = {0, 45, 80, 90, 94}, heights_m[HEIGHTS] = {0, 2000, 10000};

static double read_clock(void) {
  struct timespec t;
  (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void require(neph_result result) {
  if (!result) return;
  fprintf(stderr, "bench_sky: %s\n", neph_result_get_text(result));
  exit(1);
}

/* ---- Cost ---- */

typedef struct cost {
  double seconds;
  unsigned long evaluations;
} cost;

typedef neph_result (*job_fn)(void *user);

static cost measure(job_fn job, void *user) {
  cost c = {1e9, 0};
  for (int i = 0; i < REPEATS; i++) {
    bench_sky_evaluations = 0;
    const double start = read_clock();
    require(job(user));
    const double seconds = read_clock() - start;
    if (seconds < c.seconds) c.seconds = seconds;
    c.evaluations = bench_sky_evaluations;
  }
  return c;
}

static neph_result build_depths(void *user) {
  neph_atmosphere *a = user;
  np_depth_table_free(a->context, &a->depths);
  return np_depth_table_build(a->context, &a->medium, &a->sizes.depth, NULL, &a->depths);
}

static neph_result build_moments(void *user) {
  neph_atmosphere *a = user;
  np_moment_table_free(a->context, &a->moments);
  return np_moment_table_build(a->context, &a->depths, &a->sizes.moments, NP_ORDERS_ALL, false, NULL, &a->moments);
}

/* Includes the kernel, which the atmosphere owns. */
static neph_result build_gather(void *user) {
  neph_sky *sky = user;
  neph_atmosphere *a = sky->atmosphere;
  np_gather_kernel_free(a->context, &a->kernel);
  neph_result result = np_gather_kernel_build(a->context, &a->medium, &a->kernel);
  return result ? result : np_sky_gather_build(sky);
}
static neph_result build_view(void *user) { return np_sky_view_build(user); }
static neph_result build_aerial(void *user) { return np_sky_aerial_build(user); }

/* ---- Error ---- */

typedef struct error_sum {
  double square[3];
  unsigned count;
} error_sum;

static void add_error(error_sum *e, const double value[3], const double reference[3]) {
  for (int b = 0; b < 3; b++)
    if (reference[b] > 0.0) e->square[b] += (value[b] / reference[b] - 1.0) * (value[b] / reference[b] - 1.0);
  e->count++;
}

static double compute_worst(const error_sum *e) {
  return 100.0 * sqrt(fmax(e->square[0], fmax(e->square[1], e->square[2])) / e->count);
}

static void ask(np_sky_subject *w, np_sky_method method, const np_sky_query *q, double out[3]) {
  np_reference_value value;
  w->method = method;
  require(np_sky_query_eval(w, q, 0, NULL, &value));
  for (int b = 0; b < 3; b++) out[b] = value.mean[b];
}

/* The i-th of the questions about one sun and height, spread over the sphere by the golden ratio. */
static np_sky_query make_query(int i, double sun_deg, double height_m, bool is_aerial) {
  const double cosine = 1.0 - 2.0 * (i + 0.5) / VIEWS, distance = 1000.0 * pow(2.0, i % 8);
  return (np_sky_query){is_aerial ? NP_SKY_AP_INSCATTER : NP_SKY_RADIANCE,
                        NP_ORDERS_ALL,
                        height_m,
                        0.0,
                        sun_deg * NP_DEGREE,
                        acos(cosine),
                        NP_PI * fmod(i * 0.6180339887, 1.0),
                        distance};
}

typedef struct errors {
  double depths, sources, view, aerial;
} errors;

static double compute_depth_error(const neph_atmosphere *a) {
  error_sum sum = {0};
  for (int i = 0; i < 4096; i++) {
    const double u = (i + 0.5) / 4096, v = fmod(i * 0.6180339887, 1.0), h = 40e3 * u * u;
    const double horizon = np_horizon_cosine(&a->medium, h), cosine = horizon + (1.0 - horizon) * v * v;
    const np_ray ray = np_ray_on_side(&a->medium, h, cosine, false);
    const np_depth_row row = np_depth_table_row(&a->depths, h);
    const np_bands table = np_depth_row_lookup(&row, (float)cosine);
    const np_bands reference = np_ray_optical_depth(&a->medium, &ray, 0.0, ray.length_m);
    add_error(&sum, (double[]){(double)table[0], (double)table[1], (double)table[2]},
              (double[]){(double)reference[0], (double)reference[1], (double)reference[2]});
  }
  return compute_worst(&sum);
}

static errors compute_errors(neph_atmosphere *a, neph_atmosphere *fine) {
  np_sky_subject own = {.atmosphere = a, .sun_angular_radius_rad = 0.00467396, .irradiance_w_m2_nm = {1, 1, 1}};
  np_sky_subject best = own;
  best.atmosphere = fine;
  error_sum sources = {0}, view = {0}, aerial = {0};
  for (int s = 0; s < SUNS; s++)
    for (int h = 0; h < HEIGHTS; h++)
      for (int i = 0; i < VIEWS; i++) {
        double table[3], marched[3], reference[3];
        np_sky_query q = make_query(i, suns_deg[s], heights_m[h], false);
        ask(&own, NP_SKY_LUT, &q, table);
        ask(&own, NP_SKY_MARCH, &q, marched);
        ask(&best, NP_SKY_MARCH, &q, reference);
        add_error(&view, table, marched);
        add_error(&sources, marched, reference);
        q = make_query(i, suns_deg[s], heights_m[h], true);
        ask(&own, NP_SKY_LUT, &q, table);
        ask(&own, NP_SKY_MARCH, &q, marched);
        add_error(&aerial, table, marched);
      }
  np_sky_subject_clear(&own);
  np_sky_subject_clear(&best);
  return (errors){compute_depth_error(a), compute_worst(&sources), compute_worst(&view), compute_worst(&aerial)};
}

/* Against the tracer's rows under suns from `sun_min` to `sun_max`, up to 10 km. */
static double compute_total_error(neph_atmosphere *a, const np_csv *traced, double sun_min, double sun_max) {
  np_sky_subject w = {.atmosphere = a, .sun_angular_radius_rad = 0.00467396};
  const neph_sky_desc sun = NEPH_SKY_DESC_DEFAULT;
  for (int b = 0; b < 3; b++) w.irradiance_w_m2_nm[b] = sun.sun_irradiance_w_m2_nm[b];
  error_sum sum = {0};
  double noise[3] = {0};
  for (size_t i = 0; i < traced->row_count; i++) {
    double field[15];
    for (int c = 0; c < 15; c++) field[c] = strtod(np_csv_get_field(traced, i, c), NULL);
    const double height_km = field[3], sun_deg = field[5];
    if (strcmp(np_csv_get_field(traced, i, 0), "sky_radiance") != 0 || height_km > 10.0) continue;
    if (sun_deg < sun_min || sun_deg > sun_max) continue;
    const np_sky_query q = {.quantity = NP_SKY_RADIANCE,
                            .order_max = NP_ORDERS_ALL,
                            .altitude_m = 1000.0 * height_km,
                            .sun_zenith_rad = sun_deg * NP_DEGREE,
                            .view_zenith_rad = field[6] * NP_DEGREE,
                            .azimuth_rad = field[7] * NP_DEGREE};
    double value[3];
    ask(&w, NP_SKY_LUT, &q, value);
    add_error(&sum, value, field + 9);
    for (int b = 0; b < 3; b++) noise[b] += field[12 + b] * field[12 + b] / (field[9 + b] * field[9 + b]);
  }
  np_sky_subject_clear(&w);
  for (int b = 0; b < 3; b++) sum.square[b] = fmax(sum.square[b] - noise[b], 0.0);
  return compute_worst(&sum);
}

/* ---- Sweep ---- */

/* The Earth of the traced rows, whose haze has one lobe. */
static neph_atmosphere_desc describe_one_lobe(void) {
  static neph_atmosphere_layer layers[NEPH_EARTH_LAYER_COUNT];
  neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
  memcpy(layers, neph_earth_layers, sizeof layers);
  layers[1].phase = NEPH_PHASE_CORNETTE_SHANKS;
  desc.layers = layers;
  return desc;
}

static void print_table(const char *name, const char *size, cost c, double error) {
  printf("| %s | %s | %.3g k | %.1f | %.2f |\n", name, size, 1e-3 * (double)c.evaluations, 1e3 * c.seconds, error);
}

static void run_tolerance(neph_context *context, double tolerance, neph_atmosphere *fine, const np_csv *traced) {
  const np_table_sizes n = np_table_sizes_make(tolerance);
  neph_atmosphere *a;
  const neph_atmosphere_desc air = describe_one_lobe();
  require(np_atmosphere_create_sized(context, &air, NP_ORDERS_ALL, false, &n, NULL, &a));
  neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
  desc.sun_direction[0] = 0.8;
  desc.sun_direction[2] = 0.6;
  desc.observer_m[2] = 500.0;
  neph_sky *sky;
  require(neph_sky_create(a, &desc, &sky));
  const cost c[5] = {measure(build_depths, a), measure(build_moments, a), measure(build_gather, sky),
                     measure(build_view, sky), measure(build_aerial, sky)};
  const errors e = compute_errors(a, fine);
  double total = 0.0;
  for (int i = 0; i < 5; i++) total += c[i].seconds;
  printf(
      "\ntolerance %.2g %%: %.1f ms in all; against the tracer %.2f %% to 90 degrees, %.2f %% at 93, %.2f %% at 96\n\n",
      100.0 * tolerance, 1e3 * total, compute_total_error(a, traced, 0, 90), compute_total_error(a, traced, 93, 93),
      compute_total_error(a, traced, 96, 96));
  char size[64];
  printf("| table | size | evaluations | ms | error %% |\n| --- | --- | --- | --- | --- |\n");
  (void)snprintf(size, sizeof size, "%d × %d + %d", n.depth.rows, n.depth.columns, n.depth.levels);
  print_table("optical depth", size, c[0], e.depths);
  (void)snprintf(size, sizeof size, "%d × %d from %d × %d", n.moments.rows, n.moments.columns, n.moments.node_rows,
                 n.moments.node_columns);
  print_table("moments", size, c[1], e.sources);
  print_table("gather", "3 × 4 × 13 × 9", c[2], e.sources);
  (void)snprintf(size, sizeof size, "%d × %d", n.view.up + n.view.down, n.view.azimuths);
  print_table("sky view", size, c[3], e.view);
  (void)snprintf(size, sizeof size, "%d × %d × %d", n.aerial.up + n.aerial.down, n.aerial.azimuths, n.aerial.points);
  print_table("aerial perspective", size, c[4], e.aerial);
  neph_sky_destroy(sky);
  neph_atmosphere_release(a);
}

int main(int argc, char **argv) {
  if (argc != 2 && argc != 3) return fprintf(stderr, "usage: bench_sky TRACED.csv [ISA]\n"), 2;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = 1;
  while (argc == 3 && desc.isa_max > NEPH_ISA_X86_64 && strcmp(argv[2], neph_isa_get_name(desc.isa_max)) != 0)
    desc.isa_max--;
  neph_context *context;
  require(neph_context_create(&desc, &context));
  printf("%s\n", neph_isa_get_name(neph_context_get_isa(context)));
  np_csv traced;
  require(np_csv_load(context, argv[1], &traced));
  np_table_sizes n = np_table_sizes_make(NP_SKY_TOLERANCE_MIN);
  n.moments.up = 20;
  n.moments.down = 12;
  n.moments.points = 48;
  neph_atmosphere *fine;
  const neph_atmosphere_desc air = describe_one_lobe();
  require(np_atmosphere_create_sized(context, &air, NP_ORDERS_ALL, false, &n, NULL, &fine));
  static const double tolerances[] = {0.05, 0.02, 0.01, NP_SKY_TOLERANCE_DEFAULT, 0.005, NP_SKY_TOLERANCE_MIN};
  for (size_t i = 0; i < sizeof tolerances / sizeof *tolerances; i++) {
    run_tolerance(context, tolerances[i], fine, &traced);
    fflush(stdout);
  }
  neph_atmosphere_release(fine);
  np_csv_clear(&traced);
  neph_context_destroy(context);
  return 0;
}
