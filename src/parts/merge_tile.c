/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/merge_tile.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "frame/render_header.h"
#include "parts/merge_error.h"
#include "parts/merge_property.h"
#include "parts/part_rules.h"
#include "plan/scene_hash.h"

/* ---- Attributes ---- */

/* Parses integers with one separator between each pair; false: the text has another form. */
static bool parse_integers(const char *text, char separator, int count, int64_t *out) {
  for (int i = 0; i < count; i++) {
    char *end;
    if (*text != '-' && (*text < '0' || *text > '9')) return false;
    out[i] = strtoll(text, &end, 10);
    if (end == text || out[i] < INT_MIN || out[i] > INT_MAX) return false;
    if (*end != (i + 1 < count ? separator : '\0')) return false;
    text = end + 1;
  }
  return true;
}

/* Parses an attribute of three numbers; zeros if it is missing. */
static bool parse_triple(const neph_image *image, const char *name, double out[NP_BAND_COUNT]) {
  const char *text = neph_image_get_attribute(image, name);
  memset(out, 0, NP_BAND_COUNT * sizeof *out);
  if (!text) return true;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    char *end;
    out[b] = strtod(text, &end);
    if (end == text || (*end && *end != ' ')) return false;
    text = *end ? end + 1 : end;
  }
  return !*text;
}

static double get_real(const neph_image *image, const char *name) {
  const np_image_attribute *attribute = np_image_search_attribute(image, name);
  return attribute && attribute->type != NP_IMAGE_TEXT ? attribute->number : 0.0;
}

/* ---- Rules ---- */

static bool check_hash(const neph_image *image, np_part_fault *fault) {
  const char *hash = neph_image_get_attribute(image, NP_SCENE_HASH);
  if (hash) return np_part_rules_check_hash(hash, fault);
  return np_part_fault_set_file(fault, NEPH_ERROR_INVALID_ARGUMENT,
                                "it has no attribute " NP_SCENE_HASH ", by which parts of one picture are known: must "
                                "be a finished picture of this version of nephos");
}

static bool check_kind(const neph_image *image, np_part_fault *fault) {
  if (!check_hash(image, fault)) return false;
  if (neph_image_get_attribute(image, NP_HEADER_RANGE))
    return np_part_fault_set_file(fault, NEPH_ERROR_INVALID_ARGUMENT,
                                  "it is the picture of a range of samples, which cannot be merged: give the part's "
                                  "own file");
  if (neph_image_get_attribute(image, "nephos:sampling"))
    return np_part_fault_set_file(fault, NEPH_ERROR_INVALID_ARGUMENT,
                                  "its samples were cut by a time limit, which no other part repeats: render it "
                                  "without");
  return true;
}

/* Figures that are added up; a mean may be infinite, as a pixel may. */
static bool check_figures(const neph_image *image, np_part_fault *fault) {
  static const char *const triples[] = {"nephos:mean", "nephos:meanStandardError", "nephos:lostMean"};
  const double samples = get_real(image, "nephos:samples");
  double values[NP_BAND_COUNT];
  for (size_t i = 0; i < sizeof triples / sizeof *triples; i++)
    if (!parse_triple(image, triples[i], values))
      return np_part_fault_set(fault, "its attribute %s is \"%.64s\", must be three numbers", triples[i],
                               neph_image_get_attribute(image, triples[i]));
  if (!(samples >= 1.0 && samples <= NP_FILM_SAMPLES_MAX))
    return np_part_fault_set(fault, "its attribute nephos:samples is %g, must be 1 to %d", samples,
                             (int)NP_FILM_SAMPLES_MAX);
  return true;
}

/* ---- The header ---- */

static void set_own_windows(np_part_header *h, const neph_image *image) {
  const unsigned size[2] = {image->width, image->height};
  const np_image_header *from = &image->header;
  np_part_header_set_display(h, from);
  for (int k = 0; k < 2; k++) {
    h->min[k] = h->whole_min[k] = from->data_min[k];
    h->max[k] = h->whole_max[k] = (int)((int64_t)from->data_min[k] + size[k]);
  }
}

static bool read_tile_number(np_part_header *h, const char *tile, np_part_fault *fault) {
  int64_t number[2];
  if (!parse_integers(tile, '/', 2, number) || number[0] < 1 || number[0] > number[1])
    return np_part_fault_set(fault, "its attribute " NP_HEADER_TILE " is \"%.64s\", must be I/N, I being 1 to N", tile);
  h->tile_index = (uint32_t)number[0] - 1;
  h->tile_count = (uint32_t)number[1];
  return true;
}

static bool read_whole(np_part_header *h, const char *whole, np_part_fault *fault) {
  int64_t window[4];
  if (!parse_integers(whole, ' ', 4, window))
    return np_part_fault_set(fault,
                             "its attribute " NP_HEADER_WHOLE " is \"%.64s\", must be four integers: the first column "
                             "and row, and those behind the last",
                             whole);
  for (int k = 0; k < 2; k++) {
    h->whole_min[k] = (int32_t)window[k];
    h->whole_max[k] = (int32_t)window[2 + k];
  }
  return true;
}

/* A picture that is no tile is its whole. */
static bool read_place(np_part_header *h, const neph_image *image, np_part_fault *fault) {
  const char *tile = neph_image_get_attribute(image, NP_HEADER_TILE);
  const char *whole = neph_image_get_attribute(image, NP_HEADER_WHOLE);
  set_own_windows(h, image);
  h->tile_count = 1;
  if (!tile != !whole)
    return np_part_fault_set(fault, "its attribute %s is missing, must stand beside %s",
                             tile ? NP_HEADER_WHOLE : NP_HEADER_TILE, tile ? NP_HEADER_TILE : NP_HEADER_WHOLE);
  if (tile && (!read_tile_number(h, tile, fault) || !read_whole(h, whole, fault))) return false;
  return np_part_rules_check_place(h, image->channel_count, fault);
}

static void copy_text(char *to, size_t room, const char *text) {
  const size_t length = strnlen(text, room - 1);
  memcpy(to, text, length);
  to[length] = '\0';
}

static bool read_header(np_part_header *h, const neph_image *image, np_part_fault *fault) {
  if (!check_kind(image, fault) || !check_figures(image, fault) || !np_merge_error_check(image, fault) ||
      !np_merge_property_check(image, fault) || !read_place(h, image, fault))
    return false;
  const char *software = neph_image_get_attribute(image, "software");
  if (software && !strncmp(software, "nephos ", 7)) copy_text(h->version, sizeof h->version, software + 7);
  copy_text(h->hash, sizeof h->hash, neph_image_get_attribute(image, NP_SCENE_HASH));
  h->sample_count = h->sample_end = (uint32_t)(get_real(image, "nephos:samples") + 0.5);
  h->is_complete = true;
  return true;
}

/* Whether two images have equal sizes. The file may have been replaced since its header was checked. */
static bool is_same_size(const neph_image *a, const neph_image *b) {
  return a->width == b->width && a->height == b->height && a->channel_count == b->channel_count;
}

static neph_result check_header(const np_merge_part *p, const neph_image *image, np_part_header *out_header) {
  np_part_fault fault = {.context = p->context};
  return read_header(out_header, image, &fault) ? NEPH_OK : np_part_fault_fail(&fault, p->path);
}

neph_result np_merge_tile_read(np_merge_part *p) {
  np_image_exr_info info;
  neph_image *header = NULL;
  neph_result result = np_image_read_exr_header(p->context, p->path, &info, &header);
  if (!result) result = check_header(p, header, &p->header);
  if (!result) result = np_image_load_exr(p->context, p->path, NULL, &p->tile);
  if (!result && !is_same_size(header, p->tile))
    result = np_fail(p->context, NEPH_ERROR_BAD_FILE, "%s: it has changed while it was read", p->path);
  if (!result) result = check_header(p, p->tile, &p->header);
  p->header.image = p->tile;
  neph_image_destroy(header);
  return result;
}

/* ---- Totals ---- */

void np_merge_tile_add_totals(const np_merge_part *part, np_tile_total *total) {
  const double pixels = (double)part->tile->width * part->tile->height;
  double mean[NP_BAND_COUNT], error[NP_BAND_COUNT], lost[NP_BAND_COUNT];
  (void)parse_triple(part->tile, "nephos:mean", mean);
  (void)parse_triple(part->tile, "nephos:meanStandardError", error);
  (void)parse_triple(part->tile, "nephos:lostMean", lost);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    total->sum[b] += mean[b] * pixels;
    total->variance[b] += error[b] * pixels * error[b] * pixels;
    total->lost[b] += lost[b] * pixels;
  }
  const double pixel_error = get_real(part->tile, "nephos:pixelError");
  total->samples += (uint64_t)(get_real(part->tile, "nephos:samples") * pixels + 0.5);
  total->squares += pixel_error * pixel_error * pixels;
}
