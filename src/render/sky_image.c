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

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const sky_image *s = user;
  const np_assembly *a = s->assembly;
  for (size_t y = begin; y < end; y++)
    for (unsigned x = 0; x < s->width; x++) {
      const np_vec3 direction = direction_of(s, x, y);
      np_spectrum color = np_spectrum_grey(0.0f);
      for (unsigned p = 0; p < a->packet_count; p++) {
        const np_packet *packet = &a->packets[p];
        color = np_packet_add_color(packet, color, np_light_sky(&packet->view, packet->camera_sky, direction));
      }
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

/* In the picture's colours, as its pixels are. */
static neph_result describe_irradiances(const np_assembly *assembly, neph_image *image) {
  np_spectrum sun_color = np_spectrum_grey(0.0f), sky_color = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < assembly->packet_count; p++) {
    const np_packet *packet = &assembly->packets[p];
    double sun[3], sky[3];
    neph_sky_get_irradiance(packet->camera_sky, sun, sky);
    sun_color = np_packet_add_color(packet, sun_color, spectrum_of(sun));
    sky_color = np_packet_add_color(packet, sky_color, spectrum_of(sky));
  }
  neph_result result = set_irradiance(image, "nephos:sunIrradiance", sun_color);
  return result ? result : set_irradiance(image, "nephos:skyIrradiance", sky_color);
}

static neph_result describe_sky(const np_plan *plan, const np_assembly *assembly, neph_image *image) {
  neph_result result = np_color_header_write(plan, assembly, 1.0, image);
  if (result || !assembly->packets[0].camera_sky) return result;
  return describe_irradiances(assembly, image);
}

static neph_result render_sky(neph_scene *scene, const neph_sky_image_desc *desc, neph_image **out_image) {
  static const char *const names[NP_BAND_COUNT] = {"R", "G", "B"};
  np_monitor monitor;
  np_monitor_start(&monitor, scene->context, desc->progress, desc->progress_user);
  np_plan plan;
  np_assembly assembly;
  neph_result result = np_plan_make_sky(scene, &plan);
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
