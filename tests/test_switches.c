/* SPDX-License-Identifier: Apache-2.0 */
/* Every word that a key of a scene takes, rendered by both integrators: no value of an enumerated key crashes, fails or
 * leaves a pixel that is not a number.
 *
 * A cache on disk spares what a word does not change: each table, bake and solution is built for each of its inputs
 * once. A word left out of a cache's key would be seen as one that changes no picture.
 *
 * Keys and words are those of the key table: a word that is added there is rendered here. What a key needs beside it to
 * take effect is in `companions`; a key that changes no picture at all is an error unless `unseen` says why. */
#include <stdlib.h>

#include <png.h>

#include <nephos/nephos.h>

#include "cloud/presets.h"
#include "core/alloc.h"
#include "core/text.h"
#include "scene/scene_keys.h"
#include "test_meshes.h"
#include "test_shards.h"

enum { WORDS_MAX = 40, WIDTH = 16, HEIGHT = 9 };

/* ---- Contexts ---- */

typedef struct setting {
  bool is_path, has_air, has_terrain, has_cloud;
} setting;

/* Any two of the four meet in every way. Those of the march come first. */
static const setting settings[] = {{false, false, false, false}, {false, true, true, true}, {false, false, true, true},
                                   {true, false, true, true},    {true, true, false, true}, {true, true, true, false}};

enum { SETTING_COUNT = sizeof settings / sizeof *settings, MARCH_COUNT = 3 };

static void any_two_parts_of_a_scene_meet(void **state) {
  (void)state;
  for (int a = 0; a < 4; a++)
    for (int b = 0; b < a; b++) {
      unsigned met = 0;
      for (int i = 0; i < SETTING_COUNT; i++) {
        const bool part[4] = {settings[i].is_path, settings[i].has_air, settings[i].has_terrain, settings[i].has_cloud};
        met |= 1u << (2 * part[a] + part[b]);
      }
      assert_int_equal(met, 0xf);
    }
}

static bool begins_with(const char *path, const char *start) { return strncmp(path, start, strlen(start)) == 0; }

/* A key of clouds needs clouds, and so on. */
static setting suit(const np_key *key, setting s) {
  s.has_cloud = s.has_cloud || begins_with(key->path, "clouds");
  s.has_terrain = s.has_terrain || begins_with(key->path, "terrain");
  s.has_air = s.has_air || begins_with(key->path, "atmosphere");
  return s;
}

/* ---- Scenes ---- */

/* Settings applied before a key whose path begins with `start`, for `word` alone unless that is NULL. */
typedef struct companion {
  const char *start, *word, *key, *value;
} companion;

static const companion companions[] = {
    {"camera.motion", NULL, "camera.motion.file", "camera.chan"},
    {"camera.motion_blur", NULL, "camera.motion_blur", "{shutter: 0.5}"},
    {"camera.motion_blur", NULL, "animate", "{camera.fov: [[0, 50 deg], [2, 70 deg]]}"},
    {"camera.f_stop", NULL, "camera.f_stop", "0.001"},
    {"camera.stereo", NULL, "camera.stereo", "{interaxial: 200 m}"},
    {"output.exposure", "camera", "camera.f_stop", "8"},
    {"output.exposure", "camera", "camera.shutter", "0.01 s"},
    {"output.exposure", "camera", "camera.iso", "100"},
    {"moon", NULL, "sun.elevation", "-30 deg"},
    {"moon", NULL, "moon", "{elevation: 15 deg, azimuth: -10 deg}"},
    {"moon.earthshine", NULL, "camera.look_at", "[-168 m, -548 m, 1159 m]"}, /* the moon */
    {"moon.earthshine", NULL, "camera.fov", "0.7 deg"},
    {"stars", NULL, "sun.elevation", "-30 deg"},
    {"stars", NULL, "stars", "{sidereal_time: 100 deg}"},
    {"airglow", NULL, "sun.elevation", "-30 deg"},
    {"airglow", NULL, "airglow", "{}"},
    {"sun.limb_darkening", NULL, "sun.angular_radius", "8 deg"},
    {"atmosphere.layers[]", NULL, "atmosphere.layers", "[{scattering: 1e-4 1/m, absorption: 1e-5 1/m}]"},
    {"atmosphere.layers[].absorber", NULL, "render.wavelengths", "6"},
    {"clouds[].detail", NULL, "camera.fov", "14 deg"}, /* voxels of more than two pixels */
    {"clouds[].netcdf", NULL, "clouds[0].netcdf", "{file: " NEPHOS_TEST_SOURCE_DIR "/data/netcdf/ball.nc}"},
    {"clouds[].pivot", NULL, "clouds[0].position", "[0 m, 0 m, 900 m]"},
    {"clouds[].reference_frame", "all", "clouds[0].vdb", "cloud.####.vdb"},
    {"clouds[].reference_frame", NULL, "clouds[0].position", "[0 m, 0 m, 900 m]"},
    {"clouds[].bake.map", NULL, "clouds[1].bake.map", "{image: map.exr, coverage: R, size: 300 m}"},
    {"clouds[].bake.map.quantity", NULL, "clouds[1].bake.map", "{file: depths.asc}"},
    {"clouds[].bake.map.quantity", "reflectance", "clouds[1].bake.map",
     "{file: shares.asc, sun: {elevation: 40 deg, azimuth: 0 deg}}"},
    {"clouds[].bake.map.quantity", "radiance_factor", "clouds[1].bake.map",
     "{file: shares.asc, sun: {elevation: 40 deg, azimuth: 0 deg}}"},
    {"clouds[].bake.map.top.quantity", NULL, "clouds[1].bake.map", "{file: depths.asc, top: {file: heights.asc}}"},
    {"clouds[].bake.map.top.quantity", "temperature", "clouds[1].bake.map",
     "{file: depths.asc, top: {file: kelvins.asc}}"},
    {"clouds[].bake.repeat", NULL, "clouds[1].bake", "{preset: stratocumulus, voxel: 200 m}"}, /* a sheet */
    {"clouds[].bake.shape", NULL, "clouds[1].bake.model", "thermals"},
    {"clouds[].bake.shape.mesh", NULL, "clouds[1].bake.shape", "{mesh: {file: peak.gltf}}"},
    {"terrain.rock", NULL, "terrain.rock", "{slope: 5 deg}"},
    {"terrain.snow", NULL, "terrain.snow", "{level: 100 m}"},
    {"terrain.edge", NULL, "terrain", "{heightfield: field.r16, raw: {size: [9, 9]}, width: 2 km}"},
    {"terrain.vertical_unit", NULL, "terrain", "{heightfield: field.asc, crs: \"EPSG:32631\"}"},
    {"terrain.encoding", "terrain_rgb", "terrain", "{heightfield: tenths.png, width: 2 km}"},
    {"terrain.encoding", "terrarium", "terrain", "{heightfield: terrarium.png, width: 2 km}"},
    {"terrain.raw", NULL, "terrain", "{heightfield: field.r16, raw: {size: [9, 9]}, width: 2 km}"},
    {"terrain.raw.type", "float32", "terrain", "{heightfield: field.raw, raw: {size: [9, 9]}, width: 2 km}"},
    {"terrain.mesh", NULL, "terrain", "{mesh: {file: hill.obj, up: y, unit: 100 m, position: [0, 0, 300 m]}}"},
    {"terrain.mesh.up", "file", "terrain", "{mesh: {file: hill.gltf, unit: 80 m, position: [0, 0, 300 m]}}"},
    {"water", NULL, "water", "{level: 150 m}"},
    {"output.film.disks", NULL, "camera.look_at", "[195 m, -581 m, 1242 m]"}, /* the sun */
    {"output.film.disks", NULL, "sun.angular_radius", "8 deg"},
    {"output.cloud_air", NULL, "output.aovs", "[clouds]"},
};

/* Keys that change no pixel here, whatever they say. */
static const char *const unseen[] = {
    "clouds[].import",       /* concerns grids with invalid values */
    "clouds[].missing",      /* concerns frames without a file: test_sequence renders each word */
    "clouds[].netcdf.step",  /* concerns files of several steps: test_model_scenes renders two */
    "render.history",        /* concerns later frames: test_history renders each word, */
    "render.history_update", /* and each of these */
    "output.pixel_type",     /* concerns files */
};

static void write_scene(setting s, char *out, size_t size) {
  snprintf(out, size,
           "version: 1\n"
           "place: {latitude: 45 deg, longitude: 0 deg}\n"
           "camera: {position: [0 m, -1500 m, 900 m], look_at: [0 m, 0 m, 1100 m], fov: 60 deg, resolution: [%d, %d]}\n"
           "sun: {elevation: 20 deg, azimuth: 12 deg}\n"
           "environment: {radiance: 0.001}\n"
           "atmosphere: %s\n"
           "terrain: %s\n"
           "clouds: %s\n"
           "render: {integrator: %s, samples: 2, light_memory: 0.001 GB,\n"
           "  light_degree: 3, light_residual: 0.03}\n",
           WIDTH, HEIGHT, s.has_air ? "{preset: earth, tolerance: 0.1}" : "none",
           s.has_terrain ? "{ridges: {samples: 65, relief: 300 m}, width: 8 km}" : "none",
           s.has_cloud ? "[{vdb: cloud.vdb, extinction: 3 1/m},\n"
                         "  {bake: {extent: 600 m, cell: 300 m, billow: 200 m, base: 900 m, thickness: 300 m,\n"
                         "    coverage: 0.6, voxel: 50 m}}]"
                       : "[]",
           s.is_path ? "path" : "march");
}

/* The key as neph_scene_set has it: the first cloud is read, the second baked. */
static void name_key(const np_key *key, char *out, size_t size) {
  const char *list = strstr(key->path, "[]");
  const int index = begins_with(key->path, "clouds[].bake") ? 1 : 0;
  if (list)
    snprintf(out, size, "%.*s[%d]%s", (int)(list - key->path), key->path, index, list + 2);
  else
    snprintf(out, size, "%s", key->path);
}

static neph_scene *load_setting(test_fixture *f, setting s) {
  char text[2048];
  neph_scene *scene;
  write_scene(s, text, sizeof text);
  assert_int_equal(neph_scene_load_text(f->context, text, f->path, &scene), NEPH_OK);
  return scene;
}

static void set(test_fixture *f, neph_scene *scene, const char *key, const char *value) {
  if (neph_scene_set(scene, key, value)) fail_msg("%s: %s: %s", key, value, f->log.text);
}

/* `word` NULL: the scene that words are to make a difference to. */
static neph_scene *create_scene(test_fixture *f, const np_key *key, const char *word, setting s) {
  char name[128], value[128];
  neph_scene *scene = load_setting(f, s);
  for (size_t i = 0; i < sizeof companions / sizeof *companions; i++) {
    const companion *c = &companions[i];
    const bool is_meant = !c->word || (word && strcmp(c->word, word) == 0);
    if (begins_with(key->path, c->start) && is_meant) set(f, scene, c->key, c->value);
  }
  if (!word) return scene;
  name_key(key, name, sizeof name);
  snprintf(value, sizeof value, key->type == NP_KEY_FLAGS ? "[%s]" : "%s", word);
  set(f, scene, name, value);
  return scene;
}

/* ---- Pictures ---- */

static bool may_be_infinite(const char *channel) {
  return strcmp(channel, "Z") == 0 || begins_with(channel, "distance") || begins_with(channel, "depth") ||
         begins_with(channel, "position") || begins_with(channel, "mean_distance");
}

/* Normals, motion and identifiers have any sign. Of the march no light is negative, but as the eye's colours: of a hue
 * outside of what the primaries span. */
static bool may_be_negative(const neph_scene *scene, const char *channel) {
  return scene->render.integrator == NEPH_INTEGRATOR_PATH || scene->render.wavelength_count > 3 ||
         may_be_infinite(channel) || begins_with(channel, "normal") || begins_with(channel, "forward") ||
         begins_with(channel, "backward") || begins_with(channel, "Crypto");
}

/* Checks every value of a picture; returns a number that distinguishes it. */
static uint64_t check_picture(const neph_scene *scene, neph_image *image, const char *what) {
  uint64_t sum = 14695981039346656037u; /* Fowler, Noll and Vo's hash, by words */
  for (unsigned c = 0; c < neph_image_get_channel_count(image); c++) {
    const char *name = neph_image_get_channel_name(image, c);
    const float *values = neph_image_get_channel(image, name);
    for (const char *letter = name; *letter; letter++) sum = (sum ^ (unsigned char)*letter) * 1099511628211u;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
      uint32_t bits;
      memcpy(&bits, &values[i], sizeof bits);
      sum = (sum ^ bits) * 1099511628211u;
      if (isnan(values[i]) || (isinf(values[i]) && !may_be_infinite(name)) ||
          (values[i] < 0.0f && !may_be_negative(scene, name)))
        fail_msg("%s: %s of pixel %d, %d is %g", what, name, i % WIDTH, i / WIDTH, (double)values[i]);
    }
  }
  return sum;
}

static bool is_of_preview(const np_key *key) {
  return begins_with(key->path, "output.exposure") || begins_with(key->path, "output.view") ||
         begins_with(key->path, "output.preview") || begins_with(key->path, "output.glare");
}

/* The same of a picture as it is shown. */
static uint64_t check_preview(test_fixture *f, const neph_scene *scene, const neph_image *image) {
  neph_output output = NEPH_OUTPUT_DEFAULT;
  neph_image *shown;
  char *path = test_path(f->folder, "preview.png");
  assert_int_equal(neph_scene_get_output(scene, &output), NEPH_OK);
  assert_int_equal(neph_image_save_png(image, path, &output.preview_desc), NEPH_OK);
  assert_int_equal(neph_image_load_png(f->context, path, &shown), NEPH_OK);
  const uint64_t sum = check_picture(scene, shown, "the preview");
  neph_image_destroy(shown);
  free(path);
  return sum;
}

/* Pictures of the 16 contexts. */
typedef struct context_pictures {
  neph_renderer *renderer[16]; /* pictures that differ by camera and output alone share their light */
  bool is_known[16];
  uint64_t plain[16]; /* where no word is set, and nothing beside it */
} context_pictures;

static unsigned get_context(setting s) { return s.is_path + 2u * s.has_air + 4u * s.has_terrain + 8u * s.has_cloud; }

static neph_result render_scene(context_pictures *p, const np_key *key, setting s, neph_scene *scene,
                                neph_image **out) {
  neph_renderer **renderer = &p->renderer[get_context(s)];
  if (!begins_with(key->path, "camera") && !begins_with(key->path, "output"))
    return neph_render_image(scene, NULL, out);
  const neph_result result = *renderer ? NEPH_OK : neph_renderer_create(scene->context, renderer);
  return result ? result : neph_renderer_render(*renderer, scene, NULL, out);
}

static uint64_t render(test_fixture *f, context_pictures *p, const np_key *key, const char *word, setting s) {
  char what[256];
  snprintf(what, sizeof what, "%s: %s, %s%s%s%s", key->path, word ? word : "not set", s.is_path ? "path" : "march",
           s.has_air ? ", air" : "", s.has_terrain ? ", terrain" : "", s.has_cloud ? ", clouds" : "");
  neph_image *image;
  test_log_clear(&f->log);
  neph_scene *scene = create_scene(f, key, word, s);
  if (render_scene(p, key, s, scene, &image)) fail_msg("%s: %s", what, f->log.text);
  const uint64_t sum = check_picture(scene, image, what),
                 shown = is_of_preview(key) ? check_preview(f, scene, image) : 0;
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  return sum ^ shown;
}

/* ---- Words ---- */

typedef struct words {
  unsigned count;
  char word[WORDS_MAX][64];
} words;

static void add_word(words *w, const char *word) {
  assert_true(w->count < WORDS_MAX);
  snprintf(w->word[w->count++], sizeof w->word[0], "%s", word);
}

static void add_presets(neph_context *context, words *w) {
  np_text names = {.context = context};
  char *list;
  np_cloud_list_presets(&names);
  assert_int_equal(np_text_finish(&names, &list), NEPH_OK);
  for (char *word = strtok(list, ", "); word; word = strtok(NULL, ", ")) add_word(w, word);
  np_alloc_free(context, list);
}

/* All that a key takes by name. */
static words list_words(neph_context *context, const np_key *key) {
  words w = {0};
  for (const np_choice *choice = key->choices; choice && choice->name; choice++) add_word(&w, choice->name);
  if (key->type == NP_KEY_PRESET) add_presets(context, &w);
  if (key->word) add_word(&w, key->word);
  return w;
}

/* A number's word is its default. */
static bool may_go_unseen(const np_key *key) {
  for (size_t i = 0; i < sizeof unseen / sizeof *unseen; i++)
    if (strcmp(key->path, unseen[i]) == 0) return true;
  return key->word;
}

static bool has_companion(const np_key *key) {
  for (size_t i = 0; i < sizeof companions / sizeof *companions; i++)
    if (!companions[i].word && begins_with(key->path, companions[i].start)) return true;
  return false;
}

static uint64_t render_without(test_fixture *f, context_pictures *p, const np_key *key, setting s) {
  const unsigned i = get_context(s);
  if (has_companion(key) || is_of_preview(key)) return render(f, p, key, NULL, s);
  if (!p->is_known[i]) p->plain[i] = render(f, p, key, NULL, s);
  p->is_known[i] = true;
  return p->plain[i];
}

/* The pictures of a key: one without its words for each context, rendered when it is first needed. */
typedef struct key_pictures {
  const np_key *key;
  words words;
  bool is_known[SETTING_COUNT], is_seen;
  uint64_t without[SETTING_COUNT];
  unsigned count;
} key_pictures;

/* Renders a word in a context, and sees whether it makes a difference. */
static void render_word(test_fixture *f, context_pictures *p, key_pictures *k, unsigned word, int context) {
  const setting s = suit(k->key, settings[context]);
  if (!k->is_known[context]) k->without[context] = render_without(f, p, k->key, s);
  k->is_known[context] = true;
  k->is_seen = render(f, p, k->key, k->words.word[word], s) != k->without[context] || k->is_seen;
  k->count++;
}

/* Contexts in which no word has been rendered make a difference visible that the first ones do not show. */
static void search_difference(test_fixture *f, context_pictures *p, key_pictures *k) {
  for (int context = 0; context < SETTING_COUNT; context++)
    for (unsigned i = 0; i < k->words.count && !k->is_seen; i++) render_word(f, p, k, i, context);
  if (!k->is_seen) fail_msg("%s changes no picture", k->key->path);
}

static test_shard shard = {0, 1}; /* the keys of this process */

/* Each word is rendered by both integrators, in contexts that take turns; if no picture differs by then, in all
 * contexts, unless the key may go unseen: there is no difference to look for. */
static void every_word_of_every_key_is_rendered(void **state) {
  test_fixture *f = *state;
  unsigned keys = 0, values = 0, renders = 0;
  context_pictures p = {.is_known = {false}};
  for (size_t n = shard.first; n < np_key_count(); n += shard.step) {
    key_pictures k = {.key = np_key_get(n), .words = list_words(f->context, np_key_get(n))};
    if (k.words.count == 0) continue;
    for (unsigned i = 0; i < k.words.count; i++) {
      render_word(f, &p, &k, i, (int)((values + i) % MARCH_COUNT));
      render_word(f, &p, &k, i, MARCH_COUNT + (int)((values + i) % (SETTING_COUNT - MARCH_COUNT)));
    }
    if (!k.is_seen && !may_go_unseen(k.key)) search_difference(f, &p, &k);
    keys++;
    values += k.words.count;
    renders += k.count;
  }
  for (int i = 0; i < 16; i++) neph_renderer_destroy(p.renderer[i]);
  print_message("%u words of %u keys in %u pictures\n", values, keys, renders);
}

/* The sun is down, and only airglow is in the air: path guiding needs it all the same. */
static void paths_are_guided_by_night(void **state) {
  test_fixture *f = *state;
  const setting s = {.is_path = true, .has_air = true, .has_cloud = true};
  neph_scene *scene = load_setting(f, s);
  neph_image *image;
  set(f, scene, "sun.irradiance", "0");
  set(f, scene, "airglow", "{}");
  set(f, scene, "render.path_guiding", "adjoint");
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  (void)check_picture(scene, image, "night");
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

/* ---- Numbers of a bake ---- */

/* Keys of a bake that are no words, on thermals: `on` draws other pixels than `off`. */
static const struct {
  const char *key, *off, *on;
} bake_numbers[] = {
    {"clouds[1].bake.billow_frequencies", "[1, 1, 1]", "[4, 4, 4]"},
    {"clouds[1].bake.wisp_frequencies", "[1, 1, 1]", "[4, 4, 4]"},
    {"clouds[1].bake.map", "{image: map.exr, coverage: R, size: 300 m}",
     "{image: map.exr, coverage: R, age: R, size: 300 m}"},
};

static void numbers_of_a_bake_are_seen(void **state) {
  test_fixture *f = *state;
  for (size_t n = 0; n < sizeof bake_numbers / sizeof *bake_numbers; n++)
    for (int path = 0; path < 2; path++) {
      const setting s = {.is_path = path, .has_cloud = true};
      uint64_t hashes[2];
      for (int on = 0; on < 2; on++) {
        neph_scene *scene = load_setting(f, s);
        neph_image *image;
        set(f, scene, "clouds[1].bake.model", "thermals");
        set(f, scene, "clouds[1].bake.voxel", "6 m"); /* which shows wisps of 13 m */
        set(f, scene, "clouds[1].bake.age", "1");
        set(f, scene, bake_numbers[n].key, on ? bake_numbers[n].on : bake_numbers[n].off);
        if (neph_render_image(scene, NULL, &image)) fail_msg("%s: %s", bake_numbers[n].key, f->log.text);
        hashes[on] = check_picture(scene, image, bake_numbers[n].key);
        neph_image_destroy(image);
        neph_scene_destroy(scene);
      }
      if (hashes[0] == hashes[1]) fail_msg("%s: no pixel changes", bake_numbers[n].key);
    }
}

/* ---- Set-up ---- */

/* A cloud in a file, which values of 0.01 and 3 1/m make 0.03 1/m. */
static void write_cloud(const test_fixture *f, const char *name, double extent_m) {
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  cloud.extent_m[0] = cloud.extent_m[1] = extent_m;
  cloud.center_m[0] = -250.0;
  cloud.base_altitude_m = 1000.0;
  cloud.thickness_m = 300.0;
  cloud.cell_m = 400.0;
  cloud.coverage = 0.8;
  cloud.voxel_m = 50.0;
  cloud.extinction_per_m = 0.01;
  char *path = test_path(f->folder, name);
  assert_int_equal(neph_cloud_bake_file(f->context, &cloud, &bake, "density", path), NEPH_OK);
  free(path);
}

/* A weather map, cloudy in one corner. */
static void write_map(const test_fixture *f) {
  static const char *const names[] = {"R"};
  neph_image *image;
  assert_int_equal(neph_image_create(f->context, 4, 4, 1, names, &image), NEPH_OK);
  for (int i = 0; i < 16; i++) neph_image_get_channel(image, "R")[i] = i % 4 < 2 && i < 8 ? 1.0f : 0.0f;
  char *path = test_path(f->folder, "map.exr");
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT), NEPH_OK);
  free(path);
  neph_image_destroy(image);
}

/* A camera that is rolled. */
static void write_motion(const test_fixture *f) {
  char *path = test_path(f->folder, "camera.chan");
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  assert_true(fputs("1 0 0 0 20 30 10\n", file) > 0);
  assert_int_equal(fclose(file), 0);
  free(path);
}

static FILE *open_file(const test_fixture *f, const char *name) {
  char *path = test_path(f->folder, name);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  free(path);
  return file;
}

/* A slope encoded in colours. */
static void write_colors(const test_fixture *f, const char *name, uint8_t red, uint8_t green, uint8_t step) {
  png_image picture = {.version = PNG_IMAGE_VERSION, .width = 9, .height = 9, .format = PNG_FORMAT_RGB};
  uint8_t colors[81][3];
  for (int i = 0; i < 81; i++)
    memcpy(colors[i], (const uint8_t[]){red, (uint8_t)(green + i % 9 * step), (uint8_t)(i * 3)}, 3);
  char *path = test_path(f->folder, name);
  assert_true(png_image_write_to_file(&picture, path, 0, colors, 0, NULL));
  free(path);
}

/* A slope with a ridge, as samples of 16 bits, floats, text and colours. */
static void write_fields(const test_fixture *f) {
  FILE *shorts = open_file(f, "field.r16"), *floats = open_file(f, "field.raw"), *text = open_file(f, "field.asc");
  write_colors(f, "tenths.png", 1, 138, 1);
  write_colors(f, "terrarium.png", 129, 0, 20);
  assert_true(fputs("ncols 9\nnrows 9\nxllcorner 262429\nyllcorner 4986204\ncellsize 250\n", text) > 0);
  for (int i = 0; i < 81; i++) {
    const float height = 100.0f + (float)(20 * (i % 9)) + (i / 9 == 3 ? 250.0f : 0.0f);
    const uint8_t word[2] = {(uint8_t)((int)(32 * height) & 255), (uint8_t)((int)(32 * height) >> 8)};
    assert_int_equal(fwrite(word, sizeof word, 1, shorts), 1);
    assert_int_equal(fwrite(&height, sizeof height, 1, floats), 1);
    assert_true(fprintf(text, "%g%c", (double)height, i % 9 == 8 ? '\n' : ' ') > 0);
  }
  assert_int_equal(fclose(shorts) + fclose(floats) + fclose(text), 0);
}

/* A slope of measured values, in UTM's zone 31 around the scene's place. */
static void write_measured(const test_fixture *f, const char *name, double least, double step) {
  char file[64];
  snprintf(file, sizeof file, "%s.asc", name);
  FILE *text = open_file(f, file);
  assert_true(fputs("ncols 9\nnrows 9\nxllcorner 262429\nyllcorner 4986204\ncellsize 250\n", text) > 0);
  for (int i = 0; i < 81; i++) assert_true(fprintf(text, "%g%c", least + step * (i % 9), i % 9 == 8 ? '\n' : ' ') > 0);
  assert_int_equal(fclose(text), 0);
  snprintf(file, sizeof file, "%s.prj", name);
  text = open_file(f, file);
  assert_true(fputs("Projection UTM\nZone 31\nDatum WGS84\nSpheroid WGS84\nUnits METERS\nParameters\n", text) > 0);
  assert_int_equal(fclose(text), 0);
}

static void write_node(FILE *file, int node) { (void)fprintf(file, "{\"mesh\":%d}", node); }

static void write_gltf(const test_fixture *f, const char *name, test_gltf mesh) {
  char *path = test_path(f->folder, name);
  mesh.node_count = 1;
  mesh.write_node = write_node;
  test_write_gltf(path, &mesh);
  free(path);
}

/* A pyramid 800 m wide, in hundreds of metres: as OBJ, and as glTF, which says what is up; and a closed one on three
 * sides. */
static void write_meshes(const test_fixture *f) {
  FILE *obj = open_file(f, "hill.obj");
  assert_true(fputs("v -4 0 -4\nv 4 0 -4\nv 4 0 4\nv -4 0 4\nv 0 12 0\nf 5 1 2\nf 5 2 3\nf 5 3 4\nf 5 4 1\n", obj) > 0);
  assert_int_equal(fclose(obj), 0);
  static const float hill[5][3] = {{-4, 0, -4}, {4, 0, -4}, {4, 0, 4}, {-4, 0, 4}, {0, 12, 0}};
  static const uint16_t sides[12] = {4, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0};
  static const float peak[4][3] = {{-4, 0, -4}, {4, 0, -4}, {0, 0, 5}, {0, 9, 0}};
  static const uint16_t faces[12] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
  write_gltf(f, "hill.gltf", (test_gltf){.positions = hill, sides, 5, 12});
  write_gltf(f, "peak.gltf", (test_gltf){.positions = peak, faces, 4, 12});
}

static int set_up(void **state) {
  if (test_set_up_cached(state, 2, "scene.yaml")) return -1;
  write_fields(*state);
  write_measured(*state, "depths", 4.0, 2.0);
  write_measured(*state, "shares", 0.2, 0.05);
  write_measured(*state, "heights", 1050.0, 15.0);
  write_measured(*state, "kelvins", 278.0, 0.5);
  write_meshes(*state);
  write_motion(*state);
  write_cloud(*state, "cloud.vdb", 500.0);
  write_cloud(*state, "cloud.0001.vdb", 500.0);
  write_cloud(*state, "cloud.0002.vdb", 800.0);
  write_map(*state);
  return 0;
}

/* PROGRAM [I/N]: the keys of a shard, all without; the first shard has the other tests as well. */
int main(int count, char **arguments) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(every_word_of_every_key_is_rendered, set_up, test_tear_down),
      cmocka_unit_test(any_two_parts_of_a_scene_meet),
      cmocka_unit_test_setup_teardown(numbers_of_a_bake_are_seen, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(paths_are_guided_by_night, set_up, test_tear_down),
  };
  if (count > 1 && !test_shard_read(arguments[1], &shard)) return 2;
  if (shard.first > 0) return test_shard_run((test_shard){0, 1}, tests, 1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
