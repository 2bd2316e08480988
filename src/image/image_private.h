/* SPDX-License-Identifier: Apache-2.0 */
/* The inside of an image. */
#ifndef NP_IMAGE_IMAGE_PRIVATE_H
#define NP_IMAGE_IMAGE_PRIVATE_H

#include <nephos/image.h>

#include "core/parallel.h"

/* Limits of an image, made or claimed by a file. */
enum { NP_IMAGE_SIDE_MAX = 65536, NP_IMAGE_CHANNELS_MAX = 1024, NP_IMAGE_NAME_MAX = 255 };
#define NP_IMAGE_BYTES_MAX (UINT64_C(16) << 30) /* of all channels in memory */

typedef struct np_image_channel {
  char *name;
  float *values;      /* width·height; NULL when only a header was read */
  const char *stored; /* "half", "float", "uint" of OpenEXR; "1-bit" to "16-bit", "palette" of PNG; NULL: of no file */
} np_image_channel;

typedef enum np_image_attribute_type { NP_IMAGE_TEXT, NP_IMAGE_INTEGER, NP_IMAGE_REAL } np_image_attribute_type;

typedef struct np_image_attribute {
  char *name, *value; /* numbers as text, too */
  np_image_attribute_type type;
  double number; /* of integers and reals */
} np_image_attribute;

/* Typed header entries of a rendered picture; written to EXR when their flag is set. */
typedef struct np_image_header {
  bool has_camera, has_ndc;                    /* the first matrix, and the second: of pictures in a plane */
  bool is_latlong;                             /* longitude and latitude of the whole sphere */
  float world_to_camera[16], world_to_ndc[16]; /* row-vector convention of OpenEXR's standard attributes: p·M */
  bool has_chromaticities;
  float chromaticities[8];
  bool has_window; /* display window differs from the data window: crops and tiles */
  int data_min[2], data_max[2], display_min[2], display_max[2]; /* inclusive */
} np_image_header;

struct neph_image {
  neph_context *context;
  unsigned width, height; /* of the data window */
  unsigned channel_count, attribute_count;
  np_image_channel *channels;
  np_image_attribute *attributes;
  np_image_header header;
  struct np_deep_pixel *deep; /* of each pixel; NULL: the image is flat */
};

/* As neph_image_create; without values only a header can be kept. */
neph_result np_image_create(neph_context *context, unsigned width, unsigned height, unsigned channel_count,
                            const char *const *channel_names, bool has_values, neph_image **out_image);

/* As neph_image_load_exr and neph_image_load_png, within a call; `monitor` may be NULL. */
neph_result np_image_load_exr(neph_context *context, const char *path, np_monitor *monitor, neph_image **out_image);
neph_result np_image_load_png(neph_context *context, const char *path, np_monitor *monitor, neph_image **out_image);

/* The bytes of the .png that neph_image_save_png writes, to be freed with np_alloc_free. */
neph_result np_image_encode_png(const neph_image *image, const neph_preview_desc *desc, void **out_bytes,
                                size_t *out_size);

const np_image_attribute *np_image_search_attribute(const neph_image *image, const char *name);

/* Numbers, which OpenEXR files keep as such: `int` and `float`. */
neph_result np_image_set_integer(neph_image *image, const char *name, int32_t value);
neph_result np_image_set_real(neph_image *image, const char *name, double value);

/* Whether half precision would not do: depth, distance, position and Cryptomatte. */
bool np_image_is_float_channel(const char *name);

/* The channels that statistics and previews look at: R, G, B where there are all three, else every one. `out_indices`
 * has room for channel_count. */
unsigned np_image_choose_channels(const neph_image *image, unsigned *out_indices);

/* Coordinate of the first column (axis 0) or row of the data window. */
int np_image_get_data_min(const neph_image *image, int axis);

/* The pixel type that neph_image_save_exr promises: float where halves would not do, with a warning. Warns of NaN, and
 * of infinite colours. */
neph_pixel_type np_image_choose_pixel_type(const neph_image *image, const char *path, neph_pixel_type wanted);

/* The same type, without a warning. */
neph_pixel_type np_image_get_pixel_type(const neph_image *image, neph_pixel_type wanted);

/* Whether a file may be believed that claims so large a picture, before anything is allocated for it. */
neph_result np_image_check_claims(neph_context *context, const char *path, int64_t width, int64_t height,
                                  int channel_count);

/* Header of an OpenEXR file beside what an image stores. */
typedef struct np_image_exr_info {
  const char *storage, *compression;
  int part_count;
  unsigned tile_width, tile_height; /* 0 for scan lines */
} np_image_exr_info;

/* Header of an .exr or .png: an image without values, whose channels say how they are stored. */
neph_result np_image_read_header(neph_context *context, const char *path, neph_image **out_image);

/* Samples of a .png, as np_image_channel has them; NULL: it cannot have so many bits. */
const char *np_image_name_png_samples(unsigned bits, bool is_palette);

/* Width and height of an .exr or .png, from its header. */
neph_result np_image_read_size(neph_context *context, const char *path, unsigned out_size[2]);

/* Bits of a sample of a .png, and whether its pixels are grey, from its header. */
neph_result np_image_read_png_kind(neph_context *context, const char *path, unsigned *out_bits, bool *out_is_grey);

/* Reads an OpenEXR header into an image without values. */
neph_result np_image_read_exr_header(neph_context *context, const char *path, np_image_exr_info *out_info,
                                     neph_image **out_image);

#endif
