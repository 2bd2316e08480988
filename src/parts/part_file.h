/* SPDX-License-Identifier: Apache-2.0 */
/* Files of parts: "nephpart", version, header with its checksum, a byte for each tile, and the records of those tiles
 * that are there, each tile with its checksum. Numbers are of x86-64. */
#ifndef NP_PARTS_PART_FILE_H
#define NP_PARTS_PART_FILE_H

#include <stdatomic.h>

#include "parts/part_fault.h"
#include "parts/part_grid.h"

/* Writes a part, atomically. Only tiles of `done` are read from `records`; others may change under the call. */
neph_result np_part_file_write(neph_context *context, const char *path, const np_part_header *header,
                               const atomic_bool *done, const double *records);

typedef struct np_part_file np_part_file;

/* Opens a part and checks all but its records, each claim before memory is taken for it. False, with the fault, where
 * it is damaged, cut short, forged, of another version, or cannot be read. */
bool np_part_file_open(neph_context *context, const char *path, np_part_fault *fault, np_part_file **out_file);
void np_part_file_close(np_part_file *file); /* NULL is allowed */

const char *np_part_file_get_path(const np_part_file *file);
const np_part_header *np_part_file_get_header(const np_part_file *file);
bool np_part_file_has_tile(const np_part_file *file, size_t tile);
size_t np_part_file_count_tiles(const np_part_file *file); /* tiles that the file holds */

/* Reads the records of a finished tile; false, with the fault, where they are damaged or forged. */
bool np_part_file_read_tile(np_part_file *file, size_t tile, np_part_fault *fault, double *out_records);

#endif
