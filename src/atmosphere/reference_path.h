/* SPDX-License-Identifier: Apache-2.0 */
/* A ray through the air in double precision: depth, transmittance, and a distance sampled along it.
 *
 * The ray is cut into panels, at the perigee, where the density profile has kinks, and evenly in the signed root w of
 * the distance from the perigee (t = perigee + w·|w|), in which the air varies slowly. Each panel's depth is a
 * five-point Gauss rule in w, so that transmittances are exact to 1e-8 and no random number is spent on them.
 */
#ifndef NP_ATMOSPHERE_REFERENCE_PATH_H
#define NP_ATMOSPHERE_REFERENCE_PATH_H

#include "atmosphere/optical_depth.h"

enum { NP_REFERENCE_BANDS = 3, NP_REFERENCE_PANELS_MAX = 192, NP_REFERENCE_POINTS = 5 };

/* Scattering at one altitude, 1/m; entries of `aerosol` beyond the medium's are not set. */
typedef struct np_reference_air {
  double rayleigh[NP_REFERENCE_BANDS], aerosol[NP_AEROSOLS_MAX][NP_REFERENCE_BANDS];
} np_reference_air;

void np_reference_air_at(const np_medium *medium, double altitude_m, np_reference_air *out_air);

/* Extinction of all constituents together, of the air at a place and at an altitude. */
void np_reference_air_sum(const np_medium *medium, const np_reference_air *air,
                          double out_scattering[NP_REFERENCE_BANDS]);

/* Scattering of the air by an angle, 1/(m·sr): the sum of coefficients times phase functions. */
void np_reference_air_eval(const np_medium *medium, const np_reference_air *air, double versine,
                           double out_scattering[NP_REFERENCE_BANDS]);

/* Rayleigh's phase function. */
static inline double np_reference_rayleigh(double versine) {
  return 3.0 / (16.0 * NP_PI) * (1.0 + (1.0 - versine) * (1.0 - versine));
}

/* Brightest direction of the sky from a point: the sun, or, below the horizon, the arch of twilight over it. */
np_dvec3 np_reference_compute_bright_direction(np_dvec3 zenith, np_dvec3 to_sun);

/* Best probability to sample about there instead of from the phase function: larger the more it outshines the
 * rest. */
double np_reference_bright_share(np_dvec3 zenith, np_dvec3 to_sun);

/* Asymmetry of the lobe about there. */
#define NP_REFERENCE_BRIGHT_ASYMMETRY 0.75f

typedef struct np_reference_path {
  const np_medium *medium;
  np_ray ray;
  double perigee_m;
  int panel_count;
  double edge[NP_REFERENCE_PANELS_MAX + 1];                      /* in w */
  double depth[NP_REFERENCE_PANELS_MAX + 1][NP_REFERENCE_BANDS]; /* from the ray's start to each edge */
  double cumulated[NP_REFERENCE_PANELS_MAX + 1];                 /* probability that a distance lies before each edge */
} np_reference_path;

/* Cuts a ray's part in the air, `ray.length_m` of it, into about `panels` panels. */
void np_reference_path_build(const np_medium *medium, const np_ray *ray, int panels, np_reference_path *out_path);

static inline double np_reference_path_distance(const np_reference_path *path, double w) {
  return np_clamp(path->perigee_m + w * fabs(w), 0.0, path->ray.length_m);
}

/* Transmittance from the ray's start to its end. */
void np_reference_path_transmit(const np_reference_path *path, double out_transmittance[NP_REFERENCE_BANDS]);

/* The same to a place w in a panel. */
void np_reference_path_transmit_to(const np_reference_path *path, int panel, double w,
                                   double out_transmittance[NP_REFERENCE_BANDS]);

/* Transmittance to space from an altitude along a ray that does not meet the ground. */
void np_reference_transmit_to_space(const np_medium *medium, double altitude_m, double cosine,
                                    double out_transmittance[NP_REFERENCE_BANDS]);

/* Guide to sunlight along a ray. `depths` may be NULL: none. */
typedef struct np_reference_guide {
  const np_depth_table *depths;
  double sun_cosine;   /* at the start of the ray's part in the air */
  double angle_cosine; /* between ray and sun */
} np_reference_guide;

/* A number for each panel and band. */
typedef double np_reference_weights[NP_REFERENCE_BANDS];

/* Light that each panel scatters and lets through, and of that what comes straight from the sun: air and transmittance
 * taken in its middle. Without a guide's depths the two are the same. */
void np_reference_path_weigh(const np_reference_path *path, const np_reference_guide *guide,
                             np_reference_weights *out_scattered, np_reference_weights *out_lit);

static inline double np_reference_panel_length(const np_reference_path *path, int panel) {
  return np_reference_path_distance(path, path->edge[panel + 1]) - np_reference_path_distance(path, path->edge[panel]);
}

/* Readies a path for np_reference_path_sample. Its distances are drawn from a mixture: after the light that is
 * scattered and seen, after what of it comes straight from the sun, and evenly along the ray, so that no part of it is
 * ever forgotten. */
void np_reference_path_prepare(np_reference_path *path, const np_reference_guide *guide);

typedef struct np_reference_sample {
  double t;
  double transmittance[NP_REFERENCE_BANDS];
  double inverse_pdf_m;
} np_reference_sample;

/* A distance for one number in [0, 1), monotonic in it. */
np_reference_sample np_reference_path_sample(const np_reference_path *path, double u);

#endif
