/* SPDX-License-Identifier: Apache-2.0 */
/* Tiles of one field on the sphere: places and their matches, and the light of the sun over them. */
#include "test_scenes.h"

#include <math.h>

#include "plan/plan_choices.h"
#include "scene/cloud_places.h"
#include "transport/fold_light.h"

static const char scene[] = "camera: {position: [0 m, 0 m, 50 m]}\n"
                            "sun: {elevation: 30 deg}\n"
                            "clouds: [{bake: {preset: stratocumulus}}]\n";

static int set_up(void **state) { return set_up_scene(state, 1, scene); }

static double choose_fold(const fixture *f, np_transport_fold *out) {
  np_dvec3 low = np_dvec3_make(-1e6, -1e6, -1e6), high = np_dvec3_make(1e6, 1e6, 1e6);
  return np_plan_choose_fold(f->scene, &low, &high, out);
}

/* Distance between the matches of a place in a tile and of the equal place in the tile at the origin. */
static double compute_gap(const np_transport_fold *fold, const np_cloud_place *place, double turn_rad, np_dvec3 own) {
  const np_cloud_place middle = {.rotation_rad = turn_rad, .scale = 1.0};
  const np_affine there = np_cloud_place_get_affine(place), here = np_cloud_place_get_affine(&middle);
  const np_dvec3 match = np_transport_fold_match(fold, np_affine_point(&there, own));
  return np_dvec3_length(np_dvec3_subtract(match, np_affine_point(&here, own)));
}

/* Matches are right to a fraction of a voxel: 0.4 m of 20 m in tiles to 132 km; 15 m in the wide tiles of cirrus, to
 * 365 km, which are flat and stand on a sphere. */
static void places_match(void **state) {
  fixture *f = *state;
  static const struct {
    const char *preset;
    double most_m;
  } rows[] = {{"stratocumulus", 1}, {"altostratus", 10}, {"cirrus", 25}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    set(f, "clouds[0].bake.preset", rows[i].preset);
    const np_scene_cloud *cloud = f->scene->clouds;
    np_transport_fold fold;
    double worst_m = 0;
    assert_true(choose_fold(f, &fold) > 1.0);
    for (unsigned k = 0; k < cloud->place_count; k++)
      for (int n = 0; n < 9; n++) {
        const double x = 0.49 * (n % 3 - 1) * fold.period_m, y = 0.49 * (n / 3 - 1) * fold.period_m;
        const double z = cloud->bake.base_altitude_m + 0.5 * cloud->bake.thickness_m;
        const double turn_rad = atan2(fold.turn_sin, fold.turn_cos);
        worst_m = fmax(worst_m, compute_gap(&fold, &cloud->place[k], turn_rad, np_dvec3_make(x, y, z)));
      }
    print_message("%s: %u tiles, matches within %.3g m\n", rows[i].preset, cloud->place_count, worst_m);
    assert_true(worst_m < rows[i].most_m);
  }
}

/* Half a tile from the middle is its side, whichever way it is turned. */
static void the_tile_is_held(void **state) {
  fixture *f = *state;
  np_transport_fold fold;
  assert_true(choose_fold(f, &fold) >= 1.0);
  assert_true(np_transport_fold_is_within(&fold, np_dvec3_make(0, 0, 0), 0));
  assert_true(np_transport_fold_is_within(&fold, np_dvec3_make(0.49 * fold.period_m, 0, 0), 0));
  assert_false(np_transport_fold_is_within(&fold, np_dvec3_make(fold.period_m, 0, 0), fold.margin_m));
}

static void other_fields_are_solved_whole(void **state) {
  fixture *f = *state;
  static const char *const rows[][2] = {{"clouds[0].bake.repeat", "none"},
                                        {"clouds[0].bake.extent", "4 km"},
                                        {"clouds[0].bake.preset", "cumulus_mediocris"},
                                        {"terrain", "{ridges: {seed: 3}}"},
                                        {"environment.planet", "none"}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    neph_scene *other;
    np_transport_fold fold;
    assert_int_equal(neph_scene_load_text(f->context, scene, "dir/scene.yaml", &other), NEPH_OK);
    assert_int_equal(neph_scene_set(other, rows[i][0], rows[i][1]), NEPH_OK);
    const fixture moved = {.scene = other};
    (void)choose_fold(&moved, &fold);
    if (fold.period_m != 0.0) fail_msg("%s: %s", rows[i][0], rows[i][1]);
    neph_scene_destroy(other);
  }
}

/* Without air and with a black sky light goes by the sine of the sun's elevation, which is 1° more 111 km nearer to
 * it. */
static void light_goes_by_the_sun(void **state) {
  (void)state;
  const double radius_m = 6371e3, elevation = 0.2, angle = 1.0 / 57.29577951;
  const np_transport_fold fold = {.period_m = 8e3,
                                  .turn_cos = 1.0,
                                  .planet_radius_m = radius_m,
                                  .pitch_radius_m = radius_m + 1e3,
                                  .range_m = 150e3};
  const np_world world = {.to_sun = {(float)cos(elevation), 0.0f, (float)sin(elevation)},
                          .sun_irradiance = np_spectrum_grey(1.0f),
                          .has_planet = true,
                          .planet_radius_m = radius_m};
  np_fold_light light;
  np_fold_light_fill(&world, &fold, &light);
  for (int n = -1; n <= 1; n++) {
    const np_dvec3 place = np_dvec3_make(radius_m * sin(n * angle), 0, radius_m * (cos(n * angle) - 1.0));
    float gain[NP_BAND_COUNT];
    np_fold_light_get(&light, &fold, place, gain);
    assert_near((double)gain[0], sin(elevation + n * angle) / sin(elevation), 1e-4);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(places_match, set_up, tear_down),
      cmocka_unit_test_setup_teardown(the_tile_is_held, set_up, tear_down),
      cmocka_unit_test_setup_teardown(other_fields_are_solved_whole, set_up, tear_down),
      cmocka_unit_test(light_goes_by_the_sun),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
