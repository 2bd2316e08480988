/* SPDX-License-Identifier: Apache-2.0 */
/* Validation of the structure of a .vdb file before OpenVDB reads it. Inside the volume module only.
 *
 * OpenVDB 10 trusts each length in the file: a wrong one writes past a buffer, allocates gigabytes, or leaves a
 * half-built tree behind. So nephos walks the file first: header, metadata and transforms when it is opened, a tree
 * before it is read. Lengths must fit the file and their contents. Only the values of internal nodes are decompressed,
 * because OpenVDB leaks the current tree if that fails. A valid file may still hold any values. */
#ifndef NP_VOLUME_VDB_LAYOUT_H
#define NP_VOLUME_VDB_LAYOUT_H

#include "core/parallel.h"
#include "volume/vdb_bytes.h"
#include "volume/vdb_table.h"

typedef struct np_vdb_layout np_vdb_layout;

/* Parses and checks the headers of a file's grids. `monitor` may be NULL; it and `bytes` must outlive the layout. */
neph_result np_vdb_layout_open(np_vdb_bytes *bytes, const np_vdb_module *module, np_monitor *monitor,
                               np_vdb_layout **out_layout);
void np_vdb_layout_close(np_vdb_layout *layout); /* NULL is allowed */

/* The source from which the module reads; valid as long as the layout. */
const np_vdb_source *np_vdb_layout_get_source(const np_vdb_layout *layout);

/* Warns, once, that the file format is newer than the newest known one. */
void np_vdb_layout_warn(np_vdb_layout *layout);

#endif
