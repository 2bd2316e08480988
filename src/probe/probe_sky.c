/* SPDX-License-Identifier: Apache-2.0 */
/* Skies by three methods, read and written as comma-separated values. */
#include <nephos/probe.h>

#include <string.h>

#include "atmosphere/sky_query.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/path_map.h"
#include "probe/probe_run.h"
#include "scene/scene_private.h"

typedef enum sky_column {
  COLUMN_QUANTITY,
  COLUMN_EARTH,
  COLUMN_MAX_ORDER,
  COLUMN_ALTITUDE,
  COLUMN_COSINE,
  COLUMN_SUN,
  COLUMN_VIEW,
  COLUMN_AZIMUTH,
  COLUMN_DISTANCE,
  COLUMN_COUNT
} sky_column;

static const char *const column_names[COLUMN_COUNT] = {
    "quantity",       "earth",           "max_order",       "h_km",       "mu",
    "sun_zenith_deg", "view_zenith_deg", "rel_azimuth_deg", "distance_km"};
static const unsigned columns_needed = 1u << COLUMN_QUANTITY | 1u << COLUMN_EARTH | 1u << COLUMN_ALTITUDE;

static const struct {
  const char *name;
  unsigned columns; /* columns that must hold a number, by 1 << column */
} quantities[NP_SKY_QUANTITY_COUNT] = {
    [NP_SKY_TRANSMITTANCE_TOP] = {"transmittance_top", 1 << COLUMN_COSINE},
    [NP_SKY_SINGLE_SCATTER_RADIANCE] = {"single_scatter_radiance",
                                        1 << COLUMN_SUN | 1 << COLUMN_VIEW | 1 << COLUMN_AZIMUTH},
    [NP_SKY_RADIANCE] = {"sky_radiance", 1 << COLUMN_SUN | 1 << COLUMN_VIEW | 1 << COLUMN_AZIMUTH},
    [NP_SKY_IRRADIANCE] = {"sky_irradiance", 1 << COLUMN_SUN},
    [NP_SKY_DIRECT_IRRADIANCE] = {"direct_irradiance", 1 << COLUMN_SUN},
    [NP_SKY_AP_INSCATTER] = {"ap_inscatter",
                             1 << COLUMN_SUN | 1 << COLUMN_VIEW | 1 << COLUMN_AZIMUTH | 1 << COLUMN_DISTANCE},
    [NP_SKY_AP_TRANSMITTANCE] = {"ap_transmittance", 1 << COLUMN_VIEW | 1 << COLUMN_DISTANCE},
};

/* ---- Earths ---- */

typedef struct earth {
  const char *name;
  np_reference_light light;
  double sun_angular_radius_rad, irradiance_w_m2_nm[3];
  neph_atmosphere_desc medium;
  neph_atmosphere_layer layers[NEPH_EARTH_LAYER_COUNT]; /* layers of a medium other than the Earth's */
} earth;

/* Media: two of published models, the presets, and scenes that cases name. */
enum { NAMED_COUNT = 5, EARTHS_MAX = 32 };

/* The Earth of Bruneton's 2017 implementation (its reference/model_test.cc): 60 km of air, a darker ground. */
static void describe_bruneton(earth *out) {
  const double rayleigh[3] = {5.802339382e-6, 13.55776245e-6, 33.10000598e-6};
  const double ozone[3] = {0.6497166e-6, 1.8809e-6, 0.08501668e-6};
  memcpy(out->layers[0].scattering_per_m, rayleigh, sizeof rayleigh);
  memcpy(out->layers[2].absorption_per_m, ozone, sizeof ozone);
  out->medium.top_altitude_m = 60e3;
  for (int b = 0; b < 3; b++) out->medium.ground_albedo[b] = 0.1;
}

/* Fills the two published media, in whose tables the sun is a point that fades at the horizon. */
static neph_result describe_earths(neph_context *context, earth out[NAMED_COUNT]) {
  static const char *const presets[] = {"earth", "earth", "earth", "earth-hazy", "mars"};
  const neph_sky_desc sun = NEPH_SKY_DESC_DEFAULT;
  for (int i = 0; i < NAMED_COUNT; i++) {
    double distance_au;
    out[i].medium = (neph_atmosphere_desc)NEPH_ATMOSPHERE_DESC_DEFAULT;
    neph_result result = neph_atmosphere_get_preset(context, presets[i], &out[i].medium, &distance_au);
    if (result) return result;
    out[i].name = presets[i];
    out[i].light = i < 2 ? NP_REFERENCE_POINT : NP_REFERENCE_DISK;
    out[i].sun_angular_radius_rad = sun.sun_angular_radius_rad / distance_au;
    for (int b = 0; b < 3; b++)
      out[i].irradiance_w_m2_nm[b] = i == 1 ? 1.0 : sun.sun_irradiance_w_m2_nm[b] / (distance_au * distance_au);
  }
  for (int i = 0; i < 2; i++) {
    memcpy(out[i].layers, neph_earth_layers, sizeof out[i].layers);
    out[i].layers[1].phase = NEPH_PHASE_CORNETTE_SHANKS;
    out[i].medium.layers = out[i].layers;
  }
  out[0].name = "bruneton";
  out[1].name = "hillaire";
  out[1].sun_angular_radius_rad = 0.004675;
  describe_bruneton(&out[0]);
  return NEPH_OK;
}

/* The air and the sun of a scene. */
static void describe_scene(const neph_scene *scene, const char *name, earth *out) {
  *out = (earth){.name = name, .light = NP_REFERENCE_DISK, .medium = scene->atmosphere};
  out->sun_angular_radius_rad = scene->sun.angular_radius_rad;
  memcpy(out->irradiance_w_m2_nm, scene->sun.irradiance_w_m2_nm, sizeof out->irradiance_w_m2_nm);
}

/* ---- Cases ---- */

typedef struct sky_row {
  int earth;
  np_sky_query query;
  np_reference_value answer;
} sky_row;

typedef struct sky_probe {
  neph_context *context;
  neph_probe_sky_desc desc;
  np_csv csv;
  int columns[COLUMN_COUNT];
  int earth_count, scene_count;
  earth earths[EARTHS_MAX];
  neph_scene *scenes[EARTHS_MAX];
  sky_row *rows;
  np_sky_subject subject; /* atmosphere and sky for `subject_earth` and `subject_orders` */
  int subject_earth;
  unsigned subject_orders;
  np_monitor monitor;
} sky_probe;

static const char *get_text(const sky_probe *p, size_t row, sky_column c) {
  return np_csv_get_field(&p->csv, row, p->columns[c]);
}

/* A number that the quantity may do without: 0 then. */
static neph_result get_real(const sky_probe *p, size_t row, unsigned needed, sky_column c, double min, double max,
                            double *out) {
  *out = 0.0;
  if (!(needed & 1u << c)) return NEPH_OK;
  if (p->columns[c] == NP_CSV_NO_COLUMN)
    return np_fail(p->context, NEPH_ERROR_BAD_SCENE, "%s:%u: there is no column %s, which %s needs", p->csv.path,
                   p->csv.rows[row].line, column_names[c], get_text(p, row, COLUMN_QUANTITY));
  return np_csv_get_real(&p->csv, row, p->columns[c], min, max, out);
}

static neph_result read_quantity(const sky_probe *p, size_t row, np_sky_quantity *out) {
  const char *text = get_text(p, row, COLUMN_QUANTITY);
  for (int i = 0; i < NP_SKY_QUANTITY_COUNT; i++)
    if (strcmp(text, quantities[i].name) == 0) return *out = (np_sky_quantity)i, NEPH_OK;
  return np_fail(p->context, NEPH_ERROR_BAD_SCENE,
                 "%s:%u: quantity is '%s', must be transmittance_top, single_scatter_radiance, sky_radiance, "
                 "sky_irradiance, direct_irradiance, ap_inscatter or ap_transmittance",
                 p->csv.path, p->csv.rows[row].line, text);
}

/* Adds the air of a scene file, whose path is relative to the folder of the cases. */
static neph_result load_earth(sky_probe *p, size_t row, const char *name) {
  if (p->earth_count == EARTHS_MAX)
    return np_fail(p->context, NEPH_ERROR_BAD_SCENE,
                   "%s:%u: the cases name more than %d scenes, must be at most that many", p->csv.path,
                   p->csv.rows[row].line, EARTHS_MAX - NAMED_COUNT);
  char *path, *problem;
  neph_scene *scene;
  neph_result result = np_path_map_resolve(p->context, p->csv.path, name, &path, &problem);
  if (problem)
    np_fail(p->context, result, "%s:%u: earth is '%s': %s", p->csv.path, p->csv.rows[row].line, name, problem);
  if (!result) result = neph_scene_load(p->context, path, &scene);
  np_alloc_free(p->context, problem);
  np_alloc_free(p->context, path);
  if (result) return result;
  p->scenes[p->scene_count++] = scene;
  describe_scene(scene, name, &p->earths[p->earth_count++]);
  return NEPH_OK;
}

static neph_result read_earth(sky_probe *p, size_t row, int *out) {
  const char *text = get_text(p, row, COLUMN_EARTH), *dot = strrchr(text, '.');
  for (int i = 0; i < p->earth_count; i++)
    if (strcmp(text, p->earths[i].name) == 0) return *out = i, NEPH_OK;
  *out = p->earth_count;
  if (dot && strcmp(dot, ".yaml") == 0) return load_earth(p, row, text);
  return np_fail(p->context, NEPH_ERROR_BAD_SCENE,
                 "%s:%u: earth is '%s', must be bruneton, hillaire, earth, earth-hazy, mars or a scene, NAME.yaml",
                 p->csv.path, p->csv.rows[row].line, text);
}

static neph_result read_order(const sky_probe *p, size_t row, np_sky_query *q) {
  q->order_max = q->quantity == NP_SKY_SINGLE_SCATTER_RADIANCE ? 1 : NP_ORDERS_ALL;
  if (q->quantity == NP_SKY_SINGLE_SCATTER_RADIANCE || !*get_text(p, row, COLUMN_MAX_ORDER)) return NEPH_OK;
  double order;
  neph_result result = np_csv_get_real(&p->csv, row, p->columns[COLUMN_MAX_ORDER], 0.0, 1000.0, &order);
  if (!result && order != floor(order))
    result = np_fail(p->context, NEPH_ERROR_BAD_SCENE, "%s:%u: max_order is %g, must be a whole number or empty",
                     p->csv.path, p->csv.rows[row].line, order);
  q->order_max = (unsigned)order;
  return result;
}

static neph_result read_row(sky_probe *p, size_t row, sky_row *out) {
  np_sky_query *q = &out->query;
  double altitude_km = 0.0, sun_deg = 0.0, view_deg = 0.0, azimuth_deg = 0.0, distance_km = 0.0;
  neph_result result = read_quantity(p, row, &q->quantity);
  if (!result) result = read_earth(p, row, &out->earth);
  if (!result) result = read_order(p, row, q);
  const unsigned needed = quantities[q->quantity].columns;
  if (!result) result = get_real(p, row, 1u << COLUMN_ALTITUDE, COLUMN_ALTITUDE, 0.0, 1e6, &altitude_km);
  if (!result) result = get_real(p, row, needed, COLUMN_COSINE, -1.0, 1.0, &q->view_cosine);
  if (!result) result = get_real(p, row, needed, COLUMN_SUN, 0.0, 180.0, &sun_deg);
  if (!result) result = get_real(p, row, needed, COLUMN_VIEW, 0.0, 180.0, &view_deg);
  if (!result) result = get_real(p, row, needed, COLUMN_AZIMUTH, -360.0, 360.0, &azimuth_deg);
  if (!result) result = get_real(p, row, needed, COLUMN_DISTANCE, 0.0, 1e7, &distance_km);
  q->altitude_m = altitude_km * NP_KILOMETRE;
  q->distance_m = distance_km * NP_KILOMETRE;
  q->sun_zenith_rad = sun_deg * NP_DEGREE;
  q->view_zenith_rad = view_deg * NP_DEGREE;
  q->azimuth_rad = azimuth_deg * NP_DEGREE;
  return result;
}

static neph_result read_rows(void *skies) {
  sky_probe *p = skies;
  p->rows = np_alloc(p->context, p->csv.row_count, sizeof *p->rows);
  neph_result result = p->rows ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_csv_search_columns(&p->csv, column_names, COLUMN_COUNT, columns_needed, p->columns);
  for (size_t i = 0; !result && i < p->csv.row_count; i++) result = read_row(p, i, &p->rows[i]);
  return result;
}

/* ---- Evaluation ---- */

static void clear_subject(sky_probe *p) {
  np_sky_subject_clear(&p->subject);
  neph_atmosphere_release(p->subject.atmosphere);
  p->subject.atmosphere = NULL;
}

/* A subject that has the tables for the query; the last one's are reused where they suffice. Queries that need no
 * tables of scattered light take those of order 1, which take the least time. */
static neph_result prepare_subject(sky_probe *p, const sky_row *row) {
  const bool has_tables = p->desc.method != NEPH_SKY_METHOD_TRACE && np_sky_quantity_is_scattered(row->query.quantity);
  const unsigned orders = has_tables && row->query.order_max > 1 ? row->query.order_max : 1;
  if (p->subject.atmosphere && p->subject_earth == row->earth && p->subject_orders == orders) return NEPH_OK;
  clear_subject(p);
  const earth *e = &p->earths[row->earth];
  p->subject = (np_sky_subject){.light = e->light,
                                .sun_angular_radius_rad = e->sun_angular_radius_rad,
                                .method = (np_sky_method)p->desc.method,
                                .paths = p->desc.path_count};
  memcpy(p->subject.irradiance_w_m2_nm, e->irradiance_w_m2_nm, sizeof p->subject.irradiance_w_m2_nm);
  p->subject_earth = row->earth;
  p->subject_orders = orders;
  return np_atmosphere_create_orders(p->context, &e->medium, orders, e->light == NP_REFERENCE_POINT, &p->monitor,
                                     &p->subject.atmosphere);
}

static neph_result eval_rows(void *skies) {
  sky_probe *p = skies;
  np_monitor_set_stage(&p->monitor, "probing skies");
  const double count = (double)p->csv.row_count;
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < p->csv.row_count; i++) {
    np_monitor_set_part(&p->monitor, np_monitor_whole, (double)i / count, (double)(i + 1) / count);
    sky_row *row = &p->rows[i];
    result = prepare_subject(p, row);
    if (!result) result = np_sky_query_eval(&p->subject, &row->query, p->desc.seed + i, &p->monitor, &row->answer);
    if (!result && np_monitor_is_cancelled(&p->monitor)) result = NEPH_ERROR_CANCELLED;
  }
  clear_subject(p);
  return result;
}

/* ---- Output ---- */

static void print_rows(FILE *out, const void *user) {
  const sky_probe *p = user;
  fprintf(out, "%s,r,g,b,r_se,g_se,b_se\n", p->csv.header.text);
  for (size_t i = 0; i < p->csv.row_count; i++) {
    const np_reference_value *a = &p->rows[i].answer;
    fputs(p->csv.rows[i].text, out);
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) fprintf(out, ",%.9g", a->mean[b]);
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) fprintf(out, ",%.3g", a->error[b]);
    fputc('\n', out);
  }
}

static const np_probe_kind sky_kind = {read_rows, eval_rows, print_rows};

neph_result neph_probe_sky(neph_context *context, const char *cases_path, const neph_probe_sky_desc *desc,
                           char **out_text) {
  if (NP_LACKS_OUT(context, out_text, cases_path)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_text = NULL;
  const neph_probe_sky_desc defaults = NEPH_PROBE_SKY_DESC_DEFAULT;
  sky_probe p = {.context = context};
  neph_result result = np_desc_read(context, "neph_probe_sky_desc", &defaults, sizeof defaults, desc, &p.desc);
  if (result) return result;
  if ((unsigned)p.desc.method > NEPH_SKY_METHOD_TRACE)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "probe: method is %d, must be one of neph_sky_method",
                   (int)p.desc.method);
  if (p.desc.path_count < 1)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "probe: path_count is 0, must be at least 1");
  result = describe_earths(context, p.earths);
  if (result) return result;
  p.earth_count = NAMED_COUNT;
  np_monitor_start(&p.monitor, context, p.desc.progress, p.desc.progress_user);
  result = np_probe_run(context, cases_path, &sky_kind, &p, &p.csv, out_text);
  for (int i = 0; i < p.scene_count; i++) neph_scene_destroy(p.scenes[i]);
  np_alloc_free(context, p.rows);
  return result;
}
