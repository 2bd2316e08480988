/* SPDX-License-Identifier: Apache-2.0 */
/* A map projection is smooth: around the middle of a cloud's box it is taken as linear, with its scale and the turn of
 * its grid against north, which is 1° at the edge of a zone of UTM in mid-latitudes, 170 m in 10 km. Away from there
 * the error is the planet's bend, d²/2R: 2 m at 5 km, 31 m at 20 km, in height. */
#include "plan/georeference.h"

#include "core/alloc.h"
#include "plan/placement.h"
#include "terrain/raster_lattice.h"

/* Clouds as near to the world's origin are those of the world: no system in use has eastings or northings as small
 * where it is used, but near the equator or a false origin. */
static const double near_m = 5e4;

/* Largest distance of a cloud beside the raster, as a share of the raster's size. */
static const double beside_share = 0.5;

typedef struct box {
  np_dvec3 low, high, middle;
} box;

static box get_box(const neph_volume *volume, const np_affine *file_to_world) {
  box b;
  const np_affine index_to_world = np_affine_compose(file_to_world, &volume->index_to_world);
  np_placement_compute_bounds(&index_to_world, volume, &b.low, &b.high);
  b.middle = np_dvec3_scale(np_dvec3_add(b.low, b.high), 0.5);
  return b;
}

static bool may_be(const neph_scene *scene, const np_scene_cloud *cloud, const box *b) {
  const np_scene_terrain *terrain = &scene->terrain;
  const double size = fmax(b->high.x - b->low.x, b->high.y - b->low.y);
  return cloud->vdb && !cloud->is_baked && !cloud->has_position && !cloud->places && !terrain->given &&
         terrain->kind == NP_TERRAIN_HEIGHTFIELD && terrain->heightfield &&
         np_heightfield_is_raster(terrain->heightfield) && hypot(b->middle.x, b->middle.y) > near_m + size;
}

static bool is_beside(double position, double last) {
  return position >= -beside_share * last && position <= (1.0 + beside_share) * last;
}

static bool is_within(const np_raster_lattice *lattice, const box *b) {
  const np_field_position at = np_raster_lattice_locate(lattice, b->middle.x, b->middle.y);
  return is_beside(at.column, lattice->field.width - 1.0) && is_beside(at.row, lattice->field.height - 1.0);
}

/* Differences over a kilometre: a place of the lattice is right to a millimetre. */
static np_affine make_affine(const np_raster_lattice *lattice, np_dvec3 at) {
  static const double step_m = 1000.0;
  np_affine out;
  const np_dvec3 base = np_raster_lattice_place(lattice, at.x, at.y, at.z);
  for (int axis = 0; axis < 3; axis++) {
    const np_dvec3 step = np_dvec3_make(axis == 0 ? step_m : 0.0, axis == 1 ? step_m : 0.0, axis == 2 ? step_m : 0.0);
    const np_dvec3 ahead = np_raster_lattice_place(lattice, at.x + step.x, at.y + step.y, at.z + step.z);
    const np_dvec3 behind = np_raster_lattice_place(lattice, at.x - step.x, at.y - step.y, at.z - step.z);
    const np_dvec3 slope = np_dvec3_scale(np_dvec3_subtract(ahead, behind), 0.5 / step_m);
    out.m[0][axis] = slope.x, out.m[1][axis] = slope.y, out.m[2][axis] = slope.z;
  }
  const double bases[3] = {base.x, base.y, base.z};
  for (int row = 0; row < 3; row++)
    out.m[row][3] = bases[row] - (out.m[row][0] * at.x + out.m[row][1] * at.y + out.m[row][2] * at.z);
  return out;
}

neph_result np_georeference_apply(const neph_scene *scene, const np_scene_cloud *cloud, const neph_volume *volume,
                                  np_affine *file_to_world, np_georeference *out) {
  *out = (np_georeference){.is_applied = false};
  const box b = get_box(volume, file_to_world);
  if (!may_be(scene, cloud, &b)) return NEPH_OK;
  np_raster_lattice lattice;
  const neph_terrain_desc desc = np_scene_terrain_get_desc(&scene->terrain);
  neph_result result = np_raster_lattice_load(scene->context, scene->terrain.heightfield, &desc, &lattice);
  if (result || !lattice.is_projected || !is_within(&lattice, &b)) return result;
  out->is_applied = true;
  out->to_world = make_affine(&lattice, b.middle);
  memcpy(out->crs, lattice.crs, sizeof out->crs);
  *file_to_world = np_affine_compose(&out->to_world, file_to_world);
  return NEPH_OK;
}

char *np_georeference_describe(neph_context *context, const np_georeference *georeference) {
  return np_alloc_printf(context,
                         "stands where its file's coordinates are in the system of the terrain's raster, %s, whose "
                         "easting, northing and height they are; clouds[].position puts it elsewhere",
                         georeference->crs);
}
