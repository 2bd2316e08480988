/* SPDX-License-Identifier: Apache-2.0 */
/* Scattering by raindrops, spheres of a thousand wavelengths: rays with their rainbows, and diffraction. */
#ifndef NP_OPTICS_RAINDROP_H
#define NP_OPTICS_RAINDROP_H

#include "core/context_private.h"

/* Diffraction by disks of a gamma distribution of radii (np_mie_sizes), whose integral is one, 1/sr. */
void np_diffraction_fill(double effective_radius_m, double effective_variance, double wavelength_m, unsigned count,
                         const double *angle_rad, double *out_values);

/* Phase function of drops whose diameters have the mode `mode_diameter_m` in n(D) ∝ D³·e^{−3D/mode}, 1/sr, at ascending
 * scattering angles. */
neph_result np_raindrop_compute_phase(neph_context *context, double mode_diameter_m, double wavelength_m, double index,
                                      unsigned count, const double *angle_rad, double *out_values);

#endif
