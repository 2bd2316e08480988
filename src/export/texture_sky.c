/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of the air and of the camera's sky in the parametrisations of real-time renderers:
 *
 * - transmittance: Bruneton, "Precomputed Atmospheric Scattering: a New Implementation", 2017;
 * - multiple scattering and sky view: Hillaire, "A Scalable and Production Ready Sky and Atmosphere Rendering
 *   Technique", 2020.
 *
 * Texel i of n lies at i/(n − 1) of its coordinate, so that the first and the last are at its ends. Values are those of
 * the library's own look-ups there. */
#include <math.h>

#include "atmosphere/atmosphere_tables.h"
#include "core/alloc.h"
#include "core/parallel.h"
#include "export/texture_makers.h"
#include "stages/assembly.h"

enum { TRANSMITTANCE_WIDTH = 256, TRANSMITTANCE_HEIGHT = 64, MULTIPLE_SIZE = 32, VIEW_WIDTH = 256, VIEW_HEIGHT = 128 };

/* The air, and a table of it in memory: rows × columns × 4. */
typedef struct sky_table {
  np_texture_set *set;
  const neph_atmosphere *atmosphere;
  const neph_sky *sky;
  const np_packet *packet; /* NULL: a dry run */
  unsigned width, height;
  void (*eval)(const struct sky_table *table, double x, double y, float out_values[4]);
  float *values;
  double scale; /* divisor of the values */
} sky_table;

static void put_bands(np_bands bands, float out_values[4]) {
  for (int b = 0; b < NP_BAND_COUNT; b++) out_values[b] = bands[b];
  out_values[3] = 1.0f;
}

/* ---- Tables ---- */

/* x: distance to the top of the air, between its least value and its value along the horizon; y: distance to the
 * horizon. */
static void eval_transmittance(const sky_table *table, double x, double y, float out_values[4]) {
  const np_medium *medium = &table->atmosphere->medium;
  const double bottom = medium->planet_radius_m, top = bottom + medium->top_m;
  const double whole = sqrt((top - bottom) * (top + bottom)), rho = whole * y, r = sqrt(rho * rho + bottom * bottom);
  const double least = top - r, d = least + x * (rho + whole - least);
  const double cosine = d > 0.0 ? (whole * whole - rho * rho - d * d) / (2.0 * r * d) : 1.0;
  const np_depth_row row = np_depth_table_row(&table->atmosphere->depths, r - bottom);
  put_bands(np_bands_exp(-np_depth_row_lookup(&row, (float)np_clamp(cosine, -1.0, 1.0))), out_values);
}

/* x: cosine of the sun's zenith angle, −1 to 1; y: altitude, from 0 to the top of the air. M/(4π). */
static void eval_multiple(const sky_table *table, double x, double y, float out_values[4]) {
  const np_moment_table *moments = &table->atmosphere->moments;
  put_bands(np_moment_table_total(moments, y * table->atmosphere->medium.top_m, (float)(2.0 * x - 1.0)) *
                (float)(1.0 / (4.0 * NP_PI)),
            out_values);
}

/* x: azimuth from the sun's, cos φ = 1 − 2x²; y: zenith angle, in halves that end at the horizon, both denser there. */
static void eval_view(const sky_table *table, double x, double y, float out_values[4]) {
  const np_sky_frame *frame = &table->sky->frame;
  const double horizon = frame->horizon_angle, below = 1.0 - 2.0 * y, above = 2.0 * y - 1.0;
  const double zenith = y < 0.5 ? horizon * (1.0 - below * below) : horizon + (NP_PI - horizon) * above * above;
  const double across = 1.0 - 2.0 * x * x, aside = sqrt(fmax(1.0 - across * across, 0.0)), sine = sin(zenith);
  const np_dvec3 up = np_vec3_to_double(frame->up), toward = np_vec3_to_double(frame->toward);
  const np_dvec3 side = np_vec3_to_double(frame->across);
  const np_dvec3 level = np_dvec3_add(np_dvec3_scale(toward, sine * across), np_dvec3_scale(side, sine * aside));
  const np_dvec3 d = np_dvec3_add(np_dvec3_scale(up, cos(zenith)), level);
  double radiance[3];
  neph_sky_get_radiance(table->sky, (const double[3]){d.x, d.y, d.z}, radiance);
  for (int b = 0; b < 3; b++) out_values[b] = (float)radiance[b];
  out_values[3] = 0.0f;
}

static neph_result eval_rows(void *user, size_t begin, size_t end, unsigned thread) {
  const sky_table *table = user;
  (void)thread;
  for (size_t y = begin; y < end; y++)
    for (size_t x = 0; x < table->width; x++)
      table->eval(table, (double)x / (table->width - 1), (double)y / (table->height - 1),
                  table->values + 4 * (y * table->width + x));
  return NEPH_OK;
}

/* Divides by the greatest value, so that the dark end of twilight is not lost in halves. */
static void scale_values(sky_table *table) {
  const size_t count = (size_t)table->width * table->height;
  float greatest = 0.0f;
  for (size_t i = 0; i < 4 * count; i++) greatest = i % 4 < 3 ? np_maxf(greatest, table->values[i]) : greatest;
  table->scale = greatest > 0.0f ? (double)greatest : 1.0;
  for (size_t i = 0; i < 4 * count; i++)
    table->values[i] = i % 4 < 3 ? (float)((double)table->values[i] / table->scale) : 1.0f;
}

static neph_result copy_values(void *user, unsigned slice, float *out_values) {
  const sky_table *table = user;
  (void)slice;
  memcpy(out_values, table->values, 4 * sizeof *out_values * table->width * table->height);
  return NEPH_OK;
}

/* ---- Adding ---- */

/* Numbers that the parametrisations need. */
static void describe_air(const void *user, np_json *json) {
  const np_packet *packet = user;
  const np_packet_light *light = &packet->lights[0];
  const np_medium *medium = &packet->atmosphere->medium;
  const neph_sky *sky = light->camera_sky;
  const double irradiance[3] = {(double)light->beam.irradiance.band[0], (double)light->beam.irradiance.band[1],
                                (double)light->beam.irradiance.band[2]};
  np_json_put_text(json, "light", light->beam.group == NP_LIGHT_GROUP_MOON ? "moon" : "sun");
  const np_dvec3 *to_sun = &light->beam.direction;
  np_json_put_reals(json, "sun_direction", (const double[3]){to_sun->x, to_sun->y, to_sun->z}, 3);
  np_json_put_reals(json, "sun_irradiance_w_m2_nm", irradiance, 3);
  np_json_put_real(json, "planet_radius_m", medium->planet_radius_m);
  np_json_put_real(json, "top_altitude_m", medium->top_m);
  if (!sky) return;
  np_json_put_reals(json, "observer_m", (const double[3]){sky->observer.x, sky->observer.y, sky->observer.z}, 3);
  np_json_put_real(json, "horizon_zenith_angle_rad", sky->frame.horizon_angle);
}

static neph_result add_table(sky_table *table, np_texture *texture, bool is_scaled) {
  np_texture_set *set = table->set;
  neph_result result = NEPH_OK;
  table->width = texture->size[0];
  table->height = texture->size[1];
  table->scale = 1.0;
  texture->texel = NP_TEXEL_RGBA16F;
  texture->dimensions = 2;
  texture->fill = copy_values;
  texture->user = table;
  texture->describe = describe_air;
  texture->describe_user = table->packet;
  if (set->desc->is_dry_run) return np_texture_set_add(set, texture);
  table->values = np_alloc(set->context, 4 * (size_t)table->width * table->height, sizeof *table->values);
  if (!table->values) return NEPH_ERROR_OUT_OF_MEMORY;
  result = np_parallel_for(set->context, set->monitor, table->height, 4, eval_rows, table);
  if (is_scaled && !result) scale_values(table);
  for (int b = 0; b < 3; b++) texture->channels[b].scale = table->scale;
  if (!result) result = np_texture_set_add(set, texture);
  np_alloc_free(set->context, table->values);
  return result;
}

#define BANDS(what, unit)                                                                                              \
  {what " at 680 nm", unit, 1.0}, {what " at 550 nm", unit, 1.0}, {what " at 440 nm", unit, 1.0}, {                    \
    "unused, 1", "1", 1.0                                                                                              \
  }

static neph_result add_transmittance(sky_table table) {
  np_texture texture = {
      .name = "sky_transmittance",
      .purpose = "transmittance of the air, to its top along a ray that does not meet the ground",
      .mapping = "Bruneton 2017: R planet radius, T radius of the top, H² = T² − R², texel i of n at i/(n − 1); "
                 "r² = R² + (H·v)², d = (T − r) + u·(H·v + H − (T − r)), "
                 "cos(zenith angle) = (H² − (H·v)² − d²)/(2·r·d)",
      .size = {TRANSMITTANCE_WIDTH, TRANSMITTANCE_HEIGHT, 1},
      .channels = {BANDS("transmittance", "1")}};
  table.eval = eval_transmittance;
  return add_table(&table, &texture, false);
}

static neph_result add_multiple(sky_table table) {
  np_texture texture = {
      .name = "sky_multiple_scattering",
      .purpose = "light of all orders that arrives at a point of the air, mean over all directions, without the sun's "
                 "beam; times scattering coefficient and sun irradiance it is the source of multiple scattering",
      .mapping = "Hillaire 2020: texel i of n at i/(n − 1); cos(sun zenith angle) = 2·u − 1, altitude = v·top",
      .size = {MULTIPLE_SIZE, MULTIPLE_SIZE, 1},
      .channels = {BANDS("mean radiance per irradiance of the sun above the air", "1/sr")}};
  table.eval = eval_multiple;
  return add_table(&table, &texture, true);
}

static neph_result add_view(sky_table table) {
  np_texture texture = {
      .name = "sky_view",
      .purpose = "radiance of the air from the camera, without the sun's disk and the ground",
      .mapping = "Hillaire 2020: h zenith angle of the horizon, texel i of n at i/(n − 1); cos(azimuth from the sun) = "
                 "1 − 2·u²; v < 1/2: zenith angle = h·(1 − (1 − 2·v)²), else h + (π − h)·(2·v − 1)²",
      .size = {VIEW_WIDTH, VIEW_HEIGHT, 1},
      .channels = {BANDS("radiance", "W/(m2 sr nm)")}};
  table.eval = eval_view;
  return add_table(&table, &texture, true);
}

/* `packet` NULL: a dry run. */
static neph_result add_tables(np_texture_set *set, const np_packet *packet) {
  const sky_table table = {.set = set,
                           .packet = packet,
                           .atmosphere = packet ? packet->atmosphere : NULL,
                           .sky = packet ? packet->lights[0].camera_sky : NULL};
  const bool has_moments = !packet || packet->atmosphere->moments.moments, has_sky = !packet || table.sky;
  neph_result result = add_transmittance(table);
  if (!result && has_moments) result = add_multiple(table);
  return result || !has_sky ? result : add_view(table);
}

/* Builds air and sky as for a picture. */
static neph_result build_and_add(np_texture_set *set, const neph_scene *scene, np_stores *stores) {
  np_plan plan;
  np_assembly assembly;
  const np_build_job job = {.stores = stores, .progress = np_monitor_get_part(set->monitor)};
  neph_result result = np_plan_make_sky(scene, &(np_sky_request){.is_of_bands = true}, &plan);
  if (!result) result = np_assembly_build(scene, &plan, &job, set->monitor, &assembly);
  np_plan_clear(&plan);
  if (result) return result;
  const np_packet *packet = &assembly.packets[0];
  np_monitor_set_stage(set->monitor, "sky textures");
  if (!packet->atmosphere || !packet->lights[0].camera_sky)
    np_log(set->context, NEPH_LOG_WARNING, "export: it is night without a moon: the scene has no %s",
           packet->atmosphere ? "sky_view" : "tables of the sky");
  if (packet->atmosphere) result = add_tables(set, packet);
  np_assembly_clear(&assembly);
  return result;
}

neph_result np_texture_sky_add(np_texture_set *set, const np_texture_scene *of) {
  np_stores stores = {.results = NULL};
  if (!of->scene->has_atmosphere || !of->scene->environment.has_planet) {
    if (!set->desc->is_dry_run)
      np_log(set->context, NEPH_LOG_INFO, "export: the scene has no air: no tables of the sky are written");
    return NEPH_OK;
  }
  if (set->desc->is_dry_run) return add_tables(set, NULL);
  const neph_result result = build_and_add(set, of->scene, &stores);
  np_stores_clear(set->context, &stores);
  return result;
}
