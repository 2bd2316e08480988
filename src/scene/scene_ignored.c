/* SPDX-License-Identifier: Apache-2.0 */
#include <stddef.h>
#include <string.h>
#include <strings.h>

#include "core/frame_name.h"
#include "core/text.h"
#include "scene/scene_apply.h"
#include "volume/volume_private.h"

#define ONLY(value) (1u << (value))
#define BUT(value) (~ONLY(value))
#define MULTIPLE(kind) ONLY(NEPH_MULTIPLE_SCATTERING_##kind)

/* clang-format off */
#define NEEDS(need) (NP_MULTIPLE_SCATTERING_NEEDS_##need == NP_MULTIPLE_SCATTERING_NEEDS_APPROXIMATION)
#define APPROXIMATION(id, name, need) | (NEEDS(need) ? MULTIPLE(id) : 0u)
#define APPROXIMATIONS (0u NP_MULTIPLE_SCATTERING_ROWS(APPROXIMATION))
#define CONSTITUENTS                                                                                                   \
  "atmosphere.rayleigh_scattering", "atmosphere.rayleigh_height", "atmosphere.mie_scattering",                         \
  "atmosphere.mie_extinction", "atmosphere.mie_height", "atmosphere.mie_asymmetry", "atmosphere.ozone_absorption",     \
  "atmosphere.ozone_center", "atmosphere.ozone_width", "atmosphere.haze", "atmosphere.visibility"
#define IN_PERSPECTIVE {"camera.kind", ONLY(NEPH_CAMERA_PERSPECTIVE)}
#define WITH_PLANET {"environment.planet", ONLY(1)}
#define OWN_MODELS                                                                                                     \
  (ONLY(NEPH_CLOUD_MODEL_FOG) | ONLY(NEPH_CLOUD_MODEL_LENSES) | ONLY(NEPH_CLOUD_MODEL_TRAILS) |                        \
   ONLY(NEPH_CLOUD_MODEL_DECK) | ONLY(NEPH_CLOUD_MODEL_STREAKS))
#define IN_TOWERS {"clouds[].bake.model", BUT(NEPH_CLOUD_MODEL_SLAB) & ~OWN_MODELS}
#define IN_WEATHER                                                                                                     \
  {"clouds[].bake.model", ONLY(NEPH_CLOUD_MODEL_CELLS) | ONLY(NEPH_CLOUD_MODEL_SLAB) |                                 \
                              ONLY(NEPH_CLOUD_MODEL_THERMALS) | ONLY(NEPH_CLOUD_MODEL_DECK)}
#define IN_MARCH {"render.integrator", ONLY(NEPH_INTEGRATOR_MARCH)}
#define IN_PATHS {"render.integrator", ONLY(NEPH_INTEGRATOR_PATH)}
#define RAMP_KEYS                                                                                                      \
  "clouds[].ramp.low_cut", "clouds[].ramp.offset", "clouds[].ramp.gain", "clouds[].ramp.gamma"
#define NUMBER_KEYS "clouds[].frame_offset", "clouds[].frame_speed"
#define MEASURED_KEYS                                                                                                  \
  "clouds[].bake.map.quantity", "clouds[].bake.map.band", "clouds[].bake.map.threshold", "clouds[].bake.map.top"
#define IN_SHEETS                                                                                                      \
  {"clouds[].bake.model", BUT(NEPH_CLOUD_MODEL_CELLS) & BUT(NEPH_CLOUD_MODEL_THERMALS) & BUT(NEPH_CLOUD_MODEL_HERO)}
#define WITHOUT_MODEL {"clouds[].netcdf", ONLY(NP_GIVEN_NOT)}
#define WITHOUT_SHAPE {"clouds[].bake.shape", ONLY(NP_GIVEN_NOT)}
#define IN_HEAPS                                                                                                       \
  {"clouds[].bake.model", ONLY(NEPH_CLOUD_MODEL_THERMALS) | ONLY(NEPH_CLOUD_MODEL_HERO)}
#define LIGHT_KEYS                                                                                                     \
  "render.light_memory", "render.light_detail", "render.light_depth", "render.light_degree",                           \
      "render.light_residual", "render.light_reuse"

/* One rule at most warns of a key: each rule after the first for a key has a condition `applies`. */
static const np_ignore_rule rules[] = {
    {.keys = {"camera.fov", "camera.focal_length", "camera.focus_distance", "camera.blades", "camera.sensor"},
     .counts = IN_PERSPECTIVE, .reason = "and only a perspective uses it"},
    {.keys = {"camera.focus_distance", "camera.blades"}, .counts = {"camera.f_stop", ONLY(NP_GIVEN)},
     .reason = "a pinhole, with all in focus", .applies = IN_PERSPECTIVE},
    {.keys = {"camera.fisheye_fov"}, .counts = {"camera.kind", ONLY(NEPH_CAMERA_FISHEYE)},
     .reason = "which is no circle"},
    {.keys = {"camera.orthographic_width"}, .counts = {"camera.kind", ONLY(NEPH_CAMERA_ORTHOGRAPHIC)},
     .reason = "and only parallel rays ask for it"},
    {.keys = {"camera.shift"},
     .counts = {"camera.kind", ONLY(NEPH_CAMERA_PERSPECTIVE) | ONLY(NEPH_CAMERA_ORTHOGRAPHIC)},
     .reason = "whose picture is in no plane"},
    {.keys = {"camera.roll"}, .counts = {"camera.kind", BUT(NEPH_CAMERA_EQUIRECTANGULAR)},
     .reason = "which stays level"},

    {.keys = {"sun.frame_time"}, .counts = {"sun.time", ONLY(NP_GIVEN)}, .reason = "from which it would go on"},

    {.keys = {"water.level", "water.wind", "water.albedo"}, .counts = WITH_PLANET,
     .reason = "on which the water lies"},
    {.keys = {"terrain.width"}, .counts = {"terrain.heightfield", BUT(NP_GIVEN_HGT)},
     .reason = "a tile whose name and size say how wide it is"},
    {.keys = {"terrain.height_min", "terrain.height_max"},
     .counts = {"terrain.heightfield", ONLY(NP_GIVEN_PNG) | ONLY(NP_GIVEN_RAW) | ONLY(NP_GIVEN_NOT)},
     .reason = "whose elevations have a unit"},
    {.keys = {"terrain.crs", "terrain.vertical_unit"}, .counts = {"terrain.heightfield", ONLY(NP_GIVEN)},
     .reason = "and only a raster with a coordinate system uses it"},
    {.keys = {"terrain.encoding"}, .counts = {"terrain.heightfield", ONLY(NP_GIVEN) | ONLY(NP_GIVEN_PNG)},
     .reason = "whose samples are no colours"},
    {.keys = {"terrain.raw"}, .counts = {"terrain.heightfield", ONLY(NP_GIVEN_RAW)},
     .reason = "and only .r16 and .raw have no header"},
    {.keys = {"terrain.height_min", "terrain.height_max"}, .counts = {"terrain.ridges", ONLY(NP_GIVEN_NOT)},
     .reason = "whose elevations go from 0 to their relief"},

    {.keys = {"atmosphere.top_altitude", "atmosphere.tolerance", "atmosphere.ground_albedo", "atmosphere.layers",
              CONSTITUENTS},
     .counts = WITH_PLANET, .reason = "which takes the air with the planet"},
    {.keys = {"atmosphere.top_altitude", "atmosphere.tolerance", "atmosphere.layers"},
     .counts = {"atmosphere.preset", BUT(NP_AIR_NONE)}, .reason = "a world without air", .applies = WITH_PLANET},
    {.keys = {CONSTITUENTS}, .counts = {"atmosphere.preset", BUT(NP_AIR_NONE) & BUT(NP_AIR_EMPTY)},
     .reason = "which has none of it", .applies = WITH_PLANET},
    {.keys = {"stars.map_radiance"}, .counts = {"stars.map", BUT(NP_GIVEN_NOT)},
     .reason = "the picture whose values it scales"},

    {.keys = {"clouds[].grid", "clouds[].velocity", "clouds[].velocity_scale", "clouds[].color",
              "clouds[].import", "clouds[].level_set", RAMP_KEYS},
     .counts = {"clouds[].vdb", BUT(NP_GIVEN_NOT)}, .reason = "which names their file", .applies = WITHOUT_MODEL},
    {.keys = {"clouds[].missing"}, .counts = {"clouds[].bake", ONLY(NP_GIVEN_NOT)},
     .reason = "from whose time frames go"},
    {.keys = {NUMBER_KEYS}, .counts = {"clouds[].bake.map.image", ONLY(NP_GIVEN_NUMBERED)},
     .reason = "so that frames go from the time of the bake alone", .applies = {"clouds[].bake", BUT(NP_GIVEN_NOT)},
     .lapses = {"clouds[].bake.map.file", ONLY(NP_GIVEN_NUMBERED)}},
    {.keys = {MEASURED_KEYS}, .counts = {"clouds[].bake.map.file", BUT(NP_GIVEN_NOT)},
     .reason = "the measured map that they describe"},
    {.keys = {"clouds[].bake.map.sun", "clouds[].bake.map.view", "clouds[].bake.map.ground_albedo",
              "clouds[].bake.map.depth_max"},
     .counts = {"clouds[].bake.map.quantity", BUT(NP_MAP_OPTICAL_DEPTH)}, .reason = "which needs no conversion",
     .applies = {"clouds[].bake.map.file", BUT(NP_GIVEN_NOT)}},
    {.keys = {"clouds[].bake.extinction"}, .counts = {"clouds[].bake.map.file", ONLY(NP_GIVEN_NOT)},
     .reason = "which gives the optical depth", .applies = WITHOUT_SHAPE},
    {.keys = {"clouds[].bake.coverage"}, .counts = IN_SHEETS,
     .reason = "whose clouds stand where the measured map has them",
     .applies = {"clouds[].bake.map.file", BUT(NP_GIVEN_NOT)}},
    {.keys = {"clouds[].missing", NUMBER_KEYS},
     .counts = {"clouds[].vdb", ONLY(NP_GIVEN_NUMBERED) | ONLY(NP_GIVEN_NOT)},
     .reason = "the same file in every frame", .applies = {"clouds[].bake", ONLY(NP_GIVEN_NOT)}},
    {.keys = {"clouds[].missing", NUMBER_KEYS}, .counts = {"clouds[].netcdf.file", ONLY(NP_GIVEN_NUMBERED)},
     .reason = "the same file in every frame", .applies = {"clouds[].netcdf", BUT(NP_GIVEN_NOT)},
     .lapses = {"clouds[].netcdf.step", ONLY(NP_GIVEN_FRAME)}},
    {.keys = {"clouds[].pivot"}, .counts = {"clouds[].position", ONLY(NP_GIVEN)}, .reason = "at which it would stand",
     .applies = {"clouds[].places", ONLY(NP_GIVEN_NOT)}},
    {.keys = {"clouds[].emission.kelvin"}, .counts = {"clouds[].emission.temperature", BUT(NP_GIVEN_NONE)},
     .reason = "so that the offset is the temperature everywhere"},
    {.keys = {"clouds[].emission.absorption"}, .counts = {"clouds[].emission.flame", BUT(NP_GIVEN_NONE)},
     .reason = "so that the extinction of its density emits"},
    {.keys = {"clouds[].bake.type", "clouds[].bake.map.type", "clouds[].bake.wispiness"},
     .counts = IN_TOWERS, .reason = "which has no towers"},
    {.keys = {"clouds[].bake.type", "clouds[].bake.map.type"},
     .counts = {"clouds[].bake.profile", ONLY(NP_GIVEN_NOT)},
     .reason = "which says in its place how high a cell grows", .applies = IN_TOWERS},
    {.keys = {"clouds[].bake.coverage", "clouds[].bake.cell", "clouds[].bake.streets", "clouds[].bake.cells.kind",
              "clouds[].bake.map"},
     .counts = WITHOUT_SHAPE, .reason = "which stands in the place of the weather map"},
    {.keys = {"clouds[].bake.coverage"}, .counts = {"clouds[].bake.map.coverage", ONLY(NP_GIVEN_NOT)},
     .reason = "the channel that is the coverage itself, white 1: remove bake.coverage, or darken the channel",
     .applies = WITHOUT_SHAPE},
    {.keys = {"clouds[].bake.coverage"}, .counts = {"clouds[].bake.map", BUT(NP_GIVEN_PNG) & BUT(NP_GIVEN_EXR)},
     .reason = "a picture that is the coverage itself, white 1: remove bake.coverage, or darken the picture",
     .applies = WITHOUT_SHAPE},
    {.keys = {"clouds[].bake.map.age"}, .counts = IN_HEAPS, .reason = "and only thermals age by place"},
    {.keys = {"clouds[].bake.sublayers"},
     .counts = {"clouds[].bake.model", ONLY(NEPH_CLOUD_MODEL_SLAB) | ONLY(NEPH_CLOUD_MODEL_LENSES)},
     .reason = "and only a slab and lenses have them"},
    {.keys = {"clouds[].bake.level_pixels"}, .counts = {"clouds[].bake.levels", ONLY(NP_GIVEN)},
     .reason = "so that all voxels are of one size"},
    {.keys = {"clouds[].bake.stretch"},
     .counts = {"clouds[].bake.model", ONLY(NEPH_CLOUD_MODEL_SLAB) | ONLY(NEPH_CLOUD_MODEL_FOG) |
                                           ONLY(NEPH_CLOUD_MODEL_DECK) | ONLY(NEPH_CLOUD_MODEL_STREAKS)},
     .reason = "which has no pattern along the wind"},
    {.keys = {"clouds[].bake.streets", "clouds[].bake.cells.kind", "clouds[].bake.cells.size"},
     .counts = IN_WEATHER, .reason = "which has no streets or cells"},
    {.keys = {"clouds[].bake.cells.size"}, .counts = {"clouds[].bake.cells.kind", BUT(NEPH_CLOUD_CELLS_NONE)},
     .reason = "so that there are no cells", .applies = IN_WEATHER},
    {.keys = {"clouds[].bake.billowiness"},
     .counts = {"clouds[].bake.model", BUT(NEPH_CLOUD_MODEL_SLAB) & BUT(NEPH_CLOUD_MODEL_LENSES) &
                                           BUT(NEPH_CLOUD_MODEL_TRAILS) & BUT(NEPH_CLOUD_MODEL_STREAKS)},
     .reason = "which has no billows"},
    {.keys = {"clouds[].bake.trails", "clouds[].bake.trail_direction"},
     .counts = {"clouds[].bake.model", ONLY(NEPH_CLOUD_MODEL_TRAILS)}, .reason = "and only trails have them"},
    {.keys = {"clouds[].bake.anvil"},
     .counts = {"clouds[].bake.model", ONLY(NEPH_CLOUD_MODEL_CELLS) | ONLY(NEPH_CLOUD_MODEL_THERMALS)},
     .reason = "and only cells and thermals spread to anvils"},
    {.keys = {"clouds[].bake.age"},
     .counts = {"clouds[].bake.model", ONLY(NEPH_CLOUD_MODEL_THERMALS) | ONLY(NEPH_CLOUD_MODEL_HERO) |
                                           ONLY(NEPH_CLOUD_MODEL_TRAILS)},
     .reason = "and only thermals and trails age"},

    {.keys = {"clouds[].bake.wind_direction"}, .counts = {"clouds[].bake.wind_speed", BUT(NP_GIVEN_NOT)},
     .reason = "so that there is no wind to come from it"},

    {.keys = {"render.history_update", "render.history_weight", "render.history_frames"},
     .counts = {"render.history", BUT(NP_HISTORY_NONE)}, .reason = "so that each frame is rendered by itself"},
    {.keys = {"render.max_samples"}, .counts = {"render.target_error", ONLY(NP_GIVEN)},
     .reason = "without which each pixel has render.samples"},
    {.keys = {"render.atmosphere", "render.path_guiding"}, .counts = IN_PATHS, .reason = "and only paths ask for it"},
    {.keys = {"render.multiple_scattering", "render.approximation_gain", "render.octaves", "render.softened_beer",
              "render.powder", "render.derivative", "render.step", "render.transmittance_end"},
     .counts = IN_MARCH, .reason = "and only the march uses it"},
    {.keys = {"render.tolerance"}, .counts = IN_MARCH, .reason = "and only the march uses it",
     .applies = {"render.atmosphere", ONLY(NEPH_RENDER_ATMOSPHERE_TRACED)}},
    {.keys = {"render.air_shadows"}, .counts = {"render.atmosphere", ONLY(NEPH_RENDER_ATMOSPHERE_TABLES)},
     .reason = "which has its shadows in any case", .applies = IN_PATHS},
    {.keys = {LIGHT_KEYS}, .counts = {"render.multiple_scattering", MULTIPLE(ORDINATES)},
     .reason = "for which nothing is solved", .applies = IN_MARCH},
    {.keys = {LIGHT_KEYS}, .counts = {"render.path_guiding", ONLY(NEPH_PATH_GUIDING_ADJOINT)},
     .reason = "for which nothing is solved", .applies = IN_PATHS},
    {.keys = {"render.approximation_gain"}, .counts = {"render.multiple_scattering", APPROXIMATIONS},
     .reason = "which takes none", .applies = IN_MARCH},
    {.keys = {"render.octaves"}, .counts = {"render.multiple_scattering", MULTIPLE(OCTAVES)},
     .reason = "must be octaves", .applies = IN_MARCH},
    {.keys = {"render.softened_beer"},
     .counts = {"render.multiple_scattering", MULTIPLE(SOFTENED_BEER) | MULTIPLE(POWDER)},
     .reason = "must be softened_beer or powder", .applies = IN_MARCH},
    {.keys = {"render.powder"}, .counts = {"render.multiple_scattering", MULTIPLE(POWDER)},
     .reason = "must be powder", .applies = IN_MARCH},
    {.keys = {"render.derivative"}, .counts = {"render.multiple_scattering", MULTIPLE(DERIVATIVE)},
     .reason = "must be derivative", .applies = IN_MARCH},
};
/* clang-format on */

enum { RULE_COUNT = sizeof rules / sizeof *rules, KEYS_MAX = sizeof rules->keys / sizeof *rules->keys };

size_t np_ignore_rule_count(void) { return RULE_COUNT; }

const np_ignore_rule *np_ignore_rule_get(size_t index) { return &rules[index]; }

/* ---- Values ---- */

/* The scene's document and fields, with one of its clouds if any. */
typedef struct place {
  const neph_scene *scene;
  const np_node *clouds_node; /* node of the cloud; NULL: not in a cloud */
  unsigned cloud;
} place;

static const char clouds_prefix[] = "clouds[].";

static bool is_of_cloud(const char *path) { return !strncmp(path, clouds_prefix, strlen(clouds_prefix)); }

/* Node of a path; NULL if the key is not set. */
static const np_node *search_node(const place *at, const char *path) {
  const bool is_in_cloud = is_of_cloud(path);
  const np_node *node = is_in_cloud ? at->clouds_node : at->scene->document;
  size_t begin = is_in_cloud ? strlen(clouds_prefix) : 0;
  while (node && path[begin]) {
    char name[32];
    const size_t length = strcspn(path + begin, ".");
    np_print(name, sizeof name, "%.*s", (int)length, path + begin);
    begin += length + (path[begin + length] == '.');
    if (node->kind == NP_NODE_SCALAR && !path[begin] && np_key_is_shorthand(np_key_search_path(path))) return node;
    node = np_node_search(node, name);
  }
  return node;
}

/* Writes a path with the index of the cloud: "clouds[2].bake.type". */
static void write_path(const place *at, const char *path, char *out, size_t size) {
  if (is_of_cloud(path))
    np_print(out, size, "clouds[%u].%s", at->cloud, path + strlen(clouds_prefix));
  else
    np_print(out, size, "%s", path);
}

static np_given get_given(const np_key *key, const np_node *node) {
  if (!node) return NP_GIVEN_NOT;
  if (node->kind != NP_NODE_SCALAR) return NP_GIVEN;
  if (!strcmp(node->text, "none")) return NP_GIVEN_NONE;
  if (!strcmp(node->text, "frame")) return NP_GIVEN_FRAME;
  static const struct {
    const char *ending;
    np_given given;
  } kinds[] = {{".hgt", NP_GIVEN_HGT},
               {".exr", NP_GIVEN_EXR},
               {".png", NP_GIVEN_PNG},
               {".r16", NP_GIVEN_RAW},
               {".raw", NP_GIVEN_RAW}};
  const char *ending = strrchr(node->text, '.');
  const bool may_be_numbered = key->is_numbered || np_volume_has_ending(node->text);
  if (may_be_numbered && np_frame_name_is_pattern(node->text)) return NP_GIVEN_NUMBERED;
  for (size_t i = 0; ending && i < sizeof kinds / sizeof *kinds; i++)
    if (!strcasecmp(ending, kinds[i].ending)) return kinds[i].given;
  return NP_GIVEN;
}

static unsigned get_choice(const place *at, const np_key *key) {
  const char *base = is_of_cloud(key->path) ? (const char *)&at->scene->clouds[at->cloud] : (const char *)at->scene;
  bool flag;
  unsigned value;
  memcpy(&flag, base + key->field.offset, sizeof flag);
  if (key->field.size == sizeof flag) return flag;
  memcpy(&value, base + key->field.offset, sizeof value);
  return value;
}

static unsigned get_value(const place *at, const char *path) {
  const np_key *key = np_key_search_path(path);
  return key->type == NP_KEY_CHOICE ? get_choice(at, key) : get_given(key, search_node(at, path));
}

static bool is_fulfilled(const place *at, const np_condition *condition) {
  return !condition->key || condition->values >> get_value(at, condition->key) & 1u;
}

/* Writes a key's value for a message: "is path", "is N44W072.hgt", "is given", "is not given". */
static void write_value(const place *at, const char *path, char *out, size_t size) {
  const np_key *key = np_key_search_path(path);
  const np_node *node = search_node(at, path);
  if (key->type == NP_KEY_CHOICE) {
    const np_choice *choice = key->choices;
    while (choice->value != get_choice(at, key)) choice++;
    np_print(out, size, "%s", choice->name);
  } else if (node && node->kind == NP_NODE_SCALAR) {
    np_print_short(out, size, node->text);
  } else {
    np_print(out, size, "%s", node ? "given" : "not given");
  }
}

/* ---- Warnings ---- */

static void warn(const place *at, const np_ignore_rule *rule, const char *path, const np_node *node) {
  char key[96], decider[96], value[128];
  write_path(at, path, key, sizeof key);
  write_path(at, rule->counts.key, decider, sizeof decider);
  write_value(at, rule->counts.key, value, sizeof value);
  np_scene_warn_key(at->scene, node, "%s is ignored: %s is %s, %s", key, decider, value, rule->reason);
}

/* Whether --set or an option sets a key. */
static bool is_set(const place *at, const char *path) {
  const np_node *node = path ? search_node(at, path) : NULL;
  return node && !node->key_line;
}

/* Whether an option overrides the file: with --integrator path, for example, no warning concerns the march's keys in
 * the file. */
static bool is_overridden(const place *at, const np_ignore_rule *rule, const np_node *node) {
  return node->key_line && (is_set(at, rule->counts.key) || is_set(at, rule->applies.key));
}

static void check_rule(const place *at, const np_ignore_rule *rule) {
  if (is_fulfilled(at, &rule->counts) || !is_fulfilled(at, &rule->applies)) return;
  if (rule->lapses.key && is_fulfilled(at, &rule->lapses)) return;
  for (int k = 0; k < KEYS_MAX && rule->keys[k]; k++) {
    const np_node *node = search_node(at, rule->keys[k]);
    if (node && !is_overridden(at, rule, node)) warn(at, rule, rule->keys[k], node);
  }
}

/* Map channels that scale a key, which may be 0; `applies`: no other rule warns of the channel. */
typedef struct map_share {
  const char *key, *whole;
  size_t whole_offset; /* offset in neph_cloud_desc */
  np_condition applies[2];
} map_share;

static const map_share map_shares[] = {
    {"clouds[].bake.map.type",
     "clouds[].bake.type",
     offsetof(neph_cloud_desc, type),
     {IN_TOWERS, {"clouds[].bake.profile", ONLY(NP_GIVEN_NOT)}}},
    {"clouds[].bake.map.precipitation", "clouds[].bake.precipitation", offsetof(neph_cloud_desc, precipitation), {{0}}},
    {"clouds[].bake.map.age", "clouds[].bake.age", offsetof(neph_cloud_desc, age), {IN_HEAPS}},
};

static void check_share(const place *at, const map_share *share) {
  const np_condition without_shape = WITHOUT_SHAPE;
  const np_node *node = search_node(at, share->key);
  double whole;
  char key[96], whole_key[96];
  memcpy(&whole, (const char *)&at->scene->clouds[at->cloud].bake + share->whole_offset, sizeof whole);
  if (!node || whole != 0 || !is_fulfilled(at, &without_shape)) return;
  if (!is_fulfilled(at, &share->applies[0]) || !is_fulfilled(at, &share->applies[1])) return;
  write_path(at, share->key, key, sizeof key);
  write_path(at, share->whole, whole_key, sizeof whole_key);
  np_scene_warn_key(at->scene, node, "%s is ignored: it scales %s, which is 0: raise that key", key, whole_key);
}

static void check_shares(const place *at) {
  for (size_t i = 0; i < sizeof map_shares / sizeof *map_shares; i++) check_share(at, &map_shares[i]);
}

void np_scene_warn_of_ignored(const neph_scene *scene) {
  const np_node *list = np_node_search(scene->document, "clouds");
  for (size_t i = 0; i < RULE_COUNT; i++) {
    place at = {.scene = scene, .clouds_node = list ? list->first : NULL};
    if (!is_of_cloud(rules[i].keys[0])) {
      check_rule(&at, &rules[i]);
      continue;
    }
    for (; at.clouds_node && at.cloud < scene->cloud_count; at.cloud++, at.clouds_node = at.clouds_node->next)
      check_rule(&at, &rules[i]);
  }
  place at = {.scene = scene, .clouds_node = list ? list->first : NULL};
  for (; at.clouds_node && at.cloud < scene->cloud_count; at.cloud++, at.clouds_node = at.clouds_node->next)
    check_shares(&at);
}
