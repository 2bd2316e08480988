/* SPDX-License-Identifier: Apache-2.0 */
#include "render/star_field.h"

#include <stdlib.h>

#include "core/alloc.h"
#include "core/random.h"
#include "core/units.h"

/* ---- Where a star falls ---- */

typedef struct film_point {
  double x, y; /* pixels from the top left */
} film_point;

static bool project_pinhole(const np_star_field_desc *d, np_dvec3 direction, film_point *out) {
  const np_camera *camera = d->camera;
  const np_dvec3 right = np_vec3_to_double(camera->right), up = np_vec3_to_double(camera->up);
  const double depth = -np_dvec3_dot(direction, np_vec3_to_double(camera->back));
  if (depth <= 1e-6) return false;
  const double across = np_dvec3_dot(direction, right) / depth / (double)camera->tan_half_width;
  const double upward = np_dvec3_dot(direction, up) / depth / (double)camera->tan_half_height;
  *out = (film_point){0.5 * (1.0 + across) * camera->width, 0.5 * (1.0 - upward) * camera->height};
  const double beyond = d->overscan + 1.0;
  return out->x > -beyond && out->y > -beyond && out->x < camera->width + beyond && out->y < camera->height + beyond;
}

static film_point project_sphere(const np_star_field_desc *d, np_dvec3 direction) {
  const double azimuth = atan2(direction.x, direction.y);
  const double zenith = atan2(hypot(direction.x, direction.y), direction.z);
  return (film_point){(azimuth < 0.0 ? azimuth + 2.0 * NP_PI : azimuth) / (2.0 * NP_PI) * d->width,
                      zenith / NP_PI * d->height};
}

static bool project(const np_star_field_desc *d, np_dvec3 direction, film_point *out) {
  if (d->camera) return project_pinhole(d, direction, out);
  *out = project_sphere(d, direction);
  return true;
}

/* A pinhole's pixels lie on a plane: their solid angle goes with the cosine's cube. */
static double compute_solid_angle(const np_star_field_desc *d, int x, int y) {
  const np_camera *camera = d->camera;
  if (!camera) return 2.0 * NP_PI / d->width * (cos(NP_PI * y / d->height) - cos(NP_PI * (y + 1.0) / d->height));
  const np_vec3 direction = np_camera_direction(camera, (float)x + 0.5f, (float)y + 0.5f);
  const double cosine = -(double)np_vec3_dot(direction, camera->back);
  return 4.0 * (double)camera->tan_half_width * (double)camera->tan_half_height * cosine * cosine * cosine /
         ((double)camera->width * camera->height);
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
  np_ground_hit ground;
  if (np_disk_covers(&world->night->moon, direction)) return np_spectrum_grey(0.0f);
  if (!d->camera && np_world_intersect_ground(world, d->origin, direction, &ground)) return np_spectrum_grey(0.0f);
  const np_star *star = &d->catalogue->stars[index];
  np_spectrum irradiance = np_star_irradiance((double)star->v_magnitude, (double)star->b_minus_v, d->wavelength_nm);
  if (world->atmosphere)
    irradiance =
        np_spectrum_multiply(irradiance, np_atmosphere_transmittance_to_space(world->atmosphere, d->origin, direction));
  return np_spectrum_scale(irradiance, compute_twinkle(d, index, direction));
}

/* ---- Pixels ---- */

static void add_pixel(const np_star_field_desc *d, long x, long y, double share, np_spectrum irradiance,
                      np_star_field *field) {
  if (!d->camera) x = (x + (long)d->width) % (long)d->width;
  if (!d->camera) y = y < 0 ? 0 : y >= (long)d->height ? (long)d->height - 1 : y;
  const long low = -d->overscan, right = (long)d->width + d->overscan, bottom = (long)d->height + d->overscan;
  if (!(share > 0.0) || x < low || y < low || x >= right || y >= bottom) return;
  const double scale = share / compute_solid_angle(d, (int)x, (int)y);
  field->pixels[field->count++] = (np_star_pixel){(int)x, (int)y, np_spectrum_scale(irradiance, (float)scale)};
}

static void add_star(const np_star_field_desc *d, size_t index, np_star_field *field) {
  film_point at;
  const np_dvec3 direction = np_celestial_apply(&d->world->night->turn, np_star_direction(&d->catalogue->stars[index]));
  if (!project(d, direction, &at)) return;
  const np_spectrum irradiance = compute_irradiance(d, index, np_dvec3_to_float(direction));
  if (np_spectrum_is_zero(irradiance)) return;
  const double left = floor(at.x - 0.5), top = floor(at.y - 0.5), u = at.x - 0.5 - left, v = at.y - 0.5 - top;
  for (int i = 0; i < 4; i++)
    add_pixel(d, (long)left + (i & 1), (long)top + (i >> 1), (i & 1 ? u : 1.0 - u) * (i >> 1 ? v : 1.0 - v), irradiance,
              field);
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

neph_result np_star_field_build(neph_context *context, const np_star_field_desc *desc, np_star_field *out_field) {
  *out_field = (np_star_field){.context = context};
  const size_t stars = desc->catalogue->count;
  out_field->pixels = np_alloc(context, stars ? 4 * stars : 1, sizeof *out_field->pixels);
  if (!out_field->pixels) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < stars; i++) add_star(desc, i, out_field);
  if (out_field->count) merge_pixels(out_field);
  return NEPH_OK;
}

void np_star_field_clear(np_star_field *field) {
  if (field->pixels) np_alloc_free(field->context, field->pixels);
  *field = (np_star_field){0};
}

np_spectrum np_star_field_get(const np_star_field *field, int x, int y) {
  if (!field->count) return np_spectrum_grey(0.0f);
  const np_star_pixel key = {.x = x, .y = y};
  const np_star_pixel *found = bsearch(&key, field->pixels, field->count, sizeof key, compare_pixels);
  return found ? found->radiance : np_spectrum_grey(0.0f);
}
