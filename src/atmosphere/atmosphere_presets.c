/* SPDX-License-Identifier: Apache-2.0 */
/* Airs by name.
 *
 * The Earth: coefficients of Bruneton 2017 and Hillaire 2020, table 1.
 */
#include <nephos/atmosphere.h>

#include <math.h>

const neph_atmosphere_layer neph_earth_layers[NEPH_EARTH_LAYER_COUNT] = {
    {.profile = NEPH_LAYER_EXPONENTIAL,
     .top_m = (double)INFINITY,
     .height_m = 8000.0,
     .scattering_per_m = {5.802e-6, 13.558e-6, 33.1e-6},
     .phase = NEPH_LAYER_RAYLEIGH},
    {.profile = NEPH_LAYER_EXPONENTIAL,
     .top_m = (double)INFINITY,
     .height_m = 1200.0,
     .scattering_per_m = {3.996e-6, 3.996e-6, 3.996e-6},
     .absorption_per_m = {0.444e-6, 0.444e-6, 0.444e-6},
     .phase = NEPH_LAYER_CORNETTE_SHANKS,
     .asymmetry = {0.8, 0.8, 0.8}},
    {.profile = NEPH_LAYER_TENT,
     .top_m = (double)INFINITY,
     .center_m = 25000.0,
     .width_m = 15000.0,
     .absorption_per_m = {0.650e-6, 1.881e-6, 0.085e-6},
     .absorber = NEPH_LAYER_OZONE},
};
