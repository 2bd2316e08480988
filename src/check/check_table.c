/* SPDX-License-Identifier: Apache-2.0 */
#include "check/check_table.h"

#include "atmosphere/stars.h"
#include "core/alloc.h"
#include "core/csv.h"
#include "optics/phase_table.h"
#include "scene/cloud_places.h"

typedef np_finding_draft draft;

/* ---- Kinds ---- */

static neph_result check_phase_table(neph_context *context, const char *path) {
  np_phase_table table;
  const neph_result result = np_phase_table_load(context, path, &table);
  if (!result) np_phase_table_clear(&table);
  return result;
}

static neph_result check_places(neph_context *context, const char *path) {
  char *copy = np_alloc_text(context, path), name[] = "of any name";
  np_scene_cloud cloud = {.name = name, .places = copy};
  const neph_result result = copy ? np_cloud_places_read(context, &cloud) : NEPH_ERROR_OUT_OF_MEMORY;
  np_cloud_places_clear(context, &cloud);
  np_alloc_free(context, copy);
  return result;
}

static neph_result check_stars(neph_context *context, const char *path) {
  static const double faintest = 40.0;
  np_star_catalogue stars;
  const neph_result result = np_star_catalogue_load(context, path, faintest, &stars);
  if (!result) np_star_catalogue_clear(&stars);
  return result;
}

static neph_result check_motion(neph_context *context, const char *path) {
  neph_scene *scene;
  neph_result result = neph_scene_create(context, &scene);
  if (result) return result;
  result = neph_scene_set(scene, "camera.motion.file", path);
  if (!result) result = neph_scene_set_frame(scene, 1);
  neph_scene_destroy(scene);
  return result;
}

/* Kinds of tables, identified by a column of their own. */
static const struct {
  const char *column;
  neph_result (*check)(neph_context *context, const char *path);
} tables[] = {{"value", check_phase_table}, {"x_m", check_places}, {"frame", check_motion},
              {"v_mag", check_stars},       {"Vmag", check_stars}, {"V", check_stars}};

enum { TABLES = sizeof tables / sizeof *tables };

static size_t search_table(const np_csv *csv) {
  size_t kind = 0;
  while (kind < TABLES && np_csv_search_column(csv, tables[kind].column) == NP_CSV_NO_COLUMN) kind++;
  return kind;
}

neph_result np_check_table(neph_check *check, const char *path) {
  static const np_rule unknown = {"table.kind", NEPH_SEVERITY_WARNING, NULL};
  np_csv csv;
  draft out = {{0}, {0}};
  neph_result result = neph_check_set_file(check, path);
  if (!result) result = np_csv_load(check->context, path, &csv);
  if (result) return np_check_pass(result);
  const size_t kind = search_table(&csv);
  if (kind == TABLES && np_draft_set(&out,
                                     "its columns, %s, are those of no phase function (angle_deg or cosine, "
                                     "value), places (x_m, y_m, z_m), camera (frame, x, y, z) or star catalogue "
                                     "(ra_deg, dec_deg, v_mag)",
                                     csv.header.text))
    np_check_add(check, &unknown, &out);
  np_csv_clear(&csv);
  return kind < TABLES ? np_check_pass(tables[kind].check(check->context, path)) : NEPH_OK;
}

neph_result np_check_camera_table(neph_check *check, const char *path) {
  const neph_result result = neph_check_set_file(check, path);
  return np_check_pass(result ? result : check_motion(check->context, path));
}
