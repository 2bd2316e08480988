/* SPDX-License-Identifier: Apache-2.0 */
/* Header of an OpenEXR file as text. */
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/json.h"
#include "core/text.h"
#include "core/text_copy.h"
#include "image/image_private.h"

/* ---- Plain ---- */

static void append_matrix(np_text *out, const char *name, const float m[16]) {
  np_text_add(out, "  %-24s", name);
  for (int i = 0; i < 16; i++) np_text_add(out, "%s%g", i == 0 ? "" : i % 4 ? " " : " / ", (double)m[i]);
  np_text_add(out, "\n");
}

static void append_window(np_text *out, const char *name, const int min[2], const int max[2]) {
  np_text_add(out, "  %-24s(%d, %d) to (%d, %d)\n", name, min[0], min[1], max[0], max[1]);
}

static void append_header(np_text *out, const np_image_header *header) {
  append_window(out, "data window", header->data_min, header->data_max);
  append_window(out, "display window", header->display_min, header->display_max);
  if (header->has_camera) {
    append_matrix(out, "worldToCamera", header->world_to_camera);
    if (header->has_ndc) append_matrix(out, "worldToNDC", header->world_to_ndc);
  }
  if (!header->has_chromaticities) return;
  np_text_add(out, "  %-24s", "chromaticities");
  for (int i = 0; i < 8; i++) np_text_add(out, "%s%g", i ? " " : "", (double)header->chromaticities[i]);
  np_text_add(out, "\n");
}

/* Adds the line of an attribute, of any name and value. */
static void append_attribute(np_text *out, const np_image_attribute *a) {
  char *line = np_alloc_printf(out->context, "  %-24s%s", a->name, a->value);
  if (line) np_text_clean(line);
  np_text_add(out, "%s\n", line ? line : "");
  out->has_failed = out->has_failed || !line;
  np_alloc_free(out->context, line);
}

static neph_result describe_plain(const char *path, const np_image_exr_info *info, const neph_image *image,
                                  char **out_text) {
  np_text out = {.context = image->context};
  np_text_add(&out, "%s: OpenEXR, %u x %u pixels, %s, %s compression\n", path, image->width, image->height,
              info->storage, info->compression);
  if (info->tile_width) np_text_add(&out, "  %-24s%u x %u\n", "tile", info->tile_width, info->tile_height);
  if (info->part_count != 1) np_text_add(&out, "  %-24s%d, the first is described\n", "parts", info->part_count);
  np_text_add(&out, "  %-24s", "channels");
  for (unsigned c = 0; c < image->channel_count; c++)
    np_text_add(&out, "%s%s (%s)", c ? ", " : "", image->channels[c].name, image->channels[c].stored);
  np_text_add(&out, "\n");
  append_header(&out, &image->header);
  for (unsigned a = 0; a < image->attribute_count; a++)
    append_attribute(&out, &image->attributes[a]);
  return np_text_finish(&out, out_text);
}

/* ---- JSON ---- */

static void put_floats(np_json *json, const char *key, const float *values, size_t count) {
  np_json_begin_array(json, key);
  for (size_t i = 0; i < count; i++) np_json_put_real(json, NULL, (double)values[i]);
  np_json_end(json);
}

static void put_window(np_json *json, const char *key, const int min[2], const int max[2]) {
  np_json_begin_object(json, key);
  np_json_begin_array(json, "min");
  for (int i = 0; i < 2; i++) np_json_put_integer(json, NULL, min[i]);
  np_json_end(json);
  np_json_begin_array(json, "max");
  for (int i = 0; i < 2; i++) np_json_put_integer(json, NULL, max[i]);
  np_json_end(json);
  np_json_end(json);
}

static void put_header(np_json *json, const np_image_header *header) {
  put_window(json, "data_window", header->data_min, header->data_max);
  put_window(json, "display_window", header->display_min, header->display_max);
  if (header->has_camera) {
    put_floats(json, "worldToCamera", header->world_to_camera, 16);
    if (header->has_ndc) put_floats(json, "worldToNDC", header->world_to_ndc, 16);
  }
  if (header->has_chromaticities) put_floats(json, "chromaticities", header->chromaticities, 8);
}

static void put_channels(np_json *json, const neph_image *image) {
  np_json_begin_array(json, "channels");
  for (unsigned c = 0; c < image->channel_count; c++) {
    np_json_begin_object(json, NULL);
    np_json_put_text(json, "name", image->channels[c].name);
    np_json_put_text(json, "type", image->channels[c].stored);
    np_json_end(json);
  }
  np_json_end(json);
}

static void put_attributes(np_json *json, const neph_image *image) {
  np_json_begin_object(json, "attributes");
  for (unsigned a = 0; a < image->attribute_count; a++) {
    const np_image_attribute *attribute = &image->attributes[a];
    switch (attribute->type) {
    case NP_IMAGE_INTEGER:
      np_json_put_integer(json, attribute->name, (int64_t)attribute->number);
      break;
    case NP_IMAGE_REAL:
      np_json_put_real(json, attribute->name, attribute->number);
      break;
    case NP_IMAGE_TEXT:
      np_json_put_text(json, attribute->name, attribute->value);
      break;
    }
  }
  np_json_end(json);
}

static neph_result describe_json(const char *path, const np_image_exr_info *info, const neph_image *image,
                                 char **out_text) {
  np_json *json = np_json_create(image->context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  np_json_put_text(json, "file", path);
  np_json_put_text(json, "kind", "OpenEXR");
  np_json_put_integer(json, "width", image->width);
  np_json_put_integer(json, "height", image->height);
  np_json_put_text(json, "storage", info->storage);
  np_json_put_text(json, "compression", info->compression);
  np_json_put_integer(json, "parts", info->part_count);
  put_channels(json, image);
  put_header(json, &image->header);
  put_attributes(json, image);
  return np_json_finish(json, out_text);
}

neph_result neph_image_describe_file(neph_context *context, const char *path, neph_text_format format,
                                     char **out_text) {
  if (NP_LACKS_OUT(context, out_text, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_image_exr_info info;
  neph_image *image;
  *out_text = NULL;
  neph_result result = np_image_read_exr_header(context, path, &info, &image);
  if (result) return result;
  result = (format == NEPH_TEXT_JSON ? describe_json : describe_plain)(path, &info, image, out_text);
  neph_image_destroy(image);
  return result;
}
