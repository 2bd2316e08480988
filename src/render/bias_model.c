/* SPDX-License-Identifier: Apache-2.0 */
/* Each term is the root of a mean square over the pixels, fitted to pictures whose error was measured against the
 * tracer (docs/results/error.md). Terms are independent: their squares add up. */
#include "render/bias_model.h"

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

/* Light of a fire on smoke and ground. */
static const double emission_bias = 0.15;

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

double np_bias_model_forecast(const neph_scene *scene, const np_plan *plan) {
  if (plan->desc.integrator == NEPH_INTEGRATOR_PATH)
    return np_plan_has_air_light(plan) && !np_plan_traces_air(plan) ? air_bias : 0.0;
  cloud_light light = {.cell_error = np_plan_needs(plan, NP_STAGE_ORDINATES) ? plan->light_error : 0.0, .sine = 1.0};
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const double *albedo = scene->clouds[i].albedo;
    light.albedo = fmax(light.albedo, (albedo[0] + albedo[1] + albedo[2]) / 3.0);
    light.has_emission = light.has_emission || scene->clouds[i].emission.is_enabled;
  }
  if (plan->has_sun && plan->are_lights_known) light.sine = fmax(plan->lights.to_sun.z, sine_min);
  return combine(plan, &light, scene->render.tolerance, usual_cover);
}

double np_bias_model_choose_noise(const neph_scene *scene, const np_plan *plan) {
  const double target = plan->desc.target_error;
  if (!isfinite(target)) return HUGE_VAL;
  const double bias = np_bias_model_forecast(scene, plan);
  return sqrt(fmax(target * target - bias * bias, 0.25 * target * target));
}
