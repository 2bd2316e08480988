/* SPDX-License-Identifier: Apache-2.0 */
/* Free flight, transmittance and optical depth through clouds.
 *
 * The functions are inline, so that each kernel file compiles them for its own instruction set. Clouds may overlap:
 * optical depths add, transmittances multiply, and the shortest of independent free flights counts. Each cloud is
 * walked on its own, cell by cell of its bricks. The cells' ranges bound the interpolant, so that the acceptance
 * probability of a collision never exceeds 1. */
#ifndef NP_VOLUME_TRACKING_H
#define NP_VOLUME_TRACKING_H

#include "core/random.h"
#include "core/stable.h"
#include "volume/detail_voxel.h"
#include "volume/places.h"
#include "volume/voxel_walk.h"

static inline void np_track_start(np_brick_walk *walk, const np_instance *volume, np_dvec3 origin, np_vec3 direction,
                                  double distance_begin, double distance_end) {
  np_brick_walk_start(walk, volume->bricks, np_affine_point(&volume->world_to_index, origin),
                      np_affine_vector(&volume->world_to_index, np_vec3_to_double(direction)), distance_begin,
                      distance_end);
}

/* Voxels a metre along a ray. */
static inline float np_track_voxels_per_m(const np_instance *volume, np_vec3 direction) {
  return (float)np_dvec3_length(np_affine_vector(&volume->world_to_index, np_vec3_to_double(direction)));
}

/* Parts of a segment in a brick between the faces of its voxels, as shares of the segment. */
typedef struct np_track_faces {
  float next[3], stride[3]; /* share at the next face across each axis, and between two of them */
  float begin, end;         /* the part */
} np_track_faces;

static inline void np_track_faces_start(np_track_faces *faces, np_vec3 begin, np_vec3 along) {
  const float from[3] = {begin.x, begin.y, begin.z}, delta[3] = {along.x, along.y, along.z};
  for (int a = 0; a < 3; a++) {
    const float face = delta[a] > 0.0f ? floorf(from[a]) + 1.0f : ceilf(from[a]) - 1.0f;
    const bool is_level = fabsf(delta[a]) < 1e-6f;
    faces->next[a] = is_level ? INFINITY : (face - from[a]) / delta[a];
    faces->stride[a] = is_level ? 0.0f : 1.0f / fabsf(delta[a]);
  }
  faces->end = 0.0f;
}

/* Goes on to the next part; false at the end of the segment. */
static inline bool np_track_faces_next(np_track_faces *faces) {
  faces->begin = faces->end;
  while (faces->begin < 1.0f) {
    const float *next = faces->next;
    const int axis = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
    faces->end = np_minf(next[axis], 1.0f);
    faces->next[axis] += faces->stride[axis];
    if (faces->end > faces->begin) return true;
  }
  return false;
}

/* Exact mean of the value over a segment of a span, from the local position `begin` to begin + along. Between two faces
 * of the sample lattice the trilinear field is a cubic along the ray, which two Gauss points integrate exactly. */
static inline float np_track_mean_by(float (*sample)(const np_bricks *, uint32_t, np_vec3), const np_bricks *bricks,
                                     uint32_t brick, np_vec3 begin, np_vec3 along) {
  float sum = 0.0f;
  np_track_faces part;
  np_track_faces_start(&part, begin, along);
  while (np_track_faces_next(&part)) {
    const float length = part.end - part.begin, middle = 0.5f * (part.begin + part.end), offset = 0.28867513f * length;
    const float low = sample(bricks, brick, np_vec3_add(begin, np_vec3_scale(along, middle - offset)));
    const float high = sample(bricks, brick, np_vec3_add(begin, np_vec3_scale(along, middle + offset)));
    sum += 0.5f * length * (low + high);
  }
  return sum;
}

/* Value of the sample whose box, from i to i + 1, holds a position that is half a voxel too far along each axis. */
static inline float np_track_sample_box(const np_bricks *bricks, uint32_t brick, np_vec3 shifted) {
  return np_brick_sample(bricks, brick, np_vec3_make(floorf(shifted.x), floorf(shifted.y), floorf(shifted.z)));
}

/* Mean of the value over a segment in moving bricks, to the accuracy of the voxels; of nearest samples, exactly; or in
 * bricks with detail, by two points in each quarter of the detail's size. */
NP_BRICK_RARE static float np_track_mean_indirect(np_brick_ref ref, np_vec3 begin, np_vec3 along) {
  if (ref.bricks->motion) return np_track_mean_by(np_brick_sample_moving, ref.bricks, ref.brick, begin, along);
  if (ref.bricks->is_nearest)
    return np_track_mean_by(np_track_sample_box, ref.bricks, ref.brick,
                            np_vec3_add(begin, np_vec3_make(0.5f, 0.5f, 0.5f)), along);
  return np_brick_detail_mean(ref, begin, along);
}

static inline float np_track_mean(const np_bricks *bricks, uint32_t brick, const int32_t cell[3], np_vec3 begin,
                                  np_vec3 along) {
  if (bricks->is_indirect) return np_track_mean_indirect((np_brick_ref){bricks, brick, cell}, begin, along);
  return np_track_mean_by(np_brick_sample, bricks, brick, begin, along);
}

/* Upper estimate of the number of look-ups of np_track_mean(). */
static inline float np_track_mean_cost(np_vec3 along) {
  return 2.0f * (fabsf(along.x) + fabsf(along.y) + fabsf(along.z) + 1.0f);
}

/* Number of midpoint samples of a cell for an error of about the tolerance. `variation` is (maximum − minimum)·length
 * over the tolerance. The error of the rule falls with the square of the number of samples; far below the tolerance the
 * result is 0: no look-up. */
static inline int np_track_count_samples(float variation) {
  if (variation < 0.5f) return 0;
  return (int)np_minf(ceilf(0.6f * sqrtf(variation)), 4096.0f);
}

/* ∫ value ds over one span, in value·m, by the midpoint rule, or exactly if that takes fewer look-ups or the samples
 * are nearest ones. With no samples the cell's range gives the value. */
static inline float np_track_span_integral(const np_bricks *bricks, const np_brick_walk *walk,
                                           const np_brick_span *span, int count) {
  const float length = (float)(span->t_end - span->t_begin);
  if (count == 0 || span->brick == NP_BRICK_NONE) return 0.5f * (span->range.min + span->range.max) * length;
  const np_vec3 begin = np_brick_walk_local(walk, span, span->t_begin);
  const np_vec3 end = np_brick_walk_local(walk, span, span->t_end);
  const np_vec3 along = np_vec3_subtract(end, begin), step = np_vec3_scale(along, 1.0f / (float)count);
  if (bricks->is_nearest || (float)count > np_track_mean_cost(along))
    return length * np_track_mean(bricks, span->brick, span->cell, begin, along);
  float sum = 0.0f, value[NP_BRICK_LINE];
  for (int first = 0; first < count; first += NP_BRICK_LINE) {
    const int some = count - first < NP_BRICK_LINE ? count - first : NP_BRICK_LINE;
    const np_vec3 from = np_vec3_add(begin, np_vec3_scale(step, (float)first + 0.5f));
    np_brick_sample_line(bricks, span->brick, span->cell, from, step, some, value);
    for (int k = 0; k < some; k++) sum += value[k];
  }
  return sum * length / (float)count;
}

/* Look-ups per size of the detail, along a ray towards a light. */
static const float np_track_near_samples = 3.0f;

/* Optical depth, scaled by the fade, at which walks towards a light end. */
#define NP_TRACK_DEPTH_MAX 16.0f

/* Accuracy of an optical depth between a point and a light. */
typedef struct np_depth_query {
  float fade;  /* the light fades with e^{−fade·τ} */
  float error; /* tolerated error of the attenuated light, relative to the unattenuated light */
} np_depth_query;

/* Optical depth of one cloud along a ray whose light is already attenuated by the depth `faded`. Cells nearer to the
 * point are sampled more finely: light attenuated before a cell damps the error in it. */
static inline float np_track_volume_depth(const np_instance *volume, np_dvec3 origin, np_vec3 direction,
                                          double distance_end, const np_depth_query *query, float faded) {
  const float begin = faded;
  np_brick_walk walk;
  np_brick_span span;
  np_track_start(&walk, volume, origin, direction, 0.0, distance_end);
  while (faded < NP_TRACK_DEPTH_MAX && np_brick_walk_next(&walk, &span)) {
    const float length = (float)(span.t_end - span.t_begin), fading = query->fade * volume->extinction_per_value;
    const float variation = volume->extinction_per_value * (span.range.max - span.range.min) * length;
    const int count = np_track_count_samples(variation * np_transmittance(faded) / query->error);
    faded += fading * np_track_span_integral(volume->bricks, &walk, &span, count);
  }
  return (faded - begin) / query->fade;
}

/* Optical depth that detail adds near a point on the way to a light, when the depth without detail is known. It is
 * integrated over the range of self-shadowing; farther on the gains and losses cancel. */
NP_BRICK_RARE static float np_track_near_detail(const np_instance *volume, np_dvec3 origin, np_vec3 direction) {
  const np_brick_detail *detail = volume->bricks->detail;
  const float size = np_brick_detail_get_size(detail), per_m = np_track_voxels_per_m(volume, direction);
  const double spacing = (double)(size / (np_track_near_samples * per_m)), end = (double)((2.0f * size + 1.0f) / per_m);
  float sum = 0.0f;
  np_brick_walk walk;
  np_brick_span span;
  np_track_start(&walk, volume, origin, direction, 0.0, end);
  while (np_brick_walk_next(&walk, &span)) {
    const np_brick_ref ref = {volume->bricks, span.brick, span.cell};
    if (span.brick == NP_BRICK_NONE) continue;
    for (double k = ceil(span.t_begin / spacing - 0.5); (k + 0.5) * spacing < span.t_end; k++)
      sum += np_brick_detail_get_excess(ref, np_brick_walk_local(&walk, &span, (k + 0.5) * spacing), 0.0f);
  }
  return volume->extinction_per_value * sum * (float)spacing;
}

/* Optical depth of all clouds along a ray. */
static inline float np_track_depth(const np_instances *clouds, np_dvec3 origin, np_vec3 direction,
                                   const np_depth_query *query) {
  float depth = 0.0f;
  np_place_walk places;
  const np_instance *volume;
  np_place_walk_start(&places, clouds, origin, direction, INFINITY);
  while (query->fade * depth < NP_TRACK_DEPTH_MAX && (volume = np_place_walk_next(&places, INFINITY)))
    depth += np_track_volume_depth(volume, origin, direction, INFINITY, query, query->fade * depth);
  return depth;
}

/* Exponentially distributed optical depth with mean 1, from 53 random bits, of which 1 − u is exact: its tail reaches
 * 36. */
static inline double np_track_flight(np_random *random) { return -log(1.0 - np_random_double(random)); }

/* Exponentially distributed optical depth below `depth` (forced collision): exact even for a small `depth`. */
static inline double np_track_forced_flight(double depth, np_random *random) {
  return fmin(-log1p(np_random_double(random) * expm1(-depth)), depth);
}

/* A free flight on its way through clouds. It may leave out a share of the extinction to fly farther (exponential
 * transform); its weight compensates. */
typedef struct np_flight {
  double left;             /* optical depth to the next tentative collision */
  double stretch_fraction; /* share of the extinction left out, below 1; negative: extinction is added */
  double depth;            /* optical depth without an interaction so far */
  double
      weight; /* weight of collisions: extinction over the sampled extinction, times the probability of a forced one */
} np_flight;

/* A flight whose first tentative collision is at optical depth `depth`. */
static inline np_flight np_flight_start(double depth, double stretch_fraction) {
  return (np_flight){.left = depth, .stretch_fraction = stretch_fraction, .weight = 1.0};
}

/* A flight with a tentative collision before the bound (np_flight_bound), weighted by the probability of one. */
static inline np_flight np_flight_force(double bound, double stretch_fraction, np_random *random) {
  return (np_flight){
      .left = np_track_forced_flight(bound, random), .stretch_fraction = stretch_fraction, .weight = -expm1(-bound)};
}

/* Probability density of the flight over its sampling density. */
static inline float np_flight_weight(const np_flight *flight) { return (float)(flight->weight * exp(-flight->depth)); }

/* −ln of an unbiased estimate of the transmittance of a cell of moving bricks with detail, by ratio tracking beyond the
 * cell's minimum. */
NP_BRICK_RARE static double np_track_moving_excess(const np_instance *volume, const np_brick_walk *walk,
                                                   const np_brick_span *span, np_random *random) {
  const np_brick_ref ref = {volume->bricks, span->brick, span->cell};
  const double extinction = (double)volume->extinction_per_value, gap = (double)(span->range.max - span->range.min);
  double depth = 0.0;
  for (double t = span->t_begin + np_track_flight(random) / (extinction * gap); t < span->t_end;
       t += np_track_flight(random) / (extinction * gap)) {
    const float excess = np_brick_sample_indirect(ref, np_brick_walk_local(walk, span, t)) - span->range.min;
    depth -= log1p(-fmin((double)excess / gap, 1.0));
  }
  return depth;
}

/* Optical depth beyond which rays towards a light play Russian roulette, if no direction to the light is worth more
 * than another. Survivors represent the others. */
static const double np_track_faint_depth = 3.0;

/* Russian roulette on a ray at an optical depth. False if the ray ends; else its depth becomes the faint depth. */
static inline bool np_track_roulette(double *depth, double faint_depth, np_random *random) {
  const double beyond = *depth - faint_depth;
  if (beyond < 0.0) return true;
  *depth = faint_depth;
  return np_random_float(random) < np_transmittance((float)beyond);
}

/* −ln of an unbiased estimate of the transmittance of a cell with detail, by residual ratio tracking (Novák, Selle and
 * Jarosz 2014). The control is the value without detail, integrated exactly. Each voxel has its own bound: in most, of
 * full or empty cloud, it is 0. Beyond `depth_left` each voxel plays Russian roulette: infinite where the ray ends. */
NP_BRICK_RARE static double np_track_detail_excess(const np_instance *volume, const np_brick_walk *walk,
                                                   const np_brick_span *span, double depth_left, np_random *random) {
  const np_brick_ref ref = {volume->bricks, span->brick, span->cell};
  const np_vec3 begin = np_brick_walk_local(walk, span, span->t_begin);
  const np_vec3 along = np_vec3_subtract(np_brick_walk_local(walk, span, span->t_end), begin);
  const double extinction = (double)volume->extinction_per_value * (span->t_end - span->t_begin);
  double depth = 0.0, left = np_track_flight(random);
  np_track_faces part;
  np_track_faces_start(&part, begin, along);
  while (np_track_faces_next(&part)) {
    const float length = part.end - part.begin, middle = 0.5f * (part.begin + part.end), offset = 0.28867513f * length;
    const np_vec3 low = np_vec3_add(begin, np_vec3_scale(along, middle - offset));
    const np_vec3 high = np_vec3_add(begin, np_vec3_scale(along, middle + offset));
    const np_detail_voxel voxel =
        np_detail_voxel_load(ref.bricks, ref.brick, np_vec3_add(begin, np_vec3_scale(along, middle)));
    const float mean =
        0.5f * (np_detail_voxel_mix(ref.bricks, &voxel, low) + np_detail_voxel_mix(ref.bricks, &voxel, high));
    depth += extinction * (double)(length * (mean - span->range.min));
    const double bound = (double)np_detail_voxel_bound(ref.bricks, ref.brick, &voxel);
    double t = (double)part.begin;
    for (; left < extinction * bound * ((double)part.end - t); left = np_track_flight(random)) {
      t += left / (extinction * bound);
      const np_vec3 local = np_vec3_add(begin, np_vec3_scale(along, (float)t));
      depth -= log1p(-fmin((double)np_brick_detail_get_excess(ref, local, 0.0f) / bound, 1.0));
    }
    left -= extinction * bound * ((double)part.end - t);
    if (!np_track_roulette(&depth, depth_left, random)) return INFINITY;
  }
  return depth;
}

/* Optical depth of one cell beyond the depth of its minimum. Of clouds with detail, rays deeper than `depth_left` play
 * Russian roulette: it is infinite where they end. */
static inline double np_track_span_excess(const np_instance *volume, const np_brick_walk *walk,
                                          const np_brick_span *span, double depth_left, np_random *random) {
  if (span->brick == NP_BRICK_NONE) return 0.0;
  if (volume->bricks->detail)
    return volume->bricks->motion ? np_track_moving_excess(volume, walk, span, random)
                                  : np_track_detail_excess(volume, walk, span, depth_left, random);
  const np_vec3 begin = np_brick_walk_local(walk, span, span->t_begin);
  const np_vec3 end = np_brick_walk_local(walk, span, span->t_end);
  const float mean = np_track_mean(volume->bricks, span->brick, span->cell, begin, np_vec3_subtract(end, begin));
  return (double)(volume->extinction_per_value * (mean - span->range.min)) * (span->t_end - span->t_begin);
}

/* Unbiased transmittance along a ray. It is exact but for Russian roulette, which ends faint rays by the minimum of the
 * next cell before any look-up. Tracking takes about as long, with a hundred times the squared error or more
 * (tests/bench/bench_transmittance.c). */
static inline float np_track_transmittance(const np_instances *clouds, np_dvec3 origin, np_vec3 direction,
                                           double distance_end, double faint_depth, np_random *random) {
  double depth = 0.0;
  np_place_walk places;
  const np_instance *volume;
  np_place_walk_start(&places, clouds, origin, direction, distance_end);
  while ((volume = np_place_walk_next(&places, distance_end))) {
    np_brick_walk walk;
    np_brick_span span;
    np_track_start(&walk, volume, origin, direction, 0.0, distance_end);
    while (np_brick_walk_next(&walk, &span)) {
      depth += (double)(volume->extinction_per_value * span.range.min) * (span.t_end - span.t_begin);
      if (!np_track_roulette(&depth, faint_depth, random)) return 0.0f;
      depth += np_track_span_excess(volume, &walk, &span, faint_depth - depth, random);
    }
  }
  return np_transmittance((float)depth);
}

/* Extinction left out of a cell's values by a flight: its share of the middle of the cell's range, at most the minimum.
 */
static inline float np_flight_get_stretch(const np_flight *flight, const np_brick_span *span) {
  const float least = span->range.min, middle = 0.5f * (least + span->range.max);
  return np_clampf((float)flight->stretch_fraction * middle, -2.0f * least, 0.9f * least);
}

/* Optical depth along a ray of a flight's sampling extinction, the cells' maxima less the extinction left out;
 * integrated up to `depth_end`. */
static inline double np_flight_bound(const np_instances *clouds, np_dvec3 origin, np_vec3 direction,
                                     double distance_end, const np_flight *flight, double depth_end) {
  double depth = 0.0;
  np_place_walk places;
  const np_instance *volume;
  np_place_walk_start(&places, clouds, origin, direction, distance_end);
  while (depth < depth_end && (volume = np_place_walk_next(&places, distance_end))) {
    np_brick_walk walk;
    np_brick_span span;
    np_track_start(&walk, volume, origin, direction, 0.0, distance_end);
    while (depth < depth_end && np_brick_walk_next(&walk, &span)) {
      const float bound = span.range.max - np_flight_get_stretch(flight, &span);
      depth += (double)(volume->extinction_per_value * bound) * (span.t_end - span.t_begin);
    }
  }
  return depth;
}

/* Number of null collisions in a cell above which its optical depth is inverted instead. */
static const double np_track_null_max = 512.0;

/* Whether tracking a cell against its maximum may take that many null collisions: the cell is deep, and may be thin
 * along the ray. A cell with detail, or of nearest samples, has no cubic that could be inverted. */
static inline bool np_track_is_stiff(const np_bricks *bricks, const np_brick_span *span, double depth) {
  return depth > np_track_null_max && (double)span->range.max > np_track_null_max * (double)span->range.min &&
         np_bricks_are_smooth(bricks);
}

/* Distance of a flight's collision inside one cell, by inversion of the exact optical depth, voxel by voxel. The rest
 * of a flight is exponential from any point on. */
static inline double np_track_span_invert(const np_instance *volume, const np_brick_walk *walk,
                                          const np_brick_span *span, np_flight *flight, float stretch) {
  const double extinction = (double)volume->extinction_per_value, begin = span->t_begin;
  np_voxel_walk voxels;
  np_voxel_segment s;
  np_voxel_walk_start(&voxels, walk, span, span->t_begin, span->t_end);
  while (np_voxel_walk_next(&voxels, volume->bricks, span->brick, &s)) {
    const double depth = extinction * (np_voxel_segment_integral(&s, 1.0) - (double)stretch * s.length);
    if (flight->left < depth) {
      const double t = s.begin + s.length * np_voxel_segment_invert(&s, flight->left / extinction, (double)stretch);
      const float value = (float)np_voxel_segment_value(&s, (t - s.begin) / s.length);
      flight->left = 0.0;
      flight->depth += extinction * (double)stretch * (t - begin);
      if (stretch != 0.0f) flight->weight *= (double)(value / (value - stretch));
      return t;
    }
    flight->left -= fmax(depth, 0.0);
  }
  flight->depth += extinction * (double)stretch * (span->t_end - begin);
  return INFINITY;
}

/* Whether a tentative collision in bricks at rest with detail is real, by a threshold on the value. */
NP_BRICK_RARE static bool np_track_detail_is_hit(const np_bricks *bricks, const np_brick_walk *walk,
                                                 const np_brick_span *span, double t, float threshold) {
  if (span->brick == NP_BRICK_NONE) return threshold < span->range.min;
  const np_brick_ref ref = {bricks, span->brick, span->cell};
  return np_brick_detail_exceeds(ref, np_brick_walk_local(walk, span, t), threshold);
}

/* Distance of a free flight's collision inside one cell. It is infinite if the flight passes; then `flight->left`
 * decreases by the cell's bound. In the share of the minimum a tentative collision is real without a look-up, unless
 * extinction is left out. Null collisions have no weight, however loose the bound is. */
static inline double np_track_span_collision(const np_instance *volume, const np_brick_walk *walk,
                                             const np_brick_span *span, np_flight *flight, np_random *random) {
  const float stretch = np_flight_get_stretch(flight, span), bound = span->range.max - stretch;
  const double majorant = (double)(volume->extinction_per_value * bound);
  const double stretch_fraction = (double)(volume->extinction_per_value * stretch);
  double t = span->t_begin;
  if (np_track_is_stiff(volume->bricks, span, majorant * (span->t_end - t)))
    return np_track_span_invert(volume, walk, span, flight, stretch);
  while (flight->left < majorant * (span->t_end - t)) {
    const double step = flight->left / majorant;
    t += step;
    flight->depth += stretch_fraction * step;
    flight->left = np_track_flight(random);
    const float threshold = np_random_float(random) * bound + stretch;
    const bool is_sure = threshold < span->range.min;
    if (is_sure && stretch == 0.0f) return t;
    float value = span->range.min;
    if (volume->bricks->detail && !volume->bricks->motion && stretch == 0.0f) {
      if (np_track_detail_is_hit(volume->bricks, walk, span, t, threshold)) return t;
      continue;
    }
    if (span->brick != NP_BRICK_NONE)
      value = np_brick_eval(volume->bricks, span->brick, span->cell, np_brick_walk_local(walk, span, t));
    if (!is_sure && !(threshold < value)) continue;
    if (stretch != 0.0f) flight->weight *= (double)(value / (value - stretch));
    return t;
  }
  flight->left -= majorant * (span->t_end - t);
  flight->depth += stretch_fraction * (span->t_end - t);
  return INFINITY;
}

/* Distance to the next collision before `distance_end`, and its cloud; infinite if there is none.
 *
 * `flight` is counted in the cells' maxima, through one cloud after the other: the tentative collisions of all clouds
 * are one Poisson process on their rays laid end to end. The rest of a flight at the end of one cloud is valid for the
 * next. */
static inline double np_track_collision(const np_instances *clouds, np_dvec3 origin, np_vec3 direction,
                                        double distance_end, np_flight *flight, np_random *random,
                                        const np_instance **out_volume) {
  double nearest = INFINITY;
  np_place_walk places;
  const np_instance *volume;
  np_place_walk_start(&places, clouds, origin, direction, distance_end);
  while ((volume = np_place_walk_next(&places, nearest))) {
    np_brick_walk walk;
    np_brick_span span;
    np_track_start(&walk, volume, origin, direction, 0.0, fmin(distance_end, nearest));
    while (np_brick_walk_next(&walk, &span)) {
      const double t = np_track_span_collision(volume, &walk, &span, flight, random);
      if (t >= nearest || isinf(t)) continue;
      nearest = t;
      *out_volume = volume;
      break;
    }
  }
  return nearest;
}

#endif
