/* SPDX-License-Identifier: Apache-2.0 */
#include "image/deep.h"
#include "image/image_private.h"

#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "image/aov.h"

/* ---- Creation and destruction ---- */

static neph_result check_size(neph_context *context, unsigned width, unsigned height, unsigned channel_count) {
  if (width < 1 || width > NP_IMAGE_SIDE_MAX || height < 1 || height > NP_IMAGE_SIDE_MAX)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "image is %u × %u pixels, must be 1 to %d each way", width,
                   height, NP_IMAGE_SIDE_MAX);
  if (channel_count < 1 || channel_count > NP_IMAGE_CHANNELS_MAX)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "image has %u channels, must have 1 to %d", channel_count,
                   NP_IMAGE_CHANNELS_MAX);
  if ((uint64_t)width * height * channel_count * sizeof(float) > NP_IMAGE_BYTES_MAX)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "image of %u × %u pixels and %u channels is larger than the %d GiB allowed", width, height,
                   channel_count, (int)(NP_IMAGE_BYTES_MAX >> 30));
  return NEPH_OK;
}

static neph_result check_channel_names(neph_context *context, unsigned channel_count, const char *const *names) {
  for (unsigned i = 0; i < channel_count; i++) {
    if (!names[i] || !*names[i] || strlen(names[i]) > NP_IMAGE_NAME_MAX)
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "channel name %u must have 1 to %d bytes", i,
                     NP_IMAGE_NAME_MAX);
    for (unsigned j = 0; j < i; j++)
      if (!strcmp(names[i], names[j]))
        return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "channel \"%s\" is named twice", names[i]);
  }
  return NEPH_OK;
}

static neph_result add_channel(neph_image *image, const char *name, bool has_values) {
  np_image_channel *channel = &image->channels[image->channel_count++];
  channel->name = np_alloc_text(image->context, name);
  if (!channel->name) return NEPH_ERROR_OUT_OF_MEMORY;
  if (!has_values) return NEPH_OK;
  channel->values = np_alloc(image->context, (size_t)image->width * image->height, sizeof *channel->values);
  return channel->values ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

neph_result np_image_create(neph_context *context, unsigned width, unsigned height, unsigned channel_count,
                            const char *const *channel_names, bool has_values, neph_image **out_image) {
  *out_image = NULL;
  neph_result result = check_size(context, width, height, channel_count);
  if (!result) result = check_channel_names(context, channel_count, channel_names);
  if (result) return result;

  neph_image *image = np_alloc(context, 1, sizeof *image);
  if (!image) return NEPH_ERROR_OUT_OF_MEMORY;
  np_context_retain(context);
  image->context = context;
  image->width = width;
  image->height = height;
  image->channels = np_alloc(context, channel_count, sizeof *image->channels);
  if (!image->channels) result = NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; !result && i < channel_count; i++) result = add_channel(image, channel_names[i], has_values);
  if (result) {
    neph_image_destroy(image);
    return result;
  }
  *out_image = image;
  return NEPH_OK;
}

neph_result neph_image_create(neph_context *context, unsigned width, unsigned height, unsigned channel_count,
                              const char *const *channel_names, neph_image **out_image) {
  if (NP_LACKS_OUT(context, out_image, channel_names)) return NEPH_ERROR_INVALID_ARGUMENT;
  return np_image_create(context, width, height, channel_count, channel_names, true, out_image);
}

void neph_image_destroy(neph_image *image) {
  if (!image) return;
  neph_context *context = image->context;
  for (unsigned i = 0; i < image->channel_count; i++) {
    np_alloc_free(context, image->channels[i].name);
    np_alloc_free(context, image->channels[i].values);
  }
  for (unsigned i = 0; i < image->attribute_count; i++) {
    np_alloc_free(context, image->attributes[i].name);
    np_alloc_free(context, image->attributes[i].value);
  }
  np_image_clear_deep(image);
  np_alloc_free(context, image->channels);
  np_alloc_free(context, image->attributes);
  np_alloc_free(context, image);
  np_context_release(context);
}

/* ---- Size and channels ---- */

unsigned neph_image_get_width(const neph_image *image) { return image ? image->width : 0; }

unsigned neph_image_get_height(const neph_image *image) { return image ? image->height : 0; }

unsigned neph_image_get_channel_count(const neph_image *image) { return image ? image->channel_count : 0; }

const char *neph_image_get_channel_name(const neph_image *image, unsigned index) {
  return image && index < image->channel_count ? image->channels[index].name : NULL;
}

/* Index of a channel; channel_count when there is none of that name. */
static unsigned search_index(const neph_image *image, const char *name) {
  unsigned i = 0;
  while (i < image->channel_count && strcmp(image->channels[i].name, name)) i++;
  return i;
}

float *neph_image_get_channel(neph_image *image, const char *name) {
  if (!image || !name) return NULL;
  unsigned i = search_index(image, name);
  return i < image->channel_count ? image->channels[i].values : NULL;
}

const float *neph_image_get_values(const neph_image *image, const char *name) {
  if (!image || !name) return NULL;
  unsigned i = search_index(image, name);
  return i < image->channel_count ? image->channels[i].values : NULL;
}

static bool is_colour(const char *name) { return !strcmp(name, "R") || !strcmp(name, "G") || !strcmp(name, "B"); }

unsigned np_image_choose_channels(const neph_image *image, unsigned *out_indices) {
  bool has_colour =
      neph_image_get_values(image, "R") && neph_image_get_values(image, "G") && neph_image_get_values(image, "B");
  unsigned count = 0;
  for (unsigned i = 0; i < image->channel_count; i++)
    if (!has_colour || is_colour(image->channels[i].name)) out_indices[count++] = i;
  return count;
}

bool np_image_is_float_channel(const char *name) {
  const np_aov_row *aov = np_aov_search_channel(name);
  return aov && aov->pixel_type == NEPH_PIXEL_FLOAT;
}

int np_image_get_data_min(const neph_image *image, int axis) {
  return image->header.has_window ? image->header.data_min[axis] : 0;
}

/* ---- Attributes ---- */

const np_image_attribute *np_image_search_attribute(const neph_image *image, const char *name) {
  for (unsigned i = 0; i < image->attribute_count; i++)
    if (!strcmp(image->attributes[i].name, name)) return &image->attributes[i];
  return NULL;
}

const char *neph_image_get_attribute(const neph_image *image, const char *name) {
  const np_image_attribute *attribute = image && name ? np_image_search_attribute(image, name) : NULL;
  return attribute ? attribute->value : NULL;
}

/* Appends an attribute without a value; NULL when there is no memory. */
static np_image_attribute *add_attribute(neph_image *image, const char *name) {
  size_t count = (size_t)image->attribute_count + 1;
  np_image_attribute *attributes = np_alloc_resize(image->context, image->attributes, count, sizeof *attributes);
  if (!attributes) return NULL;
  image->attributes = attributes;
  np_image_attribute *added = &attributes[image->attribute_count];
  added->name = np_alloc_text(image->context, name);
  if (!added->name) return NULL;
  image->attribute_count++;
  return added;
}

/* Sets an attribute; takes ownership of `value` in any case. */
static neph_result set_attribute(neph_image *image, const char *name, char *value, np_image_attribute_type type,
                                 double number) {
  np_image_attribute *attribute = NULL;
  for (unsigned i = 0; value && i < image->attribute_count; i++)
    if (!strcmp(image->attributes[i].name, name)) attribute = &image->attributes[i];
  if (value && !attribute) attribute = add_attribute(image, name);
  if (!attribute) {
    np_alloc_free(image->context, value);
    return NEPH_ERROR_OUT_OF_MEMORY;
  }
  np_alloc_free(image->context, attribute->value);
  attribute->value = value;
  attribute->type = type;
  attribute->number = number;
  return NEPH_OK;
}

neph_result neph_image_set_attribute(neph_image *image, const char *name, const char *value) {
  if (NP_LACKS(NP_CONTEXT_OF(image), name, value)) return NEPH_ERROR_INVALID_ARGUMENT;
  if (!*name || strlen(name) > NP_IMAGE_NAME_MAX)
    return np_fail(image->context, NEPH_ERROR_INVALID_ARGUMENT, "attribute name \"%s\" must have 1 to %d bytes", name,
                   NP_IMAGE_NAME_MAX);
  return set_attribute(image, name, np_alloc_text(image->context, value), NP_IMAGE_TEXT, 0);
}

neph_result np_image_set_integer(neph_image *image, const char *name, int32_t value) {
  return set_attribute(image, name, np_alloc_printf(image->context, "%d", (int)value), NP_IMAGE_INTEGER, value);
}

/* Sets a number, rounded to the precision of a file, so that rendered and loaded pictures have equal attributes. */
neph_result np_image_set_real(neph_image *image, const char *name, double value) {
  const double held = (double)(float)value;
  return set_attribute(image, name, np_alloc_printf(image->context, "%.9g", held), NP_IMAGE_REAL, held);
}
