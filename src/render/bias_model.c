/* SPDX-License-Identifier: Apache-2.0 */
/* Each term is the root of a mean square over the pixels, fitted to pictures whose error was measured against the
 * tracer (docs/results/error.md). Terms are independent: their squares add up. */
#include "render/bias_model.h"

#include <math.h>

#include "atmosphere/medium.h"
#include "render/plan_detail.h"
#include "render/stage_decisions.h"

/* Tables of the air and light between air, clouds and ground, by day. */
static const double air_bias = 0.01, clear_air_bias = 0.005;

/* The error that a solution expects of its cells is that of a mean: one of pixels is so many times as large under a
 * high sun, and grows as it sinks, as light goes through more cells: by the hypotenuse of 1 and this over its sine. */
static const double cells_to_pixels = 1.5, low_sun = 0.12, sine_min = 0.03;

/* Share of a march's tolerance that its steps err by. */
static const double steps_share = 0.15;

/* Approximations of multiple scattering, over the clouds: rms in blocks of docs/results/approximations.md. */
static const double method_bias[] = {
    [NEPH_MULTIPLE_SCATTERING_NONE] = 0.9,    [NEPH_MULTIPLE_SCATTERING_OCTAVES] = 0.35,
    [NEPH_MULTIPLE_SCATTERING_ORDINATES] = 0, [NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER] = 0.35,
    [NEPH_MULTIPLE_SCATTERING_POWDER] = 0.6,  [NEPH_MULTIPLE_SCATTERING_DERIVATIVE] = 0.7,
};

/* Error of pixels over what the sky's tables may err by beyond the default, and over the tolerance of sun optical
 * depths. */
static const double tables_share = 0.5, depths_share = 0.3;

/* Bakes whose voxels are twice as long err by 4.6 % in a field of cumulus, four times by 15 %. */
static const double voxels_bias = 0.046, voxels_order = 1.75;

/* Pixels' error over the residual at which the multiple scattering ends. */
static const double residual_share = 0.5;

/* Light of a fire on smoke and ground. */
static const double emission_bias = 0.05;

/* Figures of the clouds and their lights, the worst of all. */
typedef struct cloud_light {
  double cell_error; /* of the solved multiple scattering; 0: it is not solved */
  double albedo;     /* the highest of all clouds, the mean of its bands */
  double sine;       /* of the lights' elevation, the lowest above the horizon */
  bool has_emission;
} cloud_light;

static void add_light(const np_packet_light *light, cloud_light *out) {
  const np_scattering_field *field = light->lighting.scattering;
  const np_world *world = &light->world;
  if (field) out->cell_error = fmax(out->cell_error, np_scattering_field_get_quality(field).error);
  for (unsigned i = 0; i < world->clouds.count; i++) {
    const np_spectrum albedo = world->clouds.at[i].albedo;
    out->albedo = fmax(out->albedo, (double)(albedo.band[0] + albedo.band[1] + albedo.band[2]) / NP_BAND_COUNT);
  }
  if (world->sun_scope != NP_SUN_SKY && np_spectrum_max(world->sun_irradiance) > 0.0f)
    out->sine = fmin(out->sine, fmax(light->direction.z, sine_min));
}

static cloud_light look_at_light(const np_assembly *assembly) {
  cloud_light out = {.sine = 1.0};
  for (unsigned p = 0; p < assembly->packet_count; p++) {
    const np_packet *packet = &assembly->packets[p];
    out.has_emission = out.has_emission || packet->emission.emitter_count > 0;
    for (unsigned i = 0; i < packet->light_count; i++) add_light(&packet->lights[i], &out);
  }
  return out;
}

/* Mean square of the clouds' opacity. */
static double compute_cover(const np_frame *f) {
  double sum = 0.0;
  const size_t count = (size_t)f->width * f->height;
  for (size_t i = 0; i < count; i++) sum += pow((double)f->luminances[i].opacity, 2.0);
  return sum / (double)count;
}

/* Share of the light that a limit on scatterings has taken. */
static double compute_lost(const np_frame *f) {
  double lost = 0.0, kept = 0.0;
  for (size_t tile = 0; tile < np_frame_count_tiles(f); tile++)
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      lost += f->totals[tile].lost[b];
      kept += f->totals[tile].sum[b];
    }
  return lost > 0.0 ? lost / (lost + kept) : 0.0;
}

static np_bias_model make_of_path(const np_frame *f, const np_plan *plan) {
  const double air = np_plan_has_air_light(plan) && !np_plan_traces_air(plan) ? air_bias : 0.0;
  return (np_bias_model){hypot(air, compute_lost(f)), 2.0};
}

/* Light that was scattered n times has the n-th power of the albedo; some four times are left to the cells. */
static double count_cells(const cloud_light *light) {
  return cells_to_pixels * light->cell_error * pow(light->albedo, 4.0) * hypot(1.0, low_sun / light->sine);
}

/* Bias of a march. */
static double combine(const np_plan *plan, const cloud_light *light, double tolerance, double cover) {
  const bool has_air = np_plan_needs(plan, NP_STAGE_ATMOSPHERE);
  if (!np_plan_needs(plan, NP_STAGE_VOLUMES)) return has_air ? clear_air_bias : 0.0;
  const double cells = count_cells(light), steps = steps_share * tolerance;
  const double method = sqrt(cover) * method_bias[plan->desc.multiple_scattering];
  const double rest = hypot(has_air ? air_bias : 0.0, light->has_emission ? emission_bias : 0.0);
  np_log(
      plan->context, NEPH_LOG_DEBUG,
      "model of the bias: cells %.2g, steps %.2g, method %.2g, air and fire %.2g; cells err by %.2g, clouds cover %.2g",
      cells, steps, method, rest, light->cell_error, cover);
  return hypot(hypot(cells, steps), hypot(method, rest));
}

np_bias_model np_bias_model_make(const np_frame *f, const np_plan *plan) {
  if (f->desc->integrator == NEPH_INTEGRATOR_PATH) return make_of_path(f, plan);
  const cloud_light light = look_at_light(f->assembly);
  return (np_bias_model){combine(plan, &light, (double)f->settings.tolerance, compute_cover(f)),
                         light.has_emission ? 3.0 : 1.8};
}

/* ---- Before anything is built ---- */

/* Cover of clouds that nobody has seen yet. */
static const double usual_cover = 0.3;

static bool is_march(const np_plan *plan) { return plan->desc.integrator == NEPH_INTEGRATOR_MARCH; }

static bool has_clouds(const np_plan *plan) { return np_plan_needs(plan, NP_STAGE_VOLUMES); }

double np_stage_expect_atmosphere(const np_plan *plan, const neph_scene *scene) {
  const double finer = fmax(scene->atmosphere.tolerance - NP_SKY_TOLERANCE_DEFAULT, 0.0);
  if (!is_march(plan) && (!np_plan_has_air_light(plan) || np_plan_traces_air(plan))) return 0.0;
  return hypot(has_clouds(plan) || !is_march(plan) ? air_bias : clear_air_bias, tables_share * finer);
}

double np_stage_expect_ordinates(const np_plan *plan, const neph_scene *scene) {
  cloud_light light = {.cell_error = plan->light_error, .sine = 1.0};
  if (!is_march(plan)) return 0.0;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const double *albedo = scene->clouds[i].albedo;
    light.albedo = fmax(light.albedo, (albedo[0] + albedo[1] + albedo[2]) / 3.0);
  }
  if (plan->has_sun && plan->are_lights_known) light.sine = fmax(plan->lights.to_sun.z, sine_min);
  return hypot(count_cells(&light), residual_share * scene->render.light_residual);
}

double np_stage_expect_approximation(const np_plan *plan, const neph_scene *scene) {
  (void)scene;
  return sqrt(usual_cover) * method_bias[plan->desc.multiple_scattering];
}

double np_stage_expect_emission(const np_plan *plan, const neph_scene *scene) {
  (void)scene;
  return is_march(plan) ? emission_bias : 0.0;
}

double np_stage_expect_sun_optical_depth(const np_plan *plan, const neph_scene *scene) {
  const np_sun_optical_depth_desc desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT;
  (void)scene;
  return is_march(plan) ? depths_share * (double)desc.tolerance : 0.0;
}

/* Of bakes whose voxels are coarser than the scene's. */
double np_stage_expect_volumes(const np_plan *plan, const neph_scene *scene) {
  double factor = 1.0;
  for (unsigned i = 0; i < scene->cloud_count; i++)
    if (np_plan_is_coarsened(plan, scene, &scene->clouds[i]))
      factor = fmax(factor, np_plan_get_bake(plan, scene, &scene->clouds[i]).voxel_m / scene->clouds[i].bake.voxel_m);
  return factor > 1.0 ? voxels_bias * pow(0.5 * factor, voxels_order) : 0.0;
}

/* Steps, and light that is scattered more than once where nothing stands for it. */
double np_stage_expect_integrator(const np_plan *plan, const neph_scene *scene) {
  if (!is_march(plan) || !has_clouds(plan)) return 0.0;
  const bool has_none = plan->desc.multiple_scattering == NEPH_MULTIPLE_SCATTERING_NONE;
  const double none = has_none ? sqrt(usual_cover) * method_bias[NEPH_MULTIPLE_SCATTERING_NONE] : 0.0;
  return hypot(steps_share * scene->render.tolerance, none);
}

/* ---- Noise ---- */

/* Relative noise of one sample a pixel, with clouds and without. */
static const double march_noise = 0.12, clear_march_noise = 0.05, path_noise = 1.0, clear_path_noise = 0.7;

/* Power of their number by which the variance of samples falls; even samples of a march do better than independent
 * ones. */
static const double march_exponent = 1.5, path_exponent = 1.0;

/* Samples beyond the first over those of a picture with the same number in each pixel, where each has its own
 * (sample_counts.h). */
static const double adaptive_share = 0.45;

/* Least share of a target that is left to noise where the bias takes more. */
static const double noise_share_min = 0.5;

static double get_noise_of_one(const np_plan *plan) {
  if (is_march(plan)) return has_clouds(plan) ? march_noise : clear_march_noise;
  return has_clouds(plan) ? path_noise : clear_path_noise;
}

static double get_exponent(const np_plan *plan) { return is_march(plan) ? march_exponent : path_exponent; }

static bool is_adaptive(const np_plan *plan) { return isfinite(plan->desc.target_error); }

double np_bias_model_get_noise(const np_plan *plan, double samples) {
  const double even = 1.0 + fmax(samples - 1.0, 0.0) / (is_adaptive(plan) ? adaptive_share : 1.0);
  return get_noise_of_one(plan) * pow(even, -0.5 * get_exponent(plan));
}

double np_bias_model_count_samples(const np_plan *plan, double noise) {
  const double even = pow(get_noise_of_one(plan) / noise, 2.0 / get_exponent(plan));
  return 1.0 + fmax(even - 1.0, 0.0) * (is_adaptive(plan) ? adaptive_share : 1.0);
}

double np_bias_model_choose_noise(const np_plan *plan) {
  const double target = plan->desc.target_error, bias = plan->bias;
  if (!isfinite(target)) return HUGE_VAL;
  return sqrt(fmax(target * target - bias * bias, pow(noise_share_min * target, 2.0)));
}

void np_bias_model_predict_noise(np_plan *plan) {
  const double wanted = np_bias_model_choose_noise(plan), least = plan->desc.sample_count;
  plan->sample_mean = (double)plan->ray_count / (double)np_plan_count_pixels(plan);
  if (isfinite(wanted))
    plan->sample_mean = fmin(fmax(np_bias_model_count_samples(plan, wanted), least), plan->desc.sample_count_max);
  plan->noise = np_bias_model_get_noise(plan, plan->sample_mean);
}
