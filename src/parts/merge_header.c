/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/merge_header.h"

#include <math.h>
#include <string.h>

#include "frame/render_header.h"
#include "parts/merge_error.h"
#include "plan/scene_hash.h"

/* ---- Figures of all parts ---- */

typedef enum rule { SUM, LARGEST } rule;

static const struct {
  const char *name;
  rule rule;
} figures[] = {{"renderTime", SUM},
               {"nephos:cpuSeconds", SUM},
               {"nephos:predictedSeconds", SUM},
               {"nephos:pilotSeconds", SUM},
               {"nephos:predictedBytes", LARGEST}};

enum { FIGURE_COUNT = sizeof figures / sizeof *figures };

static bool is_figure(const char *name) {
  for (int i = 0; i < FIGURE_COUNT; i++)
    if (!strcmp(name, figures[i].name)) return true;
  return false;
}

static neph_result write_figure(const np_merge_part *parts, size_t count, int figure, neph_image *image) {
  const char *name = figures[figure].name;
  double value = 0.0;
  size_t stating = 0;
  for (size_t i = 0; i < count; i++) {
    const np_image_attribute *own = np_image_search_attribute(parts[i].header.image, name);
    if (!own || own->type == NP_IMAGE_TEXT) continue;
    value = figures[figure].rule == SUM ? value + own->number : fmax(value, own->number);
    stating++;
  }
  return stating ? np_image_set_real(image, name, value) : NEPH_OK;
}

/* ---- Attributes ---- */

static bool is_of_part(const char *name) {
  static const char *const own[] = {NP_HEADER_TILE, NP_HEADER_WHOLE, NP_HEADER_RANGE, "software"};
  for (size_t i = 0; i < sizeof own / sizeof *own; i++)
    if (!strcmp(name, own[i])) return true;
  return np_merge_error_has(name) || is_figure(name);
}

static neph_result copy_attribute(neph_image *image, const np_image_attribute *a) {
  if (is_of_part(a->name) || np_image_search_attribute(image, a->name)) return NEPH_OK;
  if (a->type == NP_IMAGE_INTEGER) return np_image_set_integer(image, a->name, (int32_t)a->number);
  if (a->type == NP_IMAGE_REAL) return np_image_set_real(image, a->name, a->number);
  return neph_image_set_attribute(image, a->name, a->value);
}

static neph_result copy_attributes(neph_image *image, const np_merge_part *part) {
  const neph_image *from = part->header.image;
  neph_result result = NEPH_OK;
  for (unsigned a = 0; a < from->attribute_count && !result; a++) result = copy_attribute(image, &from->attributes[a]);
  return result;
}

neph_result np_merge_header_write(const np_merge_part *parts, size_t count, const np_merge_part *model,
                                  neph_image *image) {
  image->header = model->header.image->header;
  image->header.has_window = true;
  for (int k = 0; k < 2; k++) {
    image->header.data_min[k] = model->header.whole_min[k];
    image->header.data_max[k] = model->header.whole_max[k] - 1;
  }
  neph_result result = copy_attributes(image, model);
  for (size_t i = 0; i < count && !result; i++) result = copy_attributes(image, &parts[i]);
  if (!result) result = neph_image_set_attribute(image, NP_SCENE_HASH, model->header.hash);
  for (int i = 0; i < FIGURE_COUNT && !result; i++) result = write_figure(parts, count, i, image);
  return result ? result : np_merge_error_write(parts, count, image);
}
