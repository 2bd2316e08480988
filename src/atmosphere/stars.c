/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/stars.h"

#include <string.h>

#include "core/alloc.h"
#include "core/csv.h"
#include "core/units.h"

/* Accepted names of columns: the names of nephos first, then those of the Hipparcos and Bright Star catalogues at CDS.
 */
static const char *const ascension_names[] = {"ra_deg", "RAICRS", "_RA.icrs", "_RAJ2000", "RAdeg", NULL};
static const char *const declination_names[] = {"dec_deg", "DEICRS", "_DE.icrs", "_DEJ2000", "DEdeg", NULL};
static const char *const magnitude_names[] = {"v_mag", "Vmag", "V", NULL};
static const char *const colour_names[] = {"b_v", "B-V", NULL};

static const float colour_of_sun = 0.65f;

static int search_column(const np_csv *csv, const char *const names[]) {
  for (int i = 0; names[i]; i++) {
    const int column = np_csv_search_column(csv, names[i]);
    if (column != NP_CSV_NO_COLUMN) return column;
  }
  return NP_CSV_NO_COLUMN;
}

typedef struct star_columns {
  int ascension, declination, magnitude, colour;
} star_columns;

static neph_result require_column(const np_csv *csv, const char *what, const char *const names[], int *out_column) {
  *out_column = search_column(csv, names);
  if (*out_column != NP_CSV_NO_COLUMN) return NEPH_OK;
  return np_fail(csv->context, NEPH_ERROR_BAD_FILE, "%s:%u: no column for %s, must be named %s, or %s as at CDS",
                 csv->path, csv->header.line, what, names[0], names[1]);
}

static neph_result search_columns(const np_csv *csv, star_columns *out) {
  neph_result result = require_column(csv, "the right ascension", ascension_names, &out->ascension);
  if (!result) result = require_column(csv, "the declination", declination_names, &out->declination);
  if (!result) result = require_column(csv, "the V magnitude", magnitude_names, &out->magnitude);
  out->colour = search_column(csv, colour_names);
  return result;
}

static bool is_blank(const char *text) { return text[strspn(text, " \t")] == '\0'; }

static neph_result read_star(const np_csv *csv, size_t row, const star_columns *columns, np_star *out) {
  double ascension, declination, magnitude, colour = (double)colour_of_sun;
  neph_result result = np_csv_get_real(csv, row, columns->ascension, -360.0, 360.0, &ascension);
  if (!result) result = np_csv_get_real(csv, row, columns->declination, -90.0, 90.0, &declination);
  if (!result) result = np_csv_get_real(csv, row, columns->magnitude, -30.0, 40.0, &magnitude);
  if (!result && columns->colour != NP_CSV_NO_COLUMN && !is_blank(np_csv_get_field(csv, row, columns->colour)))
    result = np_csv_get_real(csv, row, columns->colour, -5.0, 10.0, &colour);
  if (!result) *out = (np_star){(float)ascension, (float)declination, (float)magnitude, (float)colour};
  return result;
}

static neph_result read_stars(const np_csv *csv, double faintest, np_star_catalogue *catalogue) {
  star_columns columns = {0};
  neph_result result = search_columns(csv, &columns);
  if (result) return result;
  catalogue->own = np_alloc(csv->context, csv->row_count ? csv->row_count : 1, sizeof *catalogue->own);
  if (!catalogue->own) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t row = 0; !result && row < csv->row_count; row++) {
    np_star *star = &catalogue->own[catalogue->count];
    /* A few Hipparcos stars have no magnitude. */
    if (is_blank(np_csv_get_field(csv, row, columns.magnitude))) continue;
    result = read_star(csv, row, &columns, star);
    if (!result && (double)star->v_magnitude <= faintest) catalogue->count++;
  }
  catalogue->stars = catalogue->own;
  return result;
}

neph_result np_star_catalogue_load(neph_context *context, const char *path, double faintest,
                                   np_star_catalogue *out_catalogue) {
  *out_catalogue = (np_star_catalogue){.context = context};
  np_csv csv;
  neph_result result = np_csv_load(context, path, &csv);
  if (result) return result;
  result = read_stars(&csv, faintest, out_catalogue);
  np_csv_clear(&csv);
  if (result) np_star_catalogue_clear(out_catalogue);
  return result;
}

void np_star_catalogue_clear(np_star_catalogue *catalogue) {
  if (catalogue->own) np_alloc_free(catalogue->context, catalogue->own);
  *catalogue = (np_star_catalogue){0};
}

np_dvec3 np_star_direction(const np_star *star) {
  const double a = (double)star->ascension_deg * NP_DEGREE, d = (double)star->declination_deg * NP_DEGREE;
  return np_dvec3_make(cos(d) * cos(a), cos(d) * sin(a), sin(d));
}

float np_star_twinkle(float spread, float zenith_cosine, float gaussian) {
  if (!(spread > 0.0f)) return 1.0f;
  const float mass = 1.0f / np_maxf(zenith_cosine, 0.05f), relative = np_minf(spread * powf(mass, 1.75f), 1.0f);
  /* Log-normal: e^(σg − σ²/2) has mean 1 and variance e^(σ²) − 1. */
  const float variance = log1pf(relative * relative);
  return expf(sqrtf(variance) * gaussian - 0.5f * variance);
}
