/* SPDX-License-Identifier: Apache-2.0 */
#include "export/export_fields.h"

#include <string.h>

#include "core/alloc.h"
#include "scene/cloud_file.h"
#include "volume/grid_reader.h"
#include "volume/volume_sizes.h"

/* Leaves that the tiles of a vector may become. */
enum { LEAVES_MAX = 1 << 20 };

/* ---- Scalars ---- */

/* gain·v + offset, where the grid ends too. */
static void change_values(np_sparse_grid *grid, float gain, float offset) {
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) grid->leaves[i].values[n] = gain * grid->leaves[i].values[n] + offset;
  for (size_t i = 0; i < grid->tile_count; i++) grid->tiles[i].value = gain * grid->tiles[i].value + offset;
  grid->background = gain * grid->background + offset;
}

static neph_result rename_grid(np_sparse_grid *grid, const char *name) {
  char *copy = np_alloc_text(grid->context, name);
  if (!copy) return NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(grid->context, grid->name);
  grid->name = copy;
  return NEPH_OK;
}

typedef struct scalar_field {
  neph_export_fields kind;
  const char *required_by; /* key of the scene that requires the grid; NULL: it is optional */
  const char *key, *name;  /* name of the grid in the scene, and the conventional name under which it is written */
  double gain, offset;
} scalar_field;

static neph_result load_scalar(neph_context *context, const np_export_source *source, const scalar_field *wanted,
                               np_export_fields *out) {
  neph_volume_load_desc load = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  np_export_field *field = &out->list[out->count];
  bool has_content;
  load.grid = wanted->key ? wanted->key : wanted->name;
  load.policy = source->cloud->policy;
  load.model = source->cloud->model;
  if (np_scene_is_none(wanted->key)) return NEPH_OK;
  neph_result result =
      np_volume_load_field_grid(context, source->path, &load, wanted->required_by, &field->components[0], &has_content);
  field->component_count = 1;
  field->kind = wanted->kind;
  if (result || !has_content) {
    np_sparse_grid_clear(&field->components[0]);
    return result;
  }
  out->count++;
  np_sparse_grid *grid = &field->components[0];
  change_values(grid, (float)wanted->gain, (float)wanted->offset);
  grid->index_to_world = np_affine_compose(source->file_to_world, &grid->index_to_world);
  return rename_grid(grid, wanted->name);
}

/* ---- Vectors ---- */

typedef struct vector_field {
  neph_export_fields kind;
  np_vector_role role;
  const char *key, *name;
  double turn[3][3]; /* turns the file's components into the exported ones */
} vector_field;

/* Origins of all blocks of 8³ that a component holds, on the lattice of the first. */
static neph_result add_block(np_sparse_grid *to, const int32_t origin[3]) {
  if (to->leaf_count >= LEAVES_MAX)
    return np_fail(to->context, NEPH_ERROR_LIMIT,
                   "grid '%s' has tiles that fill more than %d blocks of 8³ voxels: set its key in clouds[] to none",
                   to->name, (int)LEAVES_MAX);
  return np_sparse_grid_add_leaf(to, origin) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result add_tile(np_sparse_grid *to, const np_tile *tile) {
  int32_t at[3];
  neph_result result = NEPH_OK;
  if (!tile->is_active) return NEPH_OK;
  for (at[0] = 0; at[0] < tile->edge && !result; at[0] += NP_LEAF_EDGE)
    for (at[1] = 0; at[1] < tile->edge && !result; at[1] += NP_LEAF_EDGE)
      for (at[2] = 0; at[2] < tile->edge && !result; at[2] += NP_LEAF_EDGE)
        result = add_block(
            to, (const int32_t[3]){tile->origin[0] + at[0], tile->origin[1] + at[1], tile->origin[2] + at[2]});
  return result;
}

static neph_result list_blocks(const np_sparse_grid components[3], np_sparse_grid *to) {
  neph_result result = NEPH_OK;
  for (int a = 0; a < 3; a++) {
    for (size_t i = 0; i < components[a].leaf_count && !result; i++)
      result = add_block(to, components[a].leaves[i].origin);
    for (size_t i = 0; i < components[a].tile_count && !result; i++) result = add_tile(to, &components[a].tiles[i]);
  }
  np_sparse_grid_sort(to);
  size_t count = 0;
  for (size_t i = 0; i < to->leaf_count; i++)
    if (!count || np_grid_compare(to->leaves[count - 1].origin, to->leaves[i].origin) != 0)
      to->leaves[count++] = to->leaves[i];
  to->leaf_count = count;
  return result;
}

typedef struct vector_readers {
  np_grid_reader at[3];
  np_affine to_index[3]; /* the first component's lattice to each component's */
} vector_readers;

static neph_result start_readers(const np_sparse_grid components[3], vector_readers *out) {
  for (int a = 0; a < 3; a++) {
    np_affine inverse;
    if (!np_affine_invert(&components[a].index_to_world, &inverse))
      return np_fail(components[a].context, NEPH_ERROR_BAD_FILE, "%s%sgrid '%s': its transform cannot be inverted",
                     NP_SPARSE_GRID_LABEL(&components[a]));
    out->at[a] = (np_grid_reader){.grid = &components[a]};
    out->to_index[a] = np_affine_compose(&inverse, &components[0].index_to_world);
  }
  return NEPH_OK;
}

/* Active where any component is. */
static void fill_voxel(vector_readers *readers, const vector_field *wanted, np_sparse_grid out[3], size_t leaf, int n) {
  const int32_t *o = out[0].leaves[leaf].origin;
  const np_dvec3 index = np_dvec3_make(o[0] + (n >> 6), o[1] + (n >> 3 & 7), o[2] + (n & 7));
  float own[3];
  bool is_active = false;
  for (int a = 0; a < 3; a++)
    is_active =
        np_grid_read_between(&readers->at[a], np_affine_point(&readers->to_index[a], index), &own[a]) || is_active;
  for (int a = 0; a < 3; a++) {
    double sum = 0.0;
    for (int b = 0; b < 3; b++) sum += wanted->turn[a][b] * (double)own[b];
    out[a].leaves[leaf].values[n] = (float)sum;
    if (is_active) out[a].leaves[leaf].active[n >> 6] |= UINT64_C(1) << (n & 63);
  }
}

static neph_result fill_vector(const vector_field *wanted, const np_sparse_grid components[3], np_sparse_grid out[3]) {
  vector_readers readers;
  neph_result result = start_readers(components, &readers);
  if (!result) result = list_blocks(components, &out[0]);
  for (int a = 1; a < 3 && !result; a++)
    for (size_t i = 0; i < out[0].leaf_count && !result; i++) result = add_block(&out[a], out[0].leaves[i].origin);
  for (size_t i = 0; i < out[0].leaf_count && !result; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) fill_voxel(&readers, wanted, out, i, n);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) out[a].background += (float)wanted->turn[a][b] * components[b].background;
  return result;
}

static neph_result load_vector(neph_context *context, const np_export_source *source, const vector_field *wanted,
                               np_export_fields *out) {
  const np_vector_request request = {wanted->role, wanted->key, source->cloud->policy};
  np_sparse_grid read[3];
  bool is_found;
  if (np_scene_is_none(wanted->key)) return NEPH_OK;
  neph_result result = np_volume_load_vector(context, source->path, &request, source->monitor, read, &is_found);
  if (!result && is_found) {
    np_export_field *field = &out->list[out->count++];
    field->kind = wanted->kind;
    field->component_count = 3;
    for (int a = 0; a < 3 && !result; a++) {
      result = np_sparse_grid_init(context, wanted->name, &field->components[a]);
      field->components[a].index_to_world = np_affine_compose(source->file_to_world, &read[0].index_to_world);
    }
    if (!result) result = fill_vector(wanted, read, field->components);
  }
  for (int a = 0; a < 3; a++) np_sparse_grid_clear(&read[a]);
  return result;
}

/* ---- All ---- */

/* Velocities turn and grow with the cloud. */
static neph_result load_velocity(neph_context *context, const np_export_source *source, np_export_fields *out) {
  vector_field wanted = {NEPH_EXPORT_VELOCITY, NP_VECTOR_VELOCITY, source->cloud->velocity, "vel", {{0.0}}};
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) wanted.turn[a][b] = source->cloud->velocity_scale * source->file_to_world->m[a][b];
  return load_vector(context, source, &wanted, out);
}

static neph_result load_color(neph_context *context, const np_export_source *source, np_export_fields *out) {
  const vector_field wanted = {NEPH_EXPORT_COLOR,
                               NP_VECTOR_COLOR,
                               source->cloud->color,
                               "Cd",
                               {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  return load_vector(context, source, &wanted, out);
}

static neph_result load_sizes(neph_context *context, const np_export_source *source, np_export_fields *out) {
  const char *name = source->cloud->sizes;
  const scalar_field wanted = {NEPH_EXPORT_SIZES, name ? NP_SIZES_KEY : NULL, name, NP_SIZES_USUAL_NAME, 1.0, 0.0};
  return np_scene_cloud_has_sizes(source->cloud) ? load_scalar(context, source, &wanted, out) : NEPH_OK;
}

/* Temperatures in kelvin, which must be there without emitted light; flames by their absorption, in 1/m, times their
 * strength; light in W m⁻³ sr⁻¹ nm⁻¹. */
static neph_result load_emission(neph_context *context, const np_export_source *source, np_export_fields *out) {
  const np_scene_emission *e = &source->cloud->emission;
  const scalar_field flame = {NEPH_EXPORT_FLAME, e->flame ? NP_FLAME_KEY : NULL,    e->flame,
                              "flame",           e->absorption_per_m * e->strength, 0.0};
  const double s = e->strength;
  const vector_field light = {
      NEPH_EXPORT_LIGHT, NP_VECTOR_EMISSION, e->color, "Ce", {{s, 0.0, 0.0}, {0.0, s, 0.0}, {0.0, 0.0, s}}};
  const unsigned count = out->count;
  if (!e->is_enabled) return NEPH_OK;
  neph_result result = load_vector(context, source, &light, out);
  const bool is_required = e->temperature || out->count == count;
  const scalar_field temperature = {NEPH_EXPORT_TEMPERATURE, is_required ? NP_TEMPERATURE_KEY : NULL,
                                    e->temperature,          "temperature",
                                    e->kelvin_per_value,     e->offset_k};
  if (!result) result = load_scalar(context, source, &temperature, out);
  return result ? result : load_scalar(context, source, &flame, out);
}

neph_result np_export_fields_load(neph_context *context, const np_export_source *source, np_export_fields *out) {
  *out = (np_export_fields){.count = 0};
  neph_result result = load_velocity(context, source, out);
  if (!result) result = load_color(context, source, out);
  if (!result) result = load_sizes(context, source, out);
  return result ? result : load_emission(context, source, out);
}

void np_export_fields_clear(np_export_fields *fields) {
  for (unsigned i = 0; i < fields->count; i++)
    for (unsigned c = 0; c < fields->list[i].component_count; c++) np_sparse_grid_clear(&fields->list[i].components[c]);
  fields->count = 0;
}

size_t np_export_fields_list(const np_export_fields *fields, bool is_half, np_vdb_write_grid *out) {
  static const np_vdb_attribute units[] = {{.name = "units", .text = "m/s"},
                                           {.name = "units", .text = "W m-3 sr-1 nm-1"},
                                           {.name = "units", .text = "K"},
                                           {.name = "units", .text = "1/m"},
                                           {.name = "units", .text = "um"}};
  for (unsigned i = 0; i < fields->count; i++) {
    const np_export_field *field = &fields->list[i];
    const bool is_vector = field->component_count == 3;
    const np_vdb_attribute *unit = field->kind == NEPH_EXPORT_VELOCITY      ? &units[0]
                                   : field->kind == NEPH_EXPORT_LIGHT       ? &units[1]
                                   : field->kind == NEPH_EXPORT_TEMPERATURE ? &units[2]
                                   : field->kind == NEPH_EXPORT_FLAME       ? &units[3]
                                   : field->kind == NEPH_EXPORT_SIZES       ? &units[4]
                                                                            : NULL;
    out[i] = (np_vdb_write_grid){.grid = &field->components[0],
                                 .is_half = is_half,
                                 .attributes = unit,
                                 .attribute_count = unit != NULL,
                                 .y = is_vector ? &field->components[1] : NULL,
                                 .z = is_vector ? &field->components[2] : NULL,
                                 .is_invariant = field->kind != NEPH_EXPORT_VELOCITY};
  }
  return fields->count;
}

unsigned np_export_fields_get_kinds(const np_export_fields *fields) {
  unsigned kinds = 0;
  for (unsigned i = 0; i < fields->count; i++) kinds |= (unsigned)fields->list[i].kind;
  return kinds;
}
