/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/star_field.h"

#include <stdlib.h>

#include "core/alloc.h"
#include "core/random.h"
#include "core/units.h"

/* Circles of confusion from here on, in pixels, are points no more; wider than this, stars are no light to speak of. */
static const double blur_least = 0.5, bokeh_radius_max = 1024.0;

/* ---- The place of a star ---- */

typedef struct film_point {
  double x, y; /* pixels from the top left */
} film_point;

static bool project_on_film(const np_star_field_desc *d, np_dvec3 direction, film_point *out) {
  const np_camera *camera = d->camera;
  double at[2];
  if (!np_camera_project_direction(camera, direction, at)) return false;
  *out = (film_point){at[0], at[1]};
  const double rim = d->overscan + 1.0 + 0.5 * np_camera_get_confusion(camera, INFINITY);
  return out->x > -rim && out->y > -rim && out->x < camera->width + rim && out->y < camera->height + rim;
}

static film_point project_sphere(const np_star_field_desc *d, np_dvec3 direction) {
  const double edge = d->center_rad - NP_PI;
  const double azimuth = remainder(atan2(direction.x, direction.y) - edge, 2.0 * NP_PI);
  const double zenith = atan2(hypot(direction.x, direction.y), direction.z);
  return (film_point){(azimuth < 0.0 ? azimuth + 2.0 * NP_PI : azimuth) / (2.0 * NP_PI) * d->width,
                      zenith / NP_PI * d->height};
}

static bool project(const np_star_field_desc *d, np_dvec3 direction, film_point *out) {
  if (d->camera) return project_on_film(d, direction, out);
  *out = project_sphere(d, direction);
  return true;
}

/* A picture whose right edge is its left one. */
static bool is_round(const np_star_field_desc *d) {
  return !d->camera || d->camera->kind == NEPH_CAMERA_EQUIRECTANGULAR;
}

static double compute_solid_angle(const np_star_field_desc *d, int x, int y) {
  if (d->camera) return np_camera_get_pixel_sr(d->camera, x, y);
  return 2.0 * NP_PI / d->width * (cos(NP_PI * y / d->height) - cos(NP_PI * (y + 1.0) / d->height));
}

/* ---- How bright it is there ---- */

static float compute_twinkle(const np_star_field_desc *d, size_t index, np_vec3 direction) {
  if (!(d->twinkling > 0.0)) return 1.0f;
  np_random random = np_random_start(d->seed, (uint32_t)d->frame, (uint32_t)index, UINT32_MAX, UINT32_MAX);
  const double u = 1.0 - np_random_double(&random), v = np_random_double(&random);
  const double gaussian = sqrt(-2.0 * log(u)) * cos(2.0 * NP_PI * v); /* Box and Muller */
  const np_vec3 up = np_zenith(d->origin, d->world->planet_radius_m);
  return np_star_twinkle((float)d->twinkling, np_vec3_dot(direction, up), (float)gaussian);
}

static np_spectrum compute_irradiance(const np_star_field_desc *d, size_t index, np_vec3 direction) {
  const np_world *world = d->world;
  if (np_disk_covers(&world->night->moon, direction)) return np_spectrum_grey(0.0f);
  if (!d->camera && isfinite(np_world_find_ground(world, d->origin, direction, NULL))) return np_spectrum_grey(0.0f);
  const np_star *star = &d->catalogue->stars[index];
  np_spectrum irradiance = np_star_irradiance((double)star->v_magnitude, (double)star->b_minus_v, d->wavelength_nm);
  if (world->atmosphere)
    irradiance =
        np_spectrum_multiply(irradiance, np_atmosphere_transmittance_to_space(world->atmosphere, d->origin, direction));
  return np_spectrum_scale(irradiance, compute_twinkle(d, index, direction));
}

/* ---- Pixels ---- */

static size_t get_index(const np_star_field *field, int x, int y) {
  return (size_t)(y + field->overscan) * field->width + (size_t)(x + field->overscan);
}

static void add_pixel(const np_star_field_desc *d, long x, long y, double share, np_spectrum irradiance,
                      np_star_field *field) {
  if (is_round(d)) x = (x + (long)d->width) % (long)d->width;
  if (is_round(d)) y = y < 0 ? 0 : y >= (long)d->height ? (long)d->height - 1 : y;
  const long low = -d->overscan, right = (long)d->width + d->overscan, bottom = (long)d->height + d->overscan;
  if (!(share > 0.0) || x < low || y < low || x >= right || y >= bottom) return;
  const double sr = compute_solid_angle(d, (int)x, (int)y);
  if (!(sr > 0.0)) return;
  const np_spectrum radiance = np_spectrum_scale(irradiance, (float)(share / sr));
  if (field->blurred) {
    np_spectrum *sum = &field->blurred[get_index(field, (int)x, (int)y)];
    *sum = np_spectrum_add(*sum, radiance);
    return;
  }
  field->pixels[field->count++] = (np_star_pixel){(int)x, (int)y, radiance};
}

/* A share of a star's light, among the four pixels about a place. */
static void add_point(const np_star_field_desc *d, film_point at, double share, np_spectrum irradiance,
                      np_star_field *field) {
  const double left = floor(at.x - 0.5), top = floor(at.y - 0.5), u = at.x - 0.5 - left, v = at.y - 0.5 - top;
  for (int i = 0; i < 4; i++)
    add_pixel(d, (long)left + (i & 1), (long)top + (i >> 1), share * (i & 1 ? u : 1.0 - u) * (i >> 1 ? v : 1.0 - v),
              irradiance, field);
}

/* A star out of focus: the aperture's picture about its place. */
static void add_bokeh(const np_star_field_desc *d, film_point middle, np_spectrum irradiance, np_star_field *field) {
  const int reach = field->bokeh_reach, width = 2 * reach + 1;
  for (int i = 0; i < width * width; i++)
    if (field->bokeh[i] > 0.0f)
      add_point(d, (film_point){middle.x + i % width - reach, middle.y + i / width - reach}, (double)field->bokeh[i],
                irradiance, field);
}

static void add_star(const np_star_field_desc *d, size_t index, np_star_field *field) {
  film_point at;
  const np_dvec3 direction = np_celestial_apply(&d->world->night->turn, np_star_direction(&d->catalogue->stars[index]));
  if (!project(d, direction, &at)) return;
  const np_spectrum irradiance = compute_irradiance(d, index, np_dvec3_to_float(direction));
  if (np_spectrum_is_zero(irradiance)) return;
  if (field->blurred)
    add_bokeh(d, at, irradiance, field);
  else
    add_point(d, at, 1.0, irradiance, field);
}

static int compare_pixels(const void *a, const void *b) {
  const np_star_pixel *p = a, *q = b;
  if (p->y != q->y) return p->y < q->y ? -1 : 1;
  return p->x < q->x ? -1 : p->x > q->x;
}

/* Equal pixels become one: in the order of the sort, so that ties are settled by brightness, the same everywhere. */
static int compare_stars(const void *a, const void *b) {
  const int order = compare_pixels(a, b);
  const np_star_pixel *p = a, *q = b;
  return order ? order : p->radiance.band[1] < q->radiance.band[1] ? -1 : p->radiance.band[1] > q->radiance.band[1];
}

static void merge_pixels(np_star_field *field) {
  size_t kept = 0;
  qsort(field->pixels, field->count, sizeof *field->pixels, compare_stars);
  for (size_t i = 0; i < field->count; i++) {
    np_star_pixel *last = kept ? &field->pixels[kept - 1] : NULL;
    if (last && !compare_pixels(last, &field->pixels[i]))
      last->radiance = np_spectrum_add(last->radiance, field->pixels[i].radiance);
    else
      field->pixels[kept++] = field->pixels[i];
  }
  field->count = kept;
}

enum { BOKEH_POINTS_MIN = 4096, BOKEH_POINTS_MAX = 1 << 23, BOKEH_POINTS_PER_PIXEL = 64 };

/* The circle of confusion on whole pixels: shares of points of the plastic number (Roberts 2018) on the aperture. */
static neph_result build_bokeh(neph_context *context, const np_star_field_desc *d, np_star_field *field) {
  const double radius = fmin(0.5 * np_camera_get_confusion(d->camera, INFINITY), bokeh_radius_max);
  const int reach = field->bokeh_reach = (int)ceil(radius), width = 2 * reach + 1;
  field->bokeh = np_alloc(context, (size_t)width * (size_t)width, sizeof *field->bokeh);
  const size_t height = d->height + 2u * (unsigned)d->overscan;
  field->blurred = np_alloc(context, field->width * height, sizeof *field->blurred);
  if (!field->bokeh || !field->blurred) return NEPH_ERROR_OUT_OF_MEMORY;
  const int count = (int)np_clamp(BOKEH_POINTS_PER_PIXEL * 4.0 * radius * radius, BOKEH_POINTS_MIN, BOKEH_POINTS_MAX);
  for (int i = 0; i < count; i++) {
    const double u = 0.7548776662466927 * i, v = 0.5698402909980532 * i;
    float lens[2];
    np_camera_sample_aperture(d->camera, (float)(u - floor(u)), (float)(v - floor(v)), lens);
    const int x = reach + (int)round(radius * (double)lens[0]), y = reach - (int)round(radius * (double)lens[1]);
    field->bokeh[y * width + x] += 1.0f / (float)count;
  }
  return NEPH_OK;
}

neph_result np_star_field_build(neph_context *context, const np_star_field_desc *desc, np_star_field *out_field) {
  *out_field = (np_star_field){.context = context};
  const size_t stars = desc->catalogue->count;
  out_field->overscan = desc->overscan;
  out_field->width = desc->width + 2u * (unsigned)desc->overscan;
  neph_result result = NEPH_OK;
  if (desc->camera && np_camera_get_confusion(desc->camera, INFINITY) > blur_least)
    result = build_bokeh(context, desc, out_field);
  else if (!(out_field->pixels = np_alloc(context, stars ? 4 * stars : 1, sizeof *out_field->pixels)))
    result = NEPH_ERROR_OUT_OF_MEMORY;
  if (result) {
    np_star_field_clear(out_field);
    return result;
  }
  for (size_t i = 0; i < stars; i++) add_star(desc, i, out_field);
  if (out_field->count) merge_pixels(out_field);
  return NEPH_OK;
}

void np_star_field_clear(np_star_field *field) {
  if (field->pixels) np_alloc_free(field->context, field->pixels);
  if (field->blurred) np_alloc_free(field->context, field->blurred);
  if (field->bokeh) np_alloc_free(field->context, field->bokeh);
  *field = (np_star_field){0};
}

np_spectrum np_star_field_get(const np_star_field *field, int x, int y) {
  if (field->blurred) return field->blurred[get_index(field, x, y)];
  if (!field->count) return np_spectrum_grey(0.0f);
  const np_star_pixel key = {.x = x, .y = y};
  const np_star_pixel *found = bsearch(&key, field->pixels, field->count, sizeof key, compare_pixels);
  return found ? found->radiance : np_spectrum_grey(0.0f);
}
