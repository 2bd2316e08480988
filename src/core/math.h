/* SPDX-License-Identifier: Apache-2.0 */
/* Vectors, frames, affine maps, and small functions of one number. World positions are double; directions and offsets
 * are float. */
#ifndef NP_CORE_MATH_H
#define NP_CORE_MATH_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "core/stable.h"

typedef struct np_vec3 {
  float x, y, z;
} np_vec3;

typedef struct np_dvec3 {
  double x, y, z;
} np_dvec3;

static inline np_vec3 np_vec3_make(float x, float y, float z) { return (np_vec3){x, y, z}; }
static inline np_vec3 np_vec3_add(np_vec3 a, np_vec3 b) { return np_vec3_make(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline np_vec3 np_vec3_subtract(np_vec3 a, np_vec3 b) { return np_vec3_make(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline np_vec3 np_vec3_scale(np_vec3 a, float s) { return np_vec3_make(a.x * s, a.y * s, a.z * s); }
static inline float np_vec3_dot(np_vec3 a, np_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline np_vec3 np_vec3_cross(np_vec3 a, np_vec3 b) {
  return np_vec3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline float np_vec3_length(np_vec3 a) { return sqrtf(np_vec3_dot(a, a)); }

/* 1 − cos of the angle between two unit vectors, exact where they nearly agree: ½|a − b|². */
static inline float np_vec3_versine(np_vec3 a, np_vec3 b) {
  const np_vec3 d = np_vec3_subtract(a, b);
  return 0.5f * np_vec3_dot(d, d);
}
static inline np_vec3 np_vec3_normalize(np_vec3 a) { return np_vec3_scale(a, 1.0f / np_vec3_length(a)); }
static inline bool np_vec3_is_equal(np_vec3 a, np_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static inline np_dvec3 np_dvec3_make(double x, double y, double z) { return (np_dvec3){x, y, z}; }
static inline np_dvec3 np_dvec3_add(np_dvec3 a, np_dvec3 b) { return np_dvec3_make(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline np_dvec3 np_dvec3_subtract(np_dvec3 a, np_dvec3 b) {
  return np_dvec3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

/* Minimum and maximum by components. */
static inline np_dvec3 np_dvec3_min(np_dvec3 a, np_dvec3 b) {
  return np_dvec3_make(fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z));
}

static inline np_dvec3 np_dvec3_max(np_dvec3 a, np_dvec3 b) {
  return np_dvec3_make(fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z));
}
static inline np_dvec3 np_dvec3_scale(np_dvec3 a, double s) { return np_dvec3_make(a.x * s, a.y * s, a.z * s); }
static inline double np_dvec3_dot(np_dvec3 a, np_dvec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline np_dvec3 np_dvec3_cross(np_dvec3 a, np_dvec3 b) {
  return np_dvec3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline double np_dvec3_length(np_dvec3 a) { return sqrt(np_dvec3_dot(a, a)); }
static inline np_dvec3 np_dvec3_normalize(np_dvec3 a) { return np_dvec3_scale(a, 1.0 / np_dvec3_length(a)); }
static inline bool np_dvec3_is_equal(np_dvec3 a, np_dvec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
static inline np_vec3 np_dvec3_to_float(np_dvec3 a) { return np_vec3_make((float)a.x, (float)a.y, (float)a.z); }
static inline np_dvec3 np_vec3_to_double(np_vec3 a) { return np_dvec3_make(a.x, a.y, a.z); }

/* origin + t·direction */
static inline np_dvec3 np_dvec3_along(np_dvec3 origin, np_vec3 direction, double t) {
  return np_dvec3_make(origin.x + t * (double)direction.x, origin.y + t * (double)direction.y,
                       origin.z + t * (double)direction.z);
}

/* Affine map: p ↦ M·p + translation, rows of 3 and a translation column. */
typedef struct np_affine {
  double m[3][4];
} np_affine;

static inline np_affine np_affine_identity(void) { return (np_affine){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}; }
static inline np_dvec3 np_affine_point(const np_affine *a, np_dvec3 p) {
  return np_dvec3_make(a->m[0][0] * p.x + a->m[0][1] * p.y + a->m[0][2] * p.z + a->m[0][3],
                       a->m[1][0] * p.x + a->m[1][1] * p.y + a->m[1][2] * p.z + a->m[1][3],
                       a->m[2][0] * p.x + a->m[2][1] * p.y + a->m[2][2] * p.z + a->m[2][3]);
}
static inline np_dvec3 np_affine_vector(const np_affine *a, np_dvec3 v) {
  return np_dvec3_make(a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z,
                       a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
                       a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z);
}
/* a∘b: first b, then a. */
static inline np_affine np_affine_compose(const np_affine *a, const np_affine *b) {
  np_affine c;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++)
      c.m[i][j] =
          a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j] + (j == 3 ? a->m[i][3] : 0);
  return c;
}
static inline double np_affine_determinant(const np_affine *a) {
  return a->m[0][0] * (a->m[1][1] * a->m[2][2] - a->m[1][2] * a->m[2][1]) -
         a->m[0][1] * (a->m[1][0] * a->m[2][2] - a->m[1][2] * a->m[2][0]) +
         a->m[0][2] * (a->m[1][0] * a->m[2][1] - a->m[1][1] * a->m[2][0]);
}
/* False when the map is singular or not finite; `out` is then untouched. */
static inline bool np_affine_invert(const np_affine *a, np_affine *out) {
  double d = np_affine_determinant(a);
  if (!(fabs(d) > 0) || !isfinite(d) || !isfinite(1 / d)) return false;
  np_affine r;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      r.m[i][j] = (a->m[j1][i1] * a->m[j2][i2] - a->m[j1][i2] * a->m[j2][i1]) / d;
    }
  for (int i = 0; i < 3; i++) r.m[i][3] = -(r.m[i][0] * a->m[0][3] + r.m[i][1] * a->m[1][3] + r.m[i][2] * a->m[2][3]);
  *out = r;
  return true;
}

/* Two unit vectors that complete `n` to a right-handed frame (Duff et al. 2017, "Building an Orthonormal Basis,
 * Revisited"): continuous but for the sign of n.z. */
static inline void np_frame_around(np_vec3 n, np_vec3 *out_tangent, np_vec3 *out_bitangent) {
  float sign = copysignf(1.0f, n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
  *out_tangent = np_vec3_make(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
  *out_bitangent = np_vec3_make(b, sign + n.y * n.y * a, -n.y);
}

/* Minimum and maximum in one instruction each, where fmaxf and fminf are calls. NaN becomes `b`, `low`. */
static inline float np_maxf(float a, float b) { return a > b ? a : b; }
static inline float np_minf(float a, float b) { return a < b ? a : b; }
static inline float np_clampf(float x, float low, float high) { return np_minf(np_maxf(x, low), high); }
static inline double np_clamp(double x, double low, double high) {
  x = x > low ? x : low;
  return x < high ? x : high;
}
/* ∛x within 0.15 %, for x ≥ 0, where the order of magnitude suffices, as for the size of a step: a third of the
 * exponent by bit operations, and one Newton step. */
static inline float np_cbrtf_rough(float x) {
  uint32_t bits;
  float y;
  memcpy(&bits, &x, sizeof bits);
  bits = bits / 3 + 0x2a5137a0u;
  memcpy(&y, &bits, sizeof y);
  return y * (2.0f / 3.0f) + x / (3.0f * y * y);
}
static inline float np_mixf(float a, float b, float t) { return a + t * (b - a); }
static inline float np_smoothstepf(float t) {
  t = np_clampf(t, 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

/* Height of a world point above the sphere of radius `radius` whose centre is (0, 0, −radius), without forming
 * length − radius (numerics: errs ≤ 2 mm in float where the naive form errs 0.64 m). */
static inline double np_altitude(np_dvec3 p, double radius) {
  double r2 = p.x * p.x + p.y * p.y + (p.z + radius) * (p.z + radius);
  return (p.x * p.x + p.y * p.y + p.z * p.z + 2.0 * radius * p.z) / (sqrt(r2) + radius);
}
/* Unit vector away from the planet's centre; the world's up at the centre itself. */
static inline np_dvec3 np_dvec3_zenith(np_dvec3 p, double radius) {
  const np_dvec3 from_centre = np_dvec3_make(p.x, p.y, p.z + radius);
  const double length = np_dvec3_length(from_centre);
  return length > 0.0 ? np_dvec3_scale(from_centre, 1.0 / length) : np_dvec3_make(0.0, 0.0, 1.0);
}
static inline np_vec3 np_zenith(np_dvec3 p, double radius) { return np_dvec3_to_float(np_dvec3_zenith(p, radius)); }

#endif
