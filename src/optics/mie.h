/* SPDX-License-Identifier: Apache-2.0 */
/* Scattering by spheres: Lorenz-Mie theory (Bohren and Huffman 1983, "Absorption and Scattering of Light by Small
 * Particles", chapter 4), for one sphere and for a distribution of sizes. */
#ifndef NP_OPTICS_MIE_H
#define NP_OPTICS_MIE_H

#include "core/parallel.h"

/* Refractive index against the medium around; the imaginary part absorbs, and is not negative. */
typedef struct np_refractive_index {
  double real, imaginary;
} np_refractive_index;

/* Cross sections over that of the sphere's shadow; of a distribution, means by area. */
typedef struct np_mie_efficiency {
  double extinction, scattering;
  double asymmetry; /* mean cosine */
} np_mie_efficiency;

/* Efficiencies of a sphere of the size parameter x = 2πr/λ, 0.01 to 1e5. */
neph_result np_mie_compute_sphere(neph_context *context, double size_parameter, np_refractive_index index,
                                  np_mie_efficiency *out);

/* Gamma distribution of radii (Hansen and Travis 1974, "Light scattering in planetary atmospheres", eq. 2.56):
 * n(r) ∝ r^{(1−3b)/b}·e^{−r/(ab)} with the effective radius a and the effective variance b, 0 to 0.4. A variance
 * below 1e-6 is one size. */
typedef struct np_mie_sizes {
  double effective_radius_m, effective_variance;
} np_mie_sizes;

/* Phase function of unpolarised light, 1/sr, at `count` scattering angles. `monitor` may be NULL. */
neph_result np_mie_compute_phase(neph_context *context, np_monitor *monitor, const np_mie_sizes *sizes,
                                 double wavelength_m, np_refractive_index index, unsigned count,
                                 const double *angle_rad, double *out_values, np_mie_efficiency *out_mean);

#endif
