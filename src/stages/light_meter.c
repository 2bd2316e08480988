/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/light_meter.h"

#include "image/color_space.h"
#include "image/exposure.h"

/* The camera's place or, among hills, one above their summits: the meter stands in the open. */
static np_dvec3 get_place(const np_assembly *assembly, const np_world *world) {
  np_dvec3 at = assembly->camera.origin;
  if (world->terrain) at.z = fmax(at.z, world->terrain_max.z + 1.0);
  return at;
}

/* Irradiance of a clear sky on level ground. If paths trace the air, there is no table of its light: half of the
 * sunlight that the air scatters counts as downward. */
static np_spectrum compute_skylight(const np_world *world, np_dvec3 at, np_spectrum sunlight) {
  const np_ground_hit level = {.position = at, .normal = np_zenith(at, world->planet_radius_m)};
  if (!world->atmosphere || np_atmosphere_has_moments(world->atmosphere))
    return np_world_level_irradiance(world, &level);
  const float cosine = fmaxf(np_vec3_dot(level.normal, world->to_sun), 0.0f);
  return np_spectrum_scale(np_spectrum_subtract(world->sun_irradiance, sunlight), 0.5f * cosine);
}

/* A world of groups of lights: the sun's light is all in its beam's. */
static np_world get_whole(const np_world *world) {
  np_world whole = *world;
  whole.sun_scope = NP_SUN_WHOLE;
  if (world->sun_scope == NP_SUN_SKY) whole.sun_irradiance = np_spectrum_grey(0.0f);
  return whole;
}

/* Weight of sunlight, which falls to 0 with a sun that sinks from 6° to the horizon: a low sun lights few surfaces of a
 * scene, and the sky lights the others. Else exposure would jump when the disk sets. */
static float compute_sun_weight(const np_world *world, np_dvec3 at) {
  static const float full_sine = 0.10453f;
  const float sine = np_vec3_dot(np_zenith(at, world->planet_radius_m), world->to_sun);
  return fminf(fmaxf(sine / full_sine, 0.0f), 1.0f);
}

/* Irradiance of a plane that faces the sun, past clouds and hills. */
static np_spectrum compute_irradiance(const np_world *world, np_dvec3 at) {
  const np_spectrum sunlight = np_world_sunlight(world, at, world->to_sun);
  return np_spectrum_add(np_spectrum_scale(sunlight, compute_sun_weight(world, at)),
                         compute_skylight(world, at, sunlight));
}

/* Radiance of a white diffuser, in R, G and B. */
static np_spectrum compute_diffuser(const np_assembly *assembly) {
  np_spectrum color = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < assembly->packet_count; p++) {
    const np_packet *packet = &assembly->packets[p];
    np_spectrum sum = np_spectrum_grey(0.0f);
    for (unsigned i = 0; i < packet->light_count; i++) {
      const np_world world = get_whole(&packet->lights[i].world);
      sum = np_spectrum_add(sum, compute_irradiance(&world, get_place(assembly, &world)));
    }
    color = np_packet_add_color(packet, color, np_spectrum_scale(sum, 1.0f / NP_PI_F));
  }
  return color;
}

/* Writes the chromaticity of a light; a picture of bands has none. */
static neph_result write_chromaticity(const np_spectrum *rgb, neph_image *image) {
  double rec709[3], xy[2];
  np_exposure_convert(image, rgb->band, rec709);
  np_color_space_get_chromaticity(rec709, xy);
  if (!image->header.has_chromaticities || !isfinite(xy[0]) || !isfinite(xy[1])) return NEPH_OK;
  const neph_result result = np_image_set_real(image, NP_EXPOSURE_METER_X, (double)(float)xy[0]);
  return result ? result : np_image_set_real(image, NP_EXPOSURE_METER_Y, (double)(float)xy[1]);
}

/* Writes exposure metadata. Values are rounded to float as in a file, so that a preview of the file has the same
 * bits. */
neph_result np_light_meter_write(const np_assembly *assembly, double scale, neph_image *image) {
  const np_spectrum rgb = compute_diffuser(assembly);
  const double value = np_exposure_get_luminance(image, rgb.band);
  const float meter = (float)(scale * value), luminance = (float)(value * np_color_space_white_luminance());
  neph_result result = np_image_set_real(image, NP_EXPOSURE_METER, (double)meter);
  if (!result) result = np_image_set_real(image, NP_EXPOSURE_METER_LUMINANCE, (double)luminance);
  return result || !(value > 0.0) ? result : write_chromaticity(&rgb, image);
}
