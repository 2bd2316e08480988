/* SPDX-License-Identifier: Apache-2.0 */
/* Signed distances to closed surfaces: meshes from files, and bodies below a height map.
 *
 * The distance is to the nearest triangle, and negative where the winding number exceeds ½, which closes small holes.
 * For a surface without open edges the sign changes only near the surface, so that the number is computed there alone.
 * With open edges it is computed at each node: the share of nodes where it is far from any integer measures how open
 * the surface is. */
#include "cloud/shape_mesh.h"

#include <math.h>

#include "cloud/weather_picture.h"
#include "core/alloc.h"
#include "core/math.h"
#include "mesh/mesh_format.h"

static const float side_room = 0.75f,
                   top_room = 0.45f; /* room for billows around a mesh that fills its field, in billows */
static const double open_share =
    0.03; /* largest share of the inside with an undefined winding number; more is refused */
static const size_t triangles_max = (size_t)4 << 20;

/* ---- Meshes ---- */

static void include_triangles(const np_mesh_tree *tree, float low_m[3], float high_m[3]) {
  for (int a = 0; a < 3; a++) low_m[a] = INFINITY, high_m[a] = -INFINITY;
  for (size_t i = 0; i < 3 * tree->triangle_count; i++) {
    const np_vec3 *p = &tree->triangles[i / 3].corners[i % 3];
    const float at_m[3] = {p->x, p->y, p->z};
    for (int a = 0; a < 3; a++) {
      low_m[a] = np_minf(low_m[a], at_m[a]);
      high_m[a] = np_maxf(high_m[a], at_m[a]);
    }
  }
}

static void move_triangles(np_mesh_tree *tree, float scale, const float by_m[3]) {
  for (size_t i = 0; i < 3 * tree->triangle_count; i++) {
    np_vec3 *p = &tree->triangles[i / 3].corners[i % 3];
    *p = np_vec3_make(p->x * scale + by_m[0], p->y * scale + by_m[1], p->z * scale + by_m[2]);
  }
}

/* Scale of a mesh that fills its field except for room for billows. */
static float compute_fit(const np_cloud_model *model, const float size_m[3]) {
  const neph_cloud_desc *desc = &model->desc;
  const float billow_m = model->thermals.billow_m;
  const float room_m[3] = {(float)desc->extent_m[0] - 2.0f * side_room * billow_m,
                           (float)desc->extent_m[1] - 2.0f * side_room * billow_m,
                           np_maxf((float)desc->thickness_m - top_room * billow_m, 0.5f * (float)desc->thickness_m)};
  float fit = INFINITY;
  for (int a = 0; a < 3; a++)
    if (size_m[a] > 0.0f) fit = np_minf(fit, room_m[a] / size_m[a]);
  return fit;
}

static void place_mesh(const np_cloud_model *model, np_mesh_tree *tree) {
  const neph_cloud_shape *shape = &model->desc.shape;
  float low_m[3], high_m[3], size_m[3], by_m[3];
  include_triangles(tree, low_m, high_m);
  for (int a = 0; a < 3; a++) size_m[a] = high_m[a] - low_m[a];
  const float scale = shape->has_mesh_unit ? 1.0f : compute_fit(model, size_m);
  for (int a = 0; a < 3; a++) {
    const float pivot_m = a < 2 ? 0.5f * (low_m[a] + high_m[a]) : low_m[a];
    by_m[a] = (float)shape->mesh_position_m[a] - scale * pivot_m;
  }
  move_triangles(tree, scale, by_m);
}

neph_result np_shape_load_mesh(const np_cloud_model *model, np_monitor *monitor, np_mesh_tree *out_tree) {
  const neph_cloud_shape *shape = &model->desc.shape;
  neph_context *context = model->map.context;
  np_mesh_file file;
  neph_result result = np_mesh_format_check(context, shape->mesh_file);
  if (!result)
    result = np_mesh_format_check_up(context, shape->mesh_file, shape->mesh_up, "clouds[].bake.shape.mesh.up");
  if (!result) result = np_mesh_file_load(context, shape->mesh_file, false, monitor, &file);
  if (result) return result;
  const np_affine turn = np_mesh_format_make_turn(
      shape->mesh_file, shape->mesh_up, shape->has_mesh_unit ? shape->mesh_unit_m : 1.0, shape->mesh_rotation_rad);
  result = np_mesh_tree_collect(&file, &turn, out_tree);
  np_mesh_file_clear(&file);
  if (!result && out_tree->triangle_count > triangles_max)
    result = np_fail(context, NEPH_ERROR_LIMIT, "%s: has %zu triangles, may have %zu as a cloud's shape: thin it out",
                     shape->mesh_file, out_tree->triangle_count, triangles_max);
  if (!result) place_mesh(model, out_tree);
  return result;
}

/* ---- Height maps ---- */

enum { CELLS_MAX = 320 /* along a side */ };

/* Tops at the corners of cells, with a border of 0 around the picture. */
typedef struct height_cells {
  int count[2];
  float step_m[2], bottom_m;
  float *tops_m;
} height_cells;

static float get_top(const height_cells *h, int i, int j) { return h->tops_m[j * (h->count[0] + 1) + i]; }

static bool is_active(const height_cells *h, int i, int j) {
  if (i < 0 || j < 0 || i >= h->count[0] || j >= h->count[1]) return false;
  return get_top(h, i, j) > 0.0f || get_top(h, i + 1, j) > 0.0f || get_top(h, i, j + 1) > 0.0f ||
         get_top(h, i + 1, j + 1) > 0.0f;
}

static np_vec3 get_corner(const height_cells *h, int i, int j, bool is_top) {
  return np_vec3_make(((float)i - 0.5f * (float)h->count[0]) * h->step_m[0],
                      ((float)j - 0.5f * (float)h->count[1]) * h->step_m[1], is_top ? get_top(h, i, j) : h->bottom_m);
}

/* Adds two triangles, counter-clockwise like a, b, c, d. */
static void add_quad(np_mesh_tree *tree, np_vec3 a, np_vec3 b, np_vec3 c, np_vec3 d) {
  tree->triangles[tree->triangle_count++] = (np_mesh_triangle){{a, b, c}};
  tree->triangles[tree->triangle_count++] = (np_mesh_triangle){{a, c, d}};
}

/* Adds top, bottom, and a wall to each empty neighbour. */
static void add_cell(const height_cells *h, int i, int j, np_mesh_tree *tree) {
  static const int around[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
  static const int neighbours[4][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};
  np_vec3 top[5], bottom[5];
  for (int k = 0; k < 5; k++) {
    top[k] = get_corner(h, i + around[k][0], j + around[k][1], true);
    bottom[k] = get_corner(h, i + around[k][0], j + around[k][1], false);
  }
  add_quad(tree, top[0], top[1], top[2], top[3]);
  add_quad(tree, bottom[3], bottom[2], bottom[1], bottom[0]);
  for (int k = 0; k < 4; k++)
    if (!is_active(h, i + neighbours[k][0], j + neighbours[k][1]))
      add_quad(tree, bottom[k], bottom[k + 1], top[k + 1], top[k]);
}

static void fill_tops(const np_cloud_model *model, const np_weather_picture *picture, height_cells *h) {
  const neph_cloud_desc *desc = &model->desc;
  const float white_m = desc->shape.has_height ? (float)desc->shape.height_m
                                               : np_maxf((float)desc->thickness_m - top_room * model->thermals.billow_m,
                                                         0.5f * (float)desc->thickness_m);
  for (int j = 1; j < h->count[1]; j++)
    for (int i = 1; i < h->count[0]; i++) {
      const np_vec3 at = get_corner(h, i, j, false);
      h->tops_m[j * (h->count[0] + 1) + i] =
          white_m * np_weather_picture_sample(picture, NEPH_CLOUD_MAP_THICKNESS, (double)at.x, (double)at.y);
    }
}

/* Chooses cells: the picture's pixels, or fewer. */
static void choose_cells(const np_cloud_model *model, const np_weather_picture *picture, height_cells *h) {
  const unsigned pixels[2] = {neph_image_get_width(picture->image), neph_image_get_height(picture->image)};
  h->bottom_m = -0.5f * model->thermals.billow_m;
  for (int a = 0; a < 2; a++) {
    const int inner = pixels[a] < CELLS_MAX ? (int)pixels[a] : CELLS_MAX;
    h->count[a] = inner + 1;
    h->step_m[a] = (float)picture->size_m[a] / (float)inner;
  }
}

neph_result np_shape_load_heights(const np_cloud_model *model, np_mesh_tree *out_tree) {
  neph_context *context = model->map.context;
  np_weather_picture picture;
  height_cells h = {.tops_m = NULL};
  *out_tree = (np_mesh_tree){.context = context};
  neph_result result = np_weather_picture_load_heights(context, &model->desc.shape, &picture);
  if (result) return result;
  for (int a = 0; a < 2 && !model->desc.shape.has_height_size; a++)
    picture.size_m[a] = model->desc.extent_m[a] - 2.0 * (double)(side_room * model->thermals.billow_m);
  choose_cells(model, &picture, &h);
  const size_t cells = (size_t)h.count[0] * (size_t)h.count[1];
  h.tops_m = np_alloc(context, (size_t)(h.count[0] + 1) * (size_t)(h.count[1] + 1), sizeof *h.tops_m);
  out_tree->triangles = np_alloc(context, 12 * cells, sizeof *out_tree->triangles);
  if (h.tops_m && out_tree->triangles) {
    fill_tops(model, &picture, &h);
    for (int j = 0; j < h.count[1]; j++)
      for (int i = 0; i < h.count[0]; i++)
        if (is_active(&h, i, j)) add_cell(&h, i, j, out_tree);
  } else {
    result = NEPH_ERROR_OUT_OF_MEMORY;
  }
  np_alloc_free(context, h.tops_m);
  np_weather_picture_clear(&picture);
  if (!result && out_tree->triangle_count == 0)
    result = np_fail(context, NEPH_ERROR_BAD_FILE, "%s: is 0 everywhere, must be above it where there is cloud",
                     model->desc.shape.height_map);
  return result;
}

/* ---- Distances ---- */

typedef struct distance_job {
  const np_mesh_tree *tree;
  np_shape_grid *grid;
  bool has_holes;
  size_t *inside, *open; /* nodes of each row of rows */
} distance_job;

/* Distances of a line of nodes along z; each is at most the previous one plus a step. */
static void measure_line(const distance_job *job, int32_t i, int32_t j) {
  np_shape_grid *g = job->grid;
  float *line_m = g->distance_m + ((size_t)i * (size_t)g->size[1] + (size_t)j) * (size_t)g->size[2];
  float limit_m = 1e18f;
  bool is_inside = false;
  for (int32_t k = 0; k < g->size[2]; k++) {
    const np_vec3 at = np_vec3_make(g->origin_m[0] + (float)i * g->step_m, g->origin_m[1] + (float)j * g->step_m,
                                    g->origin_m[2] + (float)k * g->step_m);
    const float away_m = np_mesh_tree_compute_distance(job->tree, at, limit_m);
    limit_m = 1.001f * (away_m + g->step_m);
    if (job->has_holes || k == 0 || away_m < 1.5f * g->step_m) {
      const float winding = fabsf(np_mesh_tree_compute_winding(job->tree, at));
      const float part = winding - floorf(winding);
      is_inside = winding > 0.5f;
      if (away_m > 0.5f * g->step_m && part > 0.2f && part < 0.8f) job->open[i]++;
    }
    job->inside[i] += is_inside;
    line_m[k] = is_inside ? -away_m : away_m;
  }
}

static neph_result measure_rows(void *user, size_t begin, size_t end, unsigned thread) {
  const distance_job *job = user;
  (void)thread;
  for (size_t i = begin; i < end; i++)
    for (int32_t j = 0; j < job->grid->size[1]; j++) measure_line(job, (int32_t)i, j);
  return NEPH_OK;
}

/* Refuses an open surface, and logs holes that are closed. */
static neph_result check_holes(const distance_job *job, const char *file, size_t edges, np_vec3 first) {
  neph_context *context = job->grid->context;
  size_t inside = 0, open = 0;
  for (int32_t i = 0; i < job->grid->size[0]; i++) inside += job->inside[i], open += job->open[i];
  if (inside == 0 || (double)open > open_share * (double)inside)
    return np_fail(context, NEPH_ERROR_BAD_FILE,
                   "%s: is not closed: %zu edges do not join two triangles of one sense, the first at [%.4g, %.4g, "
                   "%.4g] m in the field: close its holes, or turn its triangles outwards",
                   file, edges, (double)first.x, (double)first.y, (double)first.z);
  if (edges)
    np_log(context, NEPH_LOG_WARNING,
           "%s: %zu edges do not join two triangles of one sense, the first at [%.4g, %.4g, %.4g] m in the field: "
           "its holes are taken as closed",
           file, edges, (double)first.x, (double)first.y, (double)first.z);
  return NEPH_OK;
}

/* Allocates a grid around the surface, with a margin as wide as a billow, the largest distance in use, and a narrower
 * one below the base. */
static neph_result make_grid(const np_cloud_model *model, const np_mesh_tree *tree, np_shape_grid *out_grid) {
  const float room_m = model->thermals.billow_m;
  float low_m[3], high_m[3];
  include_triangles(tree, low_m, high_m);
  for (int a = 0; a < 3; a++) {
    low_m[a] -= room_m;
    high_m[a] += room_m;
  }
  low_m[2] = np_maxf(low_m[2], -room_m);
  return np_shape_grid_init(model->map.context, low_m, high_m, (float)model->desc.voxel_m, out_grid);
}

neph_result np_shape_measure(const np_cloud_model *model, np_monitor *monitor, const char *file, np_mesh_tree *tree,
                             np_shape_grid *out_grid) {
  neph_context *context = model->map.context;
  size_t edges;
  np_vec3 first;
  neph_result result = np_mesh_tree_count_open_edges(tree, &edges, &first);
  if (!result) result = np_mesh_tree_build(tree);
  if (!result) result = make_grid(model, tree, out_grid);
  if (result) return result;
  distance_job job = {.tree = tree, .grid = out_grid, .has_holes = edges > 0};
  job.inside = np_alloc(context, (size_t)out_grid->size[0], sizeof *job.inside);
  job.open = np_alloc(context, (size_t)out_grid->size[0], sizeof *job.open);
  result = job.inside && job.open ? np_parallel_for(context, monitor, (size_t)out_grid->size[0], 1, measure_rows, &job)
                                  : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = check_holes(&job, file, edges, first);
  np_alloc_free(context, job.inside);
  np_alloc_free(context, job.open);
  if (result)
    np_shape_grid_clear(out_grid);
  else
    np_shape_grid_bound(out_grid);
  return result;
}
