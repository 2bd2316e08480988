/* SPDX-License-Identifier: Apache-2.0 */
/* The samples of one pixel: their rays, their light, their sums, and the pixel's values. */
#include <string.h>

#include "core/alloc.h"
#include "frame/frame_layers.h"
#include "frame/kept_samples.h"
#include "frame/pixel_points.h"
#include "image/film.h"
#include "integrate/blue_noise_table.h"
#include "volume/depth_cursor.h"

/* ---- Rays ---- */

/* Offset from a pixel's centre, distributed as a tent one pixel to each side: the reconstruction filter, by sampling.
 */
static float tent(float u) { return u < 0.5f ? sqrtf(2.0f * u) - 1.0f : 1.0f - sqrtf(2.0f - 2.0f * u); }

/* Low-discrepancy points (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences"), turned by a random
 * offset per pixel; the golden ratio turns the blue noise from sample to sample. */
static float turn(float offset, double step, unsigned index) {
  const double x = (double)offset + step * (double)index;
  return (float)(x - floor(x));
}

/* Ray for the integrators from a camera ray, clipped to the camera's near and far planes. */
static np_camera_ray clip_ray(const np_frame *f, const np_film_ray *ray, const float film[2]) {
  const bool is_near = ray->near_m > 0.0;
  return (np_camera_ray){.origin = is_near ? np_dvec3_along(ray->origin, ray->direction, ray->near_m) : ray->origin,
                         .direction = ray->direction,
                         .film = {film[0], film[1]},
                         .spread_rad = f->spread_rad,
                         .begin_m = ray->near_m,
                         .has_end = isfinite(ray->far_m),
                         .end_m = ray->far_m - ray->near_m};
}

/* Random offsets of a pixel: two of the film, one of the choice, two of the lens, one of the time, two of the facet. */
enum { OFFSETS = 8 };

/* Time within the exposure, by a Kronecker sequence of the silver mean, which is independent of the pixel's other
 * sequences. */
static double choose_time(const np_motion *exposure, unsigned sample, float offset) {
  return exposure->open + (exposure->close - exposure->open) * (double)turn(offset, 0.8708286933869707, sample);
}

/* The camera at a ray's time. Tables of the frame's picture are looked up in its direction. */
static const np_camera *move_camera(const np_frame *f, double time, np_camera *out) {
  if (!f->exposure || !f->exposure->has_camera) return &f->assembly->camera;
  np_motion_get_camera(f->exposure, time, out);
  return out;
}

static void move_film(const np_frame *f, np_camera_ray *ray) {
  double film[2];
  if (!f->exposure || !f->exposure->has_camera) return;
  if (!np_camera_project_direction(&f->assembly->camera, np_vec3_to_double(ray->direction), film)) return;
  for (int k = 0; k < 2; k++) ray->film[k] = (float)film[k];
}

/* Draws a position in a pixel, in the numbers of which the filter makes a place on the film. */
static void draw_position(unsigned sample, const float offset[OFFSETS], float out[2]) {
  out[0] = np_pixel_coordinate(np_pixel_point_first(sample), np_pixel_shift_to_middle(offset[0]));
  out[1] = np_pixel_coordinate(np_pixel_point_second(sample), np_pixel_shift_to_middle(offset[1]));
}

/* Makes the ray of a position in a pixel and of a lens position; false: no light passes the lens there. */
static bool make_ray(const np_frame *f, int x, int y, unsigned sample, const float offset[OFFSETS],
                     const float position[2], np_camera_ray *out) {
  const uint32_t first = np_pixel_point_first(sample), second = np_pixel_point_second(sample);
  const float film[2] = {(float)x + 0.5f + tent(position[0]), (float)y + 0.5f + tent(position[1])};
  const double time = f->exposure ? choose_time(f->exposure, sample, offset[5]) : 0.0;
  np_film_ray ray;
  np_camera moved;
  if (!np_camera_start_ray(move_camera(f, time, &moved), film[0], film[1], turn(offset[3], 0.8191725133961645, sample),
                           turn(offset[4], 0.6710436067037893, sample), &ray))
    return false;
  *out = clip_ray(f, &ray, film);
  out->time = time;
  move_film(f, out);
  out->jitter = turn(np_blue_noise_get(x, y), 0.6180339887498949, sample);
  out->facet[0] = np_pixel_coordinate(first, np_pixel_shift(offset[6]));
  out->facet[1] = np_pixel_coordinate(second, np_pixel_shift(offset[7]));
  out->choice = turn(offset[2], 0.6180339887498949, sample);
  return true;
}

/* ---- The horizon ---- */

/* Steps by which the horizon is searched within a pixel. */
enum { HORIZON_STEPS = 10 };

/* Least share of a pixel that one side of the horizon gets a ray for. */
static const float share_least = 0.01f;

static bool meets_ground(const np_frame *f, const int at[2], unsigned sample, const float offset[OFFSETS],
                         const float position[2]) {
  np_camera_ray ray;
  np_ground_hit hit;
  return make_ray(f, at[0], at[1], sample, offset, position, &ray) &&
         np_camera_ray_intersect_ground(&f->assembly->packets[0].lights[0].world, &ray, &hit);
}

/* Axis that the horizon of the sphere crosses in more of a pixel's sides, 0 or 1; -1: its corners are alike. Hills have
 * edges everywhere, and each search is many rays. */
static int search_axis(const np_frame *f, const int at[2], const float offset[OFFSETS]) {
  const np_world *world = &f->assembly->packets[0].lights[0].world;
  if (!world->has_planet || world->terrain || f->depth_components) return -1;
  bool met[4];
  for (unsigned corner = 0; corner < 4; corner++)
    met[corner] = meets_ground(f, at, 0, offset, (const float[2]){(float)(corner & 1u), (float)(corner >> 1)});
  const int across = (met[0] != met[1]) + (met[2] != met[3]), up = (met[0] != met[2]) + (met[1] != met[3]);
  return across + up == 0 ? -1 : across > up ? 0 : 1;
}

/* Number at which the horizon crosses the line along an axis through a position; 0: it does not. */
static float search_horizon(const np_frame *f, const int at[2], unsigned sample, const float offset[OFFSETS],
                            const float position[2], int axis) {
  float place[2] = {position[0], position[1]}, low = 0.0f, high = 1.0f;
  place[axis] = low;
  const bool is_low_ground = meets_ground(f, at, sample, offset, place);
  place[axis] = high;
  if (meets_ground(f, at, sample, offset, place) == is_low_ground) return 0.0f;
  for (int n = 0; n < HORIZON_STEPS; n++) {
    place[axis] = 0.5f * (low + high);
    if (meets_ground(f, at, sample, offset, place) == is_low_ground)
      low = place[axis];
    else
      high = place[axis];
  }
  return 0.5f * (low + high);
}

/* Positions of a sample and their shares. Of two one is on either side of the horizon: both get light in proportion to
 * what the filter has of them, where one ray is all ground or all sky. Returns how many. */
static unsigned split_position(const np_frame *f, const int at[2], unsigned sample, const float offset[OFFSETS],
                               int first_axis, float out[2][2], float share[2]) {
  draw_position(sample, offset, out[0]);
  share[0] = 1.0f;
  for (int n = 0; n < 2 && first_axis >= 0; n++) {
    const int axis = first_axis ^ n;
    const float edge = search_horizon(f, at, sample, offset, out[0], axis), drawn = out[0][axis];
    if (!(edge > share_least && edge < 1.0f - share_least)) continue;
    memcpy(out[1], out[0], sizeof out[0]);
    out[0][axis] = edge * drawn;
    out[1][axis] = edge + (1.0f - edge) * drawn;
    share[0] = edge;
    share[1] = 1.0f - edge;
    return 2;
  }
  return 1;
}

/* Distance along the ray through the pixel's centre and the lens's centre, at which clouds hide half, or of the ground
 * if it is nearer; infinite if there is neither. */
static double compute_distance(const np_frame *f, int x, int y, np_vec3 *out_direction) {
  const np_camera *camera = &f->assembly->camera;
  const np_world *world = &f->assembly->packets[0].lights[0].world;
  const float film[2] = {(float)x + 0.5f, (float)y + 0.5f};
  np_film_ray middle;
  const bool has_ray = np_camera_start_ray(camera, film[0], film[1], 0.5f, 0.0f, &middle);
  *out_direction = middle.direction;
  if (!has_ray) return HUGE_VAL;
  const np_camera_ray ray = clip_ray(f, &middle, film);
  np_ground_hit hit;
  const bool is_ground = np_camera_ray_intersect_ground(world, &ray, &hit);
  const double end = is_ground ? hit.distance_m : np_camera_ray_get_end(&ray);
  const double cloud = f->half_distance(world, &ray, end);
  return ray.begin_m + fmin(cloud, is_ground ? end : HUGE_VAL);
}

np_pixel_guide np_frame_compute_guide(const np_frame *f, const int at[2]) {
  const np_world *world = &f->assembly->packets[0].lights[0].world;
  const float film[2] = {(float)at[0] + 0.5f, (float)at[1] + 0.5f};
  np_film_ray middle;
  if (!np_camera_start_ray(&f->assembly->camera, film[0], film[1], 0.5f, 0.0f, &middle))
    return (np_pixel_guide){.cloud_m = HUGE_VALF, .behind_m = HUGE_VALF, .half_m = HUGE_VALF};
  const np_camera_ray ray = clip_ray(f, &middle, film);
  np_ground_hit hit;
  const bool is_ground = np_camera_ray_intersect_ground(world, &ray, &hit);
  const double end = is_ground ? hit.distance_m : np_camera_ray_get_end(&ray);
  const np_view_depth depth = f->view_depth(world, &ray, end);
  const double behind = is_ground ? end : HUGE_VAL;
  return (np_pixel_guide){.cloud_m = (float)(ray.begin_m + depth.cloud_m),
                          .behind_m = (float)(ray.begin_m + behind),
                          .half_m = (float)(ray.begin_m + fmin(depth.half_m, behind)),
                          .opacity = depth.opacity};
}

double np_frame_get_depth(const np_frame *f, const int at[2], double distance_m) {
  np_film_ray middle;
  (void)np_camera_start_ray(&f->assembly->camera, (float)at[0] + 0.5f, (float)at[1] + 0.5f, 0.5f, 0.0f, &middle);
  return np_camera_get_depth(&f->assembly->camera, middle.direction, distance_m);
}

/* Optical depth of all clouds up to the ground, without the early end of an integrator's ray. */
static float compute_depth_in(const np_world *world, const np_camera_ray *ray) {
  np_ground_hit hit;
  const bool is_ground = np_camera_ray_intersect_ground(world, ray, &hit);
  const double end = is_ground ? hit.distance_m : np_camera_ray_get_end(ray);
  np_depth_cursors clouds;
  np_depth_cursors_start(&clouds, &world->clouds, ray->origin, ray->direction, end);
  np_depth_cursors_advance(&clouds, end);
  return (float)np_depth_cursors_sum(&clouds);
}

static float compute_optical_depth(const np_frame *f, const np_camera_ray *ray) {
  const np_packet_light *light = &f->assembly->packets[0].lights[0];
  if (!f->exposure || !f->exposure->has_clouds) return compute_depth_in(&light->world, ray);
  np_moved_light moved;
  np_motion_move(f->exposure, light, ray->time, &moved);
  return compute_depth_in(&moved.world, ray);
}

static void integrate_moved(const np_frame *f, const np_packet_light *light, const np_camera_ray *ray,
                            np_random *random, np_integrator_sample *out) {
  np_moved_light moved;
  np_motion_move(f->exposure, light, ray->time, &moved);
  f->integrate(&moved.world, &moved.lighting, &f->settings, ray, random, out);
}

/* One light, with the clouds where they are at the ray's time. */
static void integrate_light(const np_frame *f, const np_packet_light *light, const np_camera_ray *ray,
                            np_random *random, np_integrator_sample *out) {
  if (f->exposure && f->exposure->has_clouds)
    integrate_moved(f, light, ray, random, out);
  else
    f->integrate(&light->world, &light->lighting, &f->settings, ray, random, out);
}

/* Stars are put on the frame's picture: of a pixel beside, drawn by how far the camera has turned. */
static np_spectrum get_stars(const np_frame *f, const np_packet *packet, const np_camera_ray *ray, const int pixel[2],
                             np_random *random) {
  if (!f->exposure || !f->exposure->has_camera) return np_star_field_get(&packet->stars, pixel[0], pixel[1]);
  double aside[2], film[2];
  const np_dvec3 direction = np_vec3_to_double(ray->direction);
  np_camera moved;
  if (!np_camera_project_direction(move_camera(f, ray->time, &moved), direction, aside) ||
      !np_camera_project_direction(&f->assembly->camera, direction, film))
    return np_spectrum_grey(0.0f);
  int at[2];
  for (int k = 0; k < 2; k++) at[k] = pixel[k] + (int)floor(film[k] - aside[k] + np_random_double(random));
  const int view[2][2] = {{f->view_min[0], f->view_max[0]}, {f->view_min[1], f->view_max[1]}};
  for (int k = 0; k < 2; k++)
    if (at[k] < view[k][0] || at[k] >= view[k][1]) return np_spectrum_grey(0.0f);
  return np_star_field_get(&packet->stars, at[0], at[1]);
}

/* Integrates one packet: the sum over its lights, since light is additive, and the stars behind whatever the sample
 * meets. */
static void integrate_packet(const np_frame *f, const np_packet *packet, const np_camera_ray *ray, const int pixel[2],
                             np_random *random, np_integrator_sample *out) {
  integrate_light(f, &packet->lights[0], ray, random, out);
  if (f->has_light_groups) np_frame_add_group(f, ray, packet->lights[0].beam.group, out);
  for (unsigned l = 1; l < packet->light_count; l++) {
    np_integrator_sample more;
    np_integrator_layers layers;
    np_camera_ray same = *ray;
    if (ray->layers) same.layers = np_frame_start_layers(f, &layers);
    integrate_light(f, &packet->lights[l], &same, random, &more);
    if (ray->layers) np_integrator_append_light(ray->layers, &layers);
    if (f->has_light_groups) np_frame_add_group(f, ray, packet->lights[l].beam.group, &more);
    for (int c = 0; c < NP_COMPONENT_ALL; c++)
      out->component[c] = np_spectrum_add(out->component[c], more.component[c]);
    out->lost = np_spectrum_add(out->lost, more.lost);
    out->cut_count += more.cut_count;
    out->followed_count += more.followed_count;
  }
  if ((!packet->stars.count && !packet->stars.blurred) || out->is_ground_behind) return;
  const np_spectrum stars = np_spectrum_scale(get_stars(f, packet, ray, pixel, random), out->transmittance);
  out->component[NP_COMPONENT_BACKGROUND] = np_spectrum_add(out->component[NP_COMPONENT_BACKGROUND], stars);
  if (!f->has_light_groups || !(f->channels.beauty & 1u << NP_COMPONENT_BACKGROUND)) return;
  np_spectrum *sky = &ray->layers->group[NP_LIGHT_GROUP_SKY];
  *sky = np_spectrum_add(*sky, stars);
}

static void add_vectors(const np_frame *f, const np_camera_ray *ray, const np_integrator_sample *sample) {
  const np_world *world = &f->assembly->packets[0].lights[0].world;
  const np_motion_vectors vectors = np_motion_compute_vectors(f->vectors, world, ray, sample, ray->time);
  for (int k = 0; k < 2; k++) {
    ray->layers->motion[k] = vectors.forward[k];
    ray->layers->motion[2 + k] = vectors.backward[k];
  }
}

/* Integrates one sample of the picture. All packets of bands follow the same path, and their bands are summed to
 * colours before the film squares them. Values that do not depend on wavelength come from the first packet. */
static void integrate(const np_frame *f, const np_camera_ray *ray, const int pixel[2], const np_random *random,
                      np_integrator_sample *out) {
  const np_assembly *a = f->assembly;
  np_random first_random = *random;
  integrate_packet(f, &a->packets[0], ray, pixel, &first_random, out);
  if (a->is_of_bands) return;
  np_integrator_sample sample = *out;
  memset(out->component, 0, sizeof out->component);
  out->lost = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < a->packet_count; p++) {
    np_random same_random = *random;
    np_integrator_layers layers;
    np_camera_ray same = *ray;
    if (ray->layers && p > 0) same.layers = np_frame_start_layers(f, &layers);
    if (p > 0) integrate_packet(f, &a->packets[p], &same, pixel, &same_random, &sample);
    if (ray->layers) np_frame_convert_layers(&a->packets[p], same.layers);
    if (ray->layers && p > 0) np_integrator_append_light(ray->layers, &layers);
    for (int c = 0; c < NP_COMPONENT_ALL; c++)
      out->component[c] = np_packet_add_color(&a->packets[p], out->component[c], sample.component[c]);
    out->lost = np_packet_add_color(&a->packets[p], out->lost, sample.lost);
  }
}

static np_random start_random(const np_frame *f, const int at[2], uint32_t sample) {
  return np_random_start(f->desc->seed, (uint32_t)f->desc->frame, (uint32_t)at[0], (uint32_t)at[1], sample);
}

/* Integrates the ray of one position, and reads its numbers; zeros where no light passes the lens. */
static void sample_position(const np_frame *f, const int at[2], uint32_t number, const float offset[OFFSETS],
                            const float position[2], np_deep_bins *bins, float values[NP_PIXEL_NUMBERS_MAX]) {
  const np_random random = start_random(f, at, number);
  np_integrator_layers layers;
  np_camera_ray ray = {.begin_m = 0.0};
  np_integrator_sample sample = {.transmittance = 1.0f};
  const bool has_ray = make_ray(f, at[0], at[1], number, offset, position, &ray);
  if (f->has_layers) ray.layers = np_frame_start_layers(f, &layers);
  if (has_ray) integrate(f, &ray, at, &random, &sample);
  if (has_ray && f->vectors) add_vectors(f, &ray, &sample);
  if (has_ray && f->aovs & NP_AOV_OPTICAL_DEPTH) sample.optical_depth = compute_optical_depth(f, &ray);
  np_channels_read_numbers(&f->channels, &ray, &sample, values);
  if (f->depth_components) np_frame_add_deep(f, &sample, &layers, bins);
}

/* Number of values of a sample: its squares are the film's. */
static unsigned count_values(const np_frame *f) { return np_channels_count_numbers(&f->channels) - NP_BAND_COUNT; }

/* Takes a sample of a pixel: one ray, or two that the horizon parts. */
static void take_sample(const np_frame *f, const int at[2], uint32_t number, const float offset[OFFSETS], int axis,
                        np_deep_bins *bins, float values[NP_PIXEL_NUMBERS_MAX]) {
  float position[2][2], share[2], other[NP_PIXEL_NUMBERS_MAX];
  const unsigned count = split_position(f, at, number, offset, axis, position, share);
  sample_position(f, at, number, offset, position[0], bins, values);
  if (count == 1) return;
  sample_position(f, at, number, offset, position[1], bins, other);
  for (unsigned i = 0; i < count_values(f); i++) values[i] = share[0] * values[i] + share[1] * other[i];
}

neph_result np_frame_sample_pixel(const np_frame *f, const int at[2], uint32_t end, np_pixel_state *p,
                                  double *numbers) {
  np_film_accumulator accumulator;
  const uint32_t begun = p->next % NP_FILM_LEAF_SAMPLES, before = p->next - begun - p->begin;
  np_film_accumulator_begin_moments(&accumulator, f->channels.sum_count + NP_PIXEL_SUMS_OWN, NP_BAND_COUNT,
                                    p->next - begun);
  if (p->kept) p->next = np_kept_samples_load(f->kept, p->kept, &accumulator);
  if (begun) (void)np_film_accumulator_add_node(&accumulator, &(np_film_node){p->next - begun, begun, numbers});
  np_random shift = start_random(f, at, UINT32_MAX);
  float offset[OFFSETS];
  for (int i = 0; i < OFFSETS; i++) offset[i] = np_random_float(&shift);
  np_deep_bins bins;
  if (f->depth_components) np_deep_bins_load(&p->deep, &bins);
  const int axis = p->next < end ? search_axis(f, at, offset) : -1;
  for (; p->next < end; p->next++) {
    float values[NP_PIXEL_NUMBERS_MAX];
    take_sample(f, at, p->next, offset, axis, &bins, values);
    if (np_monitor_is_cancelled(f->monitor)) break;
    np_film_accumulator_add(&accumulator, values);
  }
  if (f->depth_components && np_deep_bins_store(f->assembly->context, &bins, &p->deep)) return NEPH_ERROR_OUT_OF_MEMORY;
  double added[NP_PIXEL_NUMBERS_MAX];
  np_film_accumulator_finish(&accumulator, added);
  if (before) np_film_accumulator_join(&accumulator, numbers, before, added, p->next - p->begin - before);
  memcpy(numbers, added, np_channels_count_numbers(&f->channels) * sizeof *numbers);
  if (p->kept && p->next == end) np_kept_samples_store(f->kept, p->kept, &accumulator, end);
  if (p->record && p->next == end) f->sink->keep_numbers(f->film, p->record, &accumulator, added, end - p->begin);
  return p->next < end ? NEPH_ERROR_CANCELLED : NEPH_OK;
}

bool np_frame_is_in_view(const np_frame *f, const int at[2]) {
  return at[0] >= f->view_min[0] && at[0] < f->view_max[0] && at[1] >= f->view_min[1] && at[1] < f->view_max[1];
}

np_pilot np_frame_get_pilot(const np_frame *f, const double *numbers, uint32_t count) {
  const np_spread spread = np_channels_get_spread(&f->channels, numbers, count);
  const np_pixel_luminance l = np_frame_get_luminance(f, &spread);
  return (np_pilot){l.value, l.variance * l.count * (l.count - 1.0f), l.count};
}

neph_result np_frame_fly_pilot(const np_frame *f, const int at[2], uint32_t count, np_pilot *out) {
  np_pixel_state p = {.next = 0};
  double numbers[NP_PIXEL_NUMBERS_MAX];
  const neph_result result = np_frame_sample_pixel(f, at, count, &p, numbers);
  np_alloc_free(f->assembly->context, p.deep.at);
  if (!result) *out = np_frame_get_pilot(f, numbers, count);
  return result;
}

double np_frame_draw_rounding(const np_frame *f, const int at[2]) {
  np_random random = start_random(f, at, UINT32_MAX - 1);
  return np_random_double(&random);
}

np_frame *np_frame_copy_for_luminance(const np_frame *f, neph_render_desc *desc) {
  np_frame *copy = np_alloc(f->assembly->context, 1, sizeof *copy);
  if (!copy) return NULL;
  *copy = *f;
  *desc = *f->desc;
  copy->desc = desc;
  copy->channels.count = copy->channels.sum_count = 0;
  copy->depth_components = copy->aovs = 0;
  copy->has_layers = copy->has_light_groups = false;
  copy->vectors = NULL;
  copy->settings.lost_share = 0.0f;
  copy->settings.has_sun_share = false;
  return copy;
}

neph_result np_frame_finish_pixel(const np_frame *f, const int at[2], const np_pixel_state *p, const double *numbers,
                                  np_tile_total *total) {
  np_pixel_facts facts = {.spread = np_channels_get_spread(&f->channels, numbers, p->next - p->begin)};
  np_vec3 direction;
  facts.distance = compute_distance(f, at[0], at[1], &direction);
  facts.depth = np_camera_get_depth(&f->assembly->camera, direction, facts.distance);
  const size_t index = (size_t)(at[1] - f->min[1]) * f->width + (size_t)(at[0] - f->min[0]);
  if (p->record) f->sink->keep_depths(p->record, facts.distance, facts.depth);
  np_frame_develop_pixel(f, index, &facts, numbers, total);
  if (!f->depth_components) return NEPH_OK;
  return np_frame_set_deep(f, p, index, np_camera_get_depth(&f->assembly->camera, direction, 1.0));
}
