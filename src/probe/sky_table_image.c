/* SPDX-License-Identifier: Apache-2.0 */
/* The tables of a scene's atmosphere and of its camera's sky as pictures to look at.
 *
 * Values are what the tables represent, per unit of the sun's irradiance: transmittances, radiances, quotients. Light
 * that spans the decades of twilight is shown by its logarithm, 0 to 1 over the four decades below the brightest
 * number. Small tables are drawn with larger dots.
 */
#include <math.h>
#include <string.h>

#include "atmosphere/atmosphere_tables.h"
#include "core/given.h"
#include "core/parallel.h"
#include "stages/assembly.h"

enum { DECADES = 4 };

/* A picture of width × height dots, each with a value. */
typedef struct drawing {
  unsigned width, height, dot;
  bool is_logarithmic;
  np_bands (*get)(const np_packet *packet, unsigned x, unsigned y);
} drawing;

static const np_table_sizes *get_sizes(const np_packet *packet) { return &packet->atmosphere->sizes; }

/* Altitude grows upwards, the distance to the top of the air to the right: from the zenith to the level. */
static np_bands get_transmittance(const np_packet *packet, unsigned x, unsigned y) {
  const np_depth_table *t = &packet->atmosphere->depths;
  return np_bands_exp(-t->texels[((unsigned)t->rows - 1 - y) * (unsigned)t->columns + x]);
}

/* M: altitude grows upwards, the sun's cosine to the right. */
static np_bands get_scattering(const np_packet *packet, unsigned x, unsigned y) {
  const np_moment_table *t = &packet->atmosphere->moments;
  return np_moment_table_at_row(t, t->rows - 1 - (int)y)[x];
}

/* The aerosol's source over M: a tile for each altitude (upwards) and sun (to the right) of directions seen: up is up,
 * azimuth from the sun's to the right. */
static np_bands get_gather(const np_packet *packet, unsigned x, unsigned y) {
  const np_gather_kernel *kernel = &packet->atmosphere->kernel;
  const unsigned cosines = (unsigned)kernel->cosines, azimuths = (unsigned)kernel->azimuths;
  const unsigned altitude = (unsigned)kernel->altitude_count - 1 - y / cosines;
  return packet->lights[0]
      .camera_sky->gather.source[x / azimuths][altitude][cosines - 1 - y % cosines][x % azimuths]
      .smooth;
}

/* Row of a table over directions from the zenith down: its rows above the horizon run up from there. */
static unsigned row_from_zenith(const np_view_sizes *n, unsigned y) {
  return y < (unsigned)n->up ? (unsigned)n->up - 1 - y : y;
}

/* Angle of a row and azimuth with the sun, for the phase function that tables leave out. */
static np_bands put_phase(const np_packet *packet, const np_sky_layout *layout, unsigned row, unsigned azimuth,
                          np_scattered light) {
  const neph_sky *sky = packet->lights[0].camera_sky;
  const double cosine = np_sky_row_cosine(&sky->frame, layout, (int)row), sine = sqrt(fmax(1.0 - cosine * cosine, 0.0));
  const double turn = NP_PI * azimuth / (layout->azimuths - 1);
  const double to_sun = cosine * (double)sky->frame.sun_cosine + sine * (double)sky->frame.sun_sine * cos(turn);
  return light.smooth + np_aerosol_phase(&packet->atmosphere->medium, (float)fmax(1.0 - to_sun, 0.0)) * light.peak;
}

static np_bands get_view(const np_packet *packet, unsigned x, unsigned y) {
  const np_sky_layout layout = np_sky_view_layout(packet->lights[0].camera_sky);
  const unsigned row = row_from_zenith(&get_sizes(packet)->view, y);
  const np_scattered *s = &packet->lights[0].camera_sky->view[row * (unsigned)layout.azimuths + x];
  const double cosine = np_sky_row_cosine(&packet->lights[0].camera_sky->frame, &layout, (int)row);
  const float length = np_sky_view_length(packet->lights[0].camera_sky, cosine, row >= (unsigned)layout.up);
  return put_phase(packet, &layout, row, x,
                   (np_scattered){length * np_bands_exp(s->smooth), length * np_bands_exp(s->peak)});
}

enum { AERIAL_TILES = 8 }; /* side by side */

/* The in-scatter to every far plane: a tile for each slice, line by line, with directions as in the view. */
static np_bands get_aerial(const np_packet *packet, unsigned x, unsigned y) {
  const np_view_sizes *n = &get_sizes(packet)->aerial;
  const np_sky_layout layout = np_sky_aerial_layout(packet->lights[0].camera_sky);
  const unsigned rows = (unsigned)(n->up + n->down), azimuths = (unsigned)n->azimuths, slices = (unsigned)n->points;
  const unsigned slice = y / rows * AERIAL_TILES + x / azimuths, row = row_from_zenith(n, y % rows);
  if (slice >= slices) return np_bands_grey(0.0f);
  const np_scattered *s = &packet->lights[0].camera_sky->aerial[(row * azimuths + x % azimuths) * slices + slice];
  const np_sky_frame *frame = &packet->lights[0].camera_sky->frame;
  const double cosine = np_sky_row_cosine(frame, &layout, (int)row);
  const np_ray ray = np_aerial_ray(&packet->atmosphere->medium, frame, cosine, row >= (unsigned)n->up);
  const np_aerial_scale scale = np_aerial_scale_make(&ray, frame);
  const float far = (float)np_aerial_scale_distance(&scale, (slice + 1.0) / slices);
  return put_phase(packet, &layout, row, x % azimuths,
                   (np_scattered){far * np_bands_exp(s->smooth), far * np_bands_exp(s->peak)});
}

static drawing plan_drawing(const np_packet *packet, neph_sky_table table) {
  const np_table_sizes *n = get_sizes(packet);
  const unsigned aerial_lines = ((unsigned)n->aerial.points + AERIAL_TILES - 1) / AERIAL_TILES;
  switch (table) {
  case NEPH_SKY_TABLE_TRANSMITTANCE:
    return (drawing){(unsigned)n->depth.columns, (unsigned)n->depth.rows, 4, false, get_transmittance};
  case NEPH_SKY_TABLE_SCATTERING:
    return (drawing){(unsigned)n->moments.columns, (unsigned)n->moments.rows, 4, true, get_scattering};
  case NEPH_SKY_TABLE_AEROSOL:
    return (drawing){(unsigned)(packet->lights[0].camera_sky->gather.sun_count * packet->atmosphere->kernel.azimuths),
                     (unsigned)(packet->atmosphere->kernel.altitude_count * packet->atmosphere->kernel.cosines), 8,
                     false, get_gather};
  case NEPH_SKY_TABLE_VIEW:
    return (drawing){(unsigned)n->view.azimuths, (unsigned)(n->view.up + n->view.down), 6, false, get_view};
  case NEPH_SKY_TABLE_AERIAL:
    return (drawing){AERIAL_TILES * (unsigned)n->aerial.azimuths,
                     aerial_lines * (unsigned)(n->aerial.up + n->aerial.down), 3, false, get_aerial};
  case NEPH_SKY_TABLE_COUNT:
    break;
  }
  return (drawing){0};
}

static float compute_maximum(const np_packet *packet, const drawing *d) {
  float greatest = 0.0f;
  for (unsigned y = 0; y < d->height; y++)
    for (unsigned x = 0; x < d->width; x++) {
      const np_bands value = d->get(packet, x, y);
      for (int b = 0; b < NP_BAND_COUNT; b++) greatest = np_maxf(greatest, value[b]);
    }
  return greatest;
}

static float shade(const drawing *d, float value, float greatest) {
  if (!d->is_logarithmic) return value;
  return value > 0.0f ? np_clampf(1.0f + log10f(value / greatest) / DECADES, 0.0f, 1.0f) : 0.0f;
}

static void draw(const np_packet *packet, const drawing *d, neph_image *image) {
  static const char *const names[NP_BAND_COUNT] = {"R", "G", "B"};
  const float greatest = compute_maximum(packet, d);
  const size_t width = (size_t)d->width * d->dot;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    float *plane = neph_image_get_channel(image, names[b]);
    for (size_t y = 0; y < (size_t)d->height * d->dot; y++)
      for (size_t x = 0; x < width; x++)
        plane[y * width + x] = shade(d, d->get(packet, (unsigned)(x / d->dot), (unsigned)(y / d->dot))[b], greatest);
  }
}

static neph_result draw_table(const neph_scene *scene, const np_assembly *assembly, neph_sky_table table,
                              neph_image **out_image) {
  static const char *const names[NP_BAND_COUNT] = {"R", "G", "B"};
  const np_packet *packet = &assembly->packets[0];
  if (!packet->lights[0].camera_sky)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "sky: the scene has no air, and so no tables");
  if (!packet->lights[0].camera_sky->view && table >= NEPH_SKY_TABLE_AEROSOL)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "sky: it is night, and the sky has no tables");
  const drawing d = plan_drawing(packet, table);
  if (!d.width || (table == NEPH_SKY_TABLE_SCATTERING && !packet->atmosphere->moments.moments))
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "sky: the air has no such table");
  neph_result result =
      neph_image_create(scene->context, d.width * d.dot, d.height * d.dot, NP_BAND_COUNT, names, out_image);
  if (!result) draw(packet, &d, *out_image);
  return result;
}

neph_result neph_render_sky_table(const neph_scene *scene, neph_sky_table table, neph_image **out_image) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_image)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_image = NULL;
  if ((unsigned)table >= NEPH_SKY_TABLE_COUNT)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "sky: table is %d, must be one of neph_sky_table",
                   (int)table);
  const unsigned mode = np_float_mode_enter();
  np_monitor monitor;
  np_monitor_start(&monitor, scene->context, NULL, NULL);
  np_plan plan;
  np_assembly assembly;
  np_stores stores = {.results = NULL};
  const np_build_job job = np_build_job_make(&stores);
  neph_result result = np_plan_make_sky(scene, &(np_sky_request){.is_of_bands = true}, &plan);
  if (!result) result = np_assembly_build(scene, &plan, &job, &monitor, &assembly);
  np_plan_clear(&plan);
  if (!result) {
    result = draw_table(scene, &assembly, table, out_image);
    np_assembly_clear(&assembly);
  }
  np_stores_clear(scene->context, &stores);
  np_float_mode_leave(mode);
  return result;
}

const char *neph_sky_table_get_name(neph_sky_table table) {
  static const char *const names[NEPH_SKY_TABLE_COUNT] = {[NEPH_SKY_TABLE_TRANSMITTANCE] = "transmittance",
                                                          [NEPH_SKY_TABLE_SCATTERING] = "multiple_scattering",
                                                          [NEPH_SKY_TABLE_AEROSOL] = "aerosol_source",
                                                          [NEPH_SKY_TABLE_VIEW] = "sky_view",
                                                          [NEPH_SKY_TABLE_AERIAL] = "aerial_perspective"};
  return (unsigned)table < NEPH_SKY_TABLE_COUNT ? names[table] : "unknown";
}
