/* SPDX-License-Identifier: Apache-2.0 */
/* A .vdb file open for reading, the `reader` of an np_volume_file. Inside the volume module and for benchmarks. */
#ifndef NP_VOLUME_VDB_FILE_H
#define NP_VOLUME_VDB_FILE_H

#include "volume/vdb_layout.h"

typedef struct np_vdb_reader {
  neph_context *context; /* borrowed */
  const np_vdb_module *module;
  np_vdb_layout *layout; /* layout through which `vdb` reads */
  np_vdb_file *vdb;
} np_vdb_reader;

#endif
