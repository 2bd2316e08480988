/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/color_probes.h"

#include "core/units.h"

/* ---- Skies ---- */

/* Skies of the picture's bands and of the others of probes, by light; NULL: none. */
typedef struct probe_skies {
  unsigned light_count;
  neph_sky *sky[NP_COLOR_PROBE_PACKETS][NP_LIGHTS_MAX];
  bool is_owned;
} probe_skies;

static void clear_skies(probe_skies *skies) {
  for (unsigned p = 0; p < NP_COLOR_PROBE_PACKETS && skies->is_owned; p++)
    for (unsigned l = 0; l < skies->light_count; l++) neph_sky_destroy(skies->sky[p][l]);
}

/* Whether the fit needs the sky of a light; beams of light groups have none, as the sky is a group of its own. */
static bool has_sky(const np_plan *plan, const np_color_fit_inputs *made) {
  const unsigned of_sun = made->lights->has_groups ? NP_LIGHT_GROUP_SKY : NP_LIGHT_GROUP_SUN;
  return made->beam->group == NP_LIGHT_GROUP_MOON || (made->beam->group == of_sun && plan->decisions.has_sun);
}

/* Pictures whose air is traced have no sky, and get one for the fit alone: their colours equal the colours of other
 * pictures. */
static neph_result get_skies(const np_stage_part *in, const np_color_probes *probes, probe_skies *out) {
  *out = (probe_skies){.light_count = probes->light_count, .is_owned = np_request_traces_air(&in->plan->request)};
  neph_result result = NEPH_OK;
  for (unsigned p = 0; p < NP_COLOR_PROBE_PACKETS; p++)
    for (unsigned l = 0; l < probes->light_count && !result; l++) {
      const np_color_fit_inputs *made = &probes->at[p][l];
      if (!out->is_owned)
        out->sky[p][l] = made->camera_sky;
      else if (np_plan_needs(in->plan, NP_STAGE_ATMOSPHERE) && has_sky(in->plan, made))
        result = np_stage_create_sky(made, &out->sky[p][l]);
    }
  if (result) clear_skies(out);
  return result;
}

/* ---- Probes ---- */

/* Light in the six bands. */
typedef struct probe {
  double value[NP_COLOR_PROBE_BAND_COUNT];
} probe;

static void add_band_values(const double values[NP_BAND_COUNT], unsigned packet, double factor, probe *sum) {
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) sum->value[packet * NP_BAND_COUNT + b] += factor * values[b];
}

static void add_spectrum(np_spectrum values, unsigned packet, probe *sum) {
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) sum->value[packet * NP_BAND_COUNT + b] += (double)values.band[b];
}

static void divide_by_sun(const np_color_probes *probes, const probe *p, double out_x[NP_COLOR_PROBE_BAND_COUNT]) {
  for (int b = 0; b < NP_COLOR_PROBE_BAND_COUNT; b++)
    out_x[b] = p->value[b] / probes->at[b / NP_BAND_COUNT][0].bands->shape[NP_BAND_SUN][b % NP_BAND_COUNT];
}

static void add_probe(const np_color_probes *probes, const probe *p, double weight, np_color_fit *fit) {
  double x[NP_COLOR_PROBE_BAND_COUNT], xyz[3];
  divide_by_sun(probes, p, x);
  np_color_fit_compute_xyz(x, xyz);
  np_color_fit_add(fit, x, xyz, weight);
}

static probe sample_sky(const probe_skies *skies, np_dvec3 direction) {
  const double towards[3] = {direction.x, direction.y, direction.z};
  probe sum = {{0}};
  for (unsigned p = 0; p < NP_COLOR_PROBE_PACKETS; p++)
    for (unsigned l = 0; l < skies->light_count; l++) {
      double radiance[NP_BAND_COUNT];
      if (!skies->sky[p][l]) continue;
      neph_sky_get_radiance(skies->sky[p][l], towards, radiance);
      add_band_values(radiance, p, 1.0, &sum);
    }
  return sum;
}

/* Directions between the zenith and below the horizon; towards a light, beside it and away from it. */
static void add_directions(const np_stage_part *in, const np_color_probes *probes, const probe_skies *skies,
                           np_dvec3 to_light, np_color_fit *fit) {
  static const double zenith_deg[] = {0.0, 51.0, 85.0, 91.0}, azimuth_deg[] = {0.0, 45.0, 90.0, 180.0};
  const np_dvec3 up = np_dvec3_zenith(in->camera->origin, in->scene->atmosphere.planet_radius_m);
  np_dvec3 ahead = np_dvec3_subtract(to_light, np_dvec3_scale(up, np_dvec3_dot(up, to_light)));
  if (!(np_dvec3_length(ahead) > 1e-6)) ahead = np_dvec3_cross(up, np_dvec3_make(up.y, up.z, up.x));
  ahead = np_dvec3_normalize(ahead);
  const np_dvec3 aside = np_dvec3_cross(up, ahead);
  for (size_t z = 0; z < sizeof zenith_deg / sizeof *zenith_deg; z++)
    for (size_t a = 0; a < sizeof azimuth_deg / sizeof *azimuth_deg; a++) {
      const double zenith = zenith_deg[z] * NP_DEGREE, azimuth = azimuth_deg[a] * NP_DEGREE;
      const np_dvec3 level = np_dvec3_add(np_dvec3_scale(ahead, cos(azimuth)), np_dvec3_scale(aside, sin(azimuth)));
      const probe p =
          sample_sky(skies, np_dvec3_add(np_dvec3_scale(up, cos(zenith)), np_dvec3_scale(level, sin(zenith))));
      add_probe(probes, &p, 1.0, fit);
    }
}

/* Weight of the light that white clouds and white ground reflect, relative to one direction of the sky. */
static const double total_weight = 3.0;

/* Irradiances of level ground; without air irradiances of the lights themselves. */
static void add_irradiances(const np_color_probes *probes, const probe_skies *skies, np_color_fit *fit, probe *total) {
  probe direct = {{0}}, diffuse = {{0}};
  for (unsigned p = 0; p < NP_COLOR_PROBE_PACKETS; p++)
    for (unsigned l = 0; l < skies->light_count; l++) {
      double sun[NP_BAND_COUNT], sky[NP_BAND_COUNT];
      if (!skies->sky[p][l]) {
        const np_color_fit_inputs *made = &probes->at[p][l];
        const bool is_beam = made->beam->group != NP_LIGHT_GROUP_SKY;
        if (!made->atmosphere && is_beam) add_spectrum(made->beam->irradiance, p, &direct);
        continue;
      }
      neph_sky_get_irradiance(skies->sky[p][l], sun, sky);
      add_band_values(sun, p, 1.0, &direct);
      add_band_values(sky, p, 1.0, &diffuse);
    }
  add_probe(probes, &direct, 1.0, fit);
  add_probe(probes, &diffuse, 1.0, fit);
  for (unsigned p = 0; p < NP_COLOR_PROBE_PACKETS; p++) {
    add_band_values(direct.value + (size_t)p * NP_BAND_COUNT, p, 1.0, total);
    add_band_values(diffuse.value + (size_t)p * NP_BAND_COUNT, p, 1.0, total);
  }
  add_probe(probes, total, total_weight, fit);
}

/* The spectrum of the environment is known between the bands, too. */
static void add_environment(const np_stage_part *in, const np_color_probes *probes, np_color_fit *fit, probe *total) {
  const double *radiance = in->scene->environment.radiance_w_m2_sr_nm;
  np_wavelengths cells;
  probe even = {{0}};
  double x[NP_COLOR_PROBE_BAND_COUNT], xyz[3];
  np_color_fit_choose_cells(&cells);
  for (unsigned p = 0; p < NP_COLOR_PROBE_PACKETS; p++) {
    double values[NP_BAND_COUNT];
    np_band_set_convert(probes->at[p][0].bands, NP_BAND_LINEAR, radiance, values);
    add_band_values(values, p, 1.0, &even);
    add_band_values(values, p, NP_PI, total);
  }
  divide_by_sun(probes, &even, x);
  np_band_set_compute_xyz(&cells, NP_BAND_LINEAR, radiance, xyz);
  np_color_fit_add(fit, x, xyz, 1.0);
}

static void add_airglow(const np_stage_part *in, const np_color_probes *probes, np_color_fit *fit) {
  const np_scene_airglow *airglow = &in->scene->airglow;
  probe sum = {{0}};
  if (!airglow->is_enabled || !np_plan_needs(in->plan, NP_STAGE_AIRGLOW)) return;
  for (unsigned p = 0; p < NP_COLOR_PROBE_PACKETS; p++) {
    const np_airglow made = np_airglow_make(airglow->magnitude, in->scene->atmosphere.planet_radius_m,
                                            airglow->altitude_m, probes->at[p][0].bands->nm);
    add_spectrum(made.zenith_radiance, p, &sum);
  }
  add_probe(probes, &sum, 1.0, fit);
}

neph_result np_color_probes_add(const np_stage_part *in, const np_color_probes *probes, np_color_fit *fit,
                                np_picture_color *out) {
  probe total = {{0}};
  probe_skies skies;
  neph_result result = get_skies(in, probes, &skies);
  if (result) return result;
  for (unsigned l = 0; l < skies.light_count; l++)
    if (skies.sky[0][l]) add_directions(in, probes, &skies, probes->at[0][l].beam->direction, fit);
  add_irradiances(probes, &skies, fit, &total);
  add_environment(in, probes, fit, &total);
  add_airglow(in, probes, fit);
  divide_by_sun(probes, &total, out->light_x);
  for (int b = 0; b < NP_COLOR_PROBE_BAND_COUNT; b++)
    out->probe_nm[b] = probes->at[b / NP_BAND_COUNT][0].bands->nm[b % NP_BAND_COUNT];
  clear_skies(&skies);
  return NEPH_OK;
}
