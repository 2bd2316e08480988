/* SPDX-License-Identifier: Apache-2.0 */
/* Presets of the atmosphere.
 *
 * Earth: coefficients of Bruneton 2017 and Hillaire 2020, table 1, with the aerosol of the clearest days. It scatters
 * by three lobes of the mean cosine 0.8 in place of their one.
 *
 * Hazy Earth: twenty times that extinction at 550 nm, with a continental composition (Hess, Koepke and Schult 1998,
 * "Optical Properties of Aerosols and Clouds", table 4, continental average at 80 % humidity): single-scattering albedo
 * 0.925, asymmetry 0.70, extinction as λ^−1.3. The optical depth is 0.11, the visibility 38 km (Koschmieder).
 *
 * Mars: 610 Pa of carbon dioxide at 214 K, scattering 1.24e-30 m² a molecule at 532 nm (Sneep and Ubachs 2005, "Direct
 * Measurement of the Rayleigh Scattering Cross Section in Various Gases", table 2); dust of optical depth 0.5 with the
 * same scale height, effective radius 1.6 µm and variance 0.2 (Tomasko et al. 1999, "Properties of Dust in the Martian
 * Atmosphere from the Imager on Mars Pathfinder"). Its phase functions are two lobes fitted, by energy, to Mie theory
 * (Bohren and Huffman 1983, appendix A) for that size, a refractive index of 1.5, and single-scattering albedos of
 * 0.94, 0.86 and 0.73, red to blue. The diffraction lobe is three times as bright in blue as in red at the sun, and
 * fainter beyond 7°: the blue sunset. */
#include <math.h>
#include <nephos/atmosphere.h>
#include <string.h>

#include "core/context_private.h"
#include "core/given.h"

/* Properties shared by all atmospheres of the Earth. */
#define EARTH_MOLECULES                                                                                                \
  {                                                                                                                    \
    .profile = NEPH_LAYER_EXPONENTIAL, .top_m = (double)INFINITY, .height_m = 8000.0,                                  \
    .scattering_per_m = {5.802e-6, 13.558e-6, 33.1e-6}, .phase = NEPH_PHASE_RAYLEIGH                                   \
  }
#define EARTH_OZONE                                                                                                    \
  {                                                                                                                    \
    .profile = NEPH_LAYER_TENT, .top_m = (double)INFINITY, .center_m = 25000.0, .width_m = 15000.0,                    \
    .absorption_per_m = {0.650e-6, 1.881e-6, 0.085e-6}, .absorber = NEPH_LAYER_OZONE                                   \
  }

const neph_atmosphere_layer neph_earth_layers[NEPH_EARTH_LAYER_COUNT] = {
    EARTH_MOLECULES,
    {.profile = NEPH_LAYER_EXPONENTIAL,
     .top_m = (double)INFINITY,
     .height_m = 1200.0,
     .scattering_per_m = {3.996e-6, 3.996e-6, 3.996e-6},
     .absorption_per_m = {0.444e-6, 0.444e-6, 0.444e-6},
     .phase = NEPH_PHASE_HAZE,
     .asymmetry = {0.8, 0.8, 0.8}},
    EARTH_OZONE,
};

static const neph_atmosphere_layer hazy_layers[NEPH_EARTH_LAYER_COUNT] = {
    EARTH_MOLECULES,
    {.profile = NEPH_LAYER_EXPONENTIAL,
     .top_m = (double)INFINITY,
     .height_m = 1200.0,
     .scattering_per_m = {62.34e-6, 82.14e-6, 109.8e-6},
     .absorption_per_m = {5.05e-6, 6.66e-6, 8.90e-6},
     .phase = NEPH_PHASE_HENYEY_GREENSTEIN,
     .asymmetry = {0.7, 0.7, 0.7}},
    EARTH_OZONE,
};

static const neph_atmosphere_layer mars_layers[NEPH_EARTH_LAYER_COUNT] = {
    {.profile = NEPH_LAYER_EXPONENTIAL,
     .top_m = (double)INFINITY,
     .height_m = 11100.0,
     .scattering_per_m = {0.0949e-6, 0.2242e-6, 0.5535e-6},
     .phase = NEPH_PHASE_RAYLEIGH},
    {.profile = NEPH_LAYER_EXPONENTIAL,
     .top_m = (double)INFINITY,
     .height_m = 11100.0,
     .scattering_per_m = {43.47e-6, 38.74e-6, 32.09e-6},
     .absorption_per_m = {2.77e-6, 6.31e-6, 11.87e-6},
     .phase = NEPH_PHASE_TWO_LOBE,
     .asymmetry = {0.92, 0.93, 0.95},
     .second_asymmetry = {0.40, 0.42, 0.48},
     .second_weight = {0.40, 0.34, 0.27}},
    {.profile = NEPH_LAYER_TENT, .top_m = (double)INFINITY, .center_m = 25000.0, .width_m = 15000.0},
};

static const struct {
  const char *name;
  const neph_atmosphere_layer *layers;
  double planet_radius_m, sun_distance_au, ground_albedo[3];
} presets[] = {
    {"earth", neph_earth_layers, 6360e3, 1.0, {0.3, 0.3, 0.3}},
    {"earth-hazy", hazy_layers, 6360e3, 1.0, {0.3, 0.3, 0.3}},
    {"mars", mars_layers, 3389.5e3, 1.524, {0.28, 0.13, 0.07}},
};

neph_result neph_atmosphere_get_preset(neph_context *context, const char *name, neph_atmosphere_desc *out_desc,
                                       double *out_sun_distance_au) {
  if (NP_LACKS(context, name, out_desc)) return NEPH_ERROR_INVALID_ARGUMENT;
  for (size_t i = 0; i < sizeof presets / sizeof *presets; i++) {
    if (strcmp(presets[i].name, name) != 0) continue;
    neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
    desc.planet_radius_m = presets[i].planet_radius_m;
    desc.layers = presets[i].layers;
    memcpy(desc.ground_albedo, presets[i].ground_albedo, sizeof desc.ground_albedo);
    neph_result result = np_desc_write(context, "neph_atmosphere_desc", &desc, sizeof desc, out_desc);
    if (!result && out_sun_distance_au) *out_sun_distance_au = presets[i].sun_distance_au;
    return result;
  }
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                 "there is no atmosphere named %s, must be earth, earth-hazy or mars", name);
}
