/* SPDX-License-Identifier: Apache-2.0 */
/* Disk cache of the tables of atmospheres and skies, if the context has a cache. */
#ifndef NP_ATMOSPHERE_TABLES_DISK_H
#define NP_ATMOSPHERE_TABLES_DISK_H

#include "atmosphere/atmosphere_tables.h"

/* Loads optical depths and moments of an atmosphere whose description is set. False: not in the cache. */
bool np_atmosphere_load_tables(neph_atmosphere *atmosphere);
void np_atmosphere_save_tables(const neph_atmosphere *atmosphere);

/* Loads the tables of a sky whose frame and light are set and whose tables are allocated. False: not in the cache. */
bool np_sky_load_tables(neph_sky *sky);
void np_sky_save_tables(neph_sky *sky);

#endif
