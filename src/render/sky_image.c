/* SPDX-License-Identifier: Apache-2.0 */
/* The sky alone, as a latitude-longitude picture with its irradiances. */
#include <stdio.h>

#include "core/parallel.h"
#include "core/units.h"
#include "render/color_header.h"

typedef struct sky_image {
  const np_assembly *assembly;
  unsigned width, height;
  float *planes[NP_BAND_COUNT];
} sky_image;

/* North at the left edge, east a quarter in, zenith at the top. */
static np_vec3 direction_of(const sky_image *s, unsigned x, size_t y) {
  const double azimuth = 2.0 * NP_PI * (x + 0.5) / s->width, zenith = NP_PI * ((double)y + 0.5) / s->height;
  return np_vec3_make((float)(sin(zenith) * sin(azimuth)), (float)(sin(zenith) * cos(azimuth)), (float)cos(zenith));
}

/* Sky of every light, night and stars; the disks are not in the picture. */
static np_spectrum find_radiance(const sky_image *s, const np_packet *packet, unsigned x, size_t y) {
  const np_vec3 direction = direction_of(s, x, y);
  np_spectrum radiance = np_star_field_get(&packet->stars, x, (unsigned)y);
  for (unsigned l = 0; l < packet->light_count; l++) {
    const np_scene_view *view = &packet->lights[l].view;
    radiance =
        np_spectrum_add(radiance, np_light_sky(view, view->camera_sky, s->assembly->camera.origin, direction));
  }
  return radiance;
}

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const sky_image *s = user;
  const np_assembly *a = s->assembly;
  for (size_t y = begin; y < end; y++)
    for (unsigned x = 0; x < s->width; x++) {
      np_spectrum color = np_spectrum_grey(0.0f);
      for (unsigned p = 0; p < a->packet_count; p++)
        color = np_packet_add_color(&a->packets[p], color, find_radiance(s, &a->packets[p], x, y));
      for (int c = 0; c < 3; c++) s->planes[c][y * s->width + x] = color.band[c];
    }
  return NEPH_OK;
}

static neph_result set_irradiance(neph_image *image, const char *name, np_spectrum color) {
  char text[128];
  (void)snprintf(text, sizeof text, "%.6g %.6g %.6g", (double)color.band[0], (double)color.band[1],
                 (double)color.band[2]);
  return neph_image_set_attribute(image, name, text);
}

static np_spectrum spectrum_of(const double values[3]) {
  return np_spectrum_make((float)values[0], (float)values[1], (float)values[2]);
}

/* Irradiances in one packet: of each light's disk, and of all skies and the night together. */
typedef struct sky_irradiance {
  np_spectrum sun, moon, sky;
} sky_irradiance;

static sky_irradiance find_irradiance(const np_packet *packet) {
  sky_irradiance out = {.sky = packet->night.ground_irradiance};
  for (unsigned l = 0; l < packet->light_count; l++) {
    const np_packet_light *light = &packet->lights[l];
    double disk[3], sky[3];
    if (!light->camera_sky) continue;
    neph_sky_get_irradiance(light->camera_sky, disk, sky);
    *(light->is_moon ? &out.moon : &out.sun) = spectrum_of(disk);
    out.sky = np_spectrum_add(out.sky, spectrum_of(sky));
  }
  return out;
}

/* In the picture's colours, as its pixels are. */
static neph_result describe_irradiances(const np_assembly *assembly, neph_image *image) {
  sky_irradiance color = {.sun = np_spectrum_grey(0.0f)};
  for (unsigned p = 0; p < assembly->packet_count; p++) {
    const np_packet *packet = &assembly->packets[p];
    const sky_irradiance bands = find_irradiance(packet);
    color.sun = np_packet_add_color(packet, color.sun, bands.sun);
    color.moon = np_packet_add_color(packet, color.moon, bands.moon);
    color.sky = np_packet_add_color(packet, color.sky, bands.sky);
  }
  neph_result result = set_irradiance(image, "nephos:sunIrradiance", color.sun);
  if (!result && !np_spectrum_is_zero(color.moon)) result = set_irradiance(image, "nephos:moonIrradiance", color.moon);
  return result ? result : set_irradiance(image, "nephos:skyIrradiance", color.sky);
}

static neph_result describe_sky(const np_plan *plan, const np_assembly *assembly, neph_image *image) {
  neph_result result = np_color_header_write(plan, assembly, 1.0, image);
  const bool has_sky = assembly->packets[0].atmosphere && plan->stages[NP_STAGE_ATMOSPHERE].is_needed;
  return result || !has_sky ? result : describe_irradiances(assembly, image);
}

static neph_result render_sky(neph_scene *scene, const neph_sky_image_desc *desc, neph_image **out_image) {
  static const char *const names[NP_BAND_COUNT] = {"R", "G", "B"};
  np_monitor monitor;
  np_monitor_start(&monitor, scene->context, desc->progress, desc->progress_user);
  np_plan plan;
  np_assembly assembly;
  neph_result result = np_plan_make_sky(scene, &plan);
  plan.sphere_size[0] = desc->width;
  plan.sphere_size[1] = desc->height;
  if (!result) result = np_assembly_build(scene, &plan, &monitor, &assembly);
  if (result) return result;
  result = neph_image_create(scene->context, desc->width, desc->height, NP_BAND_COUNT, names, out_image);
  if (!result) {
    sky_image s = {.assembly = &assembly, .width = desc->width, .height = desc->height};
    for (int b = 0; b < NP_BAND_COUNT; b++) s.planes[b] = neph_image_get_channel(*out_image, names[b]);
    np_monitor_set_stage(&monitor, "sky");
    result = np_parallel_for(scene->context, &monitor, desc->height, 4, fill_rows, &s);
  }
  if (!result) result = describe_sky(&plan, &assembly, *out_image);
  np_assembly_clear(&assembly);
  return result;
}

neph_result neph_render_sky(neph_scene *scene, const neph_sky_image_desc *desc, neph_image **out_image) {
  *out_image = NULL;
  const neph_sky_image_desc defaults = NEPH_SKY_IMAGE_DESC_DEFAULT;
  neph_sky_image_desc own;
  neph_result result = np_desc_read(scene->context, "neph_sky_image_desc", &defaults, sizeof defaults, desc, &own);
  if (result) return result;
  if (own.width < 2 || own.height < 2 || own.width > 65536 || own.height > 65536)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "sky: size is %u x %u, must be 2 x 2 to 65536 x 65536",
                   own.width, own.height);
  const unsigned mode = np_float_mode_enter();
  result = render_sky(scene, &own, out_image);
  np_float_mode_leave(mode);
  if (result) {
    neph_image_destroy(*out_image);
    *out_image = NULL;
  }
  return result;
}
