/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/reprojection.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* Cloud opacity from which a pixel is reprojected by the motion of its clouds: 0.5 before ground, and less before the
 * sky, which has no visible motion of its own. */
static const float cloud_opacity_min = 0.5f, cloud_before_sky_min = 0.05f;

/* Differences that two pixels of one thing may have: of relative distance; of opacity, relative and at the least. */
static const float distance_tolerance = 0.05f, opacity_tolerance = 0.3f, opacity_least = 0.02f;

/* Least bilinear weight, among the four nearest pixels, of pixels at the same depth. */
static const float weight_least = 0.25f;

/* Offsets below this are rounding, in pixels. */
static const float offset_least = 1e-3f;

static float invert(float distance_m) { return 1.0f / fmaxf(distance_m, 1e-3f); }

bool np_pixel_guide_is_cloud(const np_pixel_guide *guide) {
  return guide->opacity >= (isinf(guide->behind_m) ? cloud_before_sky_min : cloud_opacity_min);
}

float np_pixel_guide_compare(float a_m, float b_m) {
  const float a = invert(a_m), b = invert(b_m), larger = fmaxf(a, b);
  return larger > 0.0f ? fabsf(a - b) / larger : 0.0f;
}

/* Differences from which neighbours show different things: of opacity, and of the inverse distance from that of a plane
 * through them, which is even over the picture, over the largest. */
static const float edge_opacity = 0.01f, edge_bend = 0.1f;

static bool has_kink(float a_m, float middle_m, float b_m) {
  const float a = invert(a_m), middle = invert(middle_m), b = invert(b_m);
  return fabsf(a + b - 2.0f * middle) > edge_bend * fmaxf(middle, fmaxf(a, b));
}

static float get_visible(const np_pixel_guide *guide) {
  return guide->opacity < cloud_opacity_min ? guide->behind_m : guide->cloud_m;
}

/* Whether the pixel between two neighbours lies at another depth than both. */
static bool shows_other(const np_pixel_guide *a, const np_pixel_guide *middle, const np_pixel_guide *b) {
  const float least = fminf(middle->opacity, fminf(a->opacity, b->opacity));
  if (fabsf(a->opacity - middle->opacity) > edge_opacity || fabsf(b->opacity - middle->opacity) > edge_opacity)
    return true;
  return least < cloud_opacity_min ? has_kink(a->behind_m, middle->behind_m, b->behind_m)
                                   : has_kink(a->cloud_m, middle->cloud_m, b->cloud_m);
}

/* Fills the range of distances in a pixel's neighbourhood. Pixels outside the window count as the nearest pixel
 * inside. */
void np_pixel_guide_fill_around(np_pixel_guide *guides, unsigned width, unsigned height, unsigned x, unsigned y) {
  assert(x < width && y < height);
  static const int steps[][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
  np_pixel_guide *guide = &guides[(size_t)y * width + x];
  guide->near_m = guide->far_m = get_visible(guide);
  for (int k = 0; k < 4; k++) {
    const np_pixel_guide *pair[2];
    for (int side = 0; side < 2; side++) {
      const int64_t column = (int64_t)x + (side ? steps[k][0] : -steps[k][0]);
      const int64_t row = (int64_t)y + (side ? steps[k][1] : -steps[k][1]);
      const bool is_inside = column >= 0 && row >= 0 && column < width && row < height;
      pair[side] = is_inside ? &guides[(size_t)row * width + (size_t)column] : guide;
    }
    guide->is_edge = guide->is_edge || shows_other(pair[0], guide, pair[1]);
    for (int side = 0; side < 2; side++) {
      guide->near_m = fminf(guide->near_m, get_visible(pair[side]));
      guide->far_m = fmaxf(guide->far_m, get_visible(pair[side]));
    }
  }
}

/* Relative difference that the neighbours of two edges may have: coarse, for they are not of the pixel itself. */
static const float around_tolerance = 0.4f;

bool np_pixel_guide_has_same_around(const np_pixel_guide *from, const np_pixel_guide *to) {
  if (!from->is_edge) return true;
  return to->is_edge && np_pixel_guide_compare(from->near_m, to->near_m) <= around_tolerance &&
         np_pixel_guide_compare(from->far_m, to->far_m) <= around_tolerance;
}

/* ---- Places ---- */

static bool is_same_camera(const np_camera *a, const np_camera *b) {
  const bool is_same_place = !memcmp(&a->origin, &b->origin, sizeof a->origin) &&
                             !memcmp(&a->right, &b->right, sizeof a->right) && !memcmp(&a->up, &b->up, sizeof a->up) &&
                             !memcmp(&a->back, &b->back, sizeof a->back);
  return is_same_place && a->row == b->row && a->tan_half_width == b->tan_half_width &&
         a->half_width_m == b->half_width_m && a->half_angle == b->half_angle && a->shift[0] == b->shift[0] &&
         a->shift[1] == b->shift[1];
}

np_reprojection np_reprojection_make(const np_history_frame *before, const np_camera *camera,
                                     const np_pixel_guide *guides, const int min[2], unsigned width, unsigned height) {
  return (np_reprojection){.before = before,
                           .camera = camera,
                           .guides = guides,
                           .min = {min[0], min[1]},
                           .width = width,
                           .height = height,
                           .is_still = is_same_camera(camera, &before->camera)};
}

static float get_distance(const np_pixel_guide *guide, bool is_cloud) {
  return is_cloud ? guide->cloud_m : guide->behind_m;
}

static float get_inverse(const np_reprojection *r, unsigned x, unsigned y, bool is_cloud) {
  return invert(get_distance(&r->guides[(size_t)y * r->width + x], is_cloud));
}

/* Change of the inverse distance to a neighbour, the lesser of two: the other may be beyond an edge. */
static float compute_slope(const np_reprojection *r, unsigned x, unsigned y, bool is_cloud) {
  const float here = get_inverse(r, x, y, is_cloud);
  float left = HUGE_VALF, right = HUGE_VALF, above = HUGE_VALF, below = HUGE_VALF;
  if (x > 0) left = fabsf(get_inverse(r, x - 1, y, is_cloud) - here);
  if (x + 1 < r->width) right = fabsf(get_inverse(r, x + 1, y, is_cloud) - here);
  if (y > 0) above = fabsf(get_inverse(r, x, y - 1, is_cloud) - here);
  if (y + 1 < r->height) below = fabsf(get_inverse(r, x, y + 1, is_cloud) - here);
  const float across = fminf(left, right), along = fminf(above, below);
  return (isinf(across) ? 0.0f : across) + (isinf(along) ? 0.0f : along);
}

/* Distance from the eye of then, or from the plane in which parallel rays start. */
static double compute_distance(const np_camera *camera, np_dvec3 point, double depth_m) {
  return np_camera_has_centre(camera) ? np_dvec3_length(np_dvec3_subtract(point, camera->origin)) : depth_m;
}

static bool project(const np_reprojection *r, unsigned x, unsigned y, double distance_m, double out_film[2],
                    double *out_distance_m) {
  const np_camera *before = &r->before->camera;
  np_film_ray ray;
  double depth_m;
  *out_distance_m = distance_m;
  out_film[0] = r->min[0] + (double)x + 0.5;
  out_film[1] = r->min[1] + (double)y + 0.5;
  if (!np_camera_start_ray(r->camera, (float)out_film[0], (float)out_film[1], 0.5f, 0.0f, &ray)) return false;
  if (r->is_still) return true;
  if (isinf(distance_m)) return np_camera_project_direction(before, np_vec3_to_double(ray.direction), out_film);
  const np_dvec3 point = np_dvec3_along(ray.origin, ray.direction, distance_m);
  if (!np_camera_project(before, point, out_film, &depth_m)) return false;
  *out_distance_m = compute_distance(before, point, depth_m);
  return true;
}

/* ---- What is there ---- */

/* Whether a pixel of the previous picture lies in its window and shows the same depth as the reprojected pixel. */
static bool shows_same(const np_reprojection *r, const np_reprojected *place, int x, int y) {
  if (x < 0 || y < 0 || x >= (int)r->width || y >= (int)r->height) return false;
  const np_pixel_guide *then = &r->before->guides[(size_t)y * r->width + (size_t)x], *now = place->guide;
  const float a = invert(get_distance(then, place->is_cloud)), b = invert(place->distance_m);
  return fabsf(a - b) <= distance_tolerance * fmaxf(a, b) + 2.0f * place->slope &&
         fabsf(then->opacity - now->opacity) <=
             opacity_least + opacity_tolerance * fminf(then->opacity, now->opacity) &&
         np_pixel_guide_has_same_around(then, now);
}

/* A position between pixel centres: the upper left pixel, and the fractional position from its centre. */
typedef struct corner {
  int at[2];
  float share[2];
} corner;

static corner get_corner(const np_reprojected *place) {
  corner c;
  for (int k = 0; k < 2; k++) {
    const float from_centre = place->at[k] - 0.5f, whole = floorf(from_centre + offset_least);
    c.at[k] = (int)whole;
    c.share[k] = from_centre - whole < offset_least ? 0.0f : from_centre - whole;
  }
  return c;
}

/* Sum of the bilinear weights of the four nearest pixels that show the same depth. */
static float compute_weight(const np_reprojection *r, const np_reprojected *place, const corner *c, int k) {
  const float across = k % 2 ? c->share[0] : 1.0f - c->share[0], along = k / 2 ? c->share[1] : 1.0f - c->share[1];
  const float weight = across * along;
  return weight > 0.0f && shows_same(r, place, c->at[0] + k % 2, c->at[1] + k / 2) ? weight : 0.0f;
}

static bool is_seen(const np_reprojection *r, const np_reprojected *place) {
  const corner c = get_corner(place);
  float sum = 0.0f;
  for (int k = 0; k < 4; k++) sum += compute_weight(r, place, &c, k);
  return sum >= weight_least;
}

np_reprojected np_reprojection_project(const np_reprojection *r, unsigned x, unsigned y) {
  const np_pixel_guide *guide = &r->guides[(size_t)y * r->width + x];
  np_reprojected out = {.is_cloud = np_pixel_guide_is_cloud(guide), .guide = guide};
  double film[2], distance_m;
  if (!project(r, x, y, (double)get_distance(guide, out.is_cloud), film, &distance_m)) return out;
  for (int k = 0; k < 2; k++) out.at[k] = (float)np_clamp(film[k] - r->min[k], -16.0, 131072.0);
  out.distance_m = (float)distance_m;
  out.slope = compute_slope(r, x, y, out.is_cloud);
  out.is_seen = is_seen(r, &out);
  return out;
}

/* ---- Values ---- */

enum { TAPS = 16 };

/* Pixels of the picture before, and their weights. */
typedef struct taps {
  unsigned count;
  size_t index[TAPS];
  float weight[TAPS];
} taps;

static void fill_cubic(float t, float out[4]) {
  out[0] = 0.5f * t * (t * (2.0f - t) - 1.0f);
  out[1] = 0.5f * (t * t * (3.0f * t - 5.0f) + 2.0f);
  out[2] = 0.5f * t * (t * (4.0f - 3.0f * t) + 1.0f);
  out[3] = 0.5f * t * t * (t - 1.0f);
}

static void add_tap(const np_reprojection *r, int x, int y, float weight, taps *out) {
  out->index[out->count] = (size_t)y * r->width + (size_t)x;
  out->weight[out->count++] = weight;
}

/* Whether the cubic may be used: all sixteen pixels show the same depth. */
static bool choose_cubic(const np_reprojection *r, const np_reprojected *place, const corner *c, taps *out) {
  float across[4], along[4];
  fill_cubic(c->share[0], across);
  fill_cubic(c->share[1], along);
  out->count = 0;
  for (int k = 0; k < TAPS; k++) {
    const float weight = across[k % 4] * along[k / 4];
    const int x = c->at[0] + k % 4 - 1, y = c->at[1] + k / 4 - 1;
    if (weight == 0.0f) continue;
    if (!shows_same(r, place, x, y)) return false;
    add_tap(r, x, y, weight, out);
  }
  return true;
}

static void choose_linear(const np_reprojection *r, const np_reprojected *place, const corner *c, taps *out) {
  float sum = 0.0f;
  out->count = 0;
  for (int k = 0; k < 4; k++) {
    const float weight = compute_weight(r, place, c, k);
    if (weight > 0.0f) add_tap(r, c->at[0] + k % 2, c->at[1] + k / 2, weight, out);
    sum += weight;
  }
  for (unsigned i = 0; i < out->count; i++) out->weight[i] /= sum;
}

/* The cubic does not go beyond the values that it lies between. */
static float sum_taps(const taps *t, const float *values) {
  float sum = 0.0f, least = HUGE_VALF, most = -HUGE_VALF;
  for (unsigned i = 0; i < t->count; i++) {
    const float value = values[t->index[i]];
    sum += t->weight[i] * value;
    least = fminf(least, value);
    most = fmaxf(most, value);
  }
  return fminf(fmaxf(sum, least), most);
}

void np_reprojection_sample(const np_reprojection *r, const np_reprojected *place, float *out_values,
                            float *out_count) {
  const corner c = get_corner(place);
  const size_t pixels = (size_t)r->width * r->height;
  taps t;
  if (!choose_cubic(r, place, &c, &t)) choose_linear(r, place, &c, &t);
  for (unsigned i = 0; i < r->before->channel_count; i++) out_values[i] = sum_taps(&t, r->before->values + i * pixels);
  *out_count = sum_taps(&t, r->before->counts);
}
