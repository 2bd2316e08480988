/* SPDX-License-Identifier: Apache-2.0 */
/* Photometry of the moon.
 *
 * Magnitudes: the sun has −26.74, the full moon at mean distance −12.73 (Allen 1973, "Astrophysical Quantities"),
 * fainter by 0.026·|α| + 4·10⁻⁹·α⁴ at a phase angle α in degrees (Allen; Krisciunas and Schaefer 1991, "A Model of the
 * Brightness of Moonlight", PASP 103, equation 9). The surge within 7° of opposition, at most a third, is left out.
 * Colour: B − V is 0.92 for the moon and 0.65 for the sun (Allen), so that the moon reflects 1.28 times less at 440
 * than at 550 nm; the reddening is linear in wavelength.
 *
 * Over the disk: Lommel-Seeliger. Its integral over the sphere is 1 − sin(α/2)·tan(α/2)·ln cot(α/4), relative to full
 * moon (Hapke 1993, "Theory of Reflectance and Emittance Spectroscopy", chapter 10). Dividing by it and multiplying by
 * the measured phase curve makes the disk sum up to the magnitude.
 *
 * Earthshine: the Earth seen from the moon, a Lambert sphere of geometric albedo 0.37 (Allen) at the phase angle π − α,
 * lights a moon seen at full phase from there. */
#include "atmosphere/moon.h"

#include "core/units.h"

static const double mean_distance_m = 384400e3, moon_radius_m = 1737.4e3, earth_radius_m = 6371e3;
static const double astronomical_unit_m = 149597870700.0;
static const double magnitude_sun = -26.74, magnitude_full = -12.73, earth_albedo = 0.37;

/* The phase curve is measured up to this angle; a thinner crescent keeps its surface brightness. */
static const double crescent_rad = 170.0 * NP_DEGREE;

static double seeliger_integral(double phase) {
  if (phase < 1e-6) return 1.0;
  return 1.0 - sin(0.5 * phase) * tan(0.5 * phase) * log(1.0 / tan(0.25 * phase));
}

/* Magnitudes fainter than full, within the measured range. */
static double compute_dimming(double phase) {
  const double degrees = phase / NP_DEGREE;
  return 0.026 * degrees + 4e-9 * degrees * degrees * degrees * degrees;
}

/* Ratio of the measured phase curve to Lommel and Seeliger's, as a factor on the surface brightness. */
static double compute_surface_factor(double phase) {
  const double measured = fmin(phase, crescent_rad);
  return pow(10.0, -0.4 * compute_dimming(measured)) / seeliger_integral(measured);
}

/* Limits the phase: the integral loses its precision for a crescent below 0.01°. */
static double limit_phase(double phase) { return np_clamp(phase, 0.0, NP_PI - 2e-4); }

double np_moon_phase_factor(double phase_angle_rad) {
  const double phase = limit_phase(phase_angle_rad);
  return compute_surface_factor(phase) * fmax(seeliger_integral(phase), 0.0);
}

/* Full moon relative to the sun, at the moon's distance. */
static double compute_full_ratio(const np_moon_place *moon, double wavelength_nm) {
  const double reddening = 1.0 + 0.0020 * (np_clamp(wavelength_nm, 300.0, 1100.0) - 550.0);
  const double nearness = mean_distance_m / moon->distance_m;
  return pow(10.0, -0.4 * (magnitude_full - magnitude_sun)) * reddening * nearness * nearness;
}

double np_moon_irradiance_ratio(const np_moon_place *moon, double wavelength_nm) {
  return compute_full_ratio(moon, wavelength_nm) * np_moon_phase_factor(np_celestial_phase_angle(moon));
}

/* Earthlight on the moon relative to sunlight. */
static double compute_earthlight(double distance_m, double phase) {
  const double of_earth = NP_PI - phase, angle = earth_radius_m / distance_m;
  return earth_albedo * angle * angle * (sin(of_earth) + (NP_PI - of_earth) * cos(of_earth)) / NP_PI;
}

/* Divides the radiance by the map's mean over the shaded disk, which preserves the irradiance. */
static void normalize_map(np_disk *disk) {
  enum { SIDE = 128 };
  np_disk plain = *disk;
  plain.map = NULL;
  const float radius = sqrtf(disk->versine * (2.0f - disk->versine)), step = 2.0f / SIDE;
  np_vec3 right, up;
  np_frame_around(disk->direction, &right, &up);
  double mapped[NP_BAND_COUNT] = {0}, even[NP_BAND_COUNT] = {0};
  for (int i = 0; i < SIDE * SIDE; i++) {
    const float x = step * ((float)(i % SIDE) + 0.5f) - 1.0f, y = step * ((float)(i / SIDE) + 0.5f) - 1.0f;
    const np_vec3 offset = np_vec3_add(np_vec3_scale(right, x * radius), np_vec3_scale(up, y * radius));
    const np_vec3 direction = np_vec3_normalize(np_vec3_add(disk->direction, offset));
    const np_spectrum a = np_disk_radiance(disk, direction), b = np_disk_radiance(&plain, direction);
    for (int c = 0; c < NP_BAND_COUNT; c++) mapped[c] += (double)a.band[c], even[c] += (double)b.band[c];
  }
  for (int c = 0; c < NP_BAND_COUNT; c++) {
    const float factor = mapped[c] > 0.0 ? (float)(even[c] / mapped[c]) : 0.0f;
    disk->radiance.band[c] *= factor;
    disk->earthshine.band[c] *= factor;
  }
}

np_disk np_moon_make_disk(const np_moon_place *moon, np_spectrum sun_irradiance,
                          const double wavelength_nm[NP_BAND_COUNT], bool has_earthshine, const np_sphere_map *map,
                          np_spectrum *out_irradiance) {
  const double phase = limit_phase(np_celestial_phase_angle(moon)), surface = compute_surface_factor(phase);
  const double earthlight = has_earthshine ? compute_earthlight(moon->distance_m, phase) : 0.0;
  const double lit = fmax(seeliger_integral(phase), 0.0), sine = sin(moon->angular_radius_rad);
  np_spectrum full;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    full.band[b] = sun_irradiance.band[b] * (float)compute_full_ratio(moon, wavelength_nm[b]);
    out_irradiance->band[b] = full.band[b] * (float)(surface * lit + earthlight);
  }
  np_disk disk = np_disk_make(np_dvec3_to_float(moon->direction), moon->angular_radius_rad, full);
  disk.kind = NP_DISK_MOON;
  disk.earthshine = np_spectrum_scale(disk.radiance, (float)earthlight);
  disk.radiance = np_spectrum_scale(disk.radiance, (float)surface);
  disk.to_sun = np_dvec3_to_float(moon->to_sun);
  for (int i = 0; i < 3; i++) disk.axes[i] = np_dvec3_to_float(moon->axes[i]);
  disk.map = map;
  if (map && sine > 0.0) normalize_map(&disk);
  return disk;
}

np_moon_place np_moon_place_between(np_dvec3 direction, np_dvec3 to_sun) {
  const np_dvec3 sun = np_dvec3_scale(to_sun, astronomical_unit_m), moon = np_dvec3_scale(direction, mean_distance_m);
  const np_dvec3 toward = np_dvec3_scale(direction, -1.0);
  const np_dvec3 up = fabs(direction.z) < 0.999 ? np_dvec3_make(0, 0, 1) : np_dvec3_make(0, 1, 0);
  const np_dvec3 east = np_dvec3_normalize(np_dvec3_cross(up, toward));
  return (np_moon_place){.direction = direction,
                         .to_sun = np_dvec3_normalize(np_dvec3_subtract(sun, moon)),
                         .axes = {toward, east, np_dvec3_cross(toward, east)},
                         .distance_m = mean_distance_m,
                         .angular_radius_rad = asin(moon_radius_m / mean_distance_m)};
}
