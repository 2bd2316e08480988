/* SPDX-License-Identifier: Apache-2.0 */
/* The surface of open water: a rough dielectric, and light that comes back out of the water.
 *
 * Waves are facets of Gaussian slopes, whose mean square grows with the wind (Cox and Munk 1954, "Measurement of the
 * roughness of the sea surface from photographs of the sun's glitter", their fit without direction):
 *
 *     s² = 0.003 + 0.00512·U,   U the wind in m/s
 *
 * which is Beckmann's distribution of roughness α = s. Reflection is the microfacet model of Walter, Marschner, Li and
 * Torrance 2007 with Fresnel's equations for n = 1.33 and Smith's height-correlated shadowing; light reflected twice is
 * left out. What is not reflected enters the water, `albedo` of it comes back out, evenly but for the surface:
 *
 *     f = F·D·G/(4·cosθi·cosθo) + albedo·T(θi)·T(θo)/(π·T̄),   T = 1 − R
 *
 * with R(θ) the share that the waves reflect and T̄ the mean of T under a uniform sky: energy is conserved. */
#ifndef NP_OPTICS_WATER_H
#define NP_OPTICS_WATER_H

#include "core/math.h"
#include "core/spectrum.h"

enum { NP_WATER_NODES = 33 };

/* Height of water above its level, so that land at the level, as the sea in SRTM, is below it. */
#define NP_WATER_LIFT_M 0.1

typedef struct np_water {
  double level_m;                    /* elevation above the planet's sphere */
  float roughness;                   /* α */
  np_spectrum albedo;                /* share of the light that entered the water and leaves it again */
  float reflectance[NP_WATER_NODES]; /* R, at even steps of √cosθ */
  float actinic[NP_WATER_NODES];     /* ½·R over the cosine of the reflected light, at the same cosines */
  float mean_transmittance;          /* T̄, mean of T over a uniform sky */
  float mean_actinic;                /* mean of `actinic` under a uniform sky */
} np_water;

np_water np_water_make(double level_m, double wind_m_s, np_spectrum albedo);

/* Reflectance of flat water for light at a cosine to its normal. */
float np_water_fresnel(float cosine);

/* R for light, or a view, at a cosine to the zenith. */
float np_water_reflectance(const np_water *water, float cosine);

/* Albedo under a sun at a cosine to the zenith and a uniform sky, weighted as in clear air: for functions that treat
 * water as Lambertian ground. */
np_spectrum np_water_get_albedo(const np_water *water, float sun_cosine);

/* Albedo of Lambertian ground that lights the air above it equally, in actinic flux: light at low angles stays long in
 * the air. */
np_spectrum np_water_get_air_albedo(const np_water *water, float sun_cosine);

/* Share of an even sky's irradiance that water reflects towards a viewer at a cosine to the zenith, times π. */
np_spectrum np_water_reflect_even(const np_water *water, float cosine);

/* Reflection between two unit directions, both away from the water. */
typedef struct np_water_value {
  np_spectrum scattered; /* BRDF times the cosine of the light, 1/sr */
  float reflected;       /* part of `scattered` that waves reflect, equal in all bands */
  float density;         /* density with which np_water_sample samples the light's direction, 1/sr */
} np_water_value;

np_water_value np_water_eval(const np_water *water, np_vec3 zenith, np_vec3 to_viewer, np_vec3 to_light);

/* `scattered` by the cosines of the viewer's and the light's direction to the zenith, and of the angle between them. */
np_spectrum np_water_reflect_beam(const np_water *water, float to_viewer, float to_light, float between);

/* Samples the direction of light that the waves reflect to the viewer, by visible facets (Heitz and d'Eon 2014, Jakob
 * 2014); `*out_weight` is BRDF times cosine over density, 0 where the direction leads below the surface. */
np_vec3 np_water_sample(const np_water *water, np_vec3 zenith, np_vec3 to_viewer, float u, float v, float *out_weight);

#endif
