/* SPDX-License-Identifier: Apache-2.0 */
/* The members of an image. */
#ifndef NP_IMAGE_IMAGE_PRIVATE_H
#define NP_IMAGE_IMAGE_PRIVATE_H

#include <nephos/image.h>

#include "core/parallel.h"

/* Limits of an image, created or claimed by a file. */
enum { NP_IMAGE_SIDE_MAX = 65536, NP_IMAGE_CHANNELS_MAX = 1024, NP_IMAGE_NAME_MAX = 255 };
#define NP_IMAGE_BYTES_MAX (UINT64_C(16) << 30) /* bytes of all channels in memory */

typedef struct np_image_channel {
  char *name;
  float *values;      /* width·height; NULL when only a header was read */
  const char *stored; /* "half", "float", "uint" in OpenEXR; "1-bit" to "16-bit", "palette" in PNG; NULL: not from a
                         file */
} np_image_channel;

typedef enum np_image_attribute_type { NP_IMAGE_TEXT, NP_IMAGE_INTEGER, NP_IMAGE_REAL } np_image_attribute_type;

typedef struct np_image_attribute {
  char *name, *value; /* value as text, also of numbers */
  np_image_attribute_type type;
  double number; /* value of integers and reals */
} np_image_attribute;

/* Typed header entries of a rendered picture; those with their flag set are written to EXR. */
typedef struct np_image_header {
  bool has_camera, has_ndc;                    /* whether the first matrix is given, and the second, for projections to
                                                  a plane */
  bool is_latlong;                             /* an equirectangular picture of the whole sphere */
  float world_to_camera[16], world_to_ndc[16]; /* row-vector convention of OpenEXR's standard attributes: p·M */
  bool has_chromaticities;
  float chromaticities[8];
  bool has_window; /* display window differs from the data window: crops and tiles */
  int data_min[2], data_max[2], display_min[2], display_max[2]; /* inclusive corners */
} np_image_header;

struct neph_image {
  neph_context *context;
  unsigned width, height; /* size of the data window */
  unsigned channel_count, attribute_count;
  np_image_channel *channels;
  np_image_attribute *attributes;
  np_image_header header;
  struct np_deep_pixel *deep; /* deep samples of each pixel; NULL: the image is flat */
};

/* Creates an image as neph_image_create does; without values it holds a header alone. */
neph_result np_image_create(neph_context *context, unsigned width, unsigned height, unsigned channel_count,
                            const char *const *channel_names, bool has_values, neph_image **out_image);

/* Load functions for calls from within the library; `monitor` may be NULL. */
neph_result np_image_load_exr(neph_context *context, const char *path, np_monitor *monitor, neph_image **out_image);
neph_result np_image_load_png(neph_context *context, const char *path, np_monitor *monitor, neph_image **out_image);

/* Encodes the bytes of the .png that neph_image_save_png writes; np_alloc_free frees them. */
neph_result np_image_encode_png(const neph_image *image, const neph_preview_desc *desc, void **out_bytes,
                                size_t *out_size);

const np_image_attribute *np_image_search_attribute(const neph_image *image, const char *name);

/* Set attributes to numbers, which OpenEXR files store as `int` and `float`. */
neph_result np_image_set_integer(neph_image *image, const char *name, int32_t value);
neph_result np_image_set_real(neph_image *image, const char *name, double value);

/* Whether half precision is insufficient for a channel, by the row of its AOV. */
bool np_image_is_float_channel(const char *name);

/* Channels of statistics and previews: R, G, B where all three exist, otherwise every channel. `out_indices` has room
 * for channel_count. */
unsigned np_image_choose_channels(const neph_image *image, unsigned *out_indices);

/* Coordinate of the first column (axis 0) or row of the data window. */
int np_image_get_data_min(const neph_image *image, int axis);

/* Pixel type for neph_image_save_exr: float where halves are insufficient, with a warning. Warns of NaN, and of
 * infinite colours. */
neph_pixel_type np_image_choose_pixel_type(const neph_image *image, const char *path, neph_pixel_type wanted);

/* Pixel type as by np_image_choose_pixel_type, without warnings. */
neph_pixel_type np_image_get_pixel_type(const neph_image *image, neph_pixel_type wanted);

/* Checks the claimed size of a file's picture before any allocation. */
neph_result np_image_check_claims(neph_context *context, const char *path, int64_t width, int64_t height,
                                  int channel_count);

/* Header of an OpenEXR file beyond the members of an image. */
typedef struct np_image_exr_info {
  const char *storage, *compression;
  int part_count;
  unsigned tile_width, tile_height; /* 0: scan lines */
} np_image_exr_info;

/* Reads the header of an .exr or .png: an image without values, whose channels have their kind of samples. */
neph_result np_image_read_header(neph_context *context, const char *path, neph_image **out_image);

/* Kind of samples of a .png, in the words of np_image_channel::stored; NULL: an invalid number of bits. */
const char *np_image_name_png_samples(unsigned bits, bool is_palette);

/* Reads width and height of an .exr or .png from its header. */
neph_result np_image_read_size(neph_context *context, const char *path, unsigned out_size[2]);

/* Reads the bits of a .png's samples, and whether its pixels are grey, from its header. */
neph_result np_image_read_png_kind(neph_context *context, const char *path, unsigned *out_bits, bool *out_is_grey);

/* Reads an OpenEXR header into an image without values. */
neph_result np_image_read_exr_header(neph_context *context, const char *path, np_image_exr_info *out_info,
                                     neph_image **out_image);

#endif
