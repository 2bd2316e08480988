/* SPDX-License-Identifier: Apache-2.0 */
/* Errors of combinations of keys. */
#include <math.h>
#include <string.h>

#include "core/given.h"
#include "core/text.h"
#include "image/aov.h"
#include "image/cryptomatte.h"
#include "scene/scene_air.h"
#include "scene/scene_apply.h"
#include "scene/scene_check_camera.h"
#include "terrain/terrain_private.h"

/* Node of a key in a section; the section's node if the key is not set, or the document's. */
static const np_node *locate(const neph_scene *scene, const char *section, const char *key) {
  const np_node *parent = np_node_search(scene->document, section);
  const np_node *node = parent ? np_node_search(parent, key) : NULL;
  return node ? node : parent;
}

static neph_result check_place(const neph_scene *scene, np_scene_problems *problems) {
  const np_node *place = np_node_search(scene->document, "place");
  if (!scene->has_place || !place) return NEPH_OK;
  bool has_both = np_node_search(place, "latitude") && np_node_search(place, "longitude");
  return has_both ? NEPH_OK : np_scene_fail_at(problems, place, "place needs both latitude and longitude");
}

static neph_result check_sun(const neph_scene *scene, np_scene_problems *problems) {
  if (!scene->sun.time.is_given || scene->has_place || scene->terrain.kind == NP_TERRAIN_HEIGHTFIELD) return NEPH_OK;
  return np_scene_fail_at(problems, locate(scene, "sun", "time"),
                          "sun.time needs a place, must come with place or terrain.heightfield");
}

static neph_result check_moon(const neph_scene *scene, np_scene_problems *problems) {
  const np_scene_moon *moon = &scene->moon;
  if (!moon->is_enabled) return NEPH_OK;
  if (moon->has_angles != moon->has_azimuth)
    return np_scene_fail_at(problems, np_node_search(scene->document, "moon"),
                            "moon has one of elevation and azimuth, must have both or neither");
  if (moon->has_angles || scene->sun.time.is_given) return NEPH_OK;
  return np_scene_fail_at(problems, np_node_search(scene->document, "moon"),
                          "moon has no position, must have elevation and azimuth, or a sun.time");
}

static neph_result check_stars(const neph_scene *scene, np_scene_problems *problems) {
  const np_scene_stars *stars = &scene->stars;
  if (!stars->is_enabled) return NEPH_OK;
  if (!stars->has_sidereal && !scene->sun.time.is_given)
    return np_scene_fail_at(problems, np_node_search(scene->document, "stars"),
                            "stars have no orientation, must have sidereal_time or a sun.time");
  if (scene->has_place || scene->terrain.kind == NP_TERRAIN_HEIGHTFIELD) return NEPH_OK;
  return np_scene_fail_at(problems, np_node_search(scene->document, "stars"),
                          "stars need the latitude, must come with place or terrain.heightfield");
}

/* Refuses keys that have no effect on a volume from an API call. */
static neph_result check_volume(unsigned index, const np_node *node, np_scene_problems *problems) {
  static const char *const names[] = {"vdb",  "netcdf",    "grid", "import",  "level_set",
                                      "ramp", "precision", "bake", "emission"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    if (np_node_search(node, names[i]))
      return np_scene_fail_at(problems, np_node_search(node, names[i]),
                              "clouds[%u].%s goes with a file or a bake: this cloud is a volume that a call has added",
                              index, names[i]);
  return NEPH_OK;
}

static neph_result check_source(const neph_scene *scene, unsigned index, const np_node *node,
                                np_scene_problems *problems) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  if (cloud->volume) return check_volume(index, node, problems);
  const np_node *model = np_node_search(node, "netcdf");
  if (model && cloud->is_baked)
    return np_scene_fail_at(problems, model, "clouds[%u].netcdf is a file that is read: a cloud with it has no bake",
                            index);
  if (model && !cloud->vdb) return np_scene_fail_at(problems, model, "clouds[%u].netcdf has no file", index);
  if (!cloud->vdb && !cloud->is_baked)
    return np_scene_fail_at(problems, node,
                            "clouds[%u] has no source, must have vdb or netcdf, a file, or bake, parameters", index);
  const np_node *water = np_node_search(node, "liquid_water");
  if (water && !np_node_search(water, "effective_radius"))
    return np_scene_fail_at(problems, water, "clouds[%u].liquid_water has no effective_radius, that of the droplets",
                            index);
  return NEPH_OK;
}

static neph_result check_reference_frame(const neph_scene *scene, unsigned index, const np_node *node,
                                         np_scene_problems *problems) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  const bool is_given = cloud->has_reference_frame || np_scene_cloud_goes_by_all(cloud);
  if (!is_given || np_scene_cloud_is_sequence(cloud)) return NEPH_OK;
  char number[32];
  np_print(number, sizeof number, "%.10g", cloud->reference_frame);
  return np_scene_fail_at(problems, np_node_search(node, "reference_frame"),
                          "clouds[%u].reference_frame is %s, but %s: it goes with a vdb that has # for the frame",
                          index, np_scene_cloud_goes_by_all(cloud) ? "all" : number,
                          cloud->is_baked ? "the cloud is baked" : "its vdb is the same file in every frame");
}

/* Refuses a scale of 0 along an axis. */
static neph_result check_scale(const neph_scene *scene, unsigned index, const np_node *node,
                               np_scene_problems *problems) {
  const double *scale = scene->clouds[index].scale;
  if (fmin(fmin(fabs(scale[0]), fabs(scale[1])), fabs(scale[2])) >= 1e-6) return NEPH_OK;
  return np_scene_fail_at(problems, np_node_search(node, "scale"),
                          "clouds[%u].scale is [%g, %g, %g], must be at least 1e-06 or at most -1e-06 along each axis",
                          index, scale[0], scale[1], scale[2]);
}

/* Channel name of an AOV that clouds must not use. */
typedef struct reserved_name {
  const char *name, *aov;
  unsigned aovs;       /* bit mask of np_aov: each of these AOVs reserves the name */
  bool is_of_emission; /* reserved only for clouds with emission */
} reserved_name;

static const reserved_name *search_reserved(const neph_scene *scene, unsigned index) {
  static const reserved_name rows[] = {
      {NP_GROUND_MATTE, "mattes or cryptomatte", NP_AOV_MATTES | NP_AOV_CRYPTOMATTE, false},
      {"sun", "lights", NP_AOV_LIGHTS, true},
      {"sky", "lights", NP_AOV_LIGHTS, true},
      {"moon", "lights", NP_AOV_LIGHTS, true}};
  const np_scene_cloud *cloud = &scene->clouds[index];
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
    if (!strcmp(cloud->name, rows[i].name) && (scene->output.aovs & rows[i].aovs) &&
        (cloud->emission.is_enabled || !rows[i].is_of_emission))
      return &rows[i];
  return NULL;
}

static neph_result check_name(const neph_scene *scene, unsigned index, const np_node *node,
                              np_scene_problems *problems) {
  const char *name = scene->clouds[index].name;
  const np_node *name_node = np_node_search(node, "name");
  if (strchr(name, '/'))
    return np_scene_fail_at(problems, name_node, "clouds[%u].name is %s, must not hold a slash: files are named by it",
                            index, name);
  const reserved_name *reserved = search_reserved(scene, index);
  if (reserved)
    return np_scene_fail_at(problems, name_node ? name_node : node,
                            "clouds[%u].name is %s, which is a channel's already: with %s in output.aovs a cloud%s "
                            "must have another name",
                            index, name, reserved->aov, reserved->is_of_emission ? " with emission" : "");
  for (unsigned i = 0; i < index; i++)
    if (!strcmp(scene->clouds[i].name, name))
      return np_scene_fail_at(problems, name_node ? name_node : node,
                              "clouds[%u].name is %s, the name of clouds[%u] too", index, name, i);
  return NEPH_OK;
}

/* Requires a picture or a measured file for keys of a map. Reading them checks channels and bands. */
static neph_result check_map(const neph_scene *scene, unsigned index, const np_node *node,
                             np_scene_problems *problems) {
  static const char *const of_image[] = {"coverage", "type", "base", "thickness", "precipitation", "age", "tiling"};
  const np_node *bake = np_node_search(node, "bake"), *map = bake ? np_node_search(bake, "map") : NULL;
  (void)scene;
  if (!map || map->kind != NP_NODE_MAPPING) return NEPH_OK;
  const np_node *file = np_node_search(map, "file"), *top = np_node_search(map, "top");
  if (!file && !np_node_search(map, "image"))
    return np_scene_fail_at(problems, map,
                            "clouds[%u].bake.map has no image, must name an EXR or PNG picture, or a GeoTIFF as file",
                            index);
  for (size_t i = 0; file && i < sizeof of_image / sizeof *of_image; i++)
    if (np_node_search(map, of_image[i]))
      return np_scene_fail_at(problems, np_node_search(map, of_image[i]),
                              "clouds[%u].bake.map.%s is of an image, cannot be given with file", index, of_image[i]);
  if (file && top && top->kind == NP_NODE_MAPPING && !np_node_search(top, "file"))
    return np_scene_fail_at(problems, top, "clouds[%u].bake.map.top has no file, must name a GeoTIFF of cloud tops",
                            index);
  return NEPH_OK;
}

/* Checks the keys of a shape. Reading its files checks their contents. */
static neph_result check_shape(const neph_scene *scene, unsigned index, const np_node *node,
                               np_scene_problems *problems) {
  const neph_cloud_desc *desc = &scene->clouds[index].bake;
  const np_node *bake = np_node_search(node, "bake"), *shape = bake ? np_node_search(bake, "shape") : NULL;
  if (!shape || shape->kind != NP_NODE_MAPPING) return NEPH_OK;
  const np_node *mesh = np_node_search(shape, "mesh"), *heights = np_node_search(shape, "height_map");
  if (mesh && !desc->shape.mesh_file)
    return np_scene_fail_at(problems, mesh, "clouds[%u].bake.shape.mesh has no file, must name a closed mesh", index);
  if (heights && !desc->shape.height_map)
    return np_scene_fail_at(problems, heights, "clouds[%u].bake.shape.height_map has no image, must name an EXR or PNG",
                            index);
  if (!shape->first)
    return np_scene_fail_at(problems, shape,
                            "clouds[%u].bake.shape is empty, must have spheres, curves, mesh or height_map", index);
  if (desc->model == NEPH_CLOUD_MODEL_THERMALS || desc->model == NEPH_CLOUD_MODEL_HERO) return NEPH_OK;
  return np_scene_fail_at(problems, shape,
                          "clouds[%u].bake.shape goes with model: thermals or hero, whose billows stand on it: set "
                          "clouds[%u].bake.model",
                          index, index);
}

static neph_result check_top(const neph_scene *scene, unsigned index, const np_node *node,
                             np_scene_problems *problems) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  const np_node *bake = np_node_search(node, "bake"), *top = bake ? np_node_search(bake, "top") : NULL;
  if (!top || cloud->top_m > cloud->bake.base_altitude_m) return NEPH_OK;
  return np_scene_fail_at(problems, top, "clouds[%u].bake.top is %g m, must be above base, %g m", index, cloud->top_m,
                          cloud->bake.base_altitude_m);
}

static neph_result check_profile(const neph_scene *scene, unsigned index, const np_node *node,
                                 np_scene_problems *problems) {
  const neph_cloud_desc *desc = &scene->clouds[index].bake;
  const np_node *bake = np_node_search(node, "bake"), *profile = bake ? np_node_search(bake, "profile") : NULL;
  for (int i = 1; i < NEPH_CLOUD_PROFILE_POINTS && profile; i++)
    if (desc->profile[i] < desc->profile[i - 1])
      return np_scene_fail_at(problems, profile, "clouds[%u].bake.profile[%d] is %g after %g, must not fall", index, i,
                              desc->profile[i], desc->profile[i - 1]);
  return NEPH_OK;
}

/* Checks the keys of emission. Reading the grids checks their contents. */
static neph_result check_emission(const neph_scene *scene, unsigned index, const np_node *node,
                                  np_scene_problems *problems) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  const np_node *emission = np_node_search(node, "emission");
  if (!cloud->emission.is_enabled || !emission) return NEPH_OK;
  if (cloud->is_baked)
    return np_scene_fail_at(problems, emission, "clouds[%u].emission goes with vdb alone: a baked cloud has no fire",
                            index);
  const char *temperature = cloud->emission.temperature, *color = cloud->emission.color;
  const bool is_cold = temperature && !strcmp(temperature, "none") && !(cloud->emission.offset_k > 0.0);
  if (!is_cold || (color && strcmp(color, "none") != 0)) return NEPH_OK;
  return np_scene_fail_at(problems, emission,
                          "clouds[%u].emission.offset is %g K, must be above 0 where emission.temperature is none",
                          index, cloud->emission.offset_k);
}

const char *np_scene_cloud_search_move(const np_scene_cloud *cloud) {
  const double *s = cloud->scale, *t = cloud->tilt_rad;
  return cloud->places                               ? "places"
         : cloud->has_position                       ? "position"
         : cloud->emission.is_enabled                ? "emission"
         : s[0] != 1.0 || s[1] != 1.0 || s[2] != 1.0 ? "scale"
         : t[0] != 0.0 || t[1] != 0.0                ? "tilt"
         : cloud->rotation_rad != 0.0                ? "rotation"
                                                     : NULL;
}

/* Refuses to move a repeating cloud: its tiles meet only where the bake places them. */
static neph_result check_repeat(const neph_scene *scene, unsigned index, const np_node *node,
                                np_scene_problems *problems) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  const char *key = np_scene_cloud_search_move(cloud);
  if (!cloud->is_baked || !(cloud->bake.repeat_m > 0.0) || !key) return NEPH_OK;
  return np_scene_fail_at(problems, np_node_search(node, key),
                          "clouds[%u].%s and clouds[%u].bake.repeat exclude each other: tiles meet where the bake puts "
                          "them; leave one of them out",
                          index, key, index);
}

/* Whether x and y stay x and y, or change places. */
static bool is_quarter_turn(double angle_rad) {
  const double quarters = angle_rad / (0.5 * NP_PI);
  return fabs(quarters - round(quarters)) < 1e-9;
}

/* First key that a cloud from a file cannot have if it repeats without end; NULL: none. */
static const char *search_unrepeatable(const np_scene_cloud *cloud) {
  return cloud->places                                            ? "places"
         : cloud->emission.is_enabled                             ? "emission"
         : cloud->up != NP_UP_Z                                   ? "up"
         : cloud->tilt_rad[0] != 0.0 || cloud->tilt_rad[1] != 0.0 ? "tilt"
         : !is_quarter_turn(cloud->rotation_rad)                  ? "rotation"
                                                                  : NULL;
}

static neph_result check_endless(const neph_scene *scene, unsigned index, const np_node *node,
                                 np_scene_problems *problems) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  const np_node *repeat = np_node_search(node, "repeat");
  if (cloud->repeat == NP_REPEAT_NONE || !repeat) return NEPH_OK;
  if (cloud->is_baked || !cloud->vdb)
    return np_scene_fail_at(
        problems, repeat,
        "clouds[%u].repeat goes with vdb and netcdf alone: a baked cloud repeats by clouds[%u].bake.repeat", index,
        index);
  if (cloud->repeat == NP_REPEAT_FILE && !cloud->is_model && np_scene_cloud_is_sequence(cloud))
    return np_scene_fail_at(problems, repeat,
                            "clouds[%u].repeat is file, but vdb names files of many frames, whose boxes may differ: "
                            "give the periods as lengths",
                            index);
  const char *key = search_unrepeatable(cloud);
  if (!key) return NEPH_OK;
  return np_scene_fail_at(problems, np_node_search(node, key),
                          "clouds[%u].%s and clouds[%u].repeat exclude each other: periods run along x and y of one "
                          "upright cloud, turned by quarters of a circle at most; leave one of them out",
                          index, key, index);
}

/* Refuses detail between nearest samples, where it has no gradient to work on. */
static neph_result check_interpolation(const neph_scene *scene, unsigned index, const np_node *node,
                                       np_scene_problems *problems) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  const bool has_detail = cloud->detail.kind == NP_DETAIL_AUTO || cloud->detail.kind == NP_DETAIL_GIVEN;
  if (cloud->interpolation == NEPH_INTERPOLATION_LINEAR || !has_detail) return NEPH_OK;
  return np_scene_fail_at(
      problems, np_node_search(node, "interpolation"),
      "clouds[%u].interpolation is nearest, which excludes clouds[%u].detail: leave one of them out", index, index);
}

/* Refuses levels of detail with keys that move or scale a bake: the level depends on the distance of each position to
 * the camera. */
static neph_result check_levels(const neph_scene *scene, unsigned index, const np_node *node,
                                np_scene_problems *problems) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  if (!cloud->is_baked || cloud->level_count < 2) return NEPH_OK;
  const np_node *bake = np_node_search(node, "bake");
  const char *move = np_scene_cloud_search_move(cloud);
  const char *key = move                                              ? move
                    : cloud->voxel_m > 0.0                            ? "voxel"
                    : cloud->density_unit == NP_DENSITY_OPTICAL_DEPTH ? "optical_depth"
                                                                      : NULL;
  if (!key) return NEPH_OK;
  return np_scene_fail_at(problems, bake ? np_node_search(bake, "levels") : node,
                          "clouds[%u].%s and clouds[%u].bake.levels exclude each other: levels depend on the distance "
                          "of each position to the camera; leave one of them out",
                          index, key, index);
}

/* Refuses emission for clouds with several places, which share one cloud's bricks. */
static neph_result check_places(const neph_scene *scene, unsigned index, const np_node *node,
                                np_scene_problems *problems) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  if (!cloud->places || !cloud->emission.is_enabled) return NEPH_OK;
  return np_scene_fail_at(problems, np_node_search(node, "places"),
                          "clouds[%u].places and clouds[%u].emission exclude each other: copies do not emit; leave one "
                          "of them out, or give each cloud that burns an element of clouds",
                          index, index);
}

static neph_result check_clouds(const neph_scene *scene, np_scene_problems *problems) {
  static neph_result (*const cloud_checks[])(const neph_scene *, unsigned, const np_node *, np_scene_problems *) = {
      check_source,  check_reference_frame, check_scale,    check_name,   check_map,    check_shape,
      check_top,     check_profile,         check_emission, check_places, check_repeat, check_levels,
      check_endless, check_interpolation};
  const np_node *list = np_node_search(scene->document, "clouds");
  const np_node *node = list ? list->first : NULL;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; node && i < scene->cloud_count; i++, node = node->next) {
    const bool is_read = !np_scene_has_problem_in(problems, node);
    for (size_t c = 0; is_read && c < sizeof cloud_checks / sizeof *cloud_checks; c++)
      np_scene_goes_on(problems, cloud_checks[c](scene, i, node, problems), &result);
  }
  return result;
}

/* Refuses keys in a section that an API object replaces. */
static neph_result check_no_keys(const np_node *section, np_scene_problems *problems) {
  const np_node *key = section->first;
  if (!key) return NEPH_OK;
  return np_scene_fail_at(problems, key, "%s.%s goes with keys alone: a call has set the %s, which has its own",
                          section->key, key->key, section->key);
}

static neph_result check_given_terrain(const neph_scene *scene, const np_node *node, np_scene_problems *problems) {
  const double radius = np_terrain_get_planet_radius_m(scene->terrain.given);
  if (radius == scene->atmosphere.planet_radius_m) return check_no_keys(node, problems);
  return np_scene_fail_at(problems, node,
                          "the terrain stands on a planet of %.9g m, must be the scene's, of %.9g m: set "
                          "planet_radius_m of its description",
                          radius, scene->atmosphere.planet_radius_m);
}

static neph_result check_terrain(const neph_scene *scene, np_scene_problems *problems) {
  const np_scene_terrain *terrain = &scene->terrain;
  const np_node *node = np_node_search(scene->document, "terrain");
  if (terrain->given) return check_given_terrain(scene, node, problems);
  const np_node *mesh = node ? np_node_search(node, "mesh") : NULL;
  if (mesh && !terrain->mesh_file)
    return np_scene_fail_at(problems, mesh, "terrain.mesh has no file, must name one of triangles");
  if (node && node->kind == NP_NODE_MAPPING && terrain->kind == NP_TERRAIN_NONE)
    return np_scene_fail_at(problems, node,
                            "terrain has no source, must have heightfield, a file, mesh, a file of triangles, or "
                            "ridges, parameters; even ground has atmosphere.ground_albedo");
  if (terrain->desc.height_max_m > terrain->desc.height_min_m) return NEPH_OK;
  return np_scene_fail_at(problems, locate(scene, "terrain", "height_max"),
                          "terrain.height_max is %g m, must be above height_min, %g m", terrain->desc.height_max_m,
                          terrain->desc.height_min_m);
}

static neph_result check_colors(const neph_scene *scene, np_scene_problems *problems) {
  const unsigned count = scene->render.wavelength_count;
  if (count % 3 != 0)
    return np_scene_fail_at(problems, locate(scene, "render", "wavelengths"),
                            "render.wavelengths is %u, must be a multiple of 3: the nearest are %u and %u", count,
                            count / 3 * 3, count / 3 * 3 + 3);
  if (scene->output.color_space == NP_COLOR_BANDS && count > 3)
    return np_scene_fail_at(problems, locate(scene, "output", "color_space"),
                            "output.color_space is bands, which are 3, must be rec709, acescg, rec2020 or xyz for the "
                            "%u render.wavelengths",
                            count);
  return NEPH_OK;
}

static neph_result check_output(const neph_scene *scene, np_scene_problems *problems) {
  int exponent;
  if (scene->output.scale == 0.0) return NEPH_OK;
  double mantissa = frexp(scene->output.scale, &exponent);
  if (mantissa <= 0.5) return NEPH_OK; /* frexp returns a mantissa in [0.5, 1) */
  return np_scene_fail_at(problems, locate(scene, "output", "scale"),
                          "output.scale is %.9g, must be a power of two; the nearest below is %g", scene->output.scale,
                          ldexp(0.5, exponent));
}

static neph_result check_preview(const neph_scene *scene, np_scene_problems *problems) {
  if (scene->output.view != NEPH_VIEW_OCIO || scene->output.ocio_config) return NEPH_OK;
  return np_scene_fail_at(problems, locate(scene, "output", "view"),
                          "output.view needs ocio, the file of a configuration of OpenColorIO");
}

static neph_result check_air(const neph_scene *scene, np_scene_problems *problems) {
  if (!scene->air.given) return np_scene_air_check(scene, problems);
  return check_no_keys(np_node_search(scene->document, "atmosphere"), problems);
}

/* Checks of combinations. A check is skipped if a key that it reads, or a nested key, has an error already. */
static const struct {
  neph_result (*check)(const neph_scene *scene, np_scene_problems *problems);
  struct {
    const char *section, *key; /* key NULL: the whole section */
  } reads[4];
} checks[] = {
    {check_place, {{"place", NULL}}},
    {check_sun, {{"sun", NULL}, {"place", NULL}, {"terrain", NULL}}},
    {check_moon, {{"moon", NULL}, {"sun", "time"}}},
    {check_stars, {{"stars", NULL}, {"sun", "time"}, {"place", NULL}, {"terrain", NULL}}},
    {np_scene_check_view, {{"camera", "position"}, {"camera", "look_at"}}},
    {np_scene_check_camera, {{"camera", NULL}}},
    {np_scene_check_exposure, {{"camera", NULL}, {"output", "exposure"}}},
    {np_scene_check_motion_blur, {{"camera", NULL}, {"output", "deep"}}},
    {check_air, {{"atmosphere", NULL}}},
    {check_clouds, {{NULL, NULL}}}, /* each cloud skips on its own errors */
    {check_terrain, {{"terrain", NULL}}},
    {check_output, {{"output", "scale"}}},
    {check_preview, {{"output", "view"}}},
    {check_colors, {{"output", "color_space"}, {"render", "wavelengths"}}},
};

static bool is_readable(const neph_scene *scene, size_t check, const np_scene_problems *problems) {
  for (int i = 0; i < 4 && checks[check].reads[i].section; i++) {
    const char *key = checks[check].reads[i].key;
    const np_node *node = np_node_search(scene->document, checks[check].reads[i].section);
    if (node && key && node->kind == NP_NODE_MAPPING) node = np_node_search(node, key);
    if (np_scene_has_problem_in(problems, node)) return false;
  }
  return true;
}

void np_scene_check_all(const neph_scene *scene, np_scene_problems *problems) {
  for (size_t i = 0; i < sizeof checks / sizeof *checks; i++)
    if (is_readable(scene, i, problems)) (void)checks[i].check(scene, problems);
}

neph_result np_scene_check(const neph_scene *scene) {
  np_scene_problems problems = {.context = scene->context, .file = scene->file};
  np_scene_check_all(scene, &problems);
  return np_scene_report(&problems, NEPH_OK);
}

neph_result neph_scene_check(const neph_scene *scene) {
  if (!scene) return NEPH_ERROR_INVALID_ARGUMENT;
  const neph_result result = np_scene_check(scene);
  if (!result) np_scene_warn_of_ignored(scene);
  return result;
}
