/* SPDX-License-Identifier: Apache-2.0 */
/* Each key changes something: the frame of a small scene, its header, or the plan. A key without an effect here names
 * the test that shows it. A new key passes alone if it changes the scene of its section. */
#include <nephos/nephos.h>

#include <stdlib.h>

#include "image/image_private.h"
#include "scene/scene_keys.h"
#include "test_box_files.h"

enum { FRAME = 3, TEXT_SIZE = 1024, BASES_MAX = 128 };

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

/* ---- Scenes ---- */

#define VIEW(keys) "camera: {position: [0, -300 m, 60 m], look_at: [0, 0, 60 m], " keys "resolution: [6, 4]}\n"
#define LOW VIEW("")
#define NO_AIR "atmosphere: {preset: none}\n"
#define AIR(keys) LOW "atmosphere: {tolerance: 0.1, " keys "}\n" QUICK
#define LAYER(keys) AIR("layers: [{bottom: 100 m, top: 8 km, scattering: 1e-5 1/m, absorption: 1e-5 1/m, " keys "}]")
#define QUICK "render: {samples: 1, multiple_scattering: none}\n"
#define HILLS "terrain: {ridges: {samples: 33, relief: 100 m, ridge: 200 m}, width: 1 km}\n"
#define BAKED(keys)                                                                                                    \
  LOW NO_AIR "clouds: [{bake: {extent: 200 m, base: 40 m, voxel: 20 m, cell: 100 m, billow: 40 m, coverage: 0.6, "     \
             "lifetime: 100 s, " keys "}}]\n"
#define CLOUD(keys)                                                                                                    \
  LOW NO_AIR "clouds: [{bake: {extent: 200 m, base: 40 m, thickness: 60 m, voxel: 20 m, cell: 100 m, "                 \
             "billow: 40 m, coverage: 0.6}, " keys "}]\n"
#define CLOUD_IN_AIR                                                                                                   \
  LOW "atmosphere: {tolerance: 0.1}\n"                                                                                 \
      "clouds: [{bake: {extent: 200 m, base: 40 m, thickness: 60 m, voxel: 20 m}}]\n"
/* A box of 1 over the half of one of 0.5. */
#define BOXES(keys) LOW NO_AIR "clouds: [{vdb: boxes.vdb, position: [0, 0, 60 m], scale: 6, " keys "}]\n"
#define FIRE(keys) BOXES("extinction: 0.01 1/m, emission: {offset: 1500 K, " keys "}") QUICK
#define SCATTERING(method) CLOUD("") "render: {samples: 1, multiple_scattering: " method "}\n"
#define MOTION                                                                                                         \
  VIEW("motion_blur: {shutter: 0.5}, ")                                                                                \
  NO_AIR HILLS QUICK "animate: {camera.position: [[1, [0, -300 m, 60 m]], [9, [80 m, -300 m, 60 m]]]}\n"
#define ROCK                                                                                                           \
  LOW NO_AIR QUICK "terrain: {ridges: {samples: 33, relief: 100 m, ridge: 200 m}, width: 1 km, rock: {slope: 1 "       \
                   "deg}}\n"
#define RAW                                                                                                            \
  LOW NO_AIR QUICK "terrain: {heightfield: heights.raw, raw: {size: [4, 4]}, width: 600 m, height_max: 100 m}\n"
#define SOLID                                                                                                          \
  BAKED("thickness: 160 m, model: thermals, shape: {mesh: {file: solid.obj, up: y, position: [0, 0, 40 m]}}") QUICK
#define EXPONENTIAL(keys) LAYER("exponential: {height: 1 km}" keys)
#define POSES(keys) "camera: {motion: {file: poses.chan, " keys "}, resolution: [6, 4]}\n" NO_AIR HILLS QUICK
#define MOON LOW NO_AIR "sun: {elevation: -30 deg}\nmoon: {elevation: 30 deg, azimuth: 90 deg}\n" HILLS QUICK

/* The scene of keys whose paths begin alike; the longest counts. */
static const struct {
  const char *section, *scene;
} homes[] = {
    {"", AIR("")},
    {"camera", LOW NO_AIR HILLS QUICK},
    {"environment", LOW "environment: {planet: none, radiance: 1}\n" QUICK},
    {"moon", MOON},
    {"terrain", LOW NO_AIR HILLS QUICK},
    {"water", LOW NO_AIR "water: {}\n" QUICK},
    {"clouds", CLOUD("") QUICK},
    {"clouds[].bake", BAKED("thickness: 60 m") QUICK},
    {"clouds[].emission", FIRE("flame: none, temperature: none")},
    {"clouds[].ramp", BOXES("extinction: 0.01 1/m") QUICK},
    {"render", CLOUD("")},
    {"output", CLOUD("") QUICK},
};

/* ---- Outcomes ---- */

/* All of a scene that a key may change. */
typedef struct outcome {
  neph_image *image;
  char *plan; /* the stages' lines of --explain */
} outcome;

static neph_scene *load(test_fixture *f, const char *text) {
  char *path = test_path(f->folder, "scene.yaml");
  neph_scene *scene = NULL;
  if (neph_scene_load_text(f->context, text, path, &scene)) fail_msg("%s\n%s", text, f->log.text);
  free(path);
  return scene;
}

/* `out` begins as {NULL, NULL}. */
static bool render(neph_scene *scene, outcome *out) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  if (neph_scene_get_render_desc(scene, &desc)) return false;
  desc.frame = FRAME;
  if (neph_render_explain(scene, &desc, NEPH_TEXT_PLAIN, &out->plan)) return false;
  return !neph_render_image(scene, &desc, &out->image);
}

static void clear(test_fixture *f, outcome *o) {
  neph_image_destroy(o->image);
  neph_text_destroy(f->context, o->plan);
}

static bool are_values_alike(const neph_image *a, const neph_image *b) {
  if (a->width != b->width || a->height != b->height || a->channel_count != b->channel_count) return false;
  for (unsigned c = 0; c < a->channel_count; c++) {
    const size_t bytes = (size_t)a->width * a->height * sizeof(float);
    if (strcmp(a->channels[c].name, b->channels[c].name) != 0) return false;
    if (memcmp(a->channels[c].values, b->channels[c].values, bytes) != 0) return false;
  }
  return true;
}

static bool are_headers_alike(const neph_image *a, const neph_image *b) {
  return !memcmp(&a->header, &b->header, sizeof a->header);
}

/* The stages' lines, with their reasons and predictions. */
static bool are_plans_alike(const char *a, const char *b) {
  return !strcmp(strstr(a, "\ncolour "), strstr(b, "\ncolour "));
}

static const char *name_difference(const outcome *a, const outcome *b) {
  if (!are_values_alike(a->image, b->image)) return "pixels";
  if (!are_headers_alike(a->image, b->image)) return "header";
  return are_plans_alike(a->plan, b->plan) ? NULL : "plan";
}

/* ---- Values ---- */

/* "clouds[].name" as --set takes it. */
static void write_path(const np_key *key, char *out, size_t size) {
  char *to = out;
  for (const char *at = key->path; *at && to + 2 < out + size; at++) {
    *to++ = *at;
    if (*at == '[') *to++ = '0';
  }
  *to = '\0';
}

/* The value of a key as the scene describes it; "": the scene has none. */
static void read_value(test_fixture *f, const neph_scene *scene, const char *path, char *out, size_t size) {
  char *text, line[2 * TEXT_SIZE];
  assert_int_equal(neph_scene_describe(scene, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  snprintf(line, sizeof line, "\n%s: ", path);
  const char *at = strstr(text, line);
  *out = '\0';
  if (at) snprintf(out, size, "%.*s", (int)strcspn(at + strlen(line), "\n"), at + strlen(line));
  neph_text_destroy(f->context, text);
}

static double change_number(const np_key *key, double x) {
  if (key->type == NP_KEY_SEED) return x + 1;
  if (key->type == NP_KEY_INTEGER) return x + 1 > key->range.max ? x - 1 : x + 1;
  if (x == 0) return key->range.max < 1 ? 0.5 * key->range.max : 0.5;
  return 1.25 * x <= key->range.max || key->unit ? 1.25 * x : 0.8 * x;
}

/* A value near the one that the scene has: another word, each number a quarter more, or one more. */
static void change_value(const np_key *key, const char *value, char *out, size_t size) {
  size_t length = 0;
  if (key->type == NP_KEY_CHOICE || key->type == NP_KEY_SECTION) {
    snprintf(out, size, "%s", key->choices[!strcmp(key->choices[0].name, value) && key->choices[1].name].name);
    return;
  }
  for (const char *at = value; *at && length + 32 < size;) {
    char *end;
    const double x = strtod(at, &end);
    const bool is_number = end != at && *end != '/' && (at == value || strchr(" [,", at[-1])); /* not of "1/m" */
    if (is_number)
      length += (size_t)snprintf(out + length, size - length, "%.9g", change_number(key, x));
    else
      out[length++] = *at++;
    if (is_number) at = end;
  }
  out[length] = '\0';
}

/* ---- Examples ---- */

/* Keys that need another scene than the home of their section, or another value than a near one. */
/* clang-format off */
static const struct {
  const char *path, *scene, *value; /* NULL: the home, a near value */
} examples[] = {
    {"atmosphere.mie_scattering", NULL, "2e-6 1/m"},
    {"camera.focal_length", NULL, "35 mm"},
    {"camera.sensor", VIEW("focal_length: 35 mm, ") NO_AIR HILLS QUICK, NULL},
    {"camera.orthographic_width", VIEW("kind: orthographic, orthographic_width: 100 m, ") NO_AIR HILLS QUICK, NULL},
    {"camera.fisheye_fov", VIEW("kind: fisheye, ") NO_AIR HILLS QUICK, NULL},
    {"camera.near", NULL, "320 m"},
    {"camera.far", NULL, "280 m"},
    {"camera.f_stop", NULL, "0.1"},
    {"camera.focus_distance", VIEW("f_stop: 0.1, ") NO_AIR HILLS QUICK, "10 m"},
    {"camera.blades", VIEW("f_stop: 0.1, focus_distance: 10 m, ") NO_AIR HILLS QUICK, "5"},
    {"camera.motion.up", POSES(""), "z"},
    {"camera.motion.order", POSES(""), "xyz"},
    {"camera.motion.unit", POSES(""), "2 m"},
    {"camera.motion.offset", POSES(""), "1"},
    {"camera.motion_blur", MOTION, "none"},
    {"camera.motion_blur.shutter", MOTION, NULL},
    {"camera.motion_blur.offset", MOTION, "0.5"},
    {"moon", MOON, "none"},
    {"atmosphere.haze", AIR(""), "dusty"},
    {"atmosphere.visibility", AIR(""), "20 km"},
    {"atmosphere.mie_asymmetry", AIR(""), "0.7"},
    {"atmosphere.layers[].exponential.height", EXPONENTIAL(""), NULL},
    {"atmosphere.layers[].tent.center", LAYER("tent: {center: 2 km, width: 1 km}"), NULL},
    {"atmosphere.layers[].tent.width", LAYER("tent: {center: 2 km, width: 1 km}"), NULL},
    {"atmosphere.layers[].table", LAYER("table: [[0 m, 1], [5 km, 0]]"), "[[0 m, 1], [3 km, 0]]"},
    {"atmosphere.layers[].bottom", EXPONENTIAL(""), "1 km"},
    {"atmosphere.layers[].top", EXPONENTIAL(""), "1 km"},
    {"atmosphere.layers[].scattering", EXPONENTIAL(""), NULL},
    {"atmosphere.layers[].absorption", EXPONENTIAL(""), NULL},
    {"atmosphere.layers[].absorber", EXPONENTIAL(""), "ozone"},
    {"atmosphere.layers[].phase", EXPONENTIAL(", phase: {hg: 0.7}"), "rayleigh"},
    {"atmosphere.layers[].phase.cornette_shanks", EXPONENTIAL(", phase: {cornette_shanks: 0.7}"), NULL},
    {"atmosphere.layers[].phase.hg", EXPONENTIAL(", phase: {hg: 0.7}"), NULL},
    {"atmosphere.layers[].phase.haze", EXPONENTIAL(", phase: {haze: 0.8}"), NULL},
    {"atmosphere.layers[].phase.two_lobe.forward", EXPONENTIAL(", phase: {two_lobe: {}}"), "0.5"},
    {"atmosphere.layers[].phase.two_lobe.backward", EXPONENTIAL(", phase: {two_lobe: {}}"), "-0.1"},
    {"atmosphere.layers[].phase.two_lobe.weight", EXPONENTIAL(", phase: {two_lobe: {}}"), "0.4"},
    {"clouds[].name", CLOUD("") QUICK "output: {aovs: [mattes]}\n", "other"},
    {"clouds[].vdb", BOXES("extinction: 0.01 1/m") QUICK, "other.vdb"},
    {"clouds[].voxel", BOXES("extinction: 0.01 1/m") QUICK, "2 m"},
    {"clouds[].position", BOXES("extinction: 0.01 1/m") QUICK, "[20 m, 0, 60 m]"},
    {"clouds[].extinction", BOXES("extinction: 0.01 1/m") QUICK, NULL},
    {"clouds[].mean_free_path", BOXES("mean_free_path: 100 m") QUICK, NULL},
    {"clouds[].optical_depth", BOXES("optical_depth: 2") QUICK, NULL},
    {"clouds[].liquid_water.effective_radius", BOXES("liquid_water: {effective_radius: 10 um}") QUICK, NULL},
    {"clouds[].ramp.low_cut", NULL, "0.7"},
    {"clouds[].ramp.gamma", NULL, "2"},
    {"clouds[].interpolation", BOXES("extinction: 0.01 1/m") QUICK, "nearest"},
    {"clouds[].repeat", BOXES("extinction: 0.01 1/m") QUICK, "file"},
    {"clouds[].phase.hg", CLOUD("phase: {hg: 0.5}") QUICK, NULL},
    {"clouds[].phase.two_lobe.forward", CLOUD("phase: {two_lobe: {}}") QUICK, "0.5"},
    {"clouds[].phase.two_lobe.backward", CLOUD("phase: {two_lobe: {}}") QUICK, "-0.1"},
    {"clouds[].phase.two_lobe.weight", CLOUD("phase: {two_lobe: {}}") QUICK, "0.4"},
    {"clouds[].phase.mie.effective_radius", CLOUD("phase: {mie: {effective_radius: 2 um}}") QUICK, "3 um"},
    {"clouds[].phase.mie.effective_variance", CLOUD("phase: {mie: {effective_radius: 2 um}}") QUICK, "0.02"},
    {"clouds[].phase.rain.mode_diameter", CLOUD("phase: {rain: {}}") QUICK, "1 mm"},
    {"clouds[].phase.ice.habit", CLOUD("phase: {ice: {}}") QUICK, "plate"},
    {"clouds[].phase.draine.g", CLOUD("phase: {draine: {g: 0.5, alpha: 1}}") QUICK, NULL},
    {"clouds[].phase.draine.alpha", CLOUD("phase: {draine: {g: 0.5, alpha: 1}}") QUICK, NULL},
    {"clouds[].emission.temperature", NULL, "density"},
    {"clouds[].emission.kelvin", FIRE("flame: none, temperature: density"), "500 K"},
    {"clouds[].emission.flame", NULL, "density"},
    {"clouds[].emission.absorption", FIRE("flame: density, temperature: none"), NULL},
    {"clouds[].bake.top", BAKED("top: 100 m") QUICK, NULL},
    {"clouds[].bake.stretch", BAKED("thickness: 60 m, model: slab") QUICK, "2"},
    {"clouds[].bake.trails", BAKED("thickness: 60 m, model: trails") QUICK, NULL},
    {"clouds[].bake.trail_direction", BAKED("thickness: 60 m, model: trails") QUICK, "70 deg"},
    {"clouds[].bake.age", BAKED("thickness: 60 m, model: trails") QUICK, NULL},
    {"clouds[].bake.wind", BAKED("thickness: 60 m, time: 10 s") QUICK, "[5 m/s, 0]"},
    {"clouds[].bake.lifetime", BAKED("thickness: 60 m, time: 30 s") QUICK, "70 s"},
    {"clouds[].bake.shape.spheres", BAKED("thickness: 60 m, model: thermals") QUICK, "[[0, 0, 30 m, 30 m]]"},
    {"clouds[].bake.shape.curves", BAKED("thickness: 60 m, model: thermals") QUICK,
     "[[[0, 0, 30 m, 20 m], [40 m, 0, 30 m, 20 m]]]"},
    {"clouds[].bake.shape.mesh.up", SOLID, "z"},
    {"clouds[].bake.shape.mesh.unit", SOLID, "1.2 m"},
    {"clouds[].bake.shape.mesh.rotation", SOLID, "45 deg"},
    {"clouds[].bake.shape.mesh.position", SOLID, "[20 m, 0, 40 m]"},
    {"clouds[].bake.billow_frequencies", BAKED("thickness: 60 m, model: thermals") QUICK, NULL},
    {"terrain.ground_cover", ROCK, "savanna"},
    {"terrain.rock", ROCK, "none"},
    {"terrain.raw.size", RAW, "[8, 2]"},
    {"terrain.raw.type", RAW, "int16"},
    {"terrain.raw.byte_order", RAW, "big"},
    {"terrain.height_min", RAW, "20 m"},
    {"terrain.height_max", RAW, NULL},
    {"render.wavelengths", NULL, "6"},
    {"render.target_error", NULL, "0.05"},
    {"render.octaves.count", SCATTERING("octaves"), "2"},
    {"render.octaves.factors", SCATTERING("octaves"), "[0.4, 0.4, 0.4]"},
    {"render.softened_beer.share", SCATTERING("softened_beer"), NULL},
    {"render.softened_beer.rate", SCATTERING("softened_beer"), NULL},
    {"render.powder.strength", SCATTERING("powder"), "0.5"},
    {"render.derivative.distance", SCATTERING("derivative"), NULL},
    {"render.approximation_gain", SCATTERING("octaves"), "0.5"},
    {"render.max_scatterings", NULL, "1"},
    {"render.transmittance_end", NULL, "0.5"},
    {"render.atmosphere", CLOUD_IN_AIR "render: {integrator: path, samples: 1}\n", "tables"},
    {"render.path_guiding", CLOUD("") "render: {integrator: path}\n", "adjoint"},
    {"render.air_shadows", CLOUD_IN_AIR QUICK, "true"},
    {"render.light_detail", NULL, "4"},
    {"render.light_depth", NULL, "0.02"},
    {"output.aovs", NULL, "[mattes]"},
    {"output.scale", NULL, "4"},
};

/* Keys without an effect in such a scene, by the test that shows one: its file in tests, which names the key. They are
 * of files, sequences, nights, eyes and outputs, or of stages that pay in larger pictures alone. */
static const struct {
  const char *path, *file;
} elsewhere[] = {
    {"version", "test_scene_file.c"},
    {"place.latitude", "cli/sun_time.sh"},
    {"place.longitude", "cli/sun_time.sh"},
    {"sun.time", "cli/sun_time.sh"},
    {"sun.frame_time", "test_animation.c"},
    {"sun.limb_darkening", "test_night.c"},
    {"moon.earthshine", "test_switches.c"},
    {"moon.map", "test_stars.c"},
    {"stars", "test_night.c"},
    {"stars.catalogue", "test_star_field.c"},
    {"stars.faintest", "test_night.c"},
    {"stars.map", "test_stars.c"},
    {"stars.map_radiance", "test_night.c"},
    {"stars.sidereal_time", "test_night.c"},
    {"stars.twinkling", "test_night.c"},
    {"airglow", "test_night.c"},
    {"airglow.magnitude", "test_night.c"},
    {"airglow.altitude", "test_night.c"},
    {"camera.shutter", "test_camera_pictures.c"},
    {"camera.iso", "test_camera_pictures.c"},
    {"camera.stereo", "test_camera_kinds.c"},
    {"camera.stereo.interaxial", "test_camera_kinds.c"},
    {"camera.stereo.convergence", "test_camera_kinds.c"},
    {"camera.motion.file", "test_camera_file.c"},
    {"camera.motion.camera", "test_camera_file.c"},
    {"clouds[].netcdf.file", "test_model_scenes.c"},
    {"clouds[].netcdf.variable", "test_model_scenes.c"},
    {"clouds[].netcdf.ice", "test_model_scenes.c"},
    {"clouds[].netcdf.radius", "test_model_scenes.c"},
    {"clouds[].netcdf.number", "test_model_scenes.c"},
    {"clouds[].netcdf.effective_radius", "test_model_scenes.c"},
    {"clouds[].netcdf.ice_effective_radius", "test_model_scenes.c"},
    {"clouds[].netcdf.droplet_number", "test_model_scenes.c"},
    {"clouds[].netcdf.dispersion", "test_model_scenes.c"},
    {"clouds[].netcdf.spacing", "test_model_scenes.c"},
    {"clouds[].netcdf.step", "test_model_scenes.c"},
    {"clouds[].missing", "test_sequence.c"},
    {"clouds[].frame_offset", "test_sequence.c"},
    {"clouds[].frame_speed", "test_sequence.c"},
    {"clouds[].reference_frame", "test_sequence.c"},
    {"clouds[].grid", "test_cloud_files.c"},
    {"clouds[].velocity", "test_motion_blur.c"},
    {"clouds[].velocity_scale", "test_motion_blur.c"},
    {"clouds[].color", "test_cloud_colors.c"},
    {"clouds[].level_set", "test_vdb_kinds.c"},
    {"clouds[].import", "test_cloud_colors.c"},
    {"clouds[].places", "test_places.c"},
    {"clouds[].pivot", "test_placement.c"},
    {"clouds[].phase.droplets.sizes", "test_cloud_sizes.c"},
    {"clouds[].phase.table", "cli/phase_table.sh"},
    {"clouds[].emission.color", "test_cloud_colors.c"},
    {"clouds[].detail", "test_brick_detail.c"},
    {"clouds[].detail.strength", "test_brick_detail.c"},
    {"clouds[].detail.size", "test_brick_detail.c"},
    {"clouds[].detail.seed", "test_brick_detail.c"},
    {"clouds[].bake.preset", "test_cloud_presets.c"},
    {"clouds[].bake.repeat", "test_sheets.c"},
    {"clouds[].bake.levels", "test_bake_lod.c"},
    {"clouds[].bake.level_pixels", "test_bake_lod.c"},
    {"clouds[].bake.billow_amounts", "test_cloud_sliders.c"},
    {"clouds[].bake.wisp_amounts", "test_cloud_sliders.c"},
    {"clouds[].bake.wisp_frequencies", "test_thermals.c"},
    {"clouds[].bake.cells.size", "test_mesoscale.c"},
    {"clouds[].bake.ground_lift", "test_cloud_kinds.c"},
    {"clouds[].bake.ground_cover", "test_repeat.c"},
    {"clouds[].bake.profile", "cli/bake_bad_input.sh"},
    {"clouds[].bake.wind_speed", "test_cloud_wind.c"},
    {"clouds[].bake.wind_direction", "test_thermals.c"},
    {"clouds[].bake.map.image", "cli/bake_preview_map.sh"},
    {"clouds[].bake.map.file", "test_measured_files.c"},
    {"clouds[].bake.map.quantity", "test_measured_files.c"},
    {"clouds[].bake.map.band", "test_measured_files.c"},
    {"clouds[].bake.map.sun.elevation", "test_measured_files.c"},
    {"clouds[].bake.map.sun.azimuth", "test_measured_files.c"},
    {"clouds[].bake.map.view.elevation", "test_measured_files.c"},
    {"clouds[].bake.map.view.azimuth", "test_measured_files.c"},
    {"clouds[].bake.map.ground_albedo", "test_measured_files.c"},
    {"clouds[].bake.map.threshold", "test_measured_files.c"},
    {"clouds[].bake.map.depth_max", "test_measured_files.c"},
    {"clouds[].bake.map.top.file", "test_measured_files.c"},
    {"clouds[].bake.map.top.quantity", "test_measured_files.c"},
    {"clouds[].bake.map.top.band", "test_measured_files.c"},
    {"clouds[].bake.map.top.ground_temperature", "test_measured_files.c"},
    {"clouds[].bake.map.coverage", "test_weather_map.c"},
    {"clouds[].bake.map.type", "test_weather_map.c"},
    {"clouds[].bake.map.base", "test_weather_map.c"},
    {"clouds[].bake.map.thickness", "test_weather_map.c"},
    {"clouds[].bake.map.precipitation", "test_weather_map.c"},
    {"clouds[].bake.map.age", "test_map_picture.c"},
    {"clouds[].bake.map.size", "test_map_picture.c"},
    {"clouds[].bake.map.tiling", "test_weather_map.c"},
    {"clouds[].bake.shape.mesh.file", "test_cloud_shape.c"},
    {"clouds[].bake.shape.height_map.image", "test_cloud_shape.c"},
    {"clouds[].bake.shape.height_map.channel", "test_cloud_shape.c"},
    {"clouds[].bake.shape.height_map.size", "test_cloud_shape.c"},
    {"clouds[].bake.shape.height_map.height", "test_cloud_shape.c"},
    {"terrain.heightfield", "cli/terrain_rasters.sh"},
    {"terrain.crs", "test_raster.c"},
    {"terrain.vertical_unit", "test_raster.c"},
    {"terrain.encoding", "test_raster_refusals.c"},
    {"terrain.edge", "test_terrain_edges.c"},
    {"terrain.mesh.file", "test_mesh_ground.c"},
    {"terrain.mesh.up", "test_mesh_ground.c"},
    {"terrain.mesh.unit", "test_mesh_ground.c"},
    {"terrain.mesh.rotation", "test_mesh_ground.c"},
    {"terrain.mesh.position", "test_mesh_ground.c"},
    {"terrain.mesh.pivot", "test_mesh_ground.c"},
    {"terrain.mesh.normals", "test_mesh_ground.c"},
    {"terrain.albedo_image", "test_ground_pictures.c"},
    {"terrain.rock.albedo", "test_ground_pictures.c"},
    {"terrain.rock.slope", "test_ground_pictures.c"},
    {"terrain.snow", "test_ground_pictures.c"},
    {"terrain.snow.albedo", "test_ground_pictures.c"},
    {"terrain.snow.level", "test_ground_pictures.c"},
    {"terrain.snow.slope", "test_ground_pictures.c"},
    {"render.detail", "test_quality.c"},
    {"render.max_samples", "test_time_limit.c"},
    {"render.time_limit", "test_time_limit.c"},
    {"render.light_memory", "test_light_reuse.c"},
    {"render.light_reuse", "test_animation.c"},
    {"render.history_update", "test_history.c"},
    {"render.history_weight", "test_history.c"},
    {"render.history_frames", "test_history.c"},
    {"output.image", "cli/same_files.sh"},
    {"output.preview", "cli/render_preview.sh"},
    {"output.deep", "test_deep.c"},
    {"output.cloud_air", "test_channels.c"},
    {"output.pixel_type", "test_ground_pictures.c"},
    {"output.exposure", "cli/render_preview.sh"},
    {"output.view", "cli/render_preview.sh"},
    {"output.view.ocio", "test_ocio.c"},
    {"output.view.display", "test_ocio.c"},
    {"output.view.view", "test_ocio.c"},
    {"output.view.input", "test_ocio.c"},
    {"output.glare", "test_preview_camera.c"},
    {"output.preview_bits", "cli/render_preview.sh"},
    {"output.film.background", "test_channels.c"},
    {"output.film.disks", "test_sky_dome.c"},
    {"frame_rate", "test_motion_blur.c"},
};
/* clang-format on */

static const char *get_home(const char *path) {
  const char *scene = NULL;
  size_t longest = 0;
  for (size_t i = 0; i < sizeof homes / sizeof *homes; i++) {
    const size_t length = strlen(homes[i].section);
    if (strncmp(homes[i].section, path, length) != 0 || (scene && length < longest)) continue;
    scene = homes[i].scene;
    longest = length;
  }
  return scene;
}

static void get_example(const np_key *key, const char **out_scene, const char **out_value) {
  *out_scene = get_home(key->path);
  *out_value = NULL;
  for (size_t i = 0; i < sizeof examples / sizeof *examples; i++) {
    if (strcmp(examples[i].path, key->path) != 0) continue;
    if (examples[i].scene) *out_scene = examples[i].scene;
    *out_value = examples[i].value;
  }
}

static bool is_elsewhere(const np_key *key) {
  for (size_t i = 0; i < sizeof elsewhere / sizeof *elsewhere; i++)
    if (!strcmp(elsewhere[i].path, key->path)) return true;
  return false;
}

/* ---- Tests ---- */

static bool has_value(const np_key *key) {
  return key->type == NP_KEY_SECTION ? key->choices != NULL : key->type != NP_KEY_LIST && key->type != NP_KEY_TRACKS;
}

/* Result of an unchanged scene, computed once. */
typedef struct base {
  const char *scene;
  outcome outcome;
} base;

static const outcome *get_base(test_fixture *f, base *bases, unsigned *count, const char *scene_text) {
  for (unsigned i = 0; i < *count; i++)
    if (!strcmp(bases[i].scene, scene_text)) return &bases[i].outcome;
  assert_true(*count < BASES_MAX);
  neph_scene *scene = load(f, scene_text);
  base *new_base = &bases[(*count)++];
  new_base->scene = scene_text;
  if (!render(scene, &new_base->outcome)) fail_msg("%s\n%s", scene_text, f->log.text);
  neph_scene_destroy(scene);
  return &new_base->outcome;
}

/* Difference that a near value, or the example's, makes; NULL: none. */
static const char *change_key(test_fixture *f, const np_key *key, base *bases, unsigned *count, char *value,
                              size_t size) {
  const char *scene_text, *given, *difference = NULL;
  char path[TEXT_SIZE], old[TEXT_SIZE];
  get_example(key, &scene_text, &given);
  const outcome *before = get_base(f, bases, count, scene_text);
  outcome after = {NULL, NULL};
  neph_scene *scene = load(f, scene_text);
  write_path(key, path, sizeof path);
  read_value(f, scene, path, old, sizeof old);
  if (given)
    snprintf(value, size, "%s", given);
  else
    change_value(key, old, value, size);
  test_log_clear(&f->log);
  if (!neph_scene_set(scene, path, value) && render(scene, &after)) difference = name_difference(before, &after);
  clear(f, &after);
  neph_scene_destroy(scene);
  return difference;
}

static void every_key_named_elsewhere_is_there(void **state) {
  (void)state;
  for (size_t i = 0; i < sizeof elsewhere / sizeof *elsewhere; i++) {
    char *path = test_path(NEPHOS_TEST_SOURCE_DIR, elsewhere[i].file);
    const test_file file = test_file_read(path);
    const char *name = strrchr(elsewhere[i].path, '.') ? strrchr(elsewhere[i].path, '.') + 1 : elsewhere[i].path;
    if (!memmem(file.bytes, file.size, name, strlen(name)))
      fail_msg("tests/%s does not name %s: name another file in `elsewhere`", elsewhere[i].file, elsewhere[i].path);
    free(file.bytes);
    free(path);
  }
}

static void write_files(const test_fixture *f) {
  static const test_box boxes[] = {{{0, 0, 0}, {16, 16, 8}, 0.5f}, {{0, 0, 8}, {16, 16, 16}, 1.0f}};
  static const char poses[] = "1 0 60 300 0 0 0 50\n5 20 60 300 5 10 15 50\n9 40 60 300 10 20 30 50\n";
  char *both = test_path(f->folder, "boxes.vdb"), *one = test_path(f->folder, "other.vdb");
  char *chan = test_path(f->folder, "poses.chan");
  test_boxes_write(f->context, both, "density", boxes, 2);
  test_boxes_write(f->context, one, "density", boxes, 1);
  test_file_write_text(chan, poses);
  static const uint16_t heights[16] = {1000, 20000, 40000, 60000, 3000, 500, 0, 50000, 9, 99, 999, 9999};
  static const char solid[] = "v -40 0 -20\nv 40 0 -20\nv 0 0 30\nv 0 40 0\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n";
  char *raw = test_path(f->folder, "heights.raw"), *obj = test_path(f->folder, "solid.obj");
  test_file_write(raw, heights, sizeof heights);
  test_file_write_text(obj, solid);
  free(both), free(one), free(chan), free(raw), free(obj);
}

/* The same scene twice: no chance makes a difference. */
static void a_scene_without_a_change_has_no_effect(void **state) {
  test_fixture *f = *state;
  write_files(f);
  for (size_t i = 0; i < sizeof homes / sizeof *homes; i++) {
    outcome outcomes[2] = {{NULL, NULL}, {NULL, NULL}};
    for (int k = 0; k < 2; k++) {
      neph_scene *scene = load(f, homes[i].scene);
      if (!render(scene, &outcomes[k])) fail_msg("%s\n%s", homes[i].scene, f->log.text);
      neph_scene_destroy(scene);
    }
    const char *difference = name_difference(&outcomes[0], &outcomes[1]);
    if (difference) fail_msg("%s differ by chance\n%s", difference, homes[i].scene);
    for (int k = 0; k < 2; k++) clear(f, &outcomes[k]);
  }
}

static void every_key_has_an_effect(void **state) {
  test_fixture *f = *state;
  static base bases[BASES_MAX];
  unsigned count = 0, failed = 0;
  write_files(f);
  for (size_t i = 0; i < np_key_count(); i++) {
    const np_key *key = np_key_get(i);
    char value[TEXT_SIZE] = "";
    if (!has_value(key) || is_elsewhere(key) || change_key(f, key, bases, &count, value, sizeof value)) continue;
    print_error("%s = %s changes neither pixels nor header nor plan. %s\n", key->path, value, f->log.text);
    failed++;
  }
  for (unsigned i = 0; i < count; i++) clear(f, &bases[i].outcome);
  if (failed)
    fail_msg("%u keys have no effect: give each a row of `examples` in tests/test_key_effects.c, a scene in which it "
             "counts and a value, or name in `elsewhere` the test that shows its effect",
             failed);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_key_named_elsewhere_is_there),
      cmocka_unit_test_setup_teardown(a_scene_without_a_change_has_no_effect, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(every_key_has_an_effect, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
