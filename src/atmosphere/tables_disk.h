/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of air and sky kept on disk, where the context keeps any. */
#ifndef NP_ATMOSPHERE_TABLES_DISK_H
#define NP_ATMOSPHERE_TABLES_DISK_H

#include "atmosphere/atmosphere_tables.h"

/* Optical depths and moments of an atmosphere that is described. False: there are none. */
bool np_atmosphere_load_tables(neph_atmosphere *atmosphere);
void np_atmosphere_save_tables(const neph_atmosphere *atmosphere);

/* Tables of a sky whose frame and light are set, and that has room for them. False: there are none. */
bool np_sky_load_tables(neph_sky *sky);
void np_sky_save_tables(neph_sky *sky);

#endif
