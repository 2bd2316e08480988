/* SPDX-License-Identifier: Apache-2.0 */
/* A thin shell of uniform emission. Its radiance rises with obliquity (van Rhijn 1921): the radiance at the zenith
 * times the path through the shell over the shell's thickness.
 *
 * Colour: the dark moonless sky of La Palma at solar minimum has 22.0, 22.7, 21.9, 21.0 and 20.0 magnitudes per square
 * arc second in U, B, V, R and I (Benn and Ellison 1998, "Brightness of the Night Sky over La Palma", La Palma
 * Technical Note 115). The logarithm of radiance is interpolated between passbands; emission lines, mainly the green
 * one, are spread over their band. */
#include "atmosphere/airglow.h"

#include "atmosphere/magnitudes.h"
#include "core/units.h"

static const double magnitude_in_v = 21.9, layer_thickness_m = 10e3;

static double compute_radiance(double magnitude, double wavelength_nm) {
  static const double sky[NP_PASSBAND_COUNT] = {22.0, 22.7, 21.9, 21.0, 20.0};
  double logarithm[NP_PASSBAND_COUNT];
  for (int i = 0; i < NP_PASSBAND_COUNT; i++)
    logarithm[i] = log(np_magnitude_irradiance((np_passband)i, sky[i] + magnitude - magnitude_in_v));
  int i = 0;
  while (i + 2 < NP_PASSBAND_COUNT && wavelength_nm > np_passband_wavelength_nm[i + 1]) i++;
  const double low = np_passband_wavelength_nm[i], high = np_passband_wavelength_nm[i + 1];
  const double t = np_clamp((wavelength_nm - low) / (high - low), 0.0, 1.0);
  const double arc_second = NP_DEGREE / 3600.0;
  return exp(logarithm[i] + t * (logarithm[i + 1] - logarithm[i])) / (arc_second * arc_second);
}

np_airglow np_airglow_make(double magnitude, double planet_radius_m, double altitude_m,
                           const double wavelength_nm[NP_BAND_COUNT]) {
  np_airglow out = {
      .planet_radius_m = planet_radius_m, .altitude_m = altitude_m, .thickness_m = fmin(layer_thickness_m, altitude_m)};
  for (int b = 0; b < NP_BAND_COUNT; b++)
    out.zenith_radiance.band[b] = (float)compute_radiance(magnitude, wavelength_nm[b]);
  return out;
}

/* Length of a ray inside the sphere of an altitude; b = r·μ, h the altitude of its start. */
static double compute_chord(double radius_m, double h, double b, double altitude_m) {
  const double c = (h - altitude_m) * (2.0 * radius_m + h + altitude_m), discriminant = b * b - c;
  if (discriminant <= 0.0) return 0.0;
  const double root = sqrt(discriminant);
  return fmax(root - b, 0.0) - fmax(-root - b, 0.0);
}

np_spectrum np_airglow_radiance(const np_airglow *airglow, np_dvec3 position, np_vec3 direction) {
  const double radius = airglow->planet_radius_m, h = np_altitude(position, radius);
  const double b = (radius + h) * (double)np_vec3_dot(np_zenith(position, radius), direction);
  const double half = 0.5 * airglow->thickness_m;
  const double path =
      compute_chord(radius, h, b, airglow->altitude_m + half) - compute_chord(radius, h, b, airglow->altitude_m - half);
  return np_spectrum_scale(airglow->zenith_radiance, (float)(fmax(path, 0.0) / airglow->thickness_m));
}
