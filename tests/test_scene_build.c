/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes built by typed calls: the same pictures as from a file that says the same, the same ranges, shared assets. */
#include "test_scenes.h"

#include <nephos/nephos.h>

#include "core/units.h"

/* The file that equals the calls of `build`. */
static const char as_file[] =
    "{camera: {position: [-1.2 km, -3.1 km, 700 m], look_at: [0, 100 m, 1500 m], fov: 47 deg, roll: 3 deg,"
    "          resolution: [48, 27]},"
    " sun: {elevation: 31 deg, azimuth: 250 deg, irradiance: [1.5, 1.8, 1.9], angular_radius: 0.3 deg},"
    " atmosphere: {preset: earth-hazy, ground_albedo: 0.2},"
    " terrain: {ridges: {seed: 4, samples: 65, relief: 500 m}, albedo: [0.1, 0.2, 0.15], width: 20 km,"
    "           rock: {albedo: 0.1}, snow: {level: 400 m}},"
    " water: {level: 100 m, wind: 7 m/s, albedo: 0.03},"
    " clouds: [{bake: {seed: 3, extent: 3 km, voxel: 100 m, thickness: 900 m}, position: [200 m, 300 m, 900 m],"
    "           rotation: 20 deg, scale: 1.25, optical_depth: 12, albedo: [0.9, 0.95, 0.99], detail: none,"
    "           phase: {two_lobe: {forward: 0.8, backward: -0.2, weight: 0.15}}}],"
    " render: {samples: 2, sun_depth: volume, air_shadows: false}}";

typedef struct assets {
  neph_volume *volume;
  neph_terrain *terrain;
  neph_atmosphere *atmosphere;
} assets;

static neph_result make_assets(neph_context *context, assets *a) {
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  neph_terrain_desc ground = NEPH_TERRAIN_DESC_DEFAULT;
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  neph_atmosphere_desc air = NEPH_ATMOSPHERE_DESC_DEFAULT;
  *a = (assets){.volume = NULL};
  cloud.seed = 3;
  cloud.extent_m[0] = cloud.extent_m[1] = 3000;
  cloud.voxel_m = 100;
  cloud.thickness_m = 900;
  ground.width_m = 20000;
  memcpy(ground.ground_albedo, (double[]){0.1, 0.2, 0.15}, sizeof ground.ground_albedo);
  ground.has_rock = ground.has_snow = true;
  memcpy(ground.rock_albedo, (double[]){0.1, 0.1, 0.1}, sizeof ground.rock_albedo);
  ground.rock_slope_rad = 35 * NP_PI / 180;
  ground.snow_slope_rad = 50 * NP_PI / 180;
  ground.snow_level_m = 400;
  ridges.seed = 4;
  ridges.sample_count = 65;
  ridges.relief_m = 500;
  neph_result result = neph_atmosphere_get_preset(context, "earth-hazy", &air, NULL);
  for (int b = 0; b < 3; b++) air.ground_albedo[b] = 0.2;
  if (!result) result = neph_cloud_bake(context, &cloud, NULL, &a->volume);
  if (!result) result = neph_terrain_create_ridges(context, &ridges, &ground, &a->terrain);
  return result ? result : neph_atmosphere_create(context, &air, &a->atmosphere);
}

static void release_assets(assets *a) {
  neph_volume_release(a->volume);
  neph_terrain_release(a->terrain);
  neph_atmosphere_release(a->atmosphere);
}

static neph_placement_desc describe_placement(void) {
  neph_placement_desc p = NEPH_PLACEMENT_DESC_DEFAULT;
  p.has_position = true;
  memcpy(p.position_m, (double[]){200, 300, 900}, sizeof p.position_m);
  p.rotation_rad = 20 * NP_DEGREE;
  p.scale = 1.25;
  p.density_unit = NEPH_DENSITY_OPTICAL_DEPTH;
  p.density_value = 12;
  memcpy(p.albedo, (double[]){0.9, 0.95, 0.99}, sizeof p.albedo);
  p.phase = NEPH_PHASE_TWO_LOBE;
  p.asymmetry = 0.8;
  p.second_asymmetry = -0.2;
  p.second_weight = 0.15;
  return p;
}

static neph_camera_desc describe_camera(void) {
  neph_camera_desc camera = NEPH_CAMERA_DESC_DEFAULT;
  memcpy(camera.position_m, (double[]){-1200, -3100, 700}, sizeof camera.position_m);
  memcpy(camera.look_at_m, (double[]){0, 100, 1500}, sizeof camera.look_at_m);
  camera.fov_rad = 47 * NP_PI / 180; /* converted like a file's degrees, to equal bits */
  camera.roll_rad = 3 * NP_PI / 180;
  camera.resolution[0] = 48;
  camera.resolution[1] = 27;
  return camera;
}

static neph_sun_desc describe_sun(void) {
  neph_sun_desc sun = NEPH_SUN_DESC_DEFAULT;
  sun.elevation_rad = 31 * NP_PI / 180;
  sun.azimuth_rad = 250 * NP_PI / 180;
  sun.has_irradiance = sun.has_angular_radius = true;
  memcpy(sun.irradiance_w_m2_nm, (double[]){1.5, 1.8, 1.9}, sizeof sun.irradiance_w_m2_nm);
  sun.angular_radius_rad = 0.3 * NP_PI / 180;
  return sun;
}

static neph_water_desc describe_water(void) {
  neph_water_desc water = NEPH_WATER_DESC_DEFAULT;
  water.level_m = 100;
  water.wind_m_s = 7;
  memcpy(water.albedo, (double[]){0.03, 0.03, 0.03}, sizeof water.albedo);
  return water;
}

/* The scene of `as_file` but for its render keys. */
static neph_result build(neph_context *context, neph_scene **out_scene) {
  assets a;
  const neph_camera_desc camera = describe_camera();
  const neph_sun_desc sun = describe_sun();
  const neph_water_desc water = describe_water();
  neph_placement_desc placement = describe_placement();
  placement.rotation_rad = 20 * NP_PI / 180;
  *out_scene = NULL;
  neph_result result = make_assets(context, &a);
  if (!result) result = neph_scene_create(context, out_scene);
  if (!result) result = neph_scene_set_camera(*out_scene, &camera);
  if (!result) result = neph_scene_set_sun(*out_scene, &sun);
  if (!result) result = neph_scene_set_atmosphere(*out_scene, a.atmosphere);
  if (!result) result = neph_scene_set_terrain(*out_scene, a.terrain);
  if (!result) result = neph_scene_set_water(*out_scene, &water);
  if (!result) result = neph_scene_add_volume(*out_scene, a.volume, &placement, NULL);
  release_assets(&a);
  return result;
}

static void assert_same_picture(fixture *f, const char *integrator, const char *atmosphere) {
  neph_scene *scene;
  neph_image *ours, *theirs;
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  assert_int_equal(build(f->context, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render", "{samples: 2, sun_depth: volume, air_shadows: false}"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.integrator", integrator), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.atmosphere", atmosphere), NEPH_OK);
  set(f, "render.integrator", integrator);
  set(f, "render.atmosphere", atmosphere);
  assert_int_equal(neph_render_image(scene, NULL, &ours), NEPH_OK);
  assert_int_equal(neph_render_image(f->scene, NULL, &theirs), NEPH_OK);
  assert_int_equal(neph_image_compare(f->context, ours, theirs, &difference), NEPH_OK);
  assert_int_equal(difference.differing_count, 0);
  assert_true(difference.value_count > 0);
  neph_image_destroy(ours);
  neph_image_destroy(theirs);
  neph_scene_destroy(scene);
}

static int set_up(void **state) { return set_up_scene(state, 2, as_file); }

static void a_built_scene_is_that_of_a_file_to_the_march(void **state) {
  assert_same_picture(*state, "march", "traced");
}

static void a_built_scene_is_that_of_a_file_to_the_path_tracer(void **state) {
  assert_same_picture(*state, "path", "traced");
  assert_same_picture(*state, "path", "tables");
}

static neph_scene *create(fixture *f) {
  neph_scene *scene;
  assert_int_equal(neph_scene_create(f->context, &scene), NEPH_OK);
  return scene;
}

static void assert_same_description(neph_context *context, const neph_scene *a, const neph_scene *b) {
  char *ours, *theirs;
  assert_int_equal(neph_scene_describe(a, NEPH_TEXT_PLAIN, &ours), NEPH_OK);
  assert_int_equal(neph_scene_describe(b, NEPH_TEXT_PLAIN, &theirs), NEPH_OK);
  assert_string_equal(ours, theirs);
  neph_text_destroy(context, ours);
  neph_text_destroy(context, theirs);
}

static void defaults_of_descriptions_are_those_of_keys(void **state) {
  fixture *f = *state;
  neph_scene *plain = create(f), *scene = create(f);
  const neph_camera_desc camera = NEPH_CAMERA_DESC_DEFAULT;
  neph_sun_desc sun = NEPH_SUN_DESC_DEFAULT;
  assert_int_equal(neph_scene_set_camera(scene, &camera), NEPH_OK);
  assert_int_equal(neph_scene_set_sun(scene, &sun), NEPH_OK);
  assert_same_description(f->context, scene, plain);
  assert_int_equal(neph_scene_set_camera(scene, NULL), NEPH_OK);
  assert_int_equal(neph_scene_set_sun(scene, NULL), NEPH_OK);
  assert_same_description(f->context, scene, plain);
  neph_scene_destroy(scene);
  neph_scene_destroy(plain);
}

static void a_sun_of_a_direction_stands_there(void **state) {
  fixture *f = *state;
  neph_scene *scene = create(f), *wanted = create(f);
  neph_sun_desc sun = NEPH_SUN_DESC_DEFAULT;
  sun.has_direction = true;
  memcpy(sun.direction, (double[]){0, -7, 7}, sizeof sun.direction);                 /* south, halfway up */
  assert_int_equal(neph_scene_set(scene, "sun.time", "2026-06-21T16:00Z"), NEPH_OK); /* gives way */
  assert_int_equal(neph_scene_set_sun(scene, &sun), NEPH_OK);
  assert_int_equal(neph_scene_set(wanted, "sun", "{elevation: 45 deg, azimuth: 180 deg}"), NEPH_OK);
  assert_same_description(f->context, scene, wanted);
  memset(sun.direction, 0, sizeof sun.direction);
  assert_int_equal(neph_scene_set_sun(scene, &sun), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "sun direction is (0, 0, 0)");
  assert_same_description(f->context, scene, wanted);
  neph_scene_destroy(scene);
  neph_scene_destroy(wanted);
}

static void keys_go_on_to_change_what_calls_have_built(void **state) {
  fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(build(f->context, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "clouds[0].scale", "2"), NEPH_OK);
  assert_int_equal(neph_scene_check(scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "clouds[0].vdb", "a.vdb"), NEPH_OK);
  assert_int_equal(neph_scene_check(scene), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "clouds[0].vdb", "a volume that a call has added");
  assert_int_equal(neph_scene_set_placement(scene, 0, NULL), NEPH_OK);
  assert_int_equal(neph_scene_check(scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "terrain.albedo", "0.5"), NEPH_OK);
  assert_int_equal(neph_scene_check(scene), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "terrain.albedo", "a call has set the terrain");
  assert_int_equal(neph_scene_set(scene, "terrain", "none"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "atmosphere", "{preset: mars}"), NEPH_OK);
  assert_int_equal(neph_scene_check(scene), NEPH_OK);
  neph_scene_destroy(scene);
}

static void nothing_given_is_nothing_there(void **state) {
  fixture *f = *state;
  neph_scene *scene, *wanted = create(f);
  assert_int_equal(build(f->context, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "clouds", "[]"), NEPH_OK);
  assert_int_equal(neph_scene_set_terrain(scene, NULL), NEPH_OK);
  assert_int_equal(neph_scene_set_water(scene, NULL), NEPH_OK);
  assert_int_equal(neph_scene_set_atmosphere(scene, NULL), NEPH_OK);
  assert_int_equal(neph_scene_set_camera(scene, NULL), NEPH_OK);
  assert_int_equal(neph_scene_set_sun(scene, NULL), NEPH_OK);
  assert_int_equal(neph_scene_set(wanted, "atmosphere", "none"), NEPH_OK);
  assert_same_description(f->context, scene, wanted);
  neph_scene_destroy(scene);
  neph_scene_destroy(wanted);
}

/* ---- Failures ---- */

static void values_have_the_ranges_of_their_keys(void **state) {
  fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(build(f->context, &scene), NEPH_OK);
  neph_camera_desc camera = NEPH_CAMERA_DESC_DEFAULT;
  camera.fov_rad = NAN;
  assert_int_equal(neph_scene_set_camera(scene, &camera), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "camera.fov is nan deg, must be", "[0.01, 170] deg");
  camera.fov_rad = 1;
  camera.resolution[1] = 0;
  assert_int_equal(neph_scene_set_camera(scene, &camera), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "camera.resolution[1] is 0, must be", "65536");
  neph_placement_desc p = NEPH_PLACEMENT_DESC_DEFAULT;
  p.albedo[2] = 1.5;
  assert_int_equal(neph_scene_set_placement(scene, 0, &p), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "clouds[0].albedo[2] is 1.5, must be", "[0, 1]");
  p = (neph_placement_desc)NEPH_PLACEMENT_DESC_DEFAULT;
  p.density_unit = NEPH_DENSITY_LIQUID_WATER;
  p.density_value = INFINITY;
  assert_int_equal(neph_scene_set_placement(scene, 0, &p), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "clouds[0].liquid_water.effective_radius is inf um, must be");
  assert_int_equal(neph_scene_check(scene), NEPH_OK);
  neph_scene_destroy(scene);
}

static void strange_descriptions_are_refused(void **state) {
  fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(build(f->context, &scene), NEPH_OK);
  const neph_camera_desc camera = {.struct_size = 1};
  const neph_sun_desc sun = {.struct_size = sizeof sun + 1};
  neph_placement_desc p = {.struct_size = 0};
  assert_int_equal(neph_scene_set_camera(scene, &camera), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "neph_camera_desc.struct_size is 1");
  assert_int_equal(neph_scene_set_sun(scene, &sun), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "neph_sun_desc.struct_size");
  assert_int_equal(neph_scene_set_placement(scene, 0, &p), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "neph_placement_desc.struct_size is 0");
  p = (neph_placement_desc)NEPH_PLACEMENT_DESC_DEFAULT;
  p.phase = (neph_phase)17;
  assert_int_equal(neph_scene_set_placement(scene, 0, &p), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "phase is 17");
  p.phase = NEPH_PHASE_HAZE;
  assert_int_equal(neph_scene_set_placement(scene, 0, &p), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "phase is 5");
  p.phase = NEPH_PHASE_TABLE;
  assert_int_equal(neph_scene_set_placement(scene, 0, &p), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "phase_table is NULL");
  p.phase = NEPH_PHASE_ISOTROPIC;
  p.density_unit = (neph_density_unit)-1;
  assert_int_equal(neph_scene_set_placement(scene, 0, &p), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "density_unit is -1");
  assert_int_equal(neph_scene_set_placement(scene, 1, NULL), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "cloud 1 of 1");
  unsigned index = 77;
  assert_int_equal(neph_scene_add_volume(scene, NULL, NULL, &index), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "volume is NULL, must be given");
  assert_int_equal(index, 77);
  neph_scene_destroy(scene);
}

static neph_result make_small_volume(neph_context *context, neph_volume **out) {
  static const float values[8] = {1, 1, 1, 1, 1, 1, 1, 1};
  neph_volume_dense_desc dense = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  for (int i = 0; i < 3; i++) dense.size[i] = 2;
  dense.values = values;
  return neph_volume_create_dense(context, &dense, out);
}

/* Each kind with the parameters of the defaults, and the value of `clouds[0].phase` that says the same. */
static const struct {
  neph_phase phase;
  const char *value;
} phases[] = {{NEPH_PHASE_RAYLEIGH, "rayleigh"},
              {NEPH_PHASE_ISOTROPIC, "isotropic"},
              {NEPH_PHASE_HENYEY_GREENSTEIN, "{hg: 0.85}"},
              {NEPH_PHASE_TWO_LOBE, "{two_lobe: {forward: 0.85, backward: -0.25, weight: 0.1}}"},
              {NEPH_PHASE_CORNETTE_SHANKS, "{draine: {g: 0.85, alpha: 1}}"},
              {NEPH_PHASE_DRAINE, "{draine: {g: 0.85, alpha: 1}}"},
              {NEPH_PHASE_DROPLETS, "{droplets: {diameter: 20 um}}"},
              {NEPH_PHASE_TABLE, "{table: \"measured.csv\"}"},
              {NEPH_PHASE_MIE, "{mie: {effective_radius: 10 um, effective_variance: 0.1}}"},
              {NEPH_PHASE_RAIN, "{rain: {mode_diameter: 500 um}}"},
              {NEPH_PHASE_ICE, "{ice: {habit: mixed}}"}};

static void every_phase_function_is_that_of_its_key(void **state) {
  fixture *f = *state;
  assert_int_equal(sizeof phases / sizeof *phases, NEPH_PHASE_ICE); /* all kinds but haze, which is of air alone */
  for (size_t i = 0; i < sizeof phases / sizeof *phases; i++) {
    neph_scene *typed = create(f), *written = create(f);
    neph_volume *volume;
    neph_placement_desc p = NEPH_PLACEMENT_DESC_DEFAULT;
    p.phase = phases[i].phase;
    p.phase_table = "measured.csv";
    assert_int_equal(make_small_volume(f->context, &volume), NEPH_OK);
    assert_int_equal(neph_scene_add_volume(typed, volume, &p, NULL), NEPH_OK);
    assert_int_equal(neph_scene_add_volume(written, volume, NULL, NULL), NEPH_OK);
    assert_int_equal(neph_scene_set(written, "clouds[0].phase", phases[i].value), NEPH_OK);
    assert_same_description(f->context, typed, written);
    neph_volume_release(volume);
    neph_scene_destroy(typed);
    neph_scene_destroy(written);
  }
}

static void assets_of_another_context_are_refused(void **state) {
  fixture *f = *state;
  neph_context *other = test_context_create(1, NULL);
  neph_scene *scene = create(f);
  assets a;
  assert_int_equal(make_assets(other, &a), NEPH_OK);
  assert_int_equal(neph_scene_add_volume(scene, a.volume, NULL, NULL), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "the volume belongs to another context");
  assert_int_equal(neph_scene_set_terrain(scene, a.terrain), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "the terrain belongs to another context");
  assert_int_equal(neph_scene_set_atmosphere(scene, a.atmosphere), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "the atmosphere belongs to another context");
  release_assets(&a);
  neph_scene_destroy(scene);
  neph_context_destroy(other);
}

static void a_terrain_of_another_planet_is_refused(void **state) {
  fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(build(f->context, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "atmosphere", "{preset: mars}"), NEPH_OK);
  assert_int_equal(neph_scene_check(scene), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "a planet of 6360000 m", "must be the scene's");
  neph_scene_destroy(scene);
}

/* Assets that cost next to nothing. */
static neph_result make_small_terrain(neph_context *context, neph_terrain **out) {
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  ridges.sample_count = 17;
  return neph_terrain_create_ridges(context, &ridges, NULL, out);
}

static neph_result make_small_atmosphere(neph_context *context, neph_atmosphere **out) {
  neph_atmosphere_desc air = NEPH_ATMOSPHERE_DESC_DEFAULT;
  air.layer_count = 0;
  air.tolerance = 0.1;
  return neph_atmosphere_create(context, &air, out);
}

/* Last, because it is slow: the scene is rebuilt for each allocation. */
static neph_result build_once(neph_context *context, void *user) {
  (void)user;
  assets a = {.volume = NULL};
  neph_scene *scene = NULL;
  neph_result result = neph_scene_create(context, &scene);
  if (!result) result = neph_scene_set_camera(scene, NULL);
  if (!result) result = neph_scene_set_sun(scene, NULL);
  if (!result) result = make_small_volume(context, &a.volume);
  if (!result) result = neph_scene_add_volume(scene, a.volume, NULL, NULL);
  if (!result) result = neph_scene_set_placement(scene, 0, NULL);
  if (!result) result = make_small_terrain(context, &a.terrain);
  if (!result) result = neph_scene_set_terrain(scene, a.terrain);
  if (!result) result = make_small_atmosphere(context, &a.atmosphere);
  if (!result) result = neph_scene_set_atmosphere(scene, a.atmosphere);
  neph_scene_destroy(scene);
  release_assets(&a);
  return result;
}

static void building_survives_each_failed_allocation(void **state) {
  (void)state;
  assert_survives_failed_allocations(build_once, NULL);
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
  const struct CMUnitTest tests[] = {
      TEST(a_built_scene_is_that_of_a_file_to_the_march), TEST(a_built_scene_is_that_of_a_file_to_the_path_tracer),
      TEST(defaults_of_descriptions_are_those_of_keys),   TEST(a_sun_of_a_direction_stands_there),
      TEST(keys_go_on_to_change_what_calls_have_built),   TEST(nothing_given_is_nothing_there),
      TEST(values_have_the_ranges_of_their_keys),         TEST(strange_descriptions_are_refused),
      TEST(every_phase_function_is_that_of_its_key),      TEST(assets_of_another_context_are_refused),
      TEST(a_terrain_of_another_planet_is_refused),       cmocka_unit_test(building_survives_each_failed_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
