/* SPDX-License-Identifier: Apache-2.0 */
/* Ice in the cold part of a cloud: its density, or that of each level of detail, split in two parts, droplets and
 * crystals, by altitude. */
#ifndef NP_VOLUME_VOLUME_ICE_H
#define NP_VOLUME_VOLUME_ICE_H

#include "volume/volume_tint.h"

/* Altitudes at which the standard atmosphere, 15 °C at sea level and 6.5 K colder each kilometre, has -15 °C and -38
 * °C. Below the first there are hardly any crystals; above the second droplets freeze by themselves (Pruppacher and
 * Klett 1997, ch. 7 and 9). Between them the share of ice rises linearly. */
#define NP_ICE_FROM_M 4615.0
#define NP_ICE_ALONE_M 8154.0

/* Share of ice in the extinction at an altitude. */
float np_ice_compute_share(double altitude_m);

/* Splits a density in metres of the world, its z the altitude; NULL if no voxel has ice. */
neph_result np_tint_create_ice(neph_context *context, const neph_volume *density, neph_precision precision,
                               np_monitor *monitor, np_tint **out_tint);

/* Splits each level of detail of a volume in metres of the world: crystals become further levels, whose number is
 * limited to NP_TINT_PARTS_MAX together with the others. */
neph_result np_volume_split_ice(neph_volume *volume, neph_precision precision, np_monitor *monitor);

#endif
