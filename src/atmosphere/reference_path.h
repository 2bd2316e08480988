/* SPDX-License-Identifier: Apache-2.0 */
/* A ray through the air in double precision: optical depth, transmittance, and distance sampling.
 *
 * The ray is cut into panels at the perigee, at kinks of the density profile, and uniformly in the signed root w of the
 * distance from the perigee (t = perigee + w·|w|), in which the air varies slowly. Each panel's depth is a five-point
 * Gauss rule in w: transmittances are exact to 1e-8 without random numbers. */
#ifndef NP_ATMOSPHERE_REFERENCE_PATH_H
#define NP_ATMOSPHERE_REFERENCE_PATH_H

#include "atmosphere/optical_depth.h"

enum { NP_REFERENCE_BANDS = 3, NP_REFERENCE_PANELS_MAX = 192, NP_REFERENCE_POINTS = 5 };

/* Scattering at one altitude, 1/m; entries of `aerosol` beyond the medium's are not set. */
typedef struct np_reference_air {
  double rayleigh[NP_REFERENCE_BANDS], aerosol[NP_AEROSOLS_MAX][NP_REFERENCE_BANDS];
} np_reference_air;

void np_reference_air_at(const np_medium *medium, double altitude_m, np_reference_air *out_air);

/* Sums the extinction of all constituents, in given air and at an altitude. */
void np_reference_air_sum(const np_medium *medium, const np_reference_air *air,
                          double out_scattering[NP_REFERENCE_BANDS]);

/* Scattering by an angle, 1/(m·sr): the sum of coefficients times phase functions. */
void np_reference_air_eval(const np_medium *medium, const np_reference_air *air, double versine,
                           double out_scattering[NP_REFERENCE_BANDS]);

/* Rayleigh's phase function. */
static inline double np_reference_rayleigh(double versine) {
  return 3.0 / (16.0 * NP_PI) * (1.0 + (1.0 - versine) * (1.0 - versine));
}

/* Brightest direction of the sky from a point: the sun, or, below the horizon, the twilight arch above it. */
np_dvec3 np_reference_compute_bright_direction(np_dvec3 zenith, np_dvec3 to_sun);

/* Probability of sampling around the brightest direction instead of by the phase function; it grows as that direction
 * outshines the rest. */
double np_reference_bright_share(np_dvec3 zenith, np_dvec3 to_sun);

/* Asymmetry of the lobe around the brightest direction. */
#define NP_REFERENCE_BRIGHT_ASYMMETRY 0.75f

typedef struct np_reference_path {
  const np_medium *medium;
  np_ray ray;
  double perigee_m;
  int panel_count;
  double edge[NP_REFERENCE_PANELS_MAX + 1];                      /* edges of panels in w */
  double depth[NP_REFERENCE_PANELS_MAX + 1][NP_REFERENCE_BANDS]; /* optical depth from the ray's start to each edge */
  double cumulated[NP_REFERENCE_PANELS_MAX + 1];                 /* probability that a distance lies before each edge */
} np_reference_path;

/* Cuts a ray's part in the air into about `panels` panels. */
void np_reference_path_build(const np_medium *medium, const np_ray *ray, int panels, np_reference_path *out_path);

static inline double np_reference_path_distance(const np_reference_path *path, double w) {
  return np_clamp(path->perigee_m + w * fabs(w), 0.0, path->ray.length_m);
}

/* Transmittance from the ray's start to its end. */
void np_reference_path_transmit(const np_reference_path *path, double out_transmittance[NP_REFERENCE_BANDS]);

/* Transmittance from the ray's start to a point w in a panel. */
void np_reference_path_transmit_to(const np_reference_path *path, int panel, double w,
                                   double out_transmittance[NP_REFERENCE_BANDS]);

/* Transmittance to space from an altitude along a ray that does not hit the ground. */
void np_reference_transmit_to_space(const np_medium *medium, double altitude_m, double cosine,
                                    double out_transmittance[NP_REFERENCE_BANDS]);

/* Importance of sunlight along a ray. `depths` may be NULL: no guiding. */
typedef struct np_reference_guide {
  const np_depth_table *depths;
  double sun_cosine;   /* value at the entry into the air */
  double angle_cosine; /* cosine between ray and sun */
} np_reference_guide;

/* One number for each panel and band. */
typedef double np_reference_weights[NP_REFERENCE_BANDS];

/* Scattered and transmitted light of each panel, and the part of it from direct sunlight, evaluated at its middle.
 * Without the guide's depths both are equal. */
void np_reference_path_weigh(const np_reference_path *path, const np_reference_guide *guide,
                             np_reference_weights *out_scattered, np_reference_weights *out_lit);

static inline double np_reference_panel_length(const np_reference_path *path, int panel) {
  return np_reference_path_distance(path, path->edge[panel + 1]) - np_reference_path_distance(path, path->edge[panel]);
}

/* Prepares a path for np_reference_path_sample. Distances come from a mixture of three densities: scattered and
 * transmitted light, its part from direct sunlight, and uniform along the ray, so that every distance has a positive
 * density. */
void np_reference_path_prepare(np_reference_path *path, const np_reference_guide *guide);

typedef struct np_reference_sample {
  double t;
  double transmittance[NP_REFERENCE_BANDS];
  double inverse_pdf_m;
} np_reference_sample;

/* Distance for a number in [0, 1), monotonic in it. */
np_reference_sample np_reference_path_sample(const np_reference_path *path, double u);

#endif
