/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "volume/model.h"

static const double sea_temperature_k = 288.15, sea_pressure_pa = 101325.0, lapse_k_m = 0.0065, tropopause_m = 11000.0;
static const double gas_constant_j_kg_k = 287.05287, gravity_m_s2 = 9.80665;

double np_standard_temperature(double altitude_m) {
  return sea_temperature_k - lapse_k_m * fmin(altitude_m, tropopause_m);
}

static double get_exponent(void) { return gravity_m_s2 / (gas_constant_j_kg_k * lapse_k_m); }

double np_standard_pressure(double altitude_m) {
  const double above_m = fmax(altitude_m - tropopause_m, 0.0), temperature = np_standard_temperature(altitude_m);
  return sea_pressure_pa * pow(temperature / sea_temperature_k, get_exponent()) *
         exp(-above_m * gravity_m_s2 / (gas_constant_j_kg_k * temperature));
}

double np_standard_altitude(double pressure_pa) {
  const double limit_pa = np_standard_pressure(tropopause_m), temperature = np_standard_temperature(tropopause_m);
  if (pressure_pa >= limit_pa)
    return sea_temperature_k / lapse_k_m * (1.0 - pow(pressure_pa / sea_pressure_pa, 1.0 / get_exponent()));
  return tropopause_m + gas_constant_j_kg_k * temperature / gravity_m_s2 * log(limit_pa / pressure_pa);
}

double np_air_density(double pressure_pa, double temperature_k) {
  return pressure_pa / (gas_constant_j_kg_k * temperature_k);
}
