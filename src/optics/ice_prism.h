/* SPDX-License-Identifier: Apache-2.0 */
/* Scattering by hexagonal prisms of ice in all orientations: traced rays, and diffraction. */
#ifndef NP_OPTICS_ICE_PRISM_H
#define NP_OPTICS_ICE_PRISM_H

#include <nephos/phase.h>

#include "core/parallel.h"

/* Effective radius of the crystals' shadows, which diffract light into the core of the forward peak. */
static const double np_ice_core_radius_m = 25e-6;

/* Mean cosine of the mixed habit, to 0.003 at all wavelengths (test_phase_bands). */
static const float np_ice_asymmetry = 0.842f;

/* Light that a habit reflects and refracts, 1/sr at ascending scattering angles, and the share that goes straight on.
 * Their integral is one. `monitor` may be NULL. */
neph_result np_ice_prism_trace(neph_context *context, np_monitor *monitor, neph_ice_habit habit, double index,
                               unsigned count, const double *angle_rad, double *out_values, double *out_straight);

/* Phase function of a habit, 1/sr, at ascending scattering angles. Rays are the same for every index, so that bands
 * share their noise, 1 to 3 % of the value. Those of the mixed habit at the wavelengths of colour pictures are read
 * from a table (ice_table.h). `monitor` may be NULL. */
neph_result np_ice_prism_compute_phase(neph_context *context, np_monitor *monitor, neph_ice_habit habit,
                                       double wavelength_m, double index, unsigned count, const double *angle_rad,
                                       double *out_values);

#endif
