/* SPDX-License-Identifier: Apache-2.0 */
/* Fires beside clouds that repeat without end. Light of the sun is alike in all periods; that of a fire is not, and
 * must not come back with them. So it is solved for apart, in the same stretch (volume/instance_period.h), whose sides
 * it leaves for good, and beyond which it lights nothing.
 */
#ifndef NP_TRANSPORT_FIRES_APART_H
#define NP_TRANSPORT_FIRES_APART_H

#include "world/world.h"

/* The world without its fires, and with no other light than theirs: not that which the air returns to them either. */
np_world np_fires_leave_out(const np_world *world);
np_world np_fires_leave_alone(const np_world *world);

#endif
