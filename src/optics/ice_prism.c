/* SPDX-License-Identifier: Apache-2.0 */
/* Half of what a large crystal scatters is diffracted, the other half is reflected and refracted. Rays of random
 * directions meet a prism; each is followed inside from face to face, and leaves a share of itself at each by Fresnel's
 * equations, as the mean over both polarisations. Rays that leave through a face parallel to their first go straight
 * on: they have a part in the diffracted core, which is as wide for them.
 *
 * Directions and places come from a Kronecker sequence in four dimensions. Intensities are sums over bins of 0.05°,
 * smoothed by less than the sun's disk where halos have edges, and by more elsewhere. */
#include "optics/ice_prism.h"

#include <math.h>

#include "core/alloc.h"
#include "core/math.h"
#include "core/units.h"
#include "optics/ice_table.h"
#include "optics/raindrop.h"

enum { FACES = 8, BINS = 3600, CHUNKS = 64, RAYS_PER_CHUNK = 16384, PASSES_MAX = 40 };

/* Length over width of each habit, the width from corner to corner across the hexagon. */
static const double column_length = 2.0, plate_length = 0.2;

/* Effective variance of their shadows. */
static const double core_variance = 0.2;

typedef struct ice_prism {
  np_dvec3 normal[FACES];
  double distance[FACES]; /* faces from the centre */
  double radius;          /* sphere around the prism */
} ice_prism;

static ice_prism make_prism(double length) {
  ice_prism prism = {.radius = sqrt(1.0 + length * length)};
  for (int f = 0; f < 6; f++) {
    prism.normal[f] = np_dvec3_make(cos(f * NP_PI / 3.0), sin(f * NP_PI / 3.0), 0.0);
    prism.distance[f] = 0.5 * sqrt(3.0);
  }
  for (int f = 6; f < FACES; f++) {
    prism.normal[f] = np_dvec3_make(0.0, 0.0, f == 6 ? 1.0 : -1.0);
    prism.distance[f] = length;
  }
  return prism;
}

static np_dvec3 move(np_dvec3 place, np_dvec3 direction, double distance) {
  return np_dvec3_add(place, np_dvec3_scale(direction, distance));
}

/* Enters the prism from outside; −1: the ray misses it. */
static int enter(const ice_prism *prism, np_dvec3 origin, np_dvec3 direction, np_dvec3 *out_place) {
  double begin = -INFINITY, end = INFINITY;
  int face = -1;
  for (int f = 0; f < FACES; f++) {
    const double rate = np_dvec3_dot(prism->normal[f], direction);
    const double gap = prism->distance[f] - np_dvec3_dot(prism->normal[f], origin);
    if (rate < 0.0 && gap / rate > begin) {
      begin = gap / rate;
      face = f;
    } else if (rate > 0.0) {
      end = fmin(end, gap / rate);
    } else if (rate == 0.0 && gap < 0.0) {
      return -1;
    }
  }
  *out_place = move(origin, direction, begin);
  return begin < end ? face : -1;
}

/* Goes to the next face from inside. */
static int cross(const ice_prism *prism, np_dvec3 *place, np_dvec3 direction) {
  double nearest = INFINITY;
  int face = 0;
  for (int f = 0; f < FACES; f++) {
    const double rate = np_dvec3_dot(prism->normal[f], direction);
    if (!(rate > 0.0)) continue;
    const double distance = fmax(0.0, (prism->distance[f] - np_dvec3_dot(prism->normal[f], *place)) / rate);
    if (distance < nearest) {
      nearest = distance;
      face = f;
    }
  }
  *place = move(*place, direction, nearest);
  return face;
}

/* Refracts at a face whose normal is on the side that light goes to; `ratio` is the index before over that behind it.
 * Returns the reflected share, 1 where all is. */
static double refract(np_dvec3 direction, np_dvec3 normal, double ratio, np_dvec3 *out_direction) {
  const double cosine = np_dvec3_dot(direction, normal), square = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
  if (!(square > 0.0)) return 1.0;
  const double behind = sqrt(square);
  *out_direction = np_dvec3_add(np_dvec3_scale(direction, ratio), np_dvec3_scale(normal, behind - ratio * cosine));
  const double across = (ratio * cosine - behind) / (ratio * cosine + behind);
  const double along = (cosine - ratio * behind) / (cosine + ratio * behind);
  return 0.5 * (across * across + along * along);
}

static np_dvec3 reflect(np_dvec3 direction, np_dvec3 normal) {
  return np_dvec3_add(direction, np_dvec3_scale(normal, -2.0 * np_dvec3_dot(direction, normal)));
}

/* Light by scattering angle, and light that goes straight on. */
typedef struct ice_light {
  double bin[BINS], straight;
} ice_light;

/* Rays that are turned by less go straight on. */
static const double straight_rad = 1e-5;

static void deposit(ice_light *light, np_dvec3 before, np_dvec3 after, double share) {
  const np_dvec3 d = np_dvec3_subtract(after, before);
  const double angle = 2.0 * asin(fmin(0.5 * np_dvec3_length(d), 1.0));
  const unsigned bin = (unsigned)(angle / NP_PI * BINS);
  if (angle < straight_rad)
    light->straight += share;
  else
    light->bin[bin < BINS ? bin : BINS - 1] += share;
}

/* Share of a ray below which it is no longer followed. */
static const double share_min = 1e-4;

static void trace(const ice_prism *prism, double index, np_dvec3 origin, np_dvec3 direction, ice_light *light) {
  np_dvec3 place, inside = direction;
  const int first = enter(prism, origin, direction, &place);
  if (first < 0) return;
  const np_dvec3 inwards = np_dvec3_scale(prism->normal[first], -1.0);
  double share = refract(direction, inwards, 1.0 / index, &inside);
  deposit(light, direction, reflect(direction, inwards), share);
  share = 1.0 - share;
  for (int pass = 0; pass < PASSES_MAX && share > share_min; pass++) {
    const np_dvec3 normal = prism->normal[cross(prism, &place, inside)];
    np_dvec3 outside;
    const double reflected = refract(inside, normal, index, &outside);
    if (reflected < 1.0) deposit(light, direction, outside, share * (1.0 - reflected));
    inside = reflect(inside, normal);
    share *= reflected;
  }
}

/* ---- Sampling ---- */

typedef struct ice_task {
  ice_prism prism;
  double index;
  ice_light *chunks;
} ice_task;

static double get_fraction(double x) { return x - floor(x); }

/* Powers of 1/g, g⁵ = g + 1 (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences"). */
static const double kronecker[4] = {0.85667488385450290, 0.73389185662712600, 0.62870672103780860, 0.53859725722361000};

static void trace_sample(const ice_task *t, double n, ice_light *light) {
  double u[4];
  for (int k = 0; k < 4; k++) u[k] = get_fraction(0.5 + n * kronecker[k]);
  const double z = 1.0 - 2.0 * u[0], rim = sqrt(fmax(0.0, 1.0 - z * z)), turn = 2.0 * NP_PI * u[1];
  const np_dvec3 direction = np_dvec3_make(rim * cos(turn), rim * sin(turn), z);
  const np_dvec3 right = np_dvec3_make(-sin(turn), cos(turn), 0.0);
  const np_dvec3 up = np_dvec3_make(-z * cos(turn), -z * sin(turn), rim);
  const double r = t->prism.radius * sqrt(u[2]), around = 2.0 * NP_PI * u[3];
  np_dvec3 origin = np_dvec3_scale(direction, -2.0 * t->prism.radius);
  origin = move(move(origin, right, r * cos(around)), up, r * sin(around));
  trace(&t->prism, t->index, origin, direction, light);
}

static neph_result trace_chunks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const ice_task *t = user;
  for (size_t c = begin; c < end; c++)
    for (unsigned i = 0; i < RAYS_PER_CHUNK; i++) trace_sample(t, (double)(c * RAYS_PER_CHUNK + i + 1), &t->chunks[c]);
  return NEPH_OK;
}

/* Light of all rays of a prism, as shares of it. */
static neph_result trace_prism(neph_context *context, np_monitor *monitor, double length, double index,
                               ice_light *out) {
  ice_task task = {make_prism(length), index, np_alloc(context, CHUNKS, sizeof *task.chunks)};
  if (!task.chunks) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_parallel_for(context, monitor, CHUNKS, 1, trace_chunks, &task);
  double sum = 0.0;
  *out = (ice_light){.straight = 0.0};
  for (int c = 0; c < CHUNKS; c++) {
    out->straight += task.chunks[c].straight;
    for (int i = 0; i < BINS; i++) out->bin[i] += task.chunks[c].bin[i];
  }
  np_alloc_free(context, task.chunks);
  for (int i = 0; i < BINS; i++) sum += out->bin[i];
  sum += out->straight;
  out->straight /= sum;
  for (int i = 0; i < BINS; i++) out->bin[i] /= sum;
  return result;
}

/* ---- Smoothing ---- */

/* Standard deviation of the smoothing: halos have edges between 20 and 50°. */
static double get_width(double angle_rad) {
  const double degrees = angle_rad / NP_DEGREE;
  if (degrees < 4.0) return 0.5 * NP_DEGREE;
  if (degrees < 18.0) return 0.3 * NP_DEGREE;
  if (degrees < 50.0) return 0.1 * NP_DEGREE;
  return fmin(0.1 + 0.1 * (degrees - 50.0), 1.0) * NP_DEGREE;
}

/* Intensity at an angle: light over solid angle, both smoothed. */
static double smooth(const ice_light *light, double angle_rad) {
  const double width = get_width(angle_rad), bin_rad = NP_PI / BINS;
  const int low = (int)fmax(floor((angle_rad - 4.0 * width) / bin_rad), 0.0);
  const int high = (int)fmin(ceil((angle_rad + 4.0 * width) / bin_rad), BINS);
  double sum = 0.0, solid = 0.0;
  for (int i = low; i < high; i++) {
    const double place = ((i + 0.5) * bin_rad - angle_rad) / width, weight = exp(-0.5 * place * place);
    sum += weight * light->bin[i];
    solid += weight * 2.0 * NP_PI * (cos(i * bin_rad) - cos((i + 1) * bin_rad));
  }
  return sum / solid;
}

static neph_result add_prism(neph_context *context, np_monitor *monitor, double length, double index, double weight,
                             unsigned count, const double *angle_rad, double *values, double *straight) {
  ice_light *light = np_alloc(context, 1, sizeof *light);
  if (!light) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = trace_prism(context, monitor, length, index, light);
  for (unsigned i = 0; i < count && !result; i++) values[i] += weight * smooth(light, angle_rad[i]);
  *straight += weight * light->straight;
  np_alloc_free(context, light);
  return result;
}

neph_result np_ice_prism_trace(neph_context *context, np_monitor *monitor, neph_ice_habit habit, double index,
                               unsigned count, const double *angle_rad, double *out_values, double *out_straight) {
  static const double share[3][2] = {
      [NEPH_ICE_MIXED] = {0.5, 0.5}, [NEPH_ICE_COLUMN] = {1.0, 0.0}, [NEPH_ICE_PLATE] = {0.0, 1.0}};
  static const double length[2] = {column_length, plate_length};
  for (unsigned i = 0; i < count; i++) out_values[i] = 0.0;
  *out_straight = 0.0;
  neph_result result = NEPH_OK;
  for (int h = 0; h < 2 && !result; h++)
    if (share[habit][h] > 0.0)
      result =
          add_prism(context, monitor, length[h], index, share[habit][h], count, angle_rad, out_values, out_straight);
  return result;
}

neph_result np_ice_prism_compute_phase(neph_context *context, np_monitor *monitor, neph_ice_habit habit,
                                       double wavelength_m, double index, unsigned count, const double *angle_rad,
                                       double *out_values) {
  double *core = np_alloc(context, count, sizeof *core), straight = 0.0;
  if (!core) return NEPH_ERROR_OUT_OF_MEMORY;
  np_diffraction_fill(np_ice_core_radius_m, core_variance, wavelength_m, count, angle_rad, core);
  const bool is_known =
      habit == NEPH_ICE_MIXED && np_ice_table_read(wavelength_m, count, angle_rad, out_values, &straight);
  neph_result result = NEPH_OK;
  if (!is_known) result = np_ice_prism_trace(context, monitor, habit, index, count, angle_rad, out_values, &straight);
  for (unsigned i = 0; i < count; i++) out_values[i] = 0.5 * (out_values[i] + (1.0 + straight) * core[i]);
  np_alloc_free(context, core);
  return result;
}
