/* SPDX-License-Identifier: Apache-2.0 */
/* The atmosphere and its sky.
 *
 * World: right-handed, z up, x east, y north, metres; origin at sea level; the planet's centre at (0, 0, −radius).
 */
#ifndef NEPHOS_ATMOSPHERE_H
#define NEPHOS_ATMOSPHERE_H

#include <nephos/context.h>
#include <nephos/phase.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A medium around a planet, with its optical depths and the moments of its scattered light; no light, no observer. */
typedef struct neph_atmosphere neph_atmosphere;

/** One atmosphere under one light, seen by one observer. */
typedef struct neph_sky neph_sky;

/** Density of a layer as a function of altitude. It has no unit: the layer's coefficients apply where it is 1. */
typedef enum neph_layer_profile {
  NEPH_LAYER_EXPONENTIAL, /**< exp(−(h − bottom_m)/height_m) */
  NEPH_LAYER_TENT,        /**< 1 − |h − center_m|/width_m, where that is positive */
  NEPH_LAYER_TABLE        /**< linear between rows, none below the first and above the last */
} neph_layer_profile;

/** Absorption of a layer between and beyond the three bands, where a picture has more wavelengths. */
typedef enum neph_layer_absorber {
  NEPH_LAYER_SMOOTH, /**< a power of the wavelength, fitted to the three bands, as is scattering */
  NEPH_LAYER_OZONE   /**< the shape of ozone's Chappuis bands, scaled to the three bands */
} neph_layer_absorber;

/** One constituent of the air: its altitudes, and its scattering and absorption in each band. */
typedef struct neph_atmosphere_layer {
  neph_layer_profile profile;
  double bottom_m, top_m;         /**< the density is 0 outside; bottom_m < top_m, which may be infinite */
  double height_m;                /**< scale height of an exponential; > 0 */
  double center_m, width_m;       /**< tent: altitude of the greatest density, and distance from there to density 0, >
                                       0 */
  const double *table_altitude_m; /**< table: altitudes, ascending */
  const double *table_density;    /**< table: densities, ≥ 0 */
  unsigned table_rows;            /**< table: number of rows, at least 2 */
  double scattering_per_m[3];     /**< coefficient at density 1; ≥ 0 */
  double absorption_per_m[3];     /**< coefficient at density 1; ≥ 0 */
  neph_phase phase;               /**< unused where scattering is 0 */
  double asymmetry[3];            /**< g of the first or only lobe in each band, −0.9999 to 0.9999; haze: mean
                                       cosine of its lobes, 0.5 to 0.95 */
  double second_asymmetry[3];     /**< g of the second lobe, −0.9999 to 0.9999 */
  double second_weight[3];        /**< share of the light that the second lobe scatters, 0 to 1 */
  neph_layer_absorber absorber;
} neph_atmosphere_layer;

enum { NEPH_EARTH_LAYER_COUNT = 3 };

/** The Earth's molecules, aerosol and ozone: the layers of NEPH_ATMOSPHERE_DESC_DEFAULT, to copy and change. */
NEPH_API extern const neph_atmosphere_layer neph_earth_layers[NEPH_EARTH_LAYER_COUNT];

/** A planet and its air, in three bands, by default 680, 550 and 440 nm. */
typedef struct neph_atmosphere_desc {
  size_t struct_size;
  double planet_radius_m;              /**< > 0 (default 6360 km) */
  double top_altitude_m;               /**< top of the atmosphere: layers are cut there; > 0 (default 100 km) */
  const neph_atmosphere_layer *layers; /**< any number; read while an atmosphere is created, not after (default
                                            neph_earth_layers) */
  unsigned layer_count;                /**< 0: no air (default 3) */
  double ground_albedo[3];             /**< Lambert, 0 to 1 (default 0.3 each) */
  double tolerance;                    /**< relative rms error that the tables may have, which sets their sizes; 0.003
                                            to 0.1 (default 0.007) */
} neph_atmosphere_desc;

#define NEPH_ATMOSPHERE_DESC_DEFAULT                                                                                   \
  {                                                                                                                    \
    .struct_size = sizeof(neph_atmosphere_desc), .planet_radius_m = 6360000.0, .top_altitude_m = 100000.0,             \
    .layers = neph_earth_layers, .layer_count = NEPH_EARTH_LAYER_COUNT, .ground_albedo = {0.3, 0.3, 0.3},              \
    .tolerance = 0.007                                                                                                 \
  }

/** Describes a planet and its air by name: "earth", the default; "earth-hazy", with twenty times its aerosol; "mars",
 * dusty.
 *
 * @param out_desc             starts from NEPH_ATMOSPHERE_DESC_DEFAULT; unchanged on failure. Its layers live as long
 *                             as the library.
 * @param out_sun_distance_au  the planet's distance from the sun: irradiance goes as its inverse square, angular radius
 *                             as its inverse. NULL is allowed.
 * @return NEPH_ERROR_INVALID_ARGUMENT for another name.
 */
NEPH_API neph_result neph_atmosphere_get_preset(neph_context *context, const char *name, neph_atmosphere_desc *out_desc,
                                                double *out_sun_distance_au) NEPH_NODISCARD;

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
    .sun_irradiance_w_m2_nm = {1.474, 1.8504, 1.91198}, .sun_angular_radius_rad = 0.00467396, .observer_m = {          \
      0,                                                                                                               \
      0,                                                                                                               \
      0                                                                                                                \
    }                                                                                                                  \
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
