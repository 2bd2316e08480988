/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <stdlib.h>

#include "core/random.h"
#include "core/units.h"
#include "scene/scene_fail.h"

static const char example[] =
    "version: 1\n"
    "place: {latitude: 44.27 deg, longitude: -71.3 deg}\n"
    "camera: {position: [0 m, -6 km, 400 m], look_at: [0, 0, 1800 m], fov: 50 deg, resolution: [960, 540]}\n"
    "sun: {elevation: 35 deg, azimuth: 120 deg}       # or time\n"
    "atmosphere: {preset: earth}\n"
    "environment: {radiance: 0, hemisphere: both}\n"
    "clouds:\n"
    "  - {name: hero, vdb: \"hero.####.vdb\", grid: density, up: y, voxel: 20 m, optical_depth: 40,\n"
    "     position: [0, 0, 1200 m], albedo: 0.999995, phase: {droplets: {diameter: 20 um}}}\n"
    "  - {name: layer, bake: {extent: [8 km, 8 km], voxel: 25 m, preset: cumulus_mediocris, seed: 7}}\n"
    "terrain: {heightfield: N44W072.hgt, albedo: 0.2}\n"
    "render: {integrator: path, samples: 16}\n"
    "output: {image: \"out/frame.####.exr\", preview: /tmp/frame.png, aovs: [depth, transmittance, sun, sky]}\n";

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

/* ---- Values ---- */

static void test_example_is_read(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, example, "shots/scene.yaml", &scene), NEPH_OK);
  assert_near(scene->latitude_rad, 44.27 * NP_DEGREE, 1e-15);
  assert_near(scene->camera.position_m[1], -6000, 0);
  assert_near(scene->camera.fov_rad, 50 * NP_DEGREE, 1e-15);
  assert_int_equal(scene->cloud_count, 2);
  const np_scene_cloud *hero = &scene->clouds[0], *layer = &scene->clouds[1];
  assert_string_equal(hero->vdb, "shots/hero.####.vdb");
  assert_int_equal(hero->up, NP_UP_Y);
  assert_int_equal(hero->density_unit, NP_DENSITY_OPTICAL_DEPTH);
  assert_near(hero->density_value, 40, 0);
  assert_true(hero->has_position);
  assert_near(hero->albedo[2], 0.999995, 0);
  assert_false(hero->is_baked);
  assert_true(layer->is_baked);
  assert_int_equal(layer->density_unit, NP_DENSITY_EXTINCTION);
  assert_near(layer->density_value, 1, 0);
  assert_int_equal(layer->bake.seed, 7);
  assert_false(layer->has_position);
  assert_int_equal(scene->terrain.kind, NP_TERRAIN_HEIGHTFIELD);
  assert_true(scene->terrain.desc.has_place);
  assert_int_equal(scene->render.integrator, NEPH_INTEGRATOR_PATH);
  assert_int_equal(scene->output.aovs, NP_AOV_DEPTH | NP_AOV_TRANSMITTANCE | NP_AOV_SUN | NP_AOV_SKY);
  assert_string_equal(scene->output.image, "shots/out/frame.####.exr");
  assert_string_equal(scene->output.preview, "/tmp/frame.png");
  neph_scene_destroy(scene);
}

static void test_preset_comes_first_wherever_it_stands(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  neph_cloud_desc preset = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(f->context, "cumulus_mediocris", &preset), NEPH_OK);
  assert_int_equal(neph_scene_load_text(f->context, example, "scene.yaml", &scene), NEPH_OK);
  assert_near(scene->clouds[1].bake.voxel_m, 25, 0);
  assert_near(scene->clouds[1].bake.coverage, preset.coverage, 0);
  assert_near(scene->clouds[1].bake.type, preset.type, 0);
  neph_scene_destroy(scene);
}

static void test_map_of_a_bake(void **state) {
  test_fixture *f = *state;
  static const char text[] = "clouds: [{bake: {map: {image: maps/sky.png, coverage: R, rain: G}, model: hero}}]";
  static const char good[] = "clouds: [{bake: {map: {image: maps/sky.png, coverage: R, precipitation: G, size: [3 km, "
                             "2 km], tiling: true}, top: 900 m, preset: stratus, model: hero}}]";
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, good, "shots/a.yaml", &scene), NEPH_OK);
  const neph_cloud_desc *bake = &scene->clouds[0].bake;
  assert_string_equal(bake->map_file, "shots/maps/sky.png");
  assert_string_equal(bake->map_channels[NEPH_CLOUD_MAP_COVERAGE], "R");
  assert_string_equal(bake->map_channels[NEPH_CLOUD_MAP_PRECIPITATION], "G");
  assert_null(bake->map_channels[NEPH_CLOUD_MAP_TYPE]);
  assert_true(bake->has_map_size && bake->is_map_tiling);
  assert_near(bake->map_size_m[1], 2000, 0);
  assert_int_equal(bake->model, NEPH_CLOUD_MODEL_HERO);
  assert_near(bake->thickness_m, 600, 1e-9); /* top less base of the preset, 300 m */
  neph_scene_destroy(scene);
  assert_int_equal(neph_scene_load_text(f->context, text, "s.yaml", &scene), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "clouds[0].bake.map.rain is not a key", "precipitation");
}

static void test_block_style_is_the_same(void **state) {
  test_fixture *f = *state;
  neph_scene *flow, *block;
  char *a, *b;
  assert_int_equal(neph_scene_load_text(f->context,
                                        "camera: {fov: 30 deg, resolution: [10, 20]}\n"
                                        "clouds: [{bake: {seed: 3}}]\n",
                                        "s", &flow),
                   NEPH_OK);
  assert_int_equal(neph_scene_load_text(f->context,
                                        "camera:\n  fov: '30 deg'\n  resolution:\n  - 10\n  - 20\n"
                                        "clouds:\n- bake:\n    seed: 3\n",
                                        "s", &block),
                   NEPH_OK);
  assert_int_equal(neph_scene_describe(flow, NEPH_TEXT_PLAIN, &a), NEPH_OK);
  assert_int_equal(neph_scene_describe(block, NEPH_TEXT_PLAIN, &b), NEPH_OK);
  assert_string_equal(a, b);
  neph_text_destroy(f->context, a);
  neph_text_destroy(f->context, b);
  neph_scene_destroy(flow);
  neph_scene_destroy(block);
}

static void test_files_are_read_from_disk(void **state) {
  test_fixture *f = *state;
  char *folder = test_folder_create(), *path = test_path(folder, "s.yaml"), *image = test_path(folder, "a.exr");
  test_file_write_text(path, "output: {image: a.exr}\n");
  neph_scene *scene;
  assert_int_equal(neph_scene_load(f->context, path, &scene), NEPH_OK);
  assert_string_equal(scene->output.image, image);
  neph_scene_destroy(scene);
  free(image);
  free(path);
  path = test_path(folder, "none.yaml");
  assert_int_equal(neph_scene_load(f->context, path, &scene), NEPH_ERROR_NOT_FOUND);
  assert_null(scene);
  assert_one_error(&f->log, "none.yaml");
  free(path);
  test_folder_destroy(folder);
}

/* ---- Errors ---- */

typedef struct bad_scene {
  const char *text, *message; /* the message without "s.yaml:" */
} bad_scene;

static void assert_bad(test_fixture *f, const bad_scene *bad) {
  char message[600];
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, bad->text, "s.yaml", &scene), NEPH_ERROR_BAD_SCENE);
  assert_null(scene);
  snprintf(message, sizeof message, "s.yaml:%s", bad->message);
  if (strncmp(f->log.text, message, strlen(message)))
    fail_msg("%s\ngave    %swanted  %s", bad->text, f->log.text, message);
  assert_one_error(&f->log, message);
}

static void assert_all_bad(test_fixture *f, const bad_scene *bad, size_t count) {
  for (size_t i = 0; i < count; i++) assert_bad(f, &bad[i]);
}

#define ASSERT_ALL_BAD(state, list) assert_all_bad(*(state), list, sizeof(list) / sizeof *(list))

static neph_scene *load_air(test_fixture *f, const char *text) {
  neph_scene *scene = NULL;
  if (neph_scene_load_text(f->context, text, "s", &scene)) fail_msg("%s: %s", text, f->log.text);
  return scene;
}

static void test_wrong_airs(void **state) {
  static const bad_scene bad[] = {
      {"atmosphere: {preset: venus}",
       "1:22: atmosphere.preset is venus, must be earth, earth-hazy, mars, empty or none"},
      {"atmosphere: {mie_extinction: 1e-9}", "1:30: atmosphere.mie_extinction is 1e-09 1/m, must not be below"},
      {"atmosphere: {mie_asymmetry: 1}", "1:29: atmosphere.mie_asymmetry is 1, must be a number in [-0.9999, 0.9999]"},
      {"atmosphere: {haze: thick}", "1:20: atmosphere.haze is thick, must be preset, clear, hazy, maritime or dusty"},
      {"atmosphere: {visibility: 20 m}", "1:26: atmosphere.visibility is 20 m, must be a length in [1000, 500000] m"},
      {"atmosphere: {visibility: 289 km}",
       "1:26: atmosphere.visibility is 289 km, must be below 288.5 km, the visual range of air without haze"},
      {"atmosphere: {visibility: 20 km, mie_scattering: 0, mie_extinction: 0}",
       "1:26: atmosphere.visibility is 20 km, and mie_extinction at 550 nm is 0 1/m: no haze to scale"},
      {"atmosphere: {visibility: 20 km, mie_extinction: 1e-9}",
       "1:49: atmosphere.mie_extinction is 1e-09 1/m, must not be below mie_scattering, 3.996e-06 1/m"},
      {"animate: {atmosphere.visibility: [[1, 20 km], [40, 300 km]]}",
       "1:34: atmosphere.visibility is 300 km in frame 40, must be below 288.5 km"},
      {"atmosphere: {layers: [{phase: {haze: 0.4}}]}",
       "1:38: atmosphere.layers[0].phase.haze is 0.4, must be a number in [0.5, 0.95]"},
      {"atmosphere: {layers: {}}", "1:22: atmosphere.layers is a mapping of 0, must be a list of mappings"},
      {"atmosphere: {layers: [1]}", "1:23: atmosphere.layers[0] is 1, must be a mapping"},
      {"atmosphere: {layers: [{scattering: -1}]}", "1:36: atmosphere.layers[0].scattering is -1, must be a number per"},
      {"atmosphere: {layers: [{tent: {}, table: [[0, 1], [1, 1]]}]}",
       "1:34: atmosphere.layers[0].table and atmosphere.layers[0].tent exclude each other"},
      {"atmosphere: {layers: [{table: [[0, 1]]}]}",
       "1:31: atmosphere.layers[0].table must be a list of at least 2 pairs of an altitude in m and a density"},
      {"atmosphere: {layers: [{table: [[0, 1], 3]}]}", "1:40: atmosphere.layers[0].table[1] must be a pair of an"},
      {"atmosphere: {layers: [{table: [[1 km, 1], [900 m, 1]]}]}",
       "1:44: atmosphere.layers[0].table[1]: the altitude is 900 m, must be above the one before, 1000 m"},
      {"atmosphere: {layers: [{table: [[0, 1], [1, -0.5]]}]}",
       "1:44: atmosphere.layers[0].table[1]: the density is -0.5, must be in [0, 1e+09]"},
      {"atmosphere: {layers: [{bottom: 2 km, top: 1 km}]}",
       "1:23: atmosphere.layers[0].top is 1000 m, must be above its bottom, 2000 m"},
      {"atmosphere: {layers: [{tent: {center: 300 km}}]}",
       "1:23: atmosphere.layers[0] begins at 285000 m, must do so below atmosphere.top_altitude, 100000 m"},
      {"atmosphere: {top_altitude: 10 m}",
       "1:28: atmosphere.top_altitude is 10 m, must be above 10000 m, where the ozone of atmosphere.preset begins"},
      {"sun: {elevation: 10 deg, azimuth: 0 deg, angular_radius: 40 deg}",
       "1:58: sun.angular_radius is 40 deg, must be an angle in [0, 28] deg"},
      {"clouds: [{bake: {extinction: 200 1/m}}]",
       "1:30: clouds[0].bake.extinction is 200 1/m, must be a number per length in [1e-09, 100] 1/m"},
      {"atmosphere: {layers: [{phase: {hg: 1}}]}", "1:36: atmosphere.layers[0].phase.hg is 1, must be a number in"},
      {"atmosphere: {layers: [{phase: {two_lobe: {weight: 1.5}}}]}",
       "1:51: atmosphere.layers[0].phase.two_lobe.weight is 1.5, must be a number in [0, 1]"},
      {"atmosphere: {layers: [{phase: {hg: 0.1, cornette_shanks: 0.2}}]}",
       "1:41: atmosphere.layers[0].phase.cornette_shanks and atmosphere.layers[0].phase.hg exclude each other"},
  };
  ASSERT_ALL_BAD(state, bad);
}

/* Sum over the layers between molecules and ozone: haze. */
static double get_haze_scattering(const neph_scene *scene, int band) {
  double sum = 0.0;
  for (unsigned i = 1; i + 1 < scene->atmosphere.layer_count; i++)
    sum += scene->atmosphere.layers[i].scattering_per_m[band];
  return sum;
}

static double get_haze_extinction(const neph_scene *scene, int band) {
  double sum = get_haze_scattering(scene, band);
  for (unsigned i = 1; i + 1 < scene->atmosphere.layer_count; i++)
    sum += scene->atmosphere.layers[i].absorption_per_m[band];
  return sum;
}

static double get_range(const neph_scene *scene) {
  return 3.912 / (scene->atmosphere.layers[0].scattering_per_m[1] + get_haze_extinction(scene, 1));
}

/* Koschmieder's range: 3.912 over the extinction of air and haze at 550 nm, for each kind at its own range and at a
 * given one, whose colour and absorption are those of the kind. */
static void test_haze_by_visual_range(void **state) {
  static const struct {
    const char *name;
    double range_m, blue_over_red; /* extinction of the haze, blue over red */
    unsigned layers;               /* layers of haze: hazy air has a grey one for the aureole */
  } kinds[] = {{"clear", 100e3, 1.728, 1},
               {"hazy", 20e3, 1.750, 2},
               {"maritime", 40e3, 1.045, 1},
               {"dusty", 25e3, 1.084, 1},
               {"preset", 3.912 / 17.998e-6, 1.0, 1}};
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
    char text[128];
    snprintf(text, sizeof text, "atmosphere: {haze: %s}", kinds[i].name);
    neph_scene *scene = load_air(f, text);
    assert_near_relative(get_range(scene), kinds[i].range_m, 1e-12);
    assert_near_relative(get_haze_extinction(scene, 2) / get_haze_extinction(scene, 0), kinds[i].blue_over_red, 1e-3);
    const double before = get_haze_scattering(scene, 2) / get_haze_extinction(scene, 1);
    assert_int_equal(neph_scene_set(scene, "atmosphere.visibility", "12 km"), NEPH_OK);
    assert_near_relative(get_range(scene), 12e3, 1e-12);
    assert_near_relative(get_haze_scattering(scene, 2) / get_haze_extinction(scene, 1), before, 1e-12);
    assert_int_equal(scene->atmosphere.layer_count, 2 + kinds[i].layers);
    assert_int_equal(scene->atmosphere.layers[1].phase,
                     kinds[i].layers == 1 ? NEPH_PHASE_HAZE : NEPH_PHASE_HENYEY_GREENSTEIN);
    neph_scene_destroy(scene);
  }
}

/* Hazy air: the narrow lobes scatter as much in each band, and both layers have the kind's mean cosine at
 * 550 nm. A key for the asymmetry leaves one layer of one lobe. */
static void test_aureole_of_haze_is_grey(void **state) {
  neph_scene *scene = load_air(*state, "atmosphere: {haze: hazy}");
  const neph_atmosphere_layer *fine = &scene->atmosphere.layers[1], *coarse = &scene->atmosphere.layers[2];
  assert_int_equal(coarse->phase, NEPH_PHASE_TWO_LOBE);
  const double narrow =
      (1.0 - coarse->second_weight[1]) * coarse->asymmetry[1] + coarse->second_weight[1] * coarse->second_asymmetry[1];
  const double sum = fine->scattering_per_m[1] + coarse->scattering_per_m[1];
  for (int b = 0; b < 3; b++) {
    assert_near_relative(coarse->scattering_per_m[b], 0.53 * sum, 1e-6);
    assert_near(coarse->absorption_per_m[b], 0.0, 0.0);
    assert_true(fine->scattering_per_m[b] > 0.0);
  }
  assert_near((fine->asymmetry[1] * fine->scattering_per_m[1] + narrow * coarse->scattering_per_m[1]) / sum, 0.698,
              1e-6);
  assert_int_equal(neph_scene_set(scene, "atmosphere.mie_asymmetry", "0.7"), NEPH_OK);
  assert_int_equal(scene->atmosphere.layer_count, 3);
  assert_int_equal(scene->atmosphere.layers[1].phase, NEPH_PHASE_CORNETTE_SHANKS);
  neph_scene_destroy(scene);
}

/* Presets of ice scatter as ice unless a phase function is given; the others as droplets. */
static void test_presets_of_ice(void **state) {
  static const struct {
    const char *keys;
    neph_phase kind;
  } clouds[] = {{"bake: {preset: cirrus}", NEPH_PHASE_ICE},
                {"bake: {preset: altostratus, voxel: 200 m}", NEPH_PHASE_ICE},
                {"bake: {voxel: 90 m, preset: contrail}", NEPH_PHASE_ICE},
                {"bake: {preset: altocumulus_floccus}", NEPH_PHASE_DROPLETS},
                {"bake: {preset: cumulonimbus}", NEPH_PHASE_DROPLETS},
                {"bake: {}", NEPH_PHASE_DROPLETS},
                {"phase: {droplets: {}}, bake: {preset: cirrus}", NEPH_PHASE_DROPLETS},
                {"bake: {preset: cirrus}, phase: {hg: 0.8}", NEPH_PHASE_HENYEY_GREENSTEIN},
                {"bake: {preset: cirrus}, phase: {mie: {}}", NEPH_PHASE_MIE}};
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof clouds / sizeof *clouds; i++) {
    char text[128];
    snprintf(text, sizeof text, "clouds: [{%s}]", clouds[i].keys);
    neph_scene *scene = load_air(f, text);
    assert_int_equal(scene->clouds[0].phase_source.kind, clouds[i].kind);
    neph_scene_destroy(scene);
  }
}

/* A key for the asymmetry has one lobe in place of three; other presets keep theirs. */
static void test_one_lobe_by_its_asymmetry(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load_air(f, "atmosphere: {mie_asymmetry: 0.3}");
  assert_int_equal(scene->atmosphere.layers[1].phase, NEPH_PHASE_CORNETTE_SHANKS);
  assert_near(scene->atmosphere.layers[1].asymmetry[2], 0.3, 0);
  neph_scene_destroy(scene);
  scene = load_air(f, "atmosphere: {preset: mars, mie_asymmetry: 0.3}");
  assert_int_equal(scene->atmosphere.layers[1].phase, NEPH_PHASE_TWO_LOBE);
  neph_scene_destroy(scene);
}

/* A preset comes first wherever it stands, other keys go over it, and the sun is as far as the preset's planet is. */
static void test_presets_and_layers_of_air(void **state) {
  test_fixture *f = *state;
  neph_scene *scene =
      load_air(f, "atmosphere: {mie_height: 9 km, preset: mars, layers: [{table: [[1 km, 0], [2 km, 3]], "
                  "scattering: 2e-6, phase: {two_lobe: {forward: [0.7, 0.8, 0.9]}}}]}");
  const neph_atmosphere_desc *air = &scene->atmosphere;
  assert_near(air->planet_radius_m, 3389.5e3, 0);
  assert_int_equal(air->layer_count, 4);
  assert_near(air->layers[1].height_m, 9e3, 0);
  assert_int_equal(air->layers[1].phase, NEPH_PHASE_TWO_LOBE);
  assert_near_relative(air->layers[1].absorption_per_m[2], 11.87e-6, 1e-9);
  const neph_atmosphere_layer *own = &air->layers[3];
  assert_int_equal(own->profile, NEPH_LAYER_TABLE);
  assert_int_equal(own->table_rows, 2);
  assert_near(own->table_altitude_m[1], 2e3, 0);
  assert_near(own->table_density[1], 3, 0);
  assert_near(own->asymmetry[2], 0.9, 0);
  assert_near(own->scattering_per_m[0], 2e-6, 0);
  /* 1.474 W/m²/nm at 1 au, at 1.524. */
  assert_near_relative(scene->sun.irradiance_w_m2_nm[0], 1.474 / (1.524 * 1.524), 1e-12);
  neph_scene_destroy(scene);
  scene = load_air(f, "{sun: {irradiance: 2}, atmosphere: {preset: mars}}");
  assert_near(scene->sun.irradiance_w_m2_nm[0], 2, 0);
  neph_scene_destroy(scene);
  scene = load_air(f, "atmosphere: {preset: empty, layers: [{exponential: {height: 5 km}}]}");
  assert_true(scene->has_atmosphere);
  assert_int_equal(scene->atmosphere.layer_count, 1);
  assert_int_equal(scene->atmosphere.layers[0].phase, NEPH_PHASE_CORNETTE_SHANKS);
  neph_scene_destroy(scene);
  scene = load_air(f, "atmosphere: none");
  assert_false(scene->has_atmosphere);
  neph_scene_destroy(scene);
}

static void test_wrong_values(void **state) {
  static const bad_scene bad[] = {
      {"version: 1\nsun:\n  elevation: 95 deg\n", "3:14: sun.elevation is 95 deg, must be an angle in [-90, 90] deg\n"},
      {"sun: {elevation: -1.6 rad}", "1:18: sun.elevation is -1.6 rad, must be an angle in [-90, 90] deg"},
      {"camera: {fov: .nan}", "1:15: camera.fov is .nan, must be an angle"},
      {"camera: {fov: .inf}", "1:15: camera.fov is .inf, must be an angle"},
      {"camera: {fov: 1e999}", "1:15: camera.fov is 1e999, must be an angle"},
      {"camera: {fov: 50 m}", "1:15: camera.fov is 50 m, must be an angle"},
      {"camera: {fov: wide}", "1:15: camera.fov is wide, must be an angle"},
      {"camera: {fov: }", "1:15: camera.fov is empty, must be an angle"},
      {"camera: {fov: ~}", "1:15: camera.fov is empty, must be an angle"},
      {"camera: {fov: [1]}", "1:15: camera.fov is a list of 1, must be an angle"},
      {"camera: {fov: {a: 1}}", "1:15: camera.fov is a mapping of 1, must be an angle"},
      {"render: {samples: 4.5}", "1:19: render.samples is 4.5, must be a whole number in [1, 16777216]\n"},
      {"render: {samples: -4}", "1:19: render.samples is -4, must be a whole number"},
      {"render: {samples: 0}", "1:19: render.samples is 0, must be a whole number"},
      {"render: {samples: 99999999999999999999}", "1:19: render.samples is 99999999999999999999, must be"},
      {"render: {seed: 18446744073709551616}",
       "1:16: render.seed is 18446744073709551616, must be a whole number from 0"},
      {"render: {integrator: marsch}", "1:22: render.integrator is marsch, must be march or path\n"},
      {"output: {film: {background: yes}}", "1:29: output.film.background is yes, must be false or true\n"},
      {"output: {aovs: sun}", "1:16: output.aovs is sun, must be a list of: background, terrain"},
      {"output: {aovs: [sun, moon]}", "1:22: output.aovs[1] is moon, must be background, terrain"},
      {"output: {exposure: bright}",
       "1:20: output.exposure is bright, must be a number of stops in [-40, 40] EV, or auto, meter or camera\n"},
      {"output: {image: ''}", "1:17: output.image is empty, must be a file name\n"},
      {"camera: {position: [1, 2]}", "1:20: camera.position is a list of 2, must be a list of 3, each a length in"},
      {"camera: {position: [1, 2, 3, 4]}", "1:20: camera.position is a list of 4, must be"},
      {"camera: {position: 5}", "1:20: camera.position is 5, must be a list of 3"},
      {"camera: {position: [1, 2, 3 furlong]}", "1:27: camera.position[2] is 3 furlong, must be a length in"},
      {"camera: {resolution: [10, 1.5]}", "1:27: camera.resolution[1] is 1.5, must be a whole number in [1, 65536]\n"},
      {"sun: {irradiance: [1, -1, 1]}", "1:23: sun.irradiance[1] is -1, must be an irradiance in"},
      {"sun: {time: tomorrow}", "1:13: sun.time is tomorrow, must be a time such as"},
      {"sun: {time: 2026-02-30T16:00Z}", "1:13: sun.time is 2026-02-30T16:00Z, must be a time such as"},
      {"version: 2", "1:10: version is 2, must be a whole number in [1, 1]\n"},
      {"camera: wide", "1:9: camera is wide, must be a mapping\n"},
      {"terrain: maybe", "1:10: terrain is maybe, must be a mapping, or none\n"},
      {"clouds: {}", "1:9: clouds is a mapping of 0, must be a list of mappings\n"},
      {"clouds: [hero]", "1:10: clouds[0] is hero, must be a mapping\n"},
      {"clouds: [{bake: {}}, {bake: {voxel: 0 m}}]", "1:37: clouds[1].bake.voxel is 0 m, must be a length in"},
      {"clouds: [{bake: {coverage: 1.5}}]", "1:28: clouds[0].bake.coverage is 1.5, must be a number in [0, 1]\n"},
      {"clouds: [{bake: {thickness: -1 m}}]", "1:29: clouds[0].bake.thickness is -1 m, must be a length in"},
      {"clouds: [{bake: {profile: [0, 1]}}]", "1:27: clouds[0].bake.profile is a list of 2, must be"},
      {"clouds: [{bake: {profile: [0, 0.1, 0.2, 0.3, 2]}}]", "1:46: clouds[0].bake.profile[4] is 2, must be"},
      {"clouds: [{bake: {map: {image: a.png, size: 0 m}}}]", "1:44: clouds[0].bake.map.size is 0 m, must be"},
      {"clouds: [{bake: {map: {image: a.png, tiling: 3}}}]", "1:46: clouds[0].bake.map.tiling is 3, must be"},
      {"- 1", "1:1: a scene must be a mapping of keys\n"},
      {"hello", "1:1: a scene must be a mapping of keys\n"},
  };
  ASSERT_ALL_BAD(state, bad);
}

static void test_unknown_keys(void **state) {
  static const bad_scene bad[] = {
      {"sun:\n  elevatoin: 5 deg",
       "2:3: sun.elevatoin is not a key, did you mean sun.elevation? sun has elevation, azimuth,"},
      {"camra: {}", "1:1: camra is not a key, did you mean camera? a scene has version, place, camera,"},
      {"fov: 3", "1:1: fov is not a key, did you mean camera.fov? a scene has"},
      {"camera: {xyzzy: 3}",
       "1:10: camera.xyzzy is not a key; camera has kind, position, look_at, fov, focal_length, sensor, "
       "orthographic_width, fisheye_fov, shift, roll, near, far, f_stop, focus_distance, blades, shutter, iso, stereo, "
       "motion, motion_blur, resolution, overscan\n"},
      {"clouds: [{bake: {covrage: 1}}]",
       "1:18: clouds[0].bake.covrage is not a key, did you mean clouds[].bake.coverage?"},
      {"\"a\\nb\": 3", "1:1: a?b is not a key"},
      {"'': 3", "1:1:  is not a key"},
  };
  ASSERT_ALL_BAD(state, bad);
}

static void test_keys_that_do_not_go_together(void **state) {
  static const bad_scene bad[] = {
      {"sun:\n  azimuth: 1\n  azimuth: 2", "3:3: sun.azimuth is given twice, first on line 2\n"},
      {"sun: {}\ncamera: {}\nsun: {}", "3:1: sun is given twice, first on line 1\n"},
      {"sun: {time: 2026-06-21T16:00Z, elevation: 3}", "1:32: sun.elevation and sun.time exclude each other\n"},
      {"clouds: [{vdb: x, extinction: 1, optical_depth: 3}]",
       "1:34: clouds[0].optical_depth and clouds[0].extinction exclude each other\n"},
      {"clouds: [{vdb: x, liquid_water: {effective_radius: 10 um}, mean_free_path: 3 m}]",
       "1:60: clouds[0].mean_free_path and clouds[0].liquid_water exclude each other\n"},
      {"clouds: [{bake: {}, phase: {hg: 0.5, droplets: {}}}]",
       "1:38: clouds[0].phase.droplets and clouds[0].phase.hg exclude each other\n"},
      {"clouds: [{bake: {top: 3 km, thickness: 1 km}}]",
       "1:29: clouds[0].bake.thickness and clouds[0].bake.top exclude each other\n"},
      {"terrain: {ridges: {}, heightfield: a.hgt}",
       "1:23: terrain.heightfield and terrain.ridges exclude each other\n"},
  };
  ASSERT_ALL_BAD(state, bad);
}

static void test_incomplete_scenes(void **state) {
  static const bad_scene bad[] = {
      {"clouds:\n  - {name: x}",
       "2:5: clouds[0] has no source, must have vdb or netcdf, a file, or bake, parameters\n"},
      {"clouds: [{vdb: x, liquid_water: {}}]", "1:33: clouds[0].liquid_water has no effective_radius"},
      {"clouds: [{bake: {}}, {bake: {}, name: cloud0}]", "1:39: clouds[1].name is cloud0, the name of clouds[0] too\n"},
      {"clouds: [{bake: {}, name: ground}]\noutput: {aovs: [mattes]}",
       "1:27: clouds[0].name is ground, which is a channel's already: with mattes or cryptomatte in output.aovs a "
       "cloud must have another name\n"},
      {"clouds: [{vdb: a.vdb, extinction: 1, emission: {}, name: sky}]\noutput: {aovs: [lights]}",
       "1:58: clouds[0].name is sky, which is a channel's already: with lights in output.aovs a cloud with emission "
       "must have another name\n"},
      {"clouds: [{bake: {}, name: a/b}]", "1:27: clouds[0].name is a/b, must not hold a slash"},
      {"terrain: {albedo: 0.1}", "1:10: terrain has no source, must have heightfield, a file, mesh, a file of "
                                 "triangles, or ridges, parameters; even ground has atmosphere.ground_albedo\n"},
      {"terrain: {ridges: {}, height_max: -5 m}", "1:35: terrain.height_max is -5 m, must be above height_min, 0 m\n"},
      {"place: {latitude: 3}", "1:8: place needs both latitude and longitude\n"},
      {"camera: {look_at: [0, -6 km, 400 m]}", "1:19: camera.look_at is camera.position, must be at least 1 mm away\n"},
      {"atmosphere: {mie_scattering: 1}",
       "1:13: atmosphere.mie_extinction is 4.44e-06 1/m, must not be below mie_scattering, 1 1/m\n"},
      {"sun: {time: 2026-06-21T16:00Z}", "1:13: sun.time needs a place, must come with place or terrain"},
      {"output: {scale: 3}", "1:17: output.scale is 3, must be a power of two; the nearest below is 2\n"},
      {"clouds: [{bake: {preset: dew}}]", "1:26: clouds[0].bake.preset is dew, must be one of cumulus_humilis"},
      {"clouds: [{bake: {map: {coverage: R}}}]", "1:23: clouds[0].bake.map has no image, must name an EXR or PNG"},
      {"clouds: [{bake: {base: 2 km, top: 1.5 km}}]",
       "1:35: clouds[0].bake.top is 1500 m, must be above base, 2000 m\n"},
      {"clouds: [{bake: {profile: [0, 0.5, 0.4, 0.6, 1]}}]",
       "1:27: clouds[0].bake.profile[2] is 0.4 after 0.5, must not fall\n"},
  };
  ASSERT_ALL_BAD(state, bad);
}

static void test_yaml_that_a_scene_may_not_use(void **state) {
  static const bad_scene bad[] = {
      {"camera: &a {}", "1:9: anchors (&) are not allowed in a scene\n"},
      {"camera: *a", "1:9: aliases (*) are not allowed in a scene\n"},
      {"*a : 1", "1:1: aliases (*) are not allowed in a scene\n"},
      {"camera: {<<: 1}", "1:10: merge keys (<<) are not allowed in a scene\n"},
      {"render: !x {}", "1:9: tags (!) are not allowed in a scene\n"},
      {"render: {samples: !!int 4}", "1:19: tags (!) are not allowed in a scene\n"},
      {"{a: 1}: 2", "1:1: a key must be a word, not a list or a mapping\n"},
      {"sun: {}\n---\nsun: {}", "2:1: a second document begins here, a scene is one\n"},
      {"", "1:1: nothing is here, must be a mapping of keys\n"},
      {"# only a comment\n", "2:1: nothing is here, must be a mapping of keys\n"},
      {"sun: [", "2:1: not valid YAML: did not find expected node content while parsing a flow node begun on line 2\n"},
      {"sun: {elevation: 3",
       "2:1: not valid YAML: did not find expected ',' or '}' while parsing a flow mapping begun on line 1\n"},
      {"sun: \"a",
       "1:8: not valid YAML: found unexpected end of stream while scanning a quoted scalar begun on line 1\n"},
      {"\tsun: 1",
       "1:1: not valid YAML: found character that cannot start any token while scanning for the next token"},
      {"sun: {elevation: \"\\0\"}", "1:18: a zero character is not allowed\n"},
  };
  ASSERT_ALL_BAD(state, bad);
}

static void test_deep_nesting_is_refused(void **state) {
  enum { DEPTH = 100000 };
  char *text = malloc(DEPTH + 1);
  assert_non_null(text);
  memset(text, '[', DEPTH);
  text[DEPTH] = '\0';
  assert_bad(*state, &(bad_scene){text, "1:17: nested more than 16 levels deep\n"});
  free(text);
}

static void test_long_lists_are_refused_soon(void **state) {
  enum { ITEMS = 200000 };
  char *text = malloc(2 * ITEMS + 32), *end = text;
  assert_non_null(text);
  end += sprintf(end, "camera: {position: [1");
  for (int i = 1; i < ITEMS; i++) end += sprintf(end, ",1");
  strcpy(end, "]}");
  assert_bad(*state, &(bad_scene){text, "1:20: camera.position is a list of 200000, must be a list of 3"});
  free(text);
}

static void test_too_many_clouds_are_refused(void **state) {
  char text[2000] = "clouds: [";
  for (int i = 0; i < 65; i++) strcat(text, "{bake: {}}, ");
  strcat(text, "]");
  assert_bad(*state, &(bad_scene){text, "1:9: clouds has 65 elements, must be at most 64\n"});
}

/* ---- Hostility ---- */

static uint64_t draw(uint64_t seed, uint64_t *counter) { return np_random_absorb(seed, ++*counter); }

/* Replaces, doubles or drops a few characters; the result is as long at most as `text` has room for. */
static size_t mutate_once(char *text, size_t length, uint64_t seed, uint64_t *counter) {
  static const char marks[] = "{}[]:,-#&*!|>'\"%@`? \n\t~<0123456789.eE\xff\xc2";
  size_t place = draw(seed, counter) % length;
  char character =
      draw(seed, counter) % 2 ? marks[draw(seed, counter) % (sizeof marks - 1)] : (char)(1 + draw(seed, counter) % 255);
  switch (draw(seed, counter) % 3) {
  case 0:
    text[place] = character;
    return length;
  case 1:
    memmove(text + place + 1, text + place, length - place);
    text[place] = character;
    return length + 1;
  default:
    memmove(text + place, text + place + 1, length - place - 1);
    return length - 1;
  }
}

static void test_random_mutations_never_crash(void **state) {
  enum { ROUNDS = 10000, CHANGES_MAX = 8 };
  test_fixture *f = *state;
  uint64_t counter = 0;
  unsigned loaded = 0;
  for (uint64_t round = 0; round < ROUNDS; round++) {
    char text[sizeof example + CHANGES_MAX];
    size_t length = sizeof example - 1;
    memcpy(text, example, length);
    for (uint64_t i = draw(round, &counter) % CHANGES_MAX; i < CHANGES_MAX; i++)
      length = mutate_once(text, length, round, &counter);
    text[length] = '\0';
    neph_scene *scene;
    neph_result result = neph_scene_load_text(f->context, text, "s.yaml", &scene);
    const unsigned errors = f->log.counts[NEPH_LOG_ERROR];
    /* One, or several and their number. */
    const bool is_reported = result ? errors == 1 || (errors > 2 && errors <= NP_SCENE_PROBLEMS_MAX + 1) : !errors;
    if (!result == !scene || !is_reported) fail_msg("%s\n%s", text, f->log.text);
    loaded += !result;
    neph_scene_destroy(scene);
    test_log_clear(&f->log);
  }
  assert_in_range(loaded, 1, ROUNDS - 1); /* changes hit comments and names as well as marks */
}

static neph_result load_example(neph_context *context, void *user) {
  (void)user;
  neph_scene *scene;
  neph_result result = neph_scene_load_text(context, example, "scene.yaml", &scene);
  neph_scene_destroy(scene);
  return result;
}

static void test_failed_allocations(void **state) {
  (void)state;
  assert_survives_failed_allocations(load_example, NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_example_is_read, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_preset_comes_first_wherever_it_stands, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_map_of_a_bake, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_block_style_is_the_same, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_files_are_read_from_disk, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_wrong_values, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_unknown_keys, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_keys_that_do_not_go_together, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_incomplete_scenes, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_yaml_that_a_scene_may_not_use, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_deep_nesting_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_long_lists_are_refused_soon, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_too_many_clouds_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_wrong_airs, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_aureole_of_haze_is_grey, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_haze_by_visual_range, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_presets_of_ice, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_one_lobe_by_its_asymmetry, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_presets_and_layers_of_air, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_random_mutations_never_crash, set_up, test_tear_down),
      cmocka_unit_test(test_failed_allocations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
