/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/part_rules.h"

#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "frame/channel_table.h"
#include "image/cryptomatte.h"
#include "parts/part_grid.h"

enum { ATTRIBUTES_MAX = 1024, SCATTERINGS_MAX = 1000000000 };

/* ---- Identity ---- */

static bool check_version(const np_part_header *h, np_part_fault *fault) {
  if (*h->version && strspn(h->version, "0123456789.-+abcdefghijklmnopqrstuvwxyz") == strlen(h->version)) return true;
  return np_part_fault_set(fault, "its field 'version' is \"%s\", must be a version of nephos", h->version);
}

bool np_part_rules_check_hash(const char *hash, np_part_fault *fault) {
  if (strlen(hash) == 32 && strspn(hash, "0123456789abcdef") == 32) return true;
  return np_part_fault_set(fault, "its field 'hash' is \"%.64s\", must be 32 hexadecimal digits", hash);
}

static bool check_hash(const np_part_header *h, np_part_fault *fault) {
  return np_part_rules_check_hash(h->hash, fault);
}

/* ---- Place ---- */

static bool check_display(const np_part_header *h, np_part_fault *fault) {
  for (int k = 0; k < 2; k++)
    if (h->display_min[k] != 0 || h->display_max[k] < 1 || h->display_max[k] > NP_IMAGE_SIDE_MAX)
      return np_part_fault_set(fault, "its field 'display window' is %d to %d along %c, must be 0 to at most %d",
                               h->display_min[k], h->display_max[k], "xy"[k], (int)NP_IMAGE_SIDE_MAX);
  return true;
}

static bool check_whole(const np_part_header *h, np_part_fault *fault) {
  for (int k = 0; k < 2; k++) {
    const int min = h->whole_min[k], max = h->whole_max[k];
    if (min > -NP_IMAGE_SIDE_MAX && min < h->display_max[k] && max > h->display_min[k] && max > min &&
        (int64_t)max - min <= NP_IMAGE_SIDE_MAX)
      continue;
    return np_part_fault_set(fault,
                             "its field 'whole window' is %d to %d along %c, must be 1 to %d pixels that meet the "
                             "display window of %d to %d",
                             min, max, "xy"[k], (int)NP_IMAGE_SIDE_MAX, h -> display_min[k], h -> display_max[k]);
  }
  return true;
}

static bool check_bytes(const np_part_header *h, unsigned channel_count, np_part_fault *fault) {
  const uint64_t width = (uint64_t)(h->whole_max[0] - h->whole_min[0]),
                 height = (uint64_t)(h->whole_max[1] - h->whole_min[1]);
  if (width * height * channel_count * sizeof(float) <= NP_IMAGE_BYTES_MAX) return true;
  return np_part_fault_set(
      fault, "its field 'whole window' is %llu x %llu pixels of %u channels, must take at most %d GiB in memory",
      (unsigned long long)width, (unsigned long long)height, channel_count, (int)(NP_IMAGE_BYTES_MAX >> 30));
}

static bool check_columns(const np_part_header *h, np_part_fault *fault) {
  if (h->min[0] == h->whole_min[0] && h->max[0] == h->whole_max[0]) return true;
  return np_part_fault_set(fault,
                           "its field 'window' is %d to %d along x, must be %d to %d, all columns of the field 'whole "
                           "window'",
                           h->min[0], h->max[0], h->whole_min[0], h->whole_max[0]);
}

static bool check_tile(const np_part_header *h, np_part_fault *fault) {
  const int64_t rows = np_part_count_rows(h);
  if (h->tile_count >= 1 && h->tile_count <= rows && h->tile_index < h->tile_count) return true;
  return np_part_fault_set(fault, "its field 'tile' is %lld of %u, must be one of 1 to %lld, the picture's rows",
                           (long long)h->tile_index + 1, h->tile_count, (long long)rows);
}

static bool check_rows(const np_part_header *h, np_part_fault *fault) {
  const int begin = np_part_get_tile_row(h, h->tile_index, h->tile_count),
            end = np_part_get_tile_row(h, h->tile_index + 1, h->tile_count);
  if (h->min[1] == begin && h->max[1] == end) return true;
  return np_part_fault_set(fault,
                           "its field 'window' is %d to %d along y, must be %d to %d, the rows of the field 'tile', "
                           "%u/%u, in the field 'whole window', %d to %d",
                           h->min[1], h->max[1], begin, end, h->tile_index + 1, h->tile_count, h->whole_min[1],
                           h->whole_max[1]);
}

bool np_part_rules_check_place(const np_part_header *h, unsigned channel_count, np_part_fault *fault) {
  return check_display(h, fault) && check_whole(h, fault) && check_bytes(h, channel_count, fault) &&
         check_columns(h, fault) && check_tile(h, fault) && check_rows(h, fault);
}

static bool check_place(const np_part_header *h, np_part_fault *fault) {
  return np_part_rules_check_place(h, h->channels.count, fault);
}

/* ---- Samples ---- */

static bool check_samples(const np_part_header *h, np_part_fault *fault) {
  const bool is_range = h->sample_count >= 1 && h->sample_count <= NP_FILM_SAMPLES_MAX &&
                        h->sample_begin < h->sample_end && h->sample_end <= h->sample_count;
  const bool is_aligned = h->sample_begin % NP_FILM_LEAF_SAMPLES == 0 &&
                          (h->sample_end % NP_FILM_LEAF_SAMPLES == 0 || h->sample_end == h->sample_count);
  if (is_range && is_aligned) return true;
  return np_part_fault_set(
      fault,
      "its field 'samples' is %u-%u of %u, must be a range of 1 to %d samples that begins and ends "
      "at multiples of %d, or with the last",
      h->sample_begin, h->sample_end, h->sample_count, (int)NP_FILM_SAMPLES_MAX, (int)NP_FILM_LEAF_SAMPLES);
}

static bool is_whole_range(const np_part_header *h) { return h->sample_begin == 0 && h->sample_end == h->sample_count; }

static bool check_complete(const np_part_header *h, np_part_fault *fault) {
  if (h->is_complete == is_whole_range(h)) return true;
  return np_part_fault_set(fault, "its field 'complete' is %u, must be %d for the samples %u-%u of %u", h->is_complete,
                           is_whole_range(h), h->sample_begin, h->sample_end, h->sample_count);
}

static bool check_target(const np_part_header *h, np_part_fault *fault) {
  const bool has_target = isfinite(h->target_error);
  if (h->target_error > 0.0 && (!has_target || h->is_complete)) return true;
  return np_part_fault_set(fault,
                           "its field 'target error' is %g, must be above 0, and infinite, which is none, for a range "
                           "of samples",
                           h->target_error);
}

/* ---- Settings ---- */

static bool check_pixel_type(const np_part_header *h, np_part_fault *fault) {
  if (h->pixel_type <= NEPH_PIXEL_FLOAT) return true;
  return np_part_fault_set(fault, "its field 'pixel type' is %u, must be %d (half) or %d (float)", h->pixel_type,
                           NEPH_PIXEL_HALF, NEPH_PIXEL_FLOAT);
}

static bool check_scatterings(const np_part_header *h, np_part_fault *fault) {
  if (h->scattering_max <= SCATTERINGS_MAX || h->scattering_max == NEPH_SCATTERINGS_ALL) return true;
  return np_part_fault_set(fault, "its field 'scatterings' is %u, must be at most %d, or %u, which is all",
                           h->scattering_max, (int)SCATTERINGS_MAX, NEPH_SCATTERINGS_ALL);
}

static bool check_dim(const np_part_header *h, np_part_fault *fault) {
  for (int b = 0; b < NP_BAND_COUNT; b++)
    if (!(h->dim[b] >= 0.0) || !isfinite(h->dim[b]))
      return np_part_fault_set(fault, "its field 'dim' is %g in %c, must be finite and not negative", h->dim[b],
                               "RGB"[b]);
  return true;
}

static bool check_lost_share(const np_part_header *h, np_part_fault *fault) {
  if (h->lost_share >= 0.0 && h->lost_share <= 1.0) return true;
  return np_part_fault_set(fault, "its field 'lost share' is %g, must be 0 to 1", h->lost_share);
}

/* ---- Channels ---- */

static bool is_among(unsigned first, unsigned count, unsigned all) { return first <= all && count <= all - first; }

bool np_part_rules_check_sums(const np_channels *c, np_part_fault *fault) {
  if (c->count < 1 || c->count > NP_CHANNELS_MAX)
    return np_part_fault_set(fault, "its field 'channels: number' is %u, must be 1 to %d", c->count,
                             (int)NP_CHANNELS_MAX);
  if (c->sum_count < c->count || c->sum_count > NP_CHANNELS_MAX)
    return np_part_fault_set(fault, "its field 'channels: number of sums' is %u, must be %u, of the channels, to %d",
                             c->sum_count, c->count, (int)NP_CHANNELS_MAX);
  if (c->opaque >= c->sum_count && c->opaque != NP_CHANNEL_NONE)
    return np_part_fault_set(fault, "its field 'channels: opacity' is sum %u, must be below %u, or %d, which is none",
                             c->opaque, c->sum_count, (int)NP_CHANNEL_NONE);
  if (c->matte_count > NP_INSTANCES_MAX + 1)
    return np_part_fault_set(fault, "its field 'channels: number of mattes' is %u, must be at most %d", c->matte_count,
                             (int)NP_INSTANCES_MAX + 1);
  if (!is_among(c->mattes, c->matte_count, c->sum_count))
    return np_part_fault_set(fault, "its field 'channels: first matte' is sum %u, must leave %u below %u", c->mattes,
                             c->matte_count, c->sum_count);
  if (!(c->scale > 0.0f) || !isfinite(c->scale))
    return np_part_fault_set(fault, "its field 'channels: scale' is %g, must be finite and above 0", (double)c->scale);
  for (unsigned i = 0; i < c->matte_count; i++)
    if (!isfinite(c->matte_ids[i]))
      return np_part_fault_set(fault, "its field 'channels: matte identifiers' is %g at %u, must be finite",
                               (double)c->matte_ids[i], i);
  return true;
}

/* Checks that a channel has a name which no earlier channel has. */
static bool check_channel_name(const np_channels *c, unsigned i, np_part_fault *fault) {
  bool is_new = *c->channel[i].name;
  for (unsigned k = 0; k < i && is_new; k++) is_new = strcmp(c->channel[i].name, c->channel[k].name) != 0;
  if (is_new) return true;
  return np_part_fault_set(fault, "its field 'channels: name' of channel %u is \"%s\", must be a name of its own", i,
                           c->channel[i].name);
}

static bool check_channel(const np_channels *c, unsigned i, np_part_fault *fault) {
  const np_channel *channel = &c->channel[i];
  const np_channel_finish_needs needs = np_channel_finish_get_needs(channel->kind.finish);
  if (!check_channel_name(c, i, fault)) return false;
  if (channel->index >= c->sum_count)
    return np_part_fault_set(fault, "its field 'channels: sum' of %s is %u, must be below %u", channel->name,
                             channel->index, c->sum_count);
  if (channel->part >= needs.part_count)
    return np_part_fault_set(fault, "its field 'channels: part' of %s is %u, must be below %u", channel->name,
                             channel->part, needs.part_count);
  if (needs.opacity && c->opaque == NP_CHANNEL_NONE)
    return np_part_fault_set(fault, "its field 'channels: opacity' is none, must be a sum, which %s is divided by",
                             channel->name);
  if (needs.mattes && c->matte_count == 0)
    return np_part_fault_set(fault, "its field 'channels: number of mattes' is 0, must be at least 1, which %s ranks",
                             channel->name);
  return true;
}

static bool check_channels(const np_part_header *h, np_part_fault *fault) {
  for (unsigned i = 0; i < h->channels.count; i++)
    if (!check_channel(&h->channels, i, fault)) return false;
  return true;
}

/* ---- All ---- */

bool np_part_rules_check(const np_part_header *h, np_part_fault *fault) {
  typedef bool check_fn(const np_part_header *h, np_part_fault *fault);
  static check_fn *const rules[] = {check_version,     check_hash,     check_channels,  check_place,
                                    check_samples,     check_complete, check_target,    check_pixel_type,
                                    check_scatterings, check_dim,      check_lost_share};
  for (size_t i = 0; i < sizeof rules / sizeof *rules; i++)
    if (!rules[i](h, fault)) return false;
  return true;
}

/* ---- The image ---- */

bool np_part_rules_check_flags(const unsigned char *bytes, np_part_fault *fault) {
  static const struct {
    const char *name;
    size_t at;
  } flags[] = {{"camera", offsetof(np_image_header, has_camera)},
               {"camera of a plane", offsetof(np_image_header, has_ndc)},
               {"latlong", offsetof(np_image_header, is_latlong)},
               {"chromaticities", offsetof(np_image_header, has_chromaticities)},
               {"display window", offsetof(np_image_header, has_window)}};
  for (size_t i = 0; i < sizeof flags / sizeof *flags; i++)
    if (bytes[flags[i].at] > 1)
      return np_part_fault_set(fault, "its field 'image: %s' is %u, must be 0 or 1", flags[i].name, bytes[flags[i].at]);
  return true;
}

static bool check_floats(const char *name, const float *values, size_t count, np_part_fault *fault) {
  for (size_t i = 0; i < count; i++)
    if (!isfinite(values[i]))
      return np_part_fault_set(fault, "its field 'image: %s' is %g at %zu, must be finite", name, (double)values[i], i);
  return true;
}

bool np_part_rules_check_image(const np_part_header *h, const np_image_header *image, np_part_fault *fault) {
  for (int k = 0; k < 2; k++)
    if (!image->has_window || image->data_min[k] != h->min[k] || image->data_max[k] != h->max[k] - 1)
      return np_part_fault_set(fault,
                               "its field 'image: data window' is %d to %d along %c, must be that of the part, %d "
                               "to %d",
                               image->data_min[k], image->data_max[k], "xy"[k], h -> min[k], h -> max[k] - 1);
  return check_floats("camera", image->world_to_camera, 16, fault) &&
         check_floats("camera of a plane", image->world_to_ndc, 16, fault) &&
         check_floats("chromaticities", image->chromaticities, 8, fault);
}

bool np_part_rules_check_attribute_count(uint32_t count, np_part_fault *fault) {
  if (count <= ATTRIBUTES_MAX) return true;
  return np_part_fault_set(fault, "its field 'attributes' is %u, must be at most %d", count, (int)ATTRIBUTES_MAX);
}

bool np_part_rules_check_attribute(const neph_image *image, uint32_t type, double number, const char *name,
                                   np_part_fault *fault) {
  const size_t length = strlen(name);
  if (length < 1 || length > NP_IMAGE_NAME_MAX)
    return np_part_fault_set(fault, "its field 'attribute' has a name of %zu bytes, must be 1 to %d", length,
                             (int)NP_IMAGE_NAME_MAX);
  if (np_image_search_attribute(image, name))
    return np_part_fault_set(fault, "its field 'attribute' has %s twice, must have each name once", name);
  if (type > NP_IMAGE_REAL)
    return np_part_fault_set(fault, "its field 'attribute' %s has the type %u, must be 0 to %d", name, type,
                             NP_IMAGE_REAL);
  if (type == NP_IMAGE_INTEGER && !(number >= INT_MIN && number <= INT_MAX && number == floor(number)))
    return np_part_fault_set(fault, "its field 'attribute' %s is %g, must be an integer of 32 bits", name, number);
  return true;
}

/* ---- Records ---- */

static bool is_count(double value, double most) { return value >= 0.0 && value <= most && value == floor(value); }

/* Checks a number of samples; with a target error it may be smaller than the range. */
static bool check_count(const np_part_header *h, double count, np_part_fault *fault) {
  const double most = h->sample_end - h->sample_begin;
  const bool has_target = isfinite(h->target_error);
  if (has_target ? is_count(count, NP_FILM_SAMPLES_MAX) && count >= 1.0 : count == most) return true;
  if (has_target)
    return np_part_fault_set(fault, "a pixel has %g samples, must have 1 to %d", count, (int)NP_FILM_SAMPLES_MAX);
  return np_part_fault_set(fault, "a pixel has %g samples, must have %g, as its header says", count, most);
}

/* Paths are counted in floats. */
static const double paths_max = 0x1p53;

static bool check_numbers(const np_part_header *h, const double *numbers, np_part_fault *fault) {
  const double *cuts = np_channels_get_cuts(&h->channels, numbers);
  const np_spread spread = np_channels_get_spread(&h->channels, numbers, 1);
  for (int k = 0; k < 2; k++)
    if (!is_count(cuts[k], paths_max))
      return np_part_fault_set(fault, "a pixel has %g paths that met the limit on scatterings, must be a whole number",
                               cuts[k]);
  for (int b = 0; b < NP_BAND_COUNT; b++)
    if (spread.squares[b] < 0.0)
      return np_part_fault_set(fault, "a pixel's sum of squares is %g in %c, must not be negative", spread.squares[b],
                               "RGB"[b]);
  return true;
}

bool np_part_rules_check_record(const np_part_header *h, const double *record, np_part_fault *fault) {
  const unsigned size = np_channels_count_numbers(&h->channels), reals = np_part_header_count_reals(h);
  if (!check_count(h, record[NP_PART_RECORD_COUNT], fault)) return false;
  for (unsigned at = NP_PART_RECORD_NUMBERS; at < reals; at += size)
    if (!check_numbers(h, record + at, fault)) return false;
  return true;
}
