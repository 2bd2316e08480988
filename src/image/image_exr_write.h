/* SPDX-License-Identifier: Apache-2.0 */
/* Writing one part of an OpenEXR file: chunks are encoded on the context's threads and written in order. */
#ifndef NP_IMAGE_IMAGE_EXR_WRITE_H
#define NP_IMAGE_IMAGE_EXR_WRITE_H

#include <openexr_encode.h>

#include "image/image_exr.h"

typedef struct np_exr_writer np_exr_writer;

/* An encoded chunk, waiting to be written in its turn. */
typedef struct np_exr_chunk {
  void *bytes;
  size_t size;
  int32_t *counts; /* deep chunks: samples up to each pixel, in count_bytes bytes; NULL for flat chunks */
  size_t counts_size, unpacked_size;
} np_exr_chunk;

/* Functions that differ between flat and deep parts. */
typedef struct np_exr_format {
  exr_storage_t storage;
  exr_compression_t compression;
  exr_result_t (*add_channels)(exr_context_t exr, const neph_image *image, neph_pixel_type pixel_type);
  neph_result (*encode_chunk)(np_exr_writer *writer, int index); /* fills one of the writer's chunks */
  exr_result_t (*write_chunk)(np_exr_writer *writer, int line, const np_exr_chunk *chunk);
} np_exr_format;

struct np_exr_writer {
  np_exr_file file;
  const neph_image *image;
  const np_exr_format *format;
  neph_pixel_type pixel_type;
  np_exr_chunk *chunks;
  int chunk_count, lines_per_chunk;
};

/* Takes the compressed bytes from a pipeline, or, where compression gains nothing, its packed bytes. */
neph_result np_exr_copy_chunk(neph_context *context, const exr_encode_pipeline_t *pipeline, np_exr_chunk *out_chunk);

/* Writes an image atomically. */
neph_result np_exr_save(const neph_image *image, const char *path, neph_pixel_type pixel_type,
                        const np_exr_format *format);

#endif
