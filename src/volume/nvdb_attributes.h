/* SPDX-License-Identifier: Apache-2.0 */
/* Names and texts that nephos writes into a grid of a .nvdb file, in place of OpenVDB's metadata: blind data called
 * NP_NVDB_ATTRIBUTES_NAME, each name and each text ended by a zero. Inside the volume module only. */
#ifndef NP_VOLUME_NVDB_ATTRIBUTES_H
#define NP_VOLUME_NVDB_ATTRIBUTES_H

#include "volume/nvdb_layout.h"
#include "volume/vdb_table.h"

typedef struct np_nvdb_attributes {
  char *text; /* owned; NULL: none */
  size_t size;
} np_nvdb_attributes;

/* Reads the attributes of a grid. The caller frees the text, after a failure too. */
neph_result np_nvdb_attributes_read(np_nvdb_layout *layout, size_t index, np_nvdb_attributes *out_attributes);

void np_nvdb_attributes_visit(const np_nvdb_attributes *attributes,
                              void (*visit)(void *user, const char *name, const char *text), void *user);

/* The text of a name; "": none. */
const char *np_nvdb_attributes_get(const np_nvdb_attributes *attributes, const char *name);

#endif
