/* SPDX-License-Identifier: Apache-2.0 */
/* The sky alone, as a latitude-longitude picture with its irradiances. */
#include "core/given.h"
#include "core/parallel.h"
#include "core/text.h"
#include "core/units.h"
#include "frame/color_header.h"
#include "stages/sky_harmonics.h"

/* Channels: R, G, B of the sky, and, in a separate layer, R, G, B of the disks of sun and moon. */
enum { CHANNELS = 2 * NP_BAND_COUNT };
static const char *const channel_names[CHANNELS] = {"R", "G", "B", "disk.R", "disk.G", "disk.B"};

typedef struct sky_image {
  const np_assembly *assembly;
  unsigned width, height;
  neph_sky_disks disks;
  double edge_rad; /* azimuth of the left edge */
  float scale;     /* factor on radiances */
  float *planes[CHANNELS];
} sky_image;

/* Azimuth grows to the right, zenith at the top; x and y from the top left, in pixels. */
static np_vec3 direction_of(const sky_image *s, double x, double y) {
  const double azimuth = s->edge_rad + 2.0 * NP_PI * x / s->width, zenith = NP_PI * y / s->height;
  return np_vec3_make((float)(sin(zenith) * sin(azimuth)), (float)(sin(zenith) * cos(azimuth)), (float)cos(zenith));
}

/* Radiance of the sky of all lights and the night, without disks and stars. */
static np_spectrum compute_sky(const np_assembly *a, const np_packet *packet, np_vec3 direction) {
  np_spectrum radiance = np_spectrum_grey(0.0f);
  for (unsigned l = 0; l < packet->light_count; l++) {
    const np_packet_light *light = &packet->lights[l];
    const np_view_ray view = {.eye = a->camera.origin, .direction = direction};
    radiance = np_spectrum_add(radiance, np_lighting_camera_sky(&light->lighting, &light->world, &view));
  }
  return radiance;
}

/* Radiance of the sky in the picture's colours. */
static np_spectrum compute_color(const void *user, np_vec3 direction) {
  const np_assembly *a = user;
  np_spectrum color = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < a->packet_count; p++)
    color = np_packet_add_color(&a->packets[p], color, compute_sky(a, &a->packets[p], direction));
  return color;
}

/* Transmittance of the air towards the disks. */
static np_spectrum compute_disks(const np_assembly *a, np_vec3 direction) {
  np_spectrum color = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < a->packet_count; p++) {
    const np_packet *packet = &a->packets[p];
    np_spectrum disk = np_world_disk_radiance(&packet->lights[0].world, direction);
    if (np_spectrum_is_zero(disk)) continue;
    if (packet->atmosphere)
      disk = np_spectrum_multiply(
          disk, np_atmosphere_transmittance_to_space(packet->atmosphere, a->camera.origin, direction));
    color = np_packet_add_color(packet, color, disk);
  }
  return color;
}

/* Sample distance for a disk that may reach into a pixel: an eighth of its radius. */
static int count_probes(const sky_image *s, const np_disk *disk, np_vec3 middle) {
  const double radius = acos(1.0 - (double)disk->versine), pixel = NP_PI / fmin(s->height, 0.5 * s->width);
  const double reach = fmin(radius + pixel, NP_PI);
  if (!(radius > 0.0) || (double)np_vec3_dot(middle, disk->direction) < cos(reach)) return 0;
  return (int)np_clamp(ceil(8.0 * pixel / radius), 4.0, 64.0);
}

static np_spectrum average_disks(const sky_image *s, unsigned x, size_t y) {
  const np_world *world = &s->assembly->packets[0].lights[0].world;
  const np_vec3 middle = direction_of(s, x + 0.5, (double)y + 0.5);
  int n = count_probes(s, &world->disk, middle);
  if (world->night) n = (int)fmax(n, count_probes(s, &world->night->moon, middle));
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int i = 0; i < n * n; i++) {
    const double column = x + (i % n + 0.5) / n, row = (double)y + (i / n + 0.5) / n;
    sum = np_spectrum_add(sum, compute_disks(s->assembly, direction_of(s, column, row)));
  }
  return n ? np_spectrum_scale(sum, 1.0f / (float)(n * n)) : sum;
}

/* The sky and its stars at one pixel. */
static np_spectrum compute_pixel(const sky_image *s, unsigned x, size_t y) {
  const np_assembly *a = s->assembly;
  np_spectrum color = compute_color(a, direction_of(s, x + 0.5, (double)y + 0.5));
  for (unsigned p = 0; p < a->packet_count; p++)
    color = np_packet_add_color(&a->packets[p], color, np_star_field_get(&a->packets[p].stars, (int)x, (int)y));
  return color;
}

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const sky_image *s = user;
  for (size_t y = begin; y < end; y++)
    for (unsigned x = 0; x < s->width; x++) {
      np_spectrum sky = compute_pixel(s, x, y), disks = np_spectrum_grey(0.0f);
      if (s->disks != NEPH_SKY_DISKS_NONE) disks = average_disks(s, x, y);
      if (s->disks == NEPH_SKY_DISKS_INCLUDE) sky = np_spectrum_add(sky, disks);
      for (int c = 0; c < NP_BAND_COUNT; c++) {
        s->planes[c][y * s->width + x] = s->scale * sky.band[c];
        if (s->disks == NEPH_SKY_DISKS_LAYER) s->planes[NP_BAND_COUNT + c][y * s->width + x] = s->scale * disks.band[c];
      }
    }
  return NEPH_OK;
}

static neph_result set_irradiance(neph_image *image, const char *name, np_spectrum color) {
  char text[128];
  np_print(text, sizeof text, "%.6g %.6g %.6g", (double)color.band[0], (double)color.band[1], (double)color.band[2]);
  return neph_image_set_attribute(image, name, text);
}

static np_spectrum spectrum_of(const double values[3]) {
  return np_spectrum_make((float)values[0], (float)values[1], (float)values[2]);
}

/* Irradiances in one packet: of each light's disk, and of all skies and the night together. */
typedef struct sky_irradiance {
  np_spectrum sun, moon, sky;
} sky_irradiance;

static sky_irradiance compute_irradiance(const np_packet *packet) {
  sky_irradiance out = {.sky = packet->night.ground_irradiance};
  for (unsigned l = 0; l < packet->light_count; l++) {
    const np_packet_light *light = &packet->lights[l];
    double disk[3], sky[3];
    if (!light->camera_sky) continue;
    neph_sky_get_irradiance(light->camera_sky, disk, sky);
    *(light->beam.group == NP_LIGHT_GROUP_MOON ? &out.moon : &out.sun) = spectrum_of(disk);
    out.sky = np_spectrum_add(out.sky, spectrum_of(sky));
  }
  return out;
}

/* Writes irradiances in the picture's colours and in physical units, without output.scale. */
static neph_result describe_irradiances(const np_assembly *assembly, neph_image *image) {
  sky_irradiance color = {.sun = np_spectrum_grey(0.0f)};
  for (unsigned p = 0; p < assembly->packet_count; p++) {
    const np_packet *packet = &assembly->packets[p];
    const sky_irradiance bands = compute_irradiance(packet);
    color.sun = np_packet_add_color(packet, color.sun, bands.sun);
    color.moon = np_packet_add_color(packet, color.moon, bands.moon);
    color.sky = np_packet_add_color(packet, color.sky, bands.sky);
  }
  neph_result result = set_irradiance(image, "nephos:sunIrradiance", color.sun);
  if (!result && !np_spectrum_is_zero(color.moon)) result = set_irradiance(image, "nephos:moonIrradiance", color.moon);
  return result ? result : set_irradiance(image, "nephos:skyIrradiance", color.sky);
}

/* Nine triples: every coefficient's R, G, B. */
static neph_result describe_harmonics(const np_assembly *assembly, neph_image *image) {
  double harmonics[NP_SKY_HARMONICS][NP_BAND_COUNT];
  np_sky_harmonics_project(compute_color, assembly, harmonics);
  char text[1024];
  size_t length = 0;
  for (int i = 0; i < NP_SKY_HARMONICS * NP_BAND_COUNT; i++)
    length += np_print(text + length, sizeof text - length, i ? " %.6g" : "%.6g",
                       harmonics[i / NP_BAND_COUNT][i % NP_BAND_COUNT]);
  return neph_image_set_attribute(image, "nephos:skyHarmonics", text);
}

/* A light as it arrives: where from, how wide, and its irradiance on a plane that faces it. */
static neph_result describe_light(const np_assembly *assembly, unsigned index, neph_image *image) {
  np_spectrum color = np_spectrum_grey(0.0f);
  const np_packet_light *first = &assembly->packets[0].lights[index];
  for (unsigned p = 0; p < assembly->packet_count; p++) {
    const np_packet *packet = &assembly->packets[p];
    const np_world *world = &packet->lights[index].world;
    const np_spectrum light = np_world_sunlight(world, assembly->camera.origin, world->to_sun);
    color = np_packet_add_color(packet, color, light);
  }
  const char *name = first->beam.group == NP_LIGHT_GROUP_MOON ? "moon" : "sun";
  char key[40], text[96];
  np_print(key, sizeof key, "nephos:%sNormalIrradiance", name);
  neph_result result = set_irradiance(image, key, color);
  np_print(key, sizeof key, "nephos:%sAngularRadius", name);
  if (!result) result = np_image_set_real(image, key, first->beam.angular_radius_rad);
  np_print(key, sizeof key, "nephos:%sDirection", name);
  np_print(text, sizeof text, "%.9g %.9g %.9g", first->beam.direction.x, first->beam.direction.y,
           first->beam.direction.z);
  return result ? result : neph_image_set_attribute(image, key, text);
}

/* Layout of the picture. */
static neph_result describe_layout(const neph_sky_image_desc *desc, neph_image *image) {
  static const char *const names[] = {"layer", "include", "none"};
  image->header.is_latlong = true;
  neph_result result = neph_image_set_attribute(image, "nephos:disks", names[desc->disks]);
  return result ? result : np_image_set_real(image, "nephos:centerAzimuth", desc->center_azimuth_rad);
}

static neph_result describe_sky(const np_plan *plan, const np_assembly *assembly, double scale, neph_image *image) {
  neph_result result = np_color_header_write(plan, assembly, scale, image);
  if (!result) result = describe_harmonics(assembly, image);
  for (unsigned i = 0; !result && i < assembly->lights.count; i++) result = describe_light(assembly, i, image);
  const bool has_sky = assembly->packets[0].atmosphere && np_plan_needs(plan, NP_STAGE_ATMOSPHERE);
  return result || !has_sky ? result : describe_irradiances(assembly, image);
}

/* The picture of a sky that is built. */
static neph_result paint_sky(const neph_scene *scene, const neph_sky_image_desc *desc, const np_plan *plan,
                             np_assembly *assembly, np_monitor *monitor, neph_image **out_image) {
  const unsigned count = desc->disks == NEPH_SKY_DISKS_LAYER ? CHANNELS : NP_BAND_COUNT;
  neph_result result = neph_image_create(scene->context, desc->width, desc->height, count, channel_names, out_image);
  if (!result) {
    sky_image s = {.assembly = assembly,
                   .width = desc->width,
                   .height = desc->height,
                   .scale = (float)np_scene_get_scale(scene),
                   .disks = desc->disks,
                   .edge_rad = desc->center_azimuth_rad - NP_PI};
    for (unsigned c = 0; c < count; c++) s.planes[c] = neph_image_get_channel(*out_image, channel_names[c]);
    np_schedule_begin(&assembly->schedule, monitor, NP_STAGE_INTEGRATOR, 0, 1);
    np_monitor_set_stage(monitor, "sky");
    result = np_parallel_for(scene->context, monitor, desc->height, 4, fill_rows, &s);
  }
  if (!result) result = describe_sky(plan, assembly, np_scene_get_scale(scene), *out_image);
  return result ? result : describe_layout(desc, *out_image);
}

static neph_result render_sky(const neph_scene *scene, const neph_sky_image_desc *desc, np_stores *stores,
                              neph_image **out_image) {
  np_monitor monitor;
  np_monitor_start(&monitor, scene->context, desc->progress, desc->progress_user);
  np_assembly assembly;
  const np_build_job job = np_build_job_make(stores);
  np_plan plan;
  const np_sky_request sky = {.size = {desc->width, desc->height}, .center_rad = desc->center_azimuth_rad};
  neph_result result = np_plan_make_sky(scene, &sky, &plan);
  if (!result) result = np_assembly_build(scene, &plan, &job, &monitor, &assembly);
  if (!result) {
    result = paint_sky(scene, desc, &plan, &assembly, &monitor, out_image);
    np_assembly_clear(&assembly);
  }
  np_plan_clear(&plan);
  return result;
}

neph_result neph_render_sky(const neph_scene *scene, const neph_sky_image_desc *desc, neph_image **out_image) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_image)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_image = NULL;
  const neph_sky_image_desc defaults = NEPH_SKY_IMAGE_DESC_DEFAULT;
  neph_sky_image_desc own;
  neph_result result = np_desc_read(scene->context, "neph_sky_image_desc", &defaults, sizeof defaults, desc, &own);
  if (result) return result;
  if (own.width < 2 || own.height < 2 || own.width > 65536 || own.height > 65536)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "sky: size is %u x %u, must be 2 x 2 to 65536 x 65536",
                   own.width, own.height);
  if ((unsigned)own.disks > NEPH_SKY_DISKS_NONE || !isfinite(own.center_azimuth_rad))
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "sky: disks is %d, must be layer (0), include (1) or none (2); center_azimuth_rad is %g, must be "
                   "finite",
                   (int)own.disks, own.center_azimuth_rad);
  np_stores stores = {.results = NULL};
  const unsigned mode = np_float_mode_enter();
  result = render_sky(scene, &own, &stores, out_image);
  np_float_mode_leave(mode);
  np_stores_clear(scene->context, &stores);
  if (result) {
    neph_image_destroy(*out_image);
    *out_image = NULL;
  }
  return result;
}
