/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/bias_model.h"

#include "plan/error_forecast.h"
#include "volume/instance_period.h"

/* Edges err more than the middles of clouds, and few clouds have more of an edge each: the error falls as this power of
 * the mean square of the opacity. */
static const double cover_exponent = 0.25;

/* Figures of the clouds and their lights, the worst of all. */
typedef struct cloud_light {
  double cell_error; /* error of the solved multiple scattering; 0: it is not solved */
  double solution;   /* bias that its degree and its residual make */
  double albedo;     /* the highest of all clouds, the mean of its bands */
  double sine;       /* sine of the lights' lowest elevation above the horizon */
  double highest;    /* the same of the highest; -1: there is no light */
  double haze;       /* vertical optical depth of scattering by aerosols, green */
  double glint;      /* share of the air that has the sun's glint on water */
  bool has_emission;
  bool has_mixed_periods; /* some clouds repeat without end, and others end or have other periods */
  bool has_false_fires;   /* all that the camera sees lacks light of fires, or has it back from a period */
  bool has_water;         /* water lights undersides of clouds that the camera sees: it is not above all of them */
  bool is_under;          /* the camera is below all clouds, on whose undersides the ground's light counts */
} cloud_light;

static void add_light(const np_packet_light *light, cloud_light *out) {
  const np_scattering_field *field = light->lighting.scattering;
  const np_world *world = &light->world;
  if (field && np_scattering_field_count_cells(field) > 0) {
    const np_scattering_quality quality = np_scattering_field_get_quality(field);
    const double solution = np_bias_of_solution(np_scattering_field_get_degree(field), quality.residual);
    out->cell_error = fmax(out->cell_error, quality.error);
    out->solution = fmax(out->solution, solution);
  }
  for (unsigned i = 0; i < world->clouds.count; i++) {
    const np_spectrum albedo = world->clouds.at[i].albedo;
    out->albedo = fmax(out->albedo, (double)(albedo.band[0] + albedo.band[1] + albedo.band[2]) / NP_BAND_COUNT);
  }
  if (world->atmosphere) {
    out->haze = fmax(out->haze, np_atmosphere_compute_haze(world->atmosphere));
    out->glint = (double)np_atmosphere_get_glint(world->atmosphere);
  }
  if (world->sun_scope == NP_SUN_SKY || !(np_spectrum_max(world->sun_irradiance) > 0.0f)) return;
  out->sine = fmin(out->sine, light->beam.direction.z);
  out->highest = fmax(out->highest, light->beam.direction.z);
}

/* Fills the figures of clouds that repeat beside others. */
static void add_periods(const np_assembly *assembly, const np_world *world, cloud_light *out) {
  const np_light_period x = np_instances_get_light_period(&world->clouds, 0),
                        y = np_instances_get_light_period(&world->clouds, 1);
  if (np_light_period_is_common(x) && np_light_period_is_common(y)) return;
  const np_dvec3 low = np_dvec3_make(x.low_m, y.low_m, assembly->clouds.low.z),
                 high = np_dvec3_make(x.low_m + x.length_m, y.low_m + y.length_m, assembly->clouds.high.z);
  out->has_mixed_periods = true;
  const bool come_back = world->emission && !np_scattering_has_fires_apart(world);
  out->has_false_fires = out->has_false_fires || come_back || !np_camera_sees_box(&assembly->camera, low, high);
}

static cloud_light measure_light(const np_assembly *assembly) {
  const bool is_below = assembly->camera.origin.z < assembly->clouds.high.z;
  cloud_light out = {.sine = 1.0, .highest = -1.0, .is_under = assembly->camera.origin.z < assembly->clouds.low.z};
  for (unsigned p = 0; p < assembly->packet_count; p++) {
    const np_packet *packet = &assembly->packets[p];
    out.has_emission = out.has_emission || packet->emission.all.emitter_count > 0;
    for (unsigned i = 0; i < packet->light_count; i++) {
      add_light(&packet->lights[i], &out);
      add_periods(assembly, &packet->lights[i].world, &out);
      out.has_water = out.has_water || (is_below && packet->lights[i].world.water);
    }
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

/* Ratio of luminances from which on a fire outshines its surroundings, and the bias of these: the air beyond the reach
 * of caches/lit_air.h has a fire's light by a power of the distance. docs/results/fire.md: 1 to 9 % around burning
 * clouds in twilight, 7 % 20 km from one at night. */
static const double outshone_ratio = 5.0, outshone_bias = 0.2;

/* Bias of the air and the ground around a fire, by their share of the picture. */
static double compute_outshone(const np_frame *f) {
  double in_cloud = 0.0, beside = 0.0, opacity = 0.0;
  const size_t count = (size_t)f->width * f->height;
  for (size_t i = 0; i < count; i++) {
    const np_pixel_luminance *pixel = &f->luminances[i];
    opacity += (double)pixel->opacity;
    in_cloud += (double)(pixel->opacity * pixel->value);
    beside += (double)((1.0f - pixel->opacity) * pixel->value);
  }
  const double share = 1.0 - opacity / (double)count;
  return in_cloud * share > outshone_ratio * beside * (1.0 - share) ? outshone_bias * sqrt(share) : 0.0;
}

/* Bias of air with haze under clouds while the sun is below the horizon: its light comes from the side of the sun,
 * where clouds hide it, and the air has it evenly. For each optical depth of the haze, and at most: 25 and 27 % at a
 * depth of 0.1 in two scenes of docs/results/population.md. */
static const double dusk_per_depth = 2.5, dusk_most = 0.3;

static double compute_dusk(const cloud_light *light, const np_plan *plan) {
  const bool is_dusk =
      light->sine < 0.0 && light->highest < 0.0 && np_plan_has_air_light(plan) && np_plan_needs(plan, NP_STAGE_VOLUMES);
  return is_dusk ? fmin(dusk_per_depth * light->haze, dusk_most) : 0.0;
}

/* Share of the air's light of the first order that clouds and hills take from the picture. */
static double measure_shade(const np_assembly *assembly) {
  double lost = 0.0, count = 0.0;
  for (unsigned p = 0; p < assembly->packet_count; p++)
    for (unsigned i = 0; i < assembly->packets[p].light_count; i++) {
      const np_air_shadow *shadow = &assembly->packets[p].lights[i].air_shadow;
      if (!shadow->visible_fraction) continue;
      lost += np_air_shadow_measure(shadow);
      count += 1.0;
    }
  return count > 0.0 ? lost / count : 0.0;
}

/* Bias of air among hills, whose light is the less even the more haze there is and the lower the sun, and of valleys in
 * their shade: 1 to 14 % in pictures of docs/results/light-caches.md. At a haze of this depth and more, and for each
 * share of the first order that is in shade. Where haze is thick, what it scatters straight on is spread by the next
 * time: 5 % at this depth and more, whatever the sun. */
static const double hill_haze = 0.065, hill_depth = 0.07, hill_shade = 0.2, hill_thick = 0.05, hill_thick_depth = 0.6;

/* The same where hills hide the sun's glint on water from a part of the air, which has it evenly: 1 and 29 % in two
 * pictures of that page, of 0.5 and 0.6 of the air. For a half. */
static const double glint_bias = 0.2;

/* The same where shade in the air is left out, times the square of that haze: 17 to 130 % in valleys of that page. */
static const double unshaded_hills = 0.5;

static double compute_hill_air(const np_frame *f, const cloud_light *light, const np_plan *plan) {
  const double low = 1.0 - fmax(light->sine, 0.0), haze = fmin(light->haze / hill_depth, 1.0);
  if (!np_plan_needs(plan, NP_STAGE_AIR_SHADOWS)) return unshaded_hills * haze * haze;
  const double thick = hill_thick * fmin(light->haze / hill_thick_depth, 1.0);
  const double glint = glint_bias * 4.0 * light->glint * (1.0 - light->glint) * haze * low;
  return hypot(hypot(hill_haze * haze * low, glint), hypot(thick, hill_shade * measure_shade(f->assembly)));
}

/* Bias of light between hills: 0 to 9 % without haze in pictures of docs/results/light-caches.md, "Slopes among hills".
 */
static const double relief_bias = 0.045;

static double compute_hills(const np_frame *f, const cloud_light *light, const np_plan *plan) {
  return np_plan_needs(plan, NP_STAGE_TERRAIN) ? hypot(relief_bias, compute_hill_air(f, light, plan)) : 0.0;
}

/* Bias of hazy air under clouds, which is less even than the fluxes that it is computed from: 8 to 20 % in blue under a
 * stratus over snow at a visual range of 5 km (docs/results/light-caches.md). For all of the first order in shade, at a
 * haze of this depth and more. */
static const double murk_bias = 0.13, murk_depth = 0.8;

/* That of paths with the air's tables, which have no light of the clouds in the air: 24 to 39 % there. */
static const double murk_bias_of_tables = 0.35;

static double compute_murk(const np_frame *f, const cloud_light *light, const np_plan *plan) {
  if (!np_plan_needs(plan, NP_STAGE_VOLUMES) || !np_plan_needs(plan, NP_STAGE_AIR_SHADOWS)) return 0.0;
  const double most = f->desc->integrator == NEPH_INTEGRATOR_PATH ? murk_bias_of_tables : murk_bias;
  return most * fmin(light->haze / murk_depth, 1.0) * measure_shade(f->assembly);
}

/* Bias of the air's tables in thick haze, times the square of its depth up to 1: at visual ranges of 2 to 4 km regions
 * are 2 to 8 % off, towards the sun most (docs/results/sky.md). */
static const double thick_tables_bias = 0.06;

static double compute_thick_tables(const cloud_light *light) {
  const double depth = fmin(light->haze, 1.0);
  return thick_tables_bias * depth * depth;
}

/* Bias of a fire in the dark beside clouds that repeat without end (docs/transport.md): in the stretch that its light
 * is solved for; and in a picture of places beyond alone, whose clouds it does not light, or beside a cloud that burns
 * in each period, so that all fires come back. */
static const double repeated_fire_bias = 0.1, false_fire_bias = 1.0;

static double compute_repeated_fire(const cloud_light *light) {
  if (!light->has_emission || !light->has_mixed_periods || light->highest >= 0.0) return 0.0;
  return light->has_false_fires ? false_fire_bias : repeated_fire_bias;
}

/* Bias of light that reaches the camera from under deep clouds. It comes from the ground, whose light is of the same
 * cells, and which the tracer has from them: cells that err by this or more are as wrong for both. 0.07 under a deck of
 * depth 432 in voxels of 120 m, whose underside was 30 % too bright (docs/results/population.md). */
static const double deep_cells = 0.05;

static double compute_under_deep(const cloud_light *light, double cover) {
  const bool is_deep = light->is_under && light->cell_error >= deep_cells;
  return is_deep ? pow(cover, cover_exponent) * np_bias_of_cells(light->cell_error, light->albedo, light->sine) : 0.0;
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
  const double air = np_plan_has_air_light(plan) && !np_request_traces_air(&plan->request) ? np_bias_terms.air : 0.0;
  const double voxels = plan->savings.are_coarse ? plan->forecast.stages[NP_STAGE_VOLUMES].error : 0.0;
  const cloud_light light = measure_light(f->assembly);
  const double of_air = hypot(compute_murk(f, &light, plan), compute_thick_tables(&light));
  const double haze = air > 0.0 ? hypot(of_air, compute_hills(f, &light, plan)) : 0.0;
  return (np_bias_model){hypot(hypot(air, voxels), hypot(haze, compute_lost(f))), 2.0, 0.0};
}

/* Bias of the stages that a finished picture says no more of than its plan, but for the air's tables, which traced
 * pixels have too. */
static double sum_forecasts(const np_plan *plan) {
  static const unsigned char stages[] = {NP_STAGE_VOLUMES, NP_STAGE_EMISSION, NP_STAGE_SUN_OPTICAL_DEPTH};
  double sum = 0.0;
  for (size_t i = 0; i < sizeof stages; i++) sum = hypot(sum, plan->forecast.stages[stages[i]].error);
  return sum;
}

/* Bias of a march. */
static double combine(const np_plan *plan, const cloud_light *light, double tolerance, double cover) {
  const double rest = hypot(sum_forecasts(plan), plan->decisions.left_out.share);
  if (!np_plan_needs(plan, NP_STAGE_VOLUMES)) return rest;
  const double solved = hypot(np_bias_of_cells(light->cell_error, light->albedo, light->sine), light->solution);
  const double water = light->has_water ? np_bias_of_water(light->sine) : 0.0;
  const double cells = pow(cover, cover_exponent) * hypot(solved, water);
  const double steps = np_bias_terms.steps * tolerance;
  const double method = np_bias_of_method(plan->request.desc.multiple_scattering, cover);
  np_log(plan->request.context, NEPH_LOG_DEBUG,
         "model of the bias: cells and water %.2g, steps %.2g, method %.2g, air, voxels and fire %.2g; cells err by "
         "%.2g, clouds cover %.2g",
         cells, steps, method, rest, light->cell_error, cover);
  return hypot(hypot(cells, steps), hypot(method, rest));
}

np_bias_model np_bias_model_make(const np_frame *f, const np_plan *plan) {
  if (f->desc->integrator == NEPH_INTEGRATOR_PATH) return make_of_path(f, plan);
  const cloud_light light = measure_light(f->assembly);
  const bool is_fire_in_air = light.has_emission && np_plan_has_air_light(plan);
  const double outshone = is_fire_in_air ? compute_outshone(f) : 0.0, cover = compute_cover(f);
  const double of_night = hypot(compute_dusk(&light, plan), compute_repeated_fire(&light));
  const double of_tables = hypot(plan->forecast.stages[NP_STAGE_ATMOSPHERE].error, compute_thick_tables(&light));
  return (np_bias_model){.bias = combine(plan, &light, (double)f->settings.tolerance, cover),
                         .factor = light.has_emission ? 3.0 : 2.0,
                         .shared = hypot(hypot(outshone, of_night),
                                         hypot(hypot(compute_under_deep(&light, cover), of_tables),
                                               hypot(compute_hills(f, &light, plan), compute_murk(f, &light, plan))))};
}
