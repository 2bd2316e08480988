/* SPDX-License-Identifier: Apache-2.0 */
/* Stiff and extreme clouds in both integrators: pairs of optical depth, albedo, asymmetry, field, ray and light. Each
 * is finite and not negative, and has the closed form where there is one.
 *
 * Closed forms: transmittance e^−τ. In a furnace of radiance 1 the light is 1 at an albedo of 1, e^−τ at 0 and between
 * them elsewhere. Of a sun along the ray, sunlight scattered once is ϖ·p·τ·e^−τ from ahead, and from behind
 * ϖ·p·e^−τ′·(1 − e^−2τ)/2, where τ′ lies behind the eye: as deep as the ray is each of its ways. A cloud of one
 * temperature emits (1 − ϖ)·B·(1 − e^−τ) along the ray, be it a slab or not, and what is scattered of that is apart.
 */
#include "march_count.h"

#include "integrate/march.h"
#include "march_picture.h"
#include "test_stability_page.h"
#include "test_stress_world.h"

#include <nephos/nephos.h>

#include "transport/scattering_field_private.h"

static const double depths[] = {0.0, 1e-8, 1e-6, 1e-3, 0.1, 1.0, 10.0, 88.0, 104.0, 1e3, 1e6};
static const float albedos[] = {0.0f, 0.5f, 0.999995f, 1.0f};
static const float asymmetries[] = {-0.999f, 0.0f, 1e-4f, 0.85f, 0.9946f, 0.999999f};

typedef enum stress_light { STRESS_FURNACE, STRESS_SUN_BEHIND, STRESS_SUN_AHEAD, STRESS_EMISSION } stress_light;
static const char *const light_names[] = {"furnace", "sun behind", "sun ahead", "emission"};

static const double bands_nm[NP_BAND_COUNT] = {680.0, 550.0, 440.0};
static const float kelvin = 1900.0f;

/* Scatterings after which paths are cut: a white path leaves a deep cloud after as many as it is deep. */
enum { SCATTERINGS = 300, MARCH_RAYS = 16, PATH_RAYS = 256 };

static test_page page;

/* ---- One case ---- */

typedef struct stress {
  const stress_case *levels;
  test_world w;
  np_camera_ray ray;
  double depth, behind; /* optical depths along the ray, and behind its eye */
  double once;          /* sunlight scattered once */
  np_emission emission; /* emission of an emitting cloud */
} stress;

static stress_light get_light(const stress *s) { return s->levels->level[STRESS_LIGHT]; }
static stress_field get_field(const stress *s) { return s->levels->level[STRESS_FIELD]; }
static bool is_march(const stress *s) { return s->levels->level[STRESS_INTEGRATOR] == 0; }
static double get_albedo(const stress *s) { return (double)albedos[s->levels->level[STRESS_ALBEDO]]; }

/* "path, τ 88 a voxel, …", for messages. */
static void name_case(const stress *s, char out[200]) {
  const unsigned *level = s->levels->level;
  (void)snprintf(out, 200, "%s, depth %g a voxel, albedo %g, g %g, %s, ray %s, %s", is_march(s) ? "march" : "path",
                 depths[level[STRESS_DEPTH]], get_albedo(s), (double)asymmetries[level[STRESS_ASYMMETRY]],
                 stress_field_names[get_field(s)], stress_ray_names[level[STRESS_RAY]], light_names[get_light(s)]);
}

/* Obeys Kirchhoff's law, at one temperature. */
static void set_emission(stress *s) {
  const np_instance *cloud = &s->w.placed[0];
  const float absorption = (1.0f - cloud->albedo.band[0]) * cloud->extinction_per_value;
  const np_emitter emitter = {.bricks = cloud->bricks,
                              .world_to_index = cloud->world_to_index,
                              .index_to_world = s->w.volumes[0]->index_to_world,
                              .absorption_per_value = np_spectrum_grey(absorption),
                              .world_to_temperature = np_affine_identity(),
                              .offset_k = kelvin};
  const np_black_body body = np_black_body_make(bands_nm);
  assert_int_equal(np_emission_build(s->w.context, &emitter, 1, &body, NULL, &s->emission), NEPH_OK);
  s->w.world.emission = &s->emission;
}

static void set_light(stress *s) {
  if (get_light(s) == STRESS_EMISSION) {
    set_emission(s);
    return;
  }
  if (get_light(s) == STRESS_FURNACE) {
    s->w.world.environment_radiance = np_spectrum_grey(1.0f);
    return;
  }
  const bool is_ahead = get_light(s) == STRESS_SUN_AHEAD;
  s->w.world.sun_irradiance = np_spectrum_grey(1.0f);
  s->w.world.to_sun = np_vec3_scale(s->ray.direction, is_ahead ? 1.0f : -1.0f);
  const float versine = np_vec3_versine(s->ray.direction, s->w.world.to_sun);
  const double scattered = get_albedo(s) * (double)np_phase_eval(&s->w.placed[0].phase, versine);
  s->once = scattered * (is_ahead ? s->depth * exp(-s->depth) : -0.5 * exp(-s->behind) * expm1(-2.0 * s->depth));
}

static void start(stress *s, const stress_case *levels, unsigned threads) {
  *s = (stress){.levels = levels};
  test_world_init(&s->w, test_context_create(threads, NULL));
  s->w.world.clouds.at = s->w.placed;
  s->w.lighting.sun_optical_depths.clouds = &s->w.world.clouds;
  s->w.volumes[0] = stress_create_volume(s->w.context, get_field(s));
  s->w.placed[0] = (np_instance){.bricks = &s->w.volumes[0]->bricks,
                                 .world_to_index = s->w.volumes[0]->world_to_index,
                                 .extinction_per_value = (float)depths[levels->level[STRESS_DEPTH]],
                                 .albedo = np_spectrum_grey((float)get_albedo(s)),
                                 .phase = np_phase_henyey_greenstein(asymmetries[levels->level[STRESS_ASYMMETRY]])};
  s->w.world.clouds.count = 1;
  s->w.desc.cells.bounds_min = np_dvec3_make(stress_low_m - 1.0, stress_low_m - 1.0, stress_low_m - 1.0);
  s->w.desc.cells.bounds_max = np_dvec3_scale(s->w.desc.cells.bounds_min, -1.0);
  s->w.desc.cells.cell_count_cheap = 4000;
  s->w.desc.cells.cell_count_max = 12000;
  s->w.desc.work_max = 0.0;
  s->ray = stress_make_ray(levels->level[STRESS_RAY]);
  const double per_value = (double)s->w.placed[0].extinction_per_value;
  const np_vec3 back = np_vec3_scale(s->ray.direction, -1.0f);
  s->depth = per_value * stress_compute_depth(get_field(s), s->ray.origin, s->ray.direction);
  s->behind = per_value * stress_compute_depth(get_field(s), s->ray.origin, back);
  set_light(s);
  if (is_march(s))
    assert_int_equal(test_world_solve(&s->w), NEPH_OK);
  else
    s->w.settings.scattering_max = SCATTERINGS;
}

static void end(stress *s) {
  np_emission_clear(&s->emission);
  test_world_destroy(&s->w);
}

/* ---- Answers ---- */

typedef struct stress_answer {
  test_tally light, transmittance, sun, emission;
  double lookups; /* density look-ups per ray */
  unsigned sweeps;
  uint64_t cut_count;
  bool is_sound; /* finite, and not negative */
} stress_answer;

static bool is_sound(const np_integrator_sample *sample) {
  bool is_good = sample->transmittance >= 0.0f && sample->transmittance <= 1.0f;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const double sum = test_sum_components(sample, b);
    is_good = is_good && isfinite(sum) && sum >= 0.0;
  }
  return is_good;
}

static void ask(stress *s, stress_answer *out) {
  *out = (stress_answer){.is_sound = true, .sweeps = s->w.scattering ? s->w.scattering->sweeps : 0};
  np_random random = np_random_start(1, 0, 0, 0, 0);
  const int count = is_march(s) ? MARCH_RAYS : PATH_RAYS;
  march_lookups = 0;
  for (int i = 0; i < count; i++) {
    np_integrator_sample sample;
    s->ray.jitter = np_random_float(&random);
    if (is_march(s))
      np_march_sample_counted(&s->w.world, &s->w.lighting, &s->w.settings, &s->ray, &random, &sample);
    else
      test_world_path(&s->w, &s->ray, &random, &sample);
    out->is_sound = out->is_sound && is_sound(&sample);
    out->cut_count += sample.cut_count;
    test_tally_add(&out->light, test_sum_components(&sample, 0));
    test_tally_add(&out->transmittance, (double)sample.transmittance);
    test_tally_add(&out->sun, (double)sample.component[NP_COMPONENT_SUN].band[0]);
    test_tally_add(&out->emission, (double)sample.component[NP_COMPONENT_EMISSION].band[0]);
  }
  out->lookups = (double)march_lookups / count;
}

/* ---- Checks ---- */

/* The worst of each kind, over what is tolerated. */
typedef struct stress_worst {
  const char *kind, *unit;
  double value;
  char name[200];
} stress_worst;

enum { MARCH_T, MARCH_ONCE, MARCH_FURNACE, MARCH_EMISSION, PATH_T, PATH_ONCE, PATH_FURNACE, PATH_EMISSION, KINDS };

static stress_worst worst[KINDS] = {
    {.kind = "march, transmittance", .unit = "of the opacity"},
    {.kind = "march, sunlight scattered once", .unit = "of what it would be without shadow"},
    {.kind = "march, furnace", .unit = "of the light"},
    {.kind = "march, emission along the ray", .unit = "of that of its opacity"},
    {.kind = "path, transmittance", .unit = "standard errors"},
    {.kind = "path, sunlight scattered once", .unit = "standard errors"},
    {.kind = "path, furnace", .unit = "standard errors"},
    {.kind = "path, emission along the ray", .unit = "standard errors"},
};

static void hold(const stress *s, int kind, double error, double tolerance) {
  char name[200];
  name_case(s, name);
  if (!(error <= tolerance)) fail_msg("%s: %s off by %g, may be %g", name, worst[kind].kind, error, tolerance);
  if (error <= worst[kind].value) return;
  worst[kind].value = error;
  memcpy(worst[kind].name, name, sizeof name);
}

/* Opacity below which an error of the march need not shrink with it, and the end of its rays. */
static double get_scale(const stress *s, double opacity) {
  return fmax(opacity, fmax((double)np_march_opacity_least, (double)s->w.settings.transmittance_end));
}

/* Emission of an opaque cloud. */
static double get_opaque(const stress *s) {
  return (1.0 - get_albedo(s)) * np_black_body_radiance(bands_nm[0], (double)kelvin);
}

/* Half the tolerance is the rms error that a ray's opacity may have, and single rays may be six times that off, as in
 * test_march_steps; sunlight along it passes the cloud twice. */
static void check_march(const stress *s, const stress_answer *a) {
  const double opacity = -expm1(-s->depth), scale = get_scale(s, opacity);
  const double tolerance = 3.0 * (double)s->w.settings.tolerance;
  hold(s, MARCH_T, fabs(test_tally_mean(&a->transmittance) - exp(-s->depth)) / scale, tolerance);
  if (get_light(s) == STRESS_FURNACE) {
    const double light = test_tally_mean(&a->light);
    const double low = get_albedo(s) == 1.0 ? 1.0 : exp(-s->depth), high = get_albedo(s) == 0.0 ? low : 1.0;
    hold(s, MARCH_FURNACE, fmax(fmax(low - light, light - high), 0.0), tolerance);
    return;
  }
  if (get_light(s) == STRESS_EMISSION) {
    const double off = fabs(test_tally_mean(&a->emission) - get_opaque(s) * opacity);
    hold(s, MARCH_EMISSION, off > 0.0 ? off / (get_opaque(s) * scale) : 0.0, tolerance);
    return;
  }
  /* Light far below that of an isotropic phase function, 1/4π, need not be known. */
  const np_vec3 d = s->ray.direction;
  const double phase = (double)np_phase_eval(&s->w.placed[0].phase, np_vec3_versine(d, s->w.world.to_sun));
  const double unshadowed = get_albedo(s) * fmax(phase, 0.25 / NP_PI) * scale;
  const double off = fabs(test_tally_mean(&a->sun) - s->once);
  hold(s, MARCH_ONCE, unshadowed > 0.0 ? off / unshadowed : off, 2.0 * tolerance);
}

/* Standard errors of a mean, those of a sum of few events being as known as its own. */
static double count_errors(const test_tally *t, double expected, double per_event) {
  const double poisson = sqrt(fabs(expected) * per_event / t->count);
  const double error = fmax(hypot(test_tally_error(t), 1e-6 * fabs(expected)), poisson);
  const double off = fabs(test_tally_mean(t) - expected);
  return off > 0.0 ? off / error : 0.0;
}

/* A ray brings at most its phase function once, and no more than 1 of the furnace. Paths that were cut bring less. */
static void check_path(const stress *s, const stress_answer *a) {
  const double through = exp(-s->depth), smaller = fmin(through, -expm1(-s->depth));
  const double opaque = test_tally_mean(&a->transmittance) - through;
  test_tally t = a->transmittance;
  const double error = fmax(hypot(test_tally_error(&t), 1e-7), s->depth > 1e-3 ? sqrt(smaller / t.count) : 0.0);
  hold(s, PATH_T, fabs(opaque) / error, 4.0);
  if (get_light(s) == STRESS_FURNACE) {
    const double light = test_tally_mean(&a->light), noise = hypot(test_tally_error(&a->light), 1e-5);
    const double low = get_albedo(s) == 1.0 ? 1.0 : through, high = get_albedo(s) == 0.0 ? low : 1.0;
    const double below = a->cut_count > 0 ? 0.0 : low - light;
    hold(s, PATH_FURNACE, fmax(fmax(below, light - high), 0.0) / fmax(noise, error), 4.0);
    return;
  }
  if (get_light(s) == STRESS_EMISSION) {
    hold(s, PATH_EMISSION, count_errors(&a->emission, -expm1(-s->depth) * get_opaque(s), get_opaque(s)), 4.0);
    return;
  }
  const np_vec3 d = s->ray.direction;
  const double phase = (double)np_phase_eval(&s->w.placed[0].phase, np_vec3_versine(d, s->w.world.to_sun));
  hold(s, PATH_ONCE, count_errors(&a->sun, s->once, get_albedo(s) * phase), 4.0);
}

/* ---- All cases ---- */

static stress_cases cases;

static void every_pair_of_levels_is_in_a_case(void **state) {
  (void)state;
  test_page_add_figure(&page, "\n## Clouds, in both integrators\n");
  stress_cases_build(&cases);
  assert_int_equal(cases.pairs, stress_count_pairs());
  unsigned found = 0;
  for (unsigned f = 0; f < STRESS_FACTORS; f++)
    for (unsigned g = f + 1; g < STRESS_FACTORS; g++)
      for (unsigned i = 0; i < stress_levels[f]; i++)
        for (unsigned j = 0; j < stress_levels[g]; j++)
          for (unsigned n = 0; n < cases.count; n++)
            if (cases.at[n].level[f] == i && cases.at[n].level[g] == j) {
              found++;
              break;
            }
  assert_int_equal(found, stress_count_pairs());
  test_page_add_fact(&page, "%u cases hold each of the %u pairs of two levels.\n", cases.count, found);
}

static int compare_doubles(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Median and greatest of a cost. */
static void compare_cost(const char *what, double *values, size_t count) {
  qsort(values, count, sizeof *values, compare_doubles);
  const double median = values[count / 2], most = values[count - 1];
  test_page_add_figure(&page, "| march, %s | median %.0f, most %.0f | 20 times the median |", what, median, most);
  if (!(most <= 20.0 * median)) fail_msg("%s: %g, of which the median is %g", what, most, median);
}

static void every_case_is_sound(void **state) {
  (void)state;
  double lookups[STRESS_CASES_MAX], sweeps[STRESS_CASES_MAX];
  size_t marched = 0, solved = 0, cut = 0, paths = 0;
  for (unsigned n = 0; n < cases.count; n++) {
    stress s;
    stress_answer a;
    start(&s, &cases.at[n], 1);
    ask(&s, &a);
    char name[200];
    name_case(&s, name);
    if (!a.is_sound) fail_msg("%s: not finite, or negative", name);
    (is_march(&s) ? check_march : check_path)(&s, &a);
    cut += a.cut_count > 0;
    paths += !is_march(&s);
    if (is_march(&s) && s.depth > 0.0) lookups[marched++] = a.lookups;
    if (is_march(&s) && s.depth > 0.1 && get_albedo(&s) > 0.0) sweeps[solved++] = a.sweeps;
    end(&s);
  }
  test_page_add_fact(&page, "March: %u cases. Path: %zu cases, of which %zu have paths cut after %d scatterings.\n",
                     cases.count - (unsigned)paths, paths, cut, SCATTERINGS);
  test_page_add_figure(&page, "| kind | worst | case, or limit |\n| --- | --- | --- |");
  for (int k = 0; k < KINDS; k++)
    test_page_add_figure(&page, "| %s | %.2g %s | %s |", worst[k].kind, worst[k].value, worst[k].unit, worst[k].name);
  compare_cost("look-ups of density a ray", lookups, marched);
  compare_cost("sweeps", sweeps, solved);
}

/* The light of a march is the same to the bit, for the solution is; a path's ray knows no threads. */
static void threads_change_no_bit(void **state) {
  (void)state;
  unsigned count = 0;
  for (unsigned n = 0; n < cases.count; n++) {
    if (cases.at[n].level[STRESS_INTEGRATOR] != 0) continue;
    double sums[2][2];
    for (unsigned threads = 1; threads <= 2; threads++) {
      stress s;
      stress_answer a;
      start(&s, &cases.at[n], threads);
      ask(&s, &a);
      sums[threads - 1][0] = test_tally_mean(&a.light);
      sums[threads - 1][1] = test_tally_error(&a.light);
      end(&s);
    }
    assert_memory_equal(sums[0], sums[1], sizeof sums[0]);
    count++;
  }
  test_page_add_fact(&page, "\nThe %u marches have the same bits with one thread and with two.\n", count);
}

/* ---- Pictures ---- */

/* A white box of a density a voxel by `path`. */
static neph_image *render_path(unsigned threads, const char *samples, double density, const char *limit,
                               test_log *log) {
  float values[STRESS_EDGE * STRESS_EDGE * STRESS_EDGE];
  const neph_volume_dense_desc desc = stress_describe(STRESS_CONSTANT, values);
  neph_context *context = test_context_create(threads, log);
  neph_scene *scene;
  neph_volume *volume;
  neph_image *image;
  assert_int_equal(
      neph_scene_load_text(context,
                           "{camera: {position: [0, -40, 0], look_at: [0, 0, 0], fov: 20 deg, resolution: [8, 8]},"
                           " atmosphere: {preset: none}, environment: {planet: none, radiance: 1},"
                           " render: {integrator: path}}",
                           "scene.yaml", &scene),
      NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.samples", samples), NEPH_OK);
  if (limit) assert_int_equal(neph_scene_set(scene, "render.max_scatterings", limit), NEPH_OK);
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
  neph_placement_desc placement = NEPH_PLACEMENT_DESC_DEFAULT;
  placement.density_value = density;
  assert_int_equal(neph_scene_add_volume(scene, volume, &placement, NULL), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_volume_release(volume);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return image;
}

static void assert_same_pictures(neph_image *images[2]) {
  static const char *const channels[] = {"R", "G", "B"};
  for (size_t c = 0; c < sizeof channels / sizeof *channels; c++)
    assert_memory_equal(neph_image_get_values(images[0], channels[c]), neph_image_get_values(images[1], channels[c]),
                        64 * sizeof(float));
  for (int i = 0; i < 2; i++) neph_image_destroy(images[i]);
}

/* Paths of some tens of scatterings, to their ends. */
static void threads_change_no_bit_of_a_path(void **state) {
  (void)state;
  neph_image *images[2];
  for (unsigned threads = 1; threads <= 2; threads++) images[threads - 1] = render_path(threads, "4", 1.0, NULL, NULL);
  assert_same_pictures(images);
  test_page_add_fact(&page, "A picture by paths has the same bits with one thread and with two.\n");
}

/* A wall of 1e5 a voxel, whose paths would leave after as many scatterings. The loss is infinite, and said to be, where
 * too few of the cut paths are followed for it to be known. Threads change no bit of the picture. */
static void a_cut_picture_states_an_infinite_loss(void **state) {
  (void)state;
  static test_log log;
  neph_image *images[2];
  for (unsigned threads = 1; threads <= 2; threads++) {
    test_log_start(&log);
    images[threads - 1] = render_path(threads, "1", 1e5, "20", &log);
    assert_string_equal(neph_image_get_attribute(images[threads - 1], "nephos:lostMean"), "inf inf inf");
    assert_non_null(strstr(log.text, "render.max_scatterings 20 ended"));
    assert_non_null(strstr(log.text, "the light that is lost is not known"));
  }
  assert_same_pictures(images);
}

/* ---- Refusals ---- */

static void refuse_fields(test_log *log, neph_context *context, stress_field field) {
  float values[STRESS_EDGE * STRESS_EDGE * STRESS_EDGE];
  const neph_volume_dense_desc desc = stress_describe(field, values);
  neph_volume *volume;
  char input[80];
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(volume);
  (void)snprintf(input, sizeof input, "array, %s", stress_field_names[field]);
  test_page_add_refusal(&page, input, log);
  np_sparse_grid grid;
  stress_fill_grid(context, field, &grid);
  assert_int_equal(np_volume_import_values(context, "stress.vdb", &grid, NP_VALUES_OF_CLOUD, NEPH_IMPORT_REFUSE, NULL),
                   NEPH_ERROR_BAD_FILE);
  np_sparse_grid_clear(&grid);
  (void)snprintf(input, sizeof input, "file, %s", stress_field_names[field]);
  test_page_add_refusal(&page, input, log);
}

static void refuse_keys(test_log *log, neph_context *context) {
  static const char *const keys[][2] = {
      {"clouds[0].albedo", "1.0000001"},   {"clouds[0].albedo", "-0.1"},     {"clouds[0].albedo", ".nan"},
      {"clouds[0].phase.hg", "1"},         {"clouds[0].phase.hg", "-1"},     {"clouds[0].phase.hg", ".nan"},
      {"clouds[0].extinction", "-1 1/m"},  {"clouds[0].extinction", ".inf"}, {"clouds[0].extinction", ".nan"},
      {"render.tolerance", "0"},           {"render.tolerance", ".nan"},     {"render.transmittance_end", "2"},
      {"camera.position", "[.inf, 0, 0]"}, {"sun.elevation", "91 deg"},      {"sun.angular_radius", "-1 deg"},
      {"environment.radiance", "-1"},
  };
  for (size_t k = 0; k < sizeof keys / sizeof *keys; k++) {
    neph_scene *scene;
    assert_int_equal(neph_scene_load_text(context, "{clouds: [{vdb: a.vdb, extinction: 1 1/m}]}", "scene.yaml", &scene),
                     NEPH_OK);
    test_log_clear(log);
    char input[120];
    (void)snprintf(input, sizeof input, "`%s: %s`", keys[k][0], keys[k][1]);
    neph_result result = neph_scene_set(scene, keys[k][0], keys[k][1]);
    if (!result) result = neph_scene_check(scene);
    if (result == NEPH_OK) fail_msg("%s is taken", input);
    test_page_add_refusal(&page, input, log);
    neph_scene_destroy(scene);
  }
}

static void others_are_refused_with_a_message(void **state) {
  (void)state;
  static test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  test_page_add_figure(&page, "| refused | message |\n| --- | --- |");
  refuse_fields(&log, context, STRESS_HALF_NAN);
  refuse_fields(&log, context, STRESS_NEGATIVE);
  refuse_keys(&log, context);
  neph_context_destroy(context);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_pair_of_levels_is_in_a_case),
      cmocka_unit_test(every_case_is_sound),
      cmocka_unit_test(threads_change_no_bit),
      cmocka_unit_test(threads_change_no_bit_of_a_path),
      cmocka_unit_test(a_cut_picture_states_an_infinite_loss),
      cmocka_unit_test(others_are_refused_with_a_message),
  };
  page = test_page_open(argc, argv);
  const int result = cmocka_run_group_tests(tests, NULL, NULL);
  test_page_close(&page);
  return result;
}
