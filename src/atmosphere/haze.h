/* SPDX-License-Identifier: Apache-2.0 */
/* Hazes of the Earth by kind, and their amount by visual range. */
#ifndef NP_ATMOSPHERE_HAZE_H
#define NP_ATMOSPHERE_HAZE_H

#include <nephos/atmosphere.h>

typedef enum np_haze { NP_HAZE_PRESET, NP_HAZE_CLEAR, NP_HAZE_HAZY, NP_HAZE_MARITIME, NP_HAZE_DUSTY } np_haze;

/* The layer of a kind of haze other than NP_HAZE_PRESET, at the kind's own visual range over air of a scattering
 * coefficient at 550 nm. */
neph_atmosphere_layer np_haze_make(np_haze kind, double air_per_m);

/* Extinction coefficient of haze at 550 nm, 1/m, that leaves a visual range over air of a scattering coefficient
 * (Koschmieder: a contrast of 2 % remains). At most 0 where the air alone has no such range. */
double np_haze_compute_extinction(double visibility_m, double air_per_m);

/* Visual range of air without haze, m; infinite without air. */
double np_haze_compute_range(double air_per_m);

#endif
