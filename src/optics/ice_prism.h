/* SPDX-License-Identifier: Apache-2.0 */
/* Scattering by hexagonal prisms of ice in all orientations: traced rays, and diffraction. */
#ifndef NP_OPTICS_ICE_PRISM_H
#define NP_OPTICS_ICE_PRISM_H

#include <nephos/phase.h>

#include "core/parallel.h"

/* Effective radius of the crystals' shadows, which diffract light into the core of the forward peak. */
static const double np_ice_core_radius_m = 25e-6;

/* Phase function of a habit, 1/sr, at ascending scattering angles. Rays are the same for every index, so that bands
 * share their noise, 1 to 3 % of the value. `monitor` may be NULL. */
neph_result np_ice_prism_compute_phase(neph_context *context, np_monitor *monitor, neph_ice_habit habit,
                                       double wavelength_m, double index, unsigned count, const double *angle_rad,
                                       double *out_values);

#endif
