/* SPDX-License-Identifier: Apache-2.0 */
/* Shading of a light's disk.
 *
 * Sun: the functions that Neckel 2005 ("Analytical Reference Functions F(λ) for the Sun's Limb Darkening and Its
 * Absolute Continuum Intensities", Solar Physics 229, table I) fits to the measurements of Neckel and Labs 1994:
 * I(μ)/I(1) = Σ Aₖ(λ)·μᵏ, each Aₖ linear in 1/λ and 1/λ⁵. The mean over the disk is 2·∫I μ dμ = Σ 2Aₖ/(k + 2).
 *
 * Moon: the law of Lommel and Seeliger, μ₀/(μ₀ + μ). It is uniform at full moon, like the real moon and unlike a
 * Lambert sphere; moon.c has the factors. */
#include "atmosphere/disk.h"

#include "core/units.h"

/* Coefficients Aₖ: constant, factors of 1/λ and of 1/λ⁵, λ in µm. */
typedef struct limb_fit {
  double least_nm;
  double coefficient[NP_LIMB_TERMS][3];
} limb_fit;

/* Coefficients of limb darkening from a wavelength on. Between 373 and 385 nm, where there is no continuum, the
 * previous row is used. */
static const limb_fit fits[] = {
    {422.57,
     {{0.75267, -0.265577, 0.0},
      {0.93874, 0.265577, -0.004095},
      {-1.89287, 0.0, 0.012582},
      {2.42234, 0.0, -0.017117},
      {-1.71150, 0.0, 0.011977},
      {0.49062, 0.0, -0.003347}}},
    {385.0,
     {{0.09900, 0.010643, 0.0},
      {1.96884, -0.010643, -0.009166},
      {-2.80511, 0.0, 0.024873},
      {3.32780, 0.0, -0.029317},
      {-2.17878, 0.0, 0.018273},
      {0.58825, 0.0, -0.004663}}},
    {0.0,
     {{0.35601, -0.085217, 0.0},
      {1.11529, 0.085217, -0.001871},
      {-0.67237, 0.0, 0.003589},
      {0.18696, 0.0, -0.002415},
      {0.00038, 0.0, 0.000897},
      {0.01373, 0.0, -0.000200}}},
};

void np_limb_darkening(double wavelength_nm, double out_coefficient[NP_LIMB_TERMS]) {
  const limb_fit *fit = fits;
  while (wavelength_nm < fit->least_nm) fit++;
  const double x = 1000.0 / np_clamp(wavelength_nm, 300.0, 1100.0), x5 = x * x * x * x * x;
  for (int k = 0; k < NP_LIMB_TERMS; k++)
    out_coefficient[k] = fit->coefficient[k][0] + fit->coefficient[k][1] * x + fit->coefficient[k][2] * x5;
}

np_disk np_disk_make(np_vec3 direction, double angular_radius_rad, np_spectrum irradiance) {
  const double half = sin(0.5 * angular_radius_rad), sine = sin(angular_radius_rad);
  /* The projected solid angle is π sin²a. */
  const float factor = angular_radius_rad > 0.0 ? (float)(1.0 / (NP_PI * sine * sine)) : 0.0f;
  return (np_disk){.kind = NP_DISK_EVEN,
                   .direction = direction,
                   .versine = (float)(2.0 * half * half),
                   .radiance = np_spectrum_scale(irradiance, factor)};
}

np_disk np_disk_make_sun(np_vec3 direction, double angular_radius_rad, np_spectrum irradiance,
                         const double wavelength_nm[NP_BAND_COUNT]) {
  np_disk disk = np_disk_make(direction, angular_radius_rad, irradiance);
  disk.kind = NP_DISK_SUN;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    double coefficient[NP_LIMB_TERMS], mean = 0.0;
    np_limb_darkening(wavelength_nm[b], coefficient);
    for (int k = 0; k < NP_LIMB_TERMS; k++) mean += 2.0 * coefficient[k] / (k + 2);
    for (int k = 0; k < NP_LIMB_TERMS; k++) disk.limb[b][k] = (float)(coefficient[k] / mean);
  }
  return disk;
}

/* 1 − cos of the angle to the disk's centre: half the squared chord, without cancellation. */
static float compute_versine(const np_disk *disk, np_vec3 direction) {
  const np_vec3 offset = np_vec3_subtract(direction, disk->direction);
  return 0.5f * np_vec3_dot(offset, offset);
}

bool np_disk_covers(const np_disk *disk, np_vec3 direction) {
  return disk->versine > 0.0f && compute_versine(disk, direction) <= disk->versine;
}

static np_spectrum shade_sun(const np_disk *disk, float cosine) {
  np_spectrum out;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    float sum = 0.0f;
    for (int k = NP_LIMB_TERMS - 1; k >= 0; k--) sum = sum * cosine + disk->limb[b][k];
    out.band[b] = disk->radiance.band[b] * np_maxf(sum, 0.0f);
  }
  return out;
}

static np_spectrum shade_moon(const np_disk *disk, np_vec3 direction, float cosine, float radius_sine) {
  const np_vec3 offset = np_vec3_subtract(direction, disk->direction), centre = disk->direction;
  const np_vec3 across = np_vec3_subtract(offset, np_vec3_scale(centre, np_vec3_dot(offset, centre)));
  const np_vec3 normal = np_vec3_subtract(np_vec3_scale(across, 1.0f / radius_sine), np_vec3_scale(centre, cosine));
  const float sunward = np_maxf(np_vec3_dot(normal, disk->to_sun), 0.0f);
  np_spectrum out = disk->earthshine;
  if (sunward > 0.0f) out = np_spectrum_add_scaled(out, 2.0f * sunward / (sunward + cosine), disk->radiance);
  if (!disk->map) return out;
  const float x = np_vec3_dot(normal, disk->axes[0]), y = np_vec3_dot(normal, disk->axes[1]);
  return np_spectrum_multiply(out, np_sphere_map_lookup(disk->map, x, y, np_vec3_dot(normal, disk->axes[2])));
}

np_spectrum np_disk_radiance(const np_disk *disk, np_vec3 direction) {
  const float versine = compute_versine(disk, direction), edge = disk->versine;
  if (edge <= 0.0f || versine > edge) return np_spectrum_grey(0.0f);
  if (disk->kind == NP_DISK_EVEN) return disk->radiance;
  /* A ray at this angle hits the sphere with sine sin θ/sin a between ray and normal. */
  const float x2 = versine * (2.0f - versine) / (edge * (2.0f - edge)), cosine = sqrtf(np_maxf(1.0f - x2, 0.0f));
  if (disk->kind == NP_DISK_SUN) return shade_sun(disk, cosine);
  return shade_moon(disk, direction, cosine, sqrtf(edge * (2.0f - edge)));
}
