/* SPDX-License-Identifier: Apache-2.0 */
/* Probes: read cases as comma-separated values, and write results as comma-separated values. */
#include <nephos/probe.h>

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/units.h"
#include "probe/probe_run.h"
#include "probe/probe_slab.h"

typedef enum slab_column {
  COLUMN_QUANTITY,
  COLUMN_G,
  COLUMN_ALBEDO,
  COLUMN_TAU,
  COLUMN_MU0,
  COLUMN_MU_VIEW,
  COLUMN_PHI,
  COLUMN_COUNT
} slab_column;

static const char *const column_names[COLUMN_COUNT] = {"quantity", "g", "albedo", "tau", "mu0", "mu_view", "phi_deg"};
static const unsigned columns_needed = (1u << COLUMN_MU_VIEW) - 1; /* radiances need the other columns too */

/* Optical depth beyond which paths through weakly absorbing slabs take too long. */
static const double traceable_depth_max = 1e4;

typedef struct slab_row {
  np_slab_case case_;
  bool is_flux, is_answered;
  np_slab_query queries[2];
  np_slab_answer answers[2]; /* R and T, or L alone */
} slab_row;

typedef struct slab_probe {
  neph_context *context;
  neph_probe_desc desc;
  np_csv csv;
  int columns[COLUMN_COUNT];
  slab_row *rows;
  np_slab *slab; /* the slab of the last row that was answered; NULL: none */
  np_monitor monitor;
} slab_probe;

/* ---- Cases ---- */

static const char *get_text(const slab_probe *p, size_t row, slab_column c) {
  return np_csv_get_field(&p->csv, row, p->columns[c]);
}

static neph_result get_real(const slab_probe *p, size_t row, slab_column c, double min, double max, double *out) {
  if (p->columns[c] == NP_CSV_NO_COLUMN)
    return np_fail(p->context, NEPH_ERROR_BAD_SCENE, "%s:%u: there is no column %s, which a radiance needs",
                   p->csv.path, p->csv.header.line, column_names[c]);
  return np_csv_get_real(&p->csv, row, p->columns[c], min, max, out);
}

static neph_result read_case(const slab_probe *p, size_t row, np_slab_case *out) {
  neph_result result = get_real(p, row, COLUMN_G, -0.999999, 0.999999, &out->asymmetry);
  if (!result) result = get_real(p, row, COLUMN_ALBEDO, 0.0, 1.0, &out->albedo);
  if (!result) result = get_real(p, row, COLUMN_TAU, 0.0, 1e7, &out->depth);
  out->is_diffuse = strcmp(get_text(p, row, COLUMN_MU0), "diffuse") == 0;
  return result || out->is_diffuse ? result : get_real(p, row, COLUMN_MU0, 1e-4, 1.0, &out->mu0);
}

static neph_result read_direction(const slab_probe *p, size_t row, bool is_top, np_slab_query *out) {
  double mu = 0.0, phi_deg = 0.0;
  neph_result result = get_real(p, row, COLUMN_MU_VIEW, is_top ? 1e-4 : -1.0, is_top ? 1.0 : -1e-4, &mu);
  if (!result) result = get_real(p, row, COLUMN_PHI, -360.0, 360.0, &phi_deg);
  *out = (np_slab_query){.is_top = is_top, .mu_view = fabs(mu), .phi_rad = phi_deg * NP_DEGREE};
  return result;
}

static neph_result read_row(const slab_probe *p, size_t row, slab_row *out) {
  const char *quantity = get_text(p, row, COLUMN_QUANTITY);
  const bool is_top = strcmp(quantity, "radiance_top_up") == 0;
  out->is_flux = strcmp(quantity, "flux") == 0;
  if (!out->is_flux && !is_top && strcmp(quantity, "radiance_bottom_down") != 0)
    return np_fail(p->context, NEPH_ERROR_BAD_SCENE,
                   "%s:%u: quantity is '%s', must be flux, radiance_top_up or radiance_bottom_down", p->csv.path,
                   p->csv.rows[row].line, quantity);
  neph_result result = read_case(p, row, &out->case_);
  if (result || !out->is_flux) return result ? result : read_direction(p, row, is_top, &out->queries[0]);
  out->queries[0] = (np_slab_query){.is_flux = true, .is_top = true};
  out->queries[1] = (np_slab_query){.is_flux = true, .is_top = false};
  return NEPH_OK;
}

static neph_result read_rows(void *slabs) {
  slab_probe *p = slabs;
  p->rows = np_alloc(p->context, p->csv.row_count, sizeof *p->rows);
  neph_result result = p->rows ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_csv_search_columns(&p->csv, column_names, COLUMN_COUNT, columns_needed, p->columns);
  for (size_t i = 0; !result && i < p->csv.row_count; i++) result = read_row(p, i, &p->rows[i]);
  return result;
}

/* ---- Answers ---- */

static void warn_of_unknown_error(const slab_probe *p, size_t row, int query) {
  const slab_row *r = &p->rows[row];
  const np_slab_answer *answer = &r->answers[query];
  if (isfinite(answer->error)) return;
  np_log(p->context, NEPH_LOG_WARNING,
         "%s:%u: %s rests on %.2g paths, must rest on %g or more for its error to be known, which is given as inf: "
         "take more paths%s",
         p->csv.path, p->csv.rows[row].line,
         !r->is_flux  ? "L"
         : query == 0 ? "R"
                      : "T",
         answer->contributions, NP_SLAB_CONTRIBUTIONS_MIN,
         p->desc.path_guiding == NEPH_PATH_GUIDING_NONE ? ", or guide them" : "");
}

static neph_result ask(slab_probe *p, size_t row, np_slab *slab, int query) {
  slab_row *r = &p->rows[row];
  neph_result result =
      np_slab_ask(slab, &r->queries[query], (uint32_t)(2 * row) + (uint32_t)query, &p->monitor, &r->answers[query]);
  if (!result) warn_of_unknown_error(p, row, query);
  return result;
}

static bool is_same_case(const np_slab_case *a, const np_slab_case *b) {
  return a->asymmetry == b->asymmetry && a->albedo == b->albedo && a->depth == b->depth &&
         a->is_diffuse == b->is_diffuse && a->mu0 == b->mu0;
}

/* Reuses the slab of the previous row if its case is the same. */
static neph_result prepare_slab(slab_probe *p, size_t row) {
  if (p->slab && is_same_case(&p->rows[row].case_, &p->rows[row - 1].case_)) return NEPH_OK;
  np_slab_destroy(p->slab);
  return np_slab_create(p->context, &p->rows[row].case_, &p->desc, &p->slab);
}

static neph_result answer_row(slab_probe *p, size_t row) {
  slab_row *r = &p->rows[row];
  if (p->desc.integrator == NEPH_INTEGRATOR_PATH && r->case_.depth > traceable_depth_max) {
    np_log(p->context, NEPH_LOG_WARNING, "%s:%u: tau is %g, and path goes up to %g: left empty", p->csv.path,
           p->csv.rows[row].line, r->case_.depth, traceable_depth_max);
    return NEPH_OK;
  }
  neph_result result = prepare_slab(p, row);
  if (!result) result = ask(p, row, p->slab, 0);
  if (!result && r->is_flux) result = ask(p, row, p->slab, 1);
  r->is_answered = !result;
  return result;
}

static neph_result answer_rows(void *slabs) {
  slab_probe *p = slabs;
  np_monitor_set_stage(&p->monitor, "probing slabs");
  const double count = (double)p->csv.row_count;
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < p->csv.row_count; i++) {
    np_monitor_set_range(&p->monitor, (double)i / count, (double)(i + 1) / count);
    result = answer_row(p, i);
  }
  np_slab_destroy(p->slab);
  p->slab = NULL;
  return result;
}

/* ---- Output ---- */

static void print_answer(FILE *out, bool has_value, double value) {
  if (has_value)
    fprintf(out, ",%.12g", value);
  else
    fputc(',', out);
}

static void print_row(FILE *out, const np_csv_row *text, const slab_row *row, bool has_flux, bool has_radiance) {
  const np_slab_answer *a = row->answers;
  const bool is_flux = row->is_answered && row->is_flux, is_radiance = row->is_answered && !row->is_flux;
  fputs(text->text, out);
  for (int i = 0; i < 2 && has_flux; i++) print_answer(out, is_flux, a[i].value);
  for (int i = 0; i < 2 && has_flux; i++) print_answer(out, is_flux, a[i].error);
  if (has_radiance) print_answer(out, is_radiance, a[0].value);
  if (has_radiance) print_answer(out, is_radiance, a[0].error);
  fputc('\n', out);
}

static void print_rows(FILE *out, const void *user) {
  const slab_probe *p = user;
  bool has_flux = false, has_radiance = false;
  for (size_t i = 0; i < p->csv.row_count; i++) {
    has_flux = has_flux || p->rows[i].is_flux;
    has_radiance = has_radiance || !p->rows[i].is_flux;
  }
  fprintf(out, "%s%s%s\n", p->csv.header.text, has_flux ? ",R_out,T_out,R_se,T_se" : "",
          has_radiance ? ",L_out,L_se" : "");
  for (size_t i = 0; i < p->csv.row_count; i++) print_row(out, &p->csv.rows[i], &p->rows[i], has_flux, has_radiance);
}

static const np_probe_kind slab_kind = {read_rows, answer_rows, print_rows};

neph_result neph_probe_slab(neph_context *context, const char *cases_path, const neph_probe_desc *desc,
                            char **out_text) {
  if (NP_LACKS_OUT(context, out_text, cases_path)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_text = NULL;
  const neph_probe_desc defaults = NEPH_PROBE_DESC_DEFAULT;
  slab_probe p = {.context = context};
  neph_result result = np_desc_read(context, "neph_probe_desc", &defaults, sizeof defaults, desc, &p.desc);
  if (result) return result;
  if (p.desc.path_count < 1)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "probe: path_count is 0, must be at least 1");
  if (!(p.desc.target_error > 0.0))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "probe: target_error is %g, must be above 0",
                   p.desc.target_error);
  if ((unsigned)p.desc.path_guiding > NEPH_PATH_GUIDING_AUTO)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "probe: path_guiding is %d, must be none (0), adjoint (1) or auto (2)", (int)p.desc.path_guiding);
  np_monitor_start(&p.monitor, context, p.desc.progress, p.desc.progress_user);
  result = np_probe_run(context, cases_path, &slab_kind, &p, &p.csv, out_text);
  np_alloc_free(context, p.rows);
  return result;
}
