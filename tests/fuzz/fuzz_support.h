/* SPDX-License-Identifier: Apache-2.0 */
/* Shared by the fuzz targets: a context whose messages are counted, a file to write inputs to, and the rule that any
 * input keeps: read, or refused for what it is with one message, of scenes with one for each error. */
#ifndef NP_FUZZ_SUPPORT_H
#define NP_FUZZ_SUPPORT_H

#include <stddef.h>
#include <stdint.h>

#include <nephos/volume.h>

/* A context of one thread, created by the first call and destroyed at the end of the program. */
neph_context *fuzz_get_context(void);

/* Writes an input to a file of this name, in a folder that goes away with the program, and returns its path. */
const char *fuzz_write_file(const char *name, const uint8_t *data, size_t size);

/* Aborts unless `result` is a valid result of a reader, with one error message (for a scene, one for each error), or
 * none for NEPH_OK. */
void fuzz_expect(neph_result result);

/* The same of a call that does much, and may say all that it finds wrong. */
void fuzz_expect_any(neph_result result);

/* Describes a volume's file, and loads it by a description from disk and from memory. */
void fuzz_read_volume(const char *name, const uint8_t *data, size_t size, const neph_volume_load_desc *desc);

/* libFuzzer's entry, which each target defines. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#endif
