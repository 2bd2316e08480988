/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/merge_property.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "frame/render_header.h"
#include "image/exposure.h"

/* ---- Texts of the picture ---- */

static const char *const texts[] = {"nephos:integrator",
                                    "nephos:atmosphere",
                                    "nephos:multipleScattering",
                                    "nephos:colorSpace",
                                    "nephos:bands",
                                    "nephos:wavelengths",
                                    "nephos:unit",
                                    "nephos:bandMatrix",
                                    "nephos:white",
                                    "nephos:camera",
                                    "view"};

/* ---- Numbers ---- */

#define POSITIVE "a finite number above 0", DBL_TRUE_MIN, DBL_MAX
#define NOT_NEGATIVE "a finite number of at least 0", 0.0, DBL_MAX
#define ANY_FINITE "a finite number", -DBL_MAX, DBL_MAX

typedef enum scope { OF_PICTURE, OF_PART } scope;

static const struct number {
  const char *name, *allowed;
  double least, most;
  scope scope;
} numbers[] = {
    {"nephos:scale", POSITIVE, OF_PICTURE},
    {"nephos:scatteringMax", NOT_NEGATIVE, OF_PICTURE},
    {"nephos:targetNoise", POSITIVE, OF_PICTURE},
    {"whiteLuminance", POSITIVE, OF_PICTURE},
    {NP_EXPOSURE_METER, NOT_NEGATIVE, OF_PICTURE},
    {NP_EXPOSURE_METER_LUMINANCE, NOT_NEGATIVE, OF_PICTURE},
    {NP_EXPOSURE_METER_X, "a chromaticity of 0 to 1", 0.0, 1.0, OF_PICTURE},
    {NP_EXPOSURE_METER_Y, "a chromaticity of 0 to 1", 0.0, 1.0, OF_PICTURE},
    {NP_EXPOSURE_EV100, ANY_FINITE, OF_PICTURE},
    {NP_HEADER_SUN_ELEVATION, "degrees of -90 to 90", -90.0, 90.0, OF_PICTURE},
    {NP_HEADER_MOON_ELEVATION, "degrees of -90 to 90", -90.0, 90.0, OF_PICTURE},
    {NP_HEADER_SUN_AZIMUTH, "degrees of 0 to 360", 0.0, 360.0, OF_PICTURE},
    {"expTime", POSITIVE, OF_PICTURE},
    {"isoSpeed", POSITIVE, OF_PICTURE},
    {"aperture", POSITIVE, OF_PICTURE},
    {"focus", POSITIVE, OF_PICTURE},
    {"nephos:lightResidual", NOT_NEGATIVE, OF_PICTURE},
    {"nephos:lightError", NOT_NEGATIVE, OF_PICTURE},
    {"nephos:pixelError", NOT_NEGATIVE, OF_PART},
    {"renderTime", NOT_NEGATIVE, OF_PART},
    {"nephos:cpuSeconds", NOT_NEGATIVE, OF_PART},
    {"nephos:predictedSeconds", NOT_NEGATIVE, OF_PART},
    {"nephos:predictedBytes", NOT_NEGATIVE, OF_PART},
    {"nephos:pilotSeconds", NOT_NEGATIVE, OF_PART},
};

static bool check_number(const struct number *row, const neph_image *image, np_part_fault *fault) {
  const np_image_attribute *a = np_image_search_attribute(image, row->name);
  if (!a || (a->type != NP_IMAGE_TEXT && a->number >= row->least && a->number <= row->most)) return true;
  return np_part_fault_set(fault, "its attribute %s is \"%.64s\", must be %s", row->name, a->value, row->allowed);
}

/* ---- Matrices ---- */

#define MATRIX(name, has, member)                                                                                      \
  {                                                                                                                    \
    name, offsetof(np_image_header, has), offsetof(np_image_header, member),                                           \
        sizeof(((np_image_header *)0)->member) / sizeof(float)                                                         \
  }

static const struct matrix {
  const char *name;
  size_t has, at, count; /* places of the flag and of the numbers */
} matrices[] = {MATRIX("worldToCamera", has_camera, world_to_camera), MATRIX("worldToNDC", has_ndc, world_to_ndc),
                MATRIX("chromaticities", has_chromaticities, chromaticities)};

/* NULL: the header has none. */
static const float *get_matrix(const struct matrix *row, const np_image_header *header) {
  const char *bytes = (const char *)header;
  return *(const bool *)(bytes + row->has) ? (const float *)(const void *)(bytes + row->at) : NULL;
}

static bool check_matrix(const struct matrix *row, const neph_image *image, np_part_fault *fault) {
  const float *values = get_matrix(row, &image->header);
  for (size_t i = 0; values && i < row->count; i++)
    if (!isfinite(values[i]))
      return np_part_fault_set(fault, "its attribute %s is %g at number %zu, must be finite", row->name,
                               (double)values[i], i);
  return true;
}

bool np_merge_property_check(const neph_image *image, np_part_fault *fault) {
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
    if (!check_number(&numbers[i], image, fault)) return false;
  for (size_t i = 0; i < sizeof matrices / sizeof *matrices; i++)
    if (!check_matrix(&matrices[i], image, fault)) return false;
  return true;
}

/* ---- Whether two are of one picture ---- */

/* OpenEXR files hold floats, files of parts doubles. */
static bool is_same(const np_image_attribute *a, const np_image_attribute *b) {
  if (a->type == NP_IMAGE_TEXT || b->type == NP_IMAGE_TEXT) return !strcmp(a->value, b->value);
  return (float)a->number == (float)b->number;
}

static neph_result compare_attribute(const np_merge_part *part, const np_merge_part *first, const char *name) {
  const np_image_attribute *a = np_image_search_attribute(part->header.image, name),
                           *b = np_image_search_attribute(first->header.image, name);
  if (!a || !b || is_same(a, b)) return NEPH_OK;
  return np_fail(part->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: its attribute %s is %.200s, that of %s is %.200s: parts must be of one picture", part->path, name,
                 a->value, first->path, b->value);
}

static neph_result compare_matrix(const np_merge_part *part, const np_merge_part *first, const struct matrix *row) {
  const float *a = get_matrix(row, &part->header.image->header), *b = get_matrix(row, &first->header.image->header);
  for (size_t i = 0; a && b && i < row->count; i++)
    if (a[i] != b[i])
      return np_fail(part->context, NEPH_ERROR_INVALID_ARGUMENT,
                     "%s: its attribute %s is %g at number %zu, that of %s is %g: parts must be of one picture",
                     part->path, row->name, (double)a[i], i, first->path, (double)b[i]);
  return NEPH_OK;
}

neph_result np_merge_property_compare(const np_merge_part *part, const np_merge_part *first) {
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < sizeof texts / sizeof *texts && !result; i++)
    result = compare_attribute(part, first, texts[i]);
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers && !result; i++)
    if (numbers[i].scope == OF_PICTURE) result = compare_attribute(part, first, numbers[i].name);
  for (size_t i = 0; i < sizeof matrices / sizeof *matrices && !result; i++)
    result = compare_matrix(part, first, &matrices[i]);
  return result;
}
