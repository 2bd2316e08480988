/* SPDX-License-Identifier: Apache-2.0 */
/* The structure of a .vdb file, checked before OpenVDB reads it. Inside the volume module only.
 *
 * OpenVDB 10 takes each length from the file as it stands: a wrong one writes past a buffer, takes gigabytes, or leaves
 * a half-built tree behind. So the file is walked first: header, metadata and transforms when it is opened, a tree
 * before it is read. Lengths must fit the file and what they are lengths of; nothing is decompressed but the values of
 * internal nodes, where OpenVDB forgets the tree under way if that fails. A file that passes may still hold any values.
 */
#ifndef NP_VOLUME_VDB_LAYOUT_H
#define NP_VOLUME_VDB_LAYOUT_H

#include "core/parallel.h"
#include "volume/vdb_table.h"

typedef struct np_vdb_layout np_vdb_layout;

/* Opens a file, and finds and checks the headers of its grids. `monitor` may be NULL; it must live as long as the
 * layout, and so must `path`. */
neph_result np_vdb_layout_open(neph_context *context, const char *path, const np_vdb_module *module,
                               np_monitor *monitor, np_vdb_layout **out_layout);
void np_vdb_layout_close(np_vdb_layout *layout); /* NULL is allowed */

/* The source that the module reads through; valid as long as the layout. */
const np_vdb_source *np_vdb_layout_get_source(const np_vdb_layout *layout);

/* Warns, once, of a format that is newer than what is known here. */
void np_vdb_layout_warn(np_vdb_layout *layout);

#endif
