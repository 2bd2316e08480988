/* SPDX-License-Identifier: Apache-2.0 */
/* Periods of clouds that repeat without end (volume/brick_periods.h), in the world. */
#ifndef NP_VOLUME_INSTANCE_PERIOD_H
#define NP_VOLUME_INSTANCE_PERIOD_H

#include "volume/instance.h"

/* The index axis that a world axis runs along alone; −1 when the volume is turned. */
int np_instance_get_index_axis(const np_instance *volume, int world_axis);

/* Period of the clouds along a world axis in metres, if all have the same; 0: none. */
double np_instances_compute_period(const np_instances *clouds, int world_axis);

#endif
