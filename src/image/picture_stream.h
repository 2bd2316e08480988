/* SPDX-License-Identifier: Apache-2.0 */
/* The program nephos_pictures, which decodes a picture that is its input, and the stream that it answers with: records
 * of this machine, one behind the other. Its words are one of these, the picture's name for messages, and the number of
 * threads:
 *
 *   exr, png     np_picture_head; each channel with its name; each attribute with its name and value; each channel's
 *                floats
 *   exr-header   the same without floats
 */
#ifndef NP_IMAGE_PICTURE_STREAM_H
#define NP_IMAGE_PICTURE_STREAM_H

#include <stdint.h>

#define NP_PICTURE_PROGRAM_FILE "nephos_pictures"
#define NP_PICTURE_STREAM_VERSION 1u

/* Limits of the program's memory and time: a constant, and shares of the file's size and of the claimed pixels. */
#define NP_PICTURE_ROOM_BYTES UINT64_C(256000000)
#define NP_PICTURE_ROOM_BYTES_PER_THREAD UINT64_C(160000000)
#define NP_PICTURE_TIME_S 10u
#define NP_PICTURE_TIME_BYTES_PER_S 2000000u

enum { NP_PICTURE_MESSAGE_BYTES = 8192 };

/* First record. If the picture could not be read, message_length characters of an error follow, and nothing else. */
typedef struct np_picture_start {
  uint32_t version, result, message_length;
} np_picture_start;

typedef struct np_picture_head {
  uint32_t width, height, channel_count, attribute_count;
  uint32_t has_camera, has_ndc, is_latlong, has_chromaticities, has_window; /* np_image_header; 0 or 1 */
  float world_to_camera[16], world_to_ndc[16], chromaticities[8];
  int32_t data_min[2], data_max[2], display_min[2], display_max[2];
  uint32_t storage, compression; /* np_image_exr_info; names are indices of np_picture_words */
  int32_t part_count;
  uint32_t tile_width, tile_height;
} np_picture_head;

typedef struct np_picture_channel {
  uint32_t stored; /* index in np_picture_words */
  uint32_t name_length;
} np_picture_channel;

typedef struct np_picture_attribute {
  uint32_t type, name_length;
  uint64_t value_length;
  double number;
} np_picture_attribute;

/* Words for kinds of samples, storage and compression. */
static const char *const np_picture_words[] = {
    "unknown", "half",   "float",   "uint",       "1-bit", "2-bit",           "4-bit",
    "8-bit",   "16-bit", "palette", "scan lines", "tiles", "deep scan lines", "deep tiles",
    "none",    "RLE",    "ZIPS",    "ZIP",        "PIZ",   "PXR24",           "B44",
    "B44A",    "DWAA",   "DWAB"};

enum { NP_PICTURE_WORDS = sizeof np_picture_words / sizeof *np_picture_words };

#endif
