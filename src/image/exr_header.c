/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_header.h"

#include <string.h>

#include "core/alloc.h"

neph_result np_exr_check_claims(np_exr_file *file, const exr_attr_box2i_t *window, int channel_count) {
  int64_t width = (int64_t)window->max.x - window->min.x + 1, height = (int64_t)window->max.y - window->min.y + 1;
  bool is_allowed = width >= 1 && width <= NP_IMAGE_SIDE_MAX && height >= 1 && height <= NP_IMAGE_SIDE_MAX &&
                    channel_count >= 1 && channel_count <= NP_IMAGE_CHANNELS_MAX;
  if (is_allowed && (uint64_t)(width * height * channel_count) * sizeof(float) <= NP_IMAGE_BYTES_MAX) return NEPH_OK;
  return np_fail(
      file->context, NEPH_ERROR_BAD_FILE,
      "%s: claims %lld × %lld pixels of %d channels, must be 1 to %d each way, 1 to %d channels, and at most "
      "%d GiB in memory",
      file->path, (long long)width, (long long)height, channel_count, NP_IMAGE_SIDE_MAX, NP_IMAGE_CHANNELS_MAX,
      (int)(NP_IMAGE_BYTES_MAX >> 30));
}

static const char *name_pixel_type(exr_pixel_type_t type) {
  switch (type) {
  case EXR_PIXEL_UINT:
    return "uint";
  case EXR_PIXEL_HALF:
    return "half";
  case EXR_PIXEL_FLOAT:
    return "float";
  case EXR_PIXEL_LAST_TYPE:
    break;
  }
  return "unknown";
}

static neph_result create_image(np_exr_file *file, bool has_values, neph_image **out_image) {
  exr_attr_box2i_t window;
  const exr_attr_chlist_t *channels;
  exr_result_t code = exr_get_data_window(file->exr, 0, &window);
  if (!code) code = exr_get_channels(file->exr, 0, &channels);
  if (code) return np_exr_fail_read(file, code);
  neph_result result = np_exr_check_claims(file, &window, channels->num_channels);
  if (result) return result;
  const char **names = np_alloc(file->context, (size_t)channels->num_channels, sizeof *names);
  if (!names) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int c = 0; c < channels->num_channels; c++) names[c] = channels->entries[c].name.str;
  unsigned width = (unsigned)(window.max.x - window.min.x + 1), height = (unsigned)(window.max.y - window.min.y + 1);
  result =
      np_image_create(file->context, width, height, (unsigned)channels->num_channels, names, has_values, out_image);
  np_alloc_free(file->context, names);
  for (int c = 0; !result && c < channels->num_channels; c++)
    (*out_image)->channels[c].stored = name_pixel_type(channels->entries[c].pixel_type);
  return result;
}

static neph_result read_windows(np_exr_file *file, np_image_header *header) {
  exr_attr_box2i_t data, display;
  exr_result_t code = exr_get_data_window(file->exr, 0, &data);
  if (!code) code = exr_get_display_window(file->exr, 0, &display);
  if (code) return np_exr_fail_read(file, code);
  header->has_window = memcmp(&data, &display, sizeof data) != 0 || data.min.x != 0 || data.min.y != 0;
  header->data_min[0] = data.min.x, header->data_min[1] = data.min.y;
  header->data_max[0] = data.max.x, header->data_max[1] = data.max.y;
  header->display_min[0] = display.min.x, header->display_min[1] = display.min.y;
  header->display_max[0] = display.max.x, header->display_max[1] = display.max.y;
  return NEPH_OK;
}

static void read_matrices(const np_exr_file *file, np_image_header *header) {
  exr_attr_m44f_t camera, ndc;
  exr_attr_chromaticities_t chromaticities;
  if (!exr_attr_get_m44f(file->exr, 0, "worldToCamera", &camera) &&
      !exr_attr_get_m44f(file->exr, 0, "worldToNDC", &ndc)) {
    memcpy(header->world_to_camera, &camera, sizeof camera);
    memcpy(header->world_to_ndc, &ndc, sizeof ndc);
    header->has_camera = true;
  }
  if (!exr_attr_get_chromaticities(file->exr, 0, "chromaticities", &chromaticities)) {
    memcpy(header->chromaticities, &chromaticities, sizeof chromaticities);
    header->has_chromaticities = true;
  }
}

static neph_result read_attribute(neph_image *image, const exr_attribute_t *attribute) {
  switch ((int)attribute->type) {
  case EXR_ATTR_INT:
    return np_image_set_integer(image, attribute->name, attribute->i);
  case EXR_ATTR_FLOAT:
    return np_image_set_real(image, attribute->name, (double)attribute->f);
  case EXR_ATTR_DOUBLE:
    return np_image_set_real(image, attribute->name, attribute->d);
  case EXR_ATTR_STRING:
    return neph_image_set_attribute(image, attribute->name, attribute->string->str);
  default:
    return NEPH_OK;
  }
}

/* What OpenEXR itself lives by is not ours to carry from file to file. */
static bool is_structural(const char *name) {
  static const char *const names[] = {
      "name", "type", "version", "chunkCount", "view", "pixelAspectRatio", "screenWindowWidth"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    if (!strcmp(names[i], name)) return true;
  return false;
}

static neph_result read_attributes(np_exr_file *file, neph_image *image) {
  int32_t count = 0;
  exr_result_t code = exr_get_attribute_count(file->exr, 0, &count);
  neph_result result = code ? np_exr_fail_read(file, code) : NEPH_OK;
  for (int32_t i = 0; !result && i < count; i++) {
    const exr_attribute_t *attribute;
    code = exr_get_attribute_by_index(file->exr, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute);
    if (code) return np_exr_fail_read(file, code);
    if (!is_structural(attribute->name)) result = read_attribute(image, attribute);
  }
  return result;
}

neph_result np_exr_read_header(np_exr_file *file, bool has_values, neph_image **out_image) {
  neph_result result = create_image(file, has_values, out_image);
  if (result) return result;
  result = read_windows(file, &(*out_image)->header);
  read_matrices(file, &(*out_image)->header);
  if (!result) result = read_attributes(file, *out_image);
  if (!result) return NEPH_OK;
  neph_image_destroy(*out_image);
  *out_image = NULL;
  return result;
}

const char *np_exr_name_storage(exr_storage_t storage) {
  switch (storage) {
  case EXR_STORAGE_SCANLINE:
    return "scan lines";
  case EXR_STORAGE_TILED:
    return "tiles";
  case EXR_STORAGE_DEEP_SCANLINE:
    return "deep scan lines";
  case EXR_STORAGE_DEEP_TILED:
    return "deep tiles";
  case EXR_STORAGE_LAST_TYPE:
    break;
  }
  return "unknown";
}

static const char *name_compression(exr_compression_t compression) {
  static const char *const names[] = {"none", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB"};
  return (unsigned)compression < sizeof names / sizeof *names ? names[compression] : "unknown";
}

static neph_result read_info(np_exr_file *file, np_image_exr_info *out_info) {
  exr_storage_t storage;
  exr_compression_t compression;
  exr_tile_level_mode_t level_mode;
  exr_tile_round_mode_t round_mode;
  *out_info = (np_image_exr_info){.part_count = 0};
  exr_result_t code = exr_get_count(file->exr, &out_info->part_count);
  if (!code) code = exr_get_storage(file->exr, 0, &storage);
  if (!code) code = exr_get_compression(file->exr, 0, &compression);
  if (!code && (storage == EXR_STORAGE_TILED || storage == EXR_STORAGE_DEEP_TILED))
    code =
        exr_get_tile_descriptor(file->exr, 0, &out_info->tile_width, &out_info->tile_height, &level_mode, &round_mode);
  if (code) return np_exr_fail_read(file, code);
  out_info->storage = np_exr_name_storage(storage);
  out_info->compression = name_compression(compression);
  return NEPH_OK;
}

neph_result np_image_read_exr_header(neph_context *context, const char *path, np_image_exr_info *out_info,
                                     neph_image **out_image) {
  *out_image = NULL;
  np_exr_file file = {.context = context, .path = path, .descriptor = -1};
  neph_result result = np_exr_file_open_read(&file);
  if (!result) result = read_info(&file, out_info);
  if (!result) result = np_exr_read_header(&file, false, out_image);
  np_exr_file_close(&file);
  return result;
}
