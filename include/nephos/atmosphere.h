/* SPDX-License-Identifier: Apache-2.0 */
/* The atmosphere and its sky.
 *
 * World: right-handed, z up, x east, y north, metres; origin at sea level; the planet's centre at (0, 0, −radius).
 */
#ifndef NEPHOS_ATMOSPHERE_H
#define NEPHOS_ATMOSPHERE_H

#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A medium around a planet, with its optical depths and the moments of its scattered light; no light, no observer. */
typedef struct neph_atmosphere neph_atmosphere;

/** One atmosphere under one light, seen by one observer. */
typedef struct neph_sky neph_sky;

/** Three bands, by default 680, 550 and 440 nm. */
typedef struct neph_atmosphere_desc {
  size_t struct_size;
  double planet_radius_m;              /**< > 0 (default 6360 km) */
  double top_altitude_m;               /**< of the atmosphere; > 0 (default 100 km) */
  double rayleigh_scattering_per_m[3]; /**< at sea level (default 5.802e-6, 13.558e-6, 33.1e-6) */
  double rayleigh_height_m;            /**< scale height; > 0 (default 8000) */
  double mie_scattering_per_m[3];      /**< at sea level (default 3.996e-6 each) */
  double mie_extinction_per_m[3];      /**< ≥ scattering (default 4.44e-6 each) */
  double mie_height_m;                 /**< scale height; > 0 (default 1200) */
  double mie_asymmetry;                /**< g of the Cornette-Shanks phase function, −0.9999 to 0.9999 (default 0.8) */
  double ozone_absorption_per_m[3];    /**< at the peak of the tent (default 0.650e-6, 1.881e-6, 0.085e-6) */
  double ozone_center_m;               /**< altitude of the peak (default 25 km) */
  double ozone_width_m;                /**< half width of the tent; > 0 (default 15 km) */
  double ground_albedo[3];             /**< Lambert, 0 to 1 (default 0.3 each) */
} neph_atmosphere_desc;

#define NEPH_ATMOSPHERE_DESC_DEFAULT                                                                                   \
  {                                                                                                                    \
    .struct_size = sizeof(neph_atmosphere_desc), .planet_radius_m = 6360000.0, .top_altitude_m = 100000.0,             \
    .rayleigh_scattering_per_m = {5.802e-6, 13.558e-6, 33.1e-6}, .rayleigh_height_m = 8000.0,                          \
    .mie_scattering_per_m = {3.996e-6, 3.996e-6, 3.996e-6}, .mie_extinction_per_m = {4.44e-6, 4.44e-6, 4.44e-6},       \
    .mie_height_m = 1200.0, .mie_asymmetry = 0.8, .ozone_absorption_per_m = {0.650e-6, 1.881e-6, 0.085e-6},            \
    .ozone_center_m = 25000.0, .ozone_width_m = 15000.0, .ground_albedo = {0.3, 0.3, 0.3}                              \
  }

/** Builds optical depths and scattering moments.
 *
 * @param desc            NULL for the defaults: the Earth.
 * @param out_atmosphere  one reference, for the caller; NULL on failure.
 */
NEPH_API neph_result neph_atmosphere_create(neph_context *context, const neph_atmosphere_desc *desc,
                                            neph_atmosphere **out_atmosphere) NEPH_NODISCARD;

/** Another reference to the same atmosphere. */
NEPH_API neph_atmosphere *neph_atmosphere_retain(neph_atmosphere *atmosphere);

/** Gives one reference back. NULL is allowed. */
NEPH_API void neph_atmosphere_release(neph_atmosphere *atmosphere);

typedef struct neph_sky_desc {
  size_t struct_size;
  double sun_direction[3];          /**< unit vector towards the sun (default 0, 0, 1) */
  double sun_irradiance_w_m2_nm[3]; /**< above the atmosphere, per band (default 1.474, 1.8504, 1.91198) */
  double sun_angular_radius_rad;    /**< ≥ 0 (default 0.00467396, that is 0.2678°) */
  double observer_m[3];             /**< world position (default 0, 0, 0) */
} neph_sky_desc;

#define NEPH_SKY_DESC_DEFAULT                                                                                          \
  {                                                                                                                    \
    .struct_size = sizeof(neph_sky_desc), .sun_direction = {0, 0, 1},                                                  \
    .sun_irradiance_w_m2_nm = {1.474, 1.8504, 1.91198}, .sun_angular_radius_rad = 0.00467396,                          \
    .observer_m = {0, 0, 0}                                                                                            \
  }

/** Builds the sky-view and aerial-perspective tables of one light and one observer. */
NEPH_API neph_result neph_sky_create(neph_atmosphere *atmosphere, const neph_sky_desc *desc,
                                     neph_sky **out_sky) NEPH_NODISCARD;

/** Ends a sky. NULL is allowed. */
NEPH_API void neph_sky_destroy(neph_sky *sky);

/** Radiance arriving at the observer along one ray, light's disk and ground excluded: in-scatter alone.
 *
 * @param direction                unit vector, away from the observer.
 * @param out_radiance_w_m2_sr_nm  per band.
 */
NEPH_API void neph_sky_get_radiance(const neph_sky *sky, const double direction[3], double out_radiance_w_m2_sr_nm[3]);

/** Transmittance and in-scatter between the observer and a point along a ray. */
NEPH_API void neph_sky_get_aerial_perspective(const neph_sky *sky, const double direction[3], double distance_m,
                                              double out_transmittance[3], double out_inscatter_w_m2_sr_nm[3]);

/** Irradiance on a horizontal surface at the observer: from the light's disk, and from the sky. */
NEPH_API void neph_sky_get_irradiance(const neph_sky *sky, double out_sun_w_m2_nm[3], double out_sky_w_m2_nm[3]);

/** Transmittance from a world point to space; 0 where the planet is in the way. */
NEPH_API void neph_atmosphere_get_transmittance(const neph_atmosphere *atmosphere, const double position_m[3],
                                                const double direction[3], double out_transmittance[3]);

#ifdef __cplusplus
}
#endif

#endif
