/* SPDX-License-Identifier: Apache-2.0 */
/* Each term is the root of a mean square over the pixels, fitted to pictures whose error was measured against the
 * tracer (docs/results/error.md). Terms are independent: their squares add up. */
#include "plan/error_forecast.h"

#include <math.h>

#include "atmosphere/medium.h"
#include "caches/sun_optical_depth.h"
#include "plan/plan_detail.h"
#include "plan/stage_decisions.h"
#include "transport/scattering_field.h"

const np_bias_term_table np_bias_terms = {
    .air = 0.015, .clear_air = 0.005, .steps = 0.15, .emission = 0.15, .water = 0.09, .air_over_water = 0.02};

/* The expected error of a solution's cells is a mean: the error of pixels is so many times as large under a high sun,
 * and grows as it sinks, as its light goes through more cells: by the hypotenuse of 1 and this over its sine. A sun
 * below the horizon soon leaves clouds to the sky's even light. */
static const double cells_to_pixels = 1.5, low_sun = 0.12, sine_min = 0.03;

/* Approximations of multiple scattering, over the clouds: rms in blocks of docs/results/approximations.md. */
static const double method_bias[] = {
    [NEPH_MULTIPLE_SCATTERING_NONE] = 0.9,    [NEPH_MULTIPLE_SCATTERING_OCTAVES] = 0.35,
    [NEPH_MULTIPLE_SCATTERING_ORDINATES] = 0, [NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER] = 0.35,
    [NEPH_MULTIPLE_SCATTERING_POWDER] = 0.6,  [NEPH_MULTIPLE_SCATTERING_DERIVATIVE] = 0.7,
};

/* Relative error of pixels per error of the sky's tables beyond the default, and per tolerance of sun optical
 * depths. */
static const double tables_share = 0.5, depths_share = 0.3;

/* Bakes whose voxels are twice as long err by 4.6 % in a field of cumulus, four times by 15 %. */
static const double voxels_bias = 0.046, voxels_order = 1.75;

/* Pixels' error over the residual at which the multiple scattering ends, and the error of degree 3
 * (docs/results/light-solve.md: a quarter of a residual of 0.01; 0.5 to 1.6 %). */
static const double residual_share = 0.25, degree_bias = 0.012;

/* Share of a light that counts by its height: 0 below the horizon, 1 above it. */
static double compute_risen(double sine) { return np_clamp(0.5 + 0.5 * sine / sine_min, 0.0, 1.0); }

/* Light that was scattered n times has the n-th power of the albedo; some four times are left to the cells. */
double np_bias_of_cells(double cell_error, double albedo, double sine) {
  const double low = compute_risen(sine) * low_sun / fmax(sine, sine_min);
  return cells_to_pixels * cell_error * pow(albedo, 4.0) * hypot(1.0, low);
}

double np_bias_of_water(double sine) { return compute_risen(sine) * np_bias_terms.water; }

double np_bias_of_solution(unsigned degree, double residual) {
  return hypot(degree <= NP_DEGREE_MIN ? degree_bias : 0.0, residual_share * residual);
}

double np_bias_of_method(neph_multiple_scattering method, double cover) { return sqrt(cover) * method_bias[method]; }

/* ---- Stages ---- */

/* Cover assumed before clouds are built. */
static const double usual_cover = 0.3;

static bool is_march(const np_plan *plan) { return plan->request.desc.integrator == NEPH_INTEGRATOR_MARCH; }

static bool has_clouds(const np_plan *plan) { return np_plan_needs(plan, NP_STAGE_VOLUMES); }

double np_stage_expect_atmosphere(const np_plan *plan, const neph_scene *scene) {
  const double excess = fmax(scene->atmosphere.tolerance - NP_SKY_TOLERANCE_DEFAULT, 0.0);
  if (!is_march(plan) && (!np_plan_has_air_light(plan) || np_request_traces_air(&plan->request))) return 0.0;
  const double air = has_clouds(plan) || !is_march(plan) ? np_bias_terms.air : np_bias_terms.clear_air;
  return hypot(hypot(air, np_scene_has_water(scene) ? np_bias_terms.air_over_water : 0.0), tables_share * excess);
}

double np_stage_expect_ordinates(const np_plan *plan, const neph_scene *scene) {
  double albedo = 0.0, sine = 1.0;
  if (!is_march(plan)) return 0.0;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const double *own = scene->clouds[i].albedo;
    albedo = fmax(albedo, (own[0] + own[1] + own[2]) / 3.0);
  }
  if (plan->decisions.left_out.is_all) return plan->decisions.left_out.share;
  if (plan->decisions.has_sun && plan->decisions.are_lights_known) sine = plan->decisions.lights.to_sun.z;
  const double solution = np_bias_of_solution((unsigned)scene->render.light_degree, scene->render.light_residual);
  return hypot(hypot(np_bias_of_cells(plan->decisions.cells.error, albedo, sine), solution),
               plan->decisions.left_out.share);
}

double np_stage_expect_approximation(const np_plan *plan, const neph_scene *scene) {
  (void)scene;
  return np_bias_of_method(plan->request.desc.multiple_scattering, usual_cover);
}

double np_stage_expect_emission(const np_plan *plan, const neph_scene *scene) {
  (void)scene;
  return is_march(plan) ? np_bias_terms.emission : 0.0;
}

double np_stage_expect_sun_optical_depth(const np_plan *plan, const neph_scene *scene) {
  const np_sun_optical_depth_desc desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT;
  (void)scene;
  return is_march(plan) ? depths_share * (double)desc.tolerance : 0.0;
}

/* Whether a cloud's voxels are read from a file. */
static bool is_of_file(const np_scene_cloud *cloud) { return cloud->vdb && !cloud->volume; }

/* Clouds whose voxels are coarser than the scene's err by that. */
double np_stage_expect_volumes(const np_plan *plan, const neph_scene *scene) {
  double factor = 1.0;
  for (unsigned i = 0; i < scene->cloud_count && plan->savings.are_coarse; i++)
    if (is_of_file(&scene->clouds[i])) factor = 2.0;
  for (unsigned i = 0; i < scene->cloud_count; i++)
    if (np_plan_is_coarsened(&plan->request, scene, &scene->clouds[i]))
      factor = fmax(factor,
                    np_plan_get_bake(&plan->request, scene, &scene->clouds[i]).voxel_m / scene->clouds[i].bake.voxel_m);
  return factor > 1.0 ? voxels_bias * pow(0.5 * factor, voxels_order) : 0.0;
}

/* Error of the integrator: of the march's steps, and of multiple scattering if it is neglected. */
double np_stage_expect_integrator(const np_plan *plan, const neph_scene *scene) {
  if (!is_march(plan) || !has_clouds(plan)) return 0.0;
  const bool has_none = plan->request.desc.multiple_scattering == NEPH_MULTIPLE_SCATTERING_NONE;
  const double none = has_none ? np_bias_of_method(NEPH_MULTIPLE_SCATTERING_NONE, usual_cover) : 0.0;
  return hypot(np_bias_terms.steps * scene->render.tolerance, none);
}

/* ---- Noise ---- */

/* Relative noise of a pixel by one sample, with clouds and without. For the march it holds for pictures 240 pixels
 * wide; smaller pixels contain less of an edge. */
static const double march_noise = 0.08, clear_march_noise = 0.05, path_noise = 1.2, clear_path_noise = 0.8;

/* The same of paths where there are fires, whose light in the air and on the ground few paths meet: 15 around burning
 * cumuli at night. */
static const double fire_path_noise = 12.0;
static const double usual_pixels = 240.0, edges_exponent = 0.6;

/* Exponents by which the variance falls with the number of samples; stratified samples of the march converge faster
 * than independent ones. */
static const double march_exponent = 1.5, path_exponent = 1.0;

/* Samples beyond the first with adaptive sampling (sample_counts.h), relative to uniform sampling with equal noise. */
static const double adaptive_share = 0.45, adaptive_path_share = 0.75;

/* Least share of a target that is left to noise where the bias takes more. */
static const double noise_share_min = 0.5;

static double get_noise_of_one(const np_plan *plan) {
  const double edges = pow(usual_pixels / plan->request.desc.width, edges_exponent);
  if (is_march(plan)) return edges * (has_clouds(plan) ? march_noise : clear_march_noise);
  if (plan->decisions.emission_count > 0) return fire_path_noise;
  return has_clouds(plan) ? path_noise : clear_path_noise;
}

static double get_exponent(const np_plan *plan) { return is_march(plan) ? march_exponent : path_exponent; }

static double get_share(const np_plan *plan) {
  if (!isfinite(plan->request.desc.target_error)) return 1.0;
  return is_march(plan) ? adaptive_share : adaptive_path_share;
}

double np_plan_get_noise(const np_plan *plan, double samples) {
  const double even = 1.0 + fmax(samples - 1.0, 0.0) / get_share(plan);
  return get_noise_of_one(plan) * pow(even, -0.5 * get_exponent(plan));
}

double np_plan_count_samples(const np_plan *plan, double noise) {
  const double even = pow(get_noise_of_one(plan) / noise, 2.0 / get_exponent(plan));
  return 1.0 + fmax(even - 1.0, 0.0) * get_share(plan);
}

double np_plan_choose_noise(const np_plan *plan) {
  const double target = plan->request.desc.target_error, bias = plan->forecast.bias;
  if (!isfinite(target)) return HUGE_VAL;
  return sqrt(fmax(target * target - bias * bias, pow(noise_share_min * target, 2.0)));
}

double np_plan_choose_samples(const np_plan *plan) {
  const np_request *r = &plan->request;
  const double noise = np_plan_choose_noise(plan);
  if (!isfinite(noise)) return (double)r->ray_count / (double)np_request_count_pixels(r);
  return fmin(fmax(np_plan_count_samples(plan, noise), r->desc.sample_count), r->desc.sample_count_max);
}
