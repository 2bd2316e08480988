/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes with fire, from files: the grids are found, placed and meant as the scene says; what no fire can be is refused
 * or repaired, and never in the picture. */
#include <nephos/nephos.h>

#include "core/units.h"
#include "image/deep.h"
#include "optics/black_body.h"
#include "test_color_difference.h"
#include "test_support.h"
#include "volume/volume_private.h"

enum { EDGE = 24 };

/* ---- Files ---- */

/* Content of a grid; nothing if its radius is 0. */
typedef struct recipe {
  const char *name;
  float inside;             /* in the middle, falling to 0 at `radius` */
  double middle[3], radius; /* voxels */
  float poison;             /* in one voxel of the middle, where it is not 0 */
  float background;
} recipe;

static void fill(const recipe *r, np_sparse_grid *grid) {
  int32_t o[3];
  for (o[0] = 0; o[0] < EDGE; o[0] += NP_LEAF_EDGE)
    for (o[1] = 0; o[1] < EDGE; o[1] += NP_LEAF_EDGE)
      for (o[2] = 0; o[2] < EDGE; o[2] += NP_LEAF_EDGE) {
        np_leaf *leaf = np_sparse_grid_add_leaf(grid, o);
        assert_non_null(leaf);
        for (int n = 0; n < NP_LEAF_SIZE; n++) {
          const double x = o[0] + (n >> 6) - r->middle[0], y = o[1] + (n >> 3 & 7) - r->middle[1],
                       z = o[2] + (n & 7) - r->middle[2], r2 = (x * x + y * y + z * z) / (r->radius * r->radius);
          leaf->values[n] = r2 < 1.0 ? r->inside * (float)(1.0 - r2) : r->background;
          if (r->poison != 0.0f && x * x + y * y + z * z < 1.0) leaf->values[n] = r->poison;
          if (r2 < 1.0) leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
        }
      }
}

static void write_grids(neph_context *context, const char *path, const recipe *recipes, size_t count) {
  np_sparse_grid grids[3] = {{0}};
  np_vdb_write_grid outputs[3] = {{0}};
  for (size_t i = 0; i < count; i++) {
    assert_int_equal(np_sparse_grid_init(context, recipes[i].name, &grids[i]), NEPH_OK);
    grids[i].index_to_world = np_affine_identity();
    grids[i].background = recipes[i].background;
    if (recipes[i].radius > 0.0) fill(&recipes[i], &grids[i]);
    outputs[i].grid = &grids[i];
  }
  assert_int_equal(np_volume_save_grids(context, path, outputs, count, NULL), NEPH_OK);
  for (size_t i = 0; i < count; i++) np_sparse_grid_clear(&grids[i]);
}

/* Smoke above a flame that reaches out of it, hot around the flame. */
static const recipe smoke = {.name = "density", .inside = 1.0f, .middle = {11.5, 11.5, 14.0}, .radius = 9.0};
static const recipe flame = {.name = "flame", .inside = 1.0f, .middle = {11.5, 11.5, 5.0}, .radius = 5.0};
static const recipe heat = {.name = "temperature", .inside = 1900.0f, .middle = {11.5, 11.5, 5.0}, .radius = 20.0};

typedef test_fixture fixture;

static int set_up(void **state) {
  const int failed = test_set_up_cached(state, 2, "fire.vdb");
  const fixture *f = *state;
  const recipe all[] = {smoke, flame, heat};
  if (!failed) write_grids(f->context, f->path, all, 3);
  return failed;
}

/* ---- Pictures ---- */

/* High above the ground, whose points of light are the farther apart, and so the fewer. Coarse tables of the air, of
 * which 60 m lie before the fire, and multiple scattering in few directions. */
static const char format[] =
    "version: 1\n"
    "camera: {position: [0 m, -60 m, 314 m], look_at: [0 m, 0 m, 312 m], fov: 32 deg, resolution: [20, 20]}\n"
    "sun: {elevation: 20 deg, azimuth: 240 deg}\n"
    "clouds:\n"
    "  - {name: fire, vdb: \"%s\", extinction: 0.3 1/m, albedo: [0.9, 0.85, 0.8], phase: {hg: 0.5},\n"
    "     position: [0, 0, 305 m], emission: {%s}, import: %s}\n"
    "atmosphere: {tolerance: 0.1}\n"
    "render: {samples: 16, light_degree: 3, light_residual: 0.03}\n"
    "output: {color_space: bands, aovs: [background, terrain, air, sun, sky, ground, multiple, emission]}\n";

static neph_scene *load(const fixture *f, const char *emission, const char *import) {
  char text[2048];
  (void)snprintf(text, sizeof text, format, f->path, emission, import);
  neph_scene *scene = NULL;
  assert_int_equal(neph_scene_load_text(f->context, text, "fire.yaml", &scene), NEPH_OK);
  return scene;
}

/* One of `tile_count` tiles, the middle one. */
static neph_image *render_tile(neph_scene *scene, neph_integrator integrator, unsigned tile_count) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image = NULL;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.integrator = integrator;
  desc.tile_count = tile_count;
  desc.tile_index = tile_count / 2;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  return image;
}

static neph_image *render(neph_scene *scene, neph_integrator integrator) { return render_tile(scene, integrator, 1); }

static double compute_mean(neph_image *image, const char *channel) {
  const float *values = neph_image_get_channel(image, channel);
  const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  double sum = 0.0;
  for (size_t p = 0; p < count; p++) sum += (double)values[p];
  return sum / (double)count;
}

static void set(neph_scene *scene, const char *key, const char *value) {
  assert_int_equal(neph_scene_set(scene, key, value), NEPH_OK);
}

/* The mean of a component of a scene's picture: of what the camera sees of the fire itself, to which multiple
 * scattering adds nothing. */
static double measure(const fixture *f, const char *emission, neph_integrator integrator, const char *channel) {
  neph_scene *scene = load(f, emission, "refuse");
  if (integrator == NEPH_INTEGRATOR_MARCH) set(scene, "render.multiple_scattering", "none");
  neph_image *image = render(scene, integrator);
  const double mean = compute_mean(image, channel);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  return mean;
}

/* Each component went through its own film; sums of 8 floats agree with the beauty's to float rounding. */
static void components_add_up_to_the_beauty(void **state) {
  static const char *const layers[] = {"background", "terrain", "air", "sun", "sky", "ground", "multiple", "emission"};
  static const char *const bands[] = {"R", "G", "B"};
  const fixture *f = *state;
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_scene *scene = load(f, "", "refuse");
    neph_image *image = render(scene, i);
    const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
    for (int b = 0; b < 3; b++)
      for (size_t p = 0; p < count; p++) {
        double sum = 0.0;
        for (size_t l = 0; l < sizeof layers / sizeof *layers; l++) {
          char name[32];
          (void)snprintf(name, sizeof name, "%s.%s", layers[l], bands[b]);
          const double value = (double)neph_image_get_channel(image, name)[p];
          assert_true(value >= 0.0);
          sum += value;
        }
        assert_near_relative((double)neph_image_get_channel(image, bands[b])[p], sum, 1e-5);
      }
    assert_true(compute_mean(image, "emission.R") > 0.0);
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
}

/* Both see one fire: 16 samples a pixel of the tracer leave 2 % in the emission's mean, drawn pixel points most of it.
 */
static void integrators_agree_on_emission(void **state) {
  const fixture *f = *state;
  const double march = measure(f, "", NEPH_INTEGRATOR_MARCH, "emission.R"),
               path = measure(f, "", NEPH_INTEGRATOR_PATH, "emission.R");
  print_message("emission.R: march %.5g, path %.5g\n", march, path);
  assert_near_relative(march, path, 0.02);
}

/* The keys set the emission: twice the absorption or the strength is twice the light; 273.15 K of offset with
 * that much less in the grid is the same light; a constant temperature is the black body's ratio of colours. */
static void keys_mean_what_they_say(void **state) {
  const fixture *f = *state;
  const neph_integrator march = NEPH_INTEGRATOR_MARCH;
  const double once = measure(f, "flame: flame, temperature: temperature", march, "emission.G");
  assert_near_relative(measure(f, "", march, "emission.G"), once, 1e-6); /* the defaults */
  assert_near_relative(measure(f, "absorption: 2 1/m", march, "emission.G"), 2.0 * once, 1e-5);
  assert_near_relative(measure(f, "strength: 2", march, "emission.G"), 2.0 * once, 1e-5);
  assert_near_relative(measure(f, "absorption: 2 1/km, strength: 500", march, "emission.G"), once, 1e-5);
  const double red = measure(f, "temperature: none, offset: 1500 K", march, "emission.R"),
               green = measure(f, "temperature: none, offset: 1500 K", march, "emission.G");
  /* The air before the camera, 60 m of it, takes 1e-3 of either. */
  assert_near_relative(red / green, np_black_body_radiance(680.0, 1500.0) / np_black_body_radiance(550.0, 1500.0),
                       3e-3);
  assert_true(measure(f, "kelvin: 0.5 K", march, "emission.R") < 1e-3 * once);
}

/* The cloud's own absorption: (1−ϖ)·σ, most in blue, where it is darkest, and none where nothing is absorbed. */
static void without_a_flame_the_cloud_emits_by_its_absorption(void **state) {
  const fixture *f = *state;
  const char *const keys = "flame: none, temperature: none, offset: 1500 K";
  neph_scene *scene = load(f, keys, "refuse");
  set(scene, "render.multiple_scattering", "none"); /* not in the emission */
  neph_image *image = render(scene, NEPH_INTEGRATOR_MARCH);
  const double red = compute_mean(image, "emission.R"), green = compute_mean(image, "emission.G");
  /* The same smoke hides both, and both glow in proportion to what they absorb, 0.10 and 0.15. */
  assert_near_relative(green / red, 1.5 * np_black_body_radiance(550.0, 1500.0) / np_black_body_radiance(680.0, 1500.0),
                       3e-3);
  neph_image_destroy(image);
  assert_int_equal(neph_scene_set(scene, "clouds[0].albedo", "1"), NEPH_OK);
  image = render(scene, NEPH_INTEGRATOR_MARCH);
  assert_true(compute_mean(image, "emission.R") == 0.0);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

static double compute_group_sum(neph_image *image) {
  return compute_mean(image, "light_sun.R") + compute_mean(image, "light_sky.R") + compute_mean(image, "light_fire.R");
}

/* Each emission is a group of lights: with the others it adds up, and it is the picture with no other light. The march
 * errs by its tolerance, the mean of 6400 paths by 3 %. */
static void a_fire_is_a_group_of_lights(void **state) {
  const fixture *f = *state;
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_scene *scene = load(f, "", "refuse");
    assert_int_equal(neph_scene_set(scene, "camera.resolution", "[10, 10]"), NEPH_OK);
    if (i == NEPH_INTEGRATOR_PATH) assert_int_equal(neph_scene_set(scene, "render.samples", "64"), NEPH_OK);
    assert_int_equal(neph_scene_set(scene, "output.aovs", "[lights]"), NEPH_OK);
    neph_image *groups = render(scene, i);
    assert_near_relative(compute_group_sum(groups), compute_mean(groups, "R"), 1e-5);
    assert_int_equal(neph_scene_set(scene, "output.aovs", "[]"), NEPH_OK);
    assert_int_equal(neph_scene_set(scene, "sun.irradiance", "0"), NEPH_OK);
    neph_image *alone = render(scene, i);
    assert_near_relative(compute_mean(groups, "light_fire.R"), compute_mean(alone, "R"),
                         i == NEPH_INTEGRATOR_MARCH ? 0.01 : 0.05);
    neph_image_destroy(groups);
    neph_image_destroy(alone);
    neph_scene_destroy(scene);
  }
}

static double flatten(const np_deep_pixel *pixel) {
  double sum = 0.0, left = 1.0;
  for (unsigned s = 0; s < pixel->count; s++) {
    sum += left * (double)pixel->samples[s].color[0];
    left *= 1.0 - (double)pixel->samples[s].alpha;
  }
  return sum;
}

/* Emission has light and no opacity, and may be where no smoke is. */
static void deep_pixels_hold_the_flame(void **state) {
  const fixture *f = *state;
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_scene *scene = load(f, "", "refuse");
    assert_int_equal(neph_scene_set(scene, "camera.resolution", "[10, 10]"), NEPH_OK);
    assert_int_equal(neph_scene_set(scene, "output.aovs", "[clouds, emission]"), NEPH_OK);
    assert_int_equal(neph_scene_set(scene, "output.deep", "deep.exr"), NEPH_OK);
    neph_image *image = render(scene, i);
    const float *clouds = neph_image_get_channel(image, "clouds.R");
    for (size_t p = 0; p < 100; p++)
      assert_near(flatten(&image->deep[p]), (double)clouds[p], 1e-3 * fmax((double)clouds[p], 1e-3));
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
}

/* Sun and moon are two views of one scene; a fire is in one of them. */
static void a_second_light_does_not_light_the_fire_twice(void **state) {
  const fixture *f = *state;
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_scene *scene = load(f, "", "refuse");
    assert_int_equal(neph_scene_set(scene, "sun.elevation", "-12 deg"), NEPH_OK);
    if (i == NEPH_INTEGRATOR_MARCH) set(scene, "render.multiple_scattering", "none"); /* not in the emission */
    neph_image *one = render(scene, i);
    assert_int_equal(neph_scene_set(scene, "moon", "{elevation: 40 deg, azimuth: 60 deg}"), NEPH_OK);
    neph_image *two = render(scene, i);
    assert_near_relative(compute_mean(two, "emission.G"), compute_mean(one, "emission.G"), 0.02);
    neph_image_destroy(one);
    neph_image_destroy(two);
    neph_scene_destroy(scene);
  }
}

/* Fire alone in the dark is seen, and lights ground, smoke and air. */
static void fire_alone_lights_a_scene(void **state) {
  const fixture *f = *state;
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_scene *scene = load(f, "", "refuse");
    assert_int_equal(neph_scene_set(scene, "sun.irradiance", "0"), NEPH_OK);
    neph_image *image = render(scene, i);
    static const char *const lit[] = {"terrain.R", "multiple.R", "emission.R", "air.R"};
    for (size_t c = 0; c < 4; c++) assert_true(compute_mean(image, lit[c]) > 0.0);
    assert_true(compute_mean(image, "sun.R") == 0.0);
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
}

/* Air that scatters 1e-5 of a fire's light a metre, by Rayleigh's phase function, over black ground; no sun. */
static const char thin_air[] =
    "{preset: earth, ground_albedo: 0, rayleigh_scattering: 1e-5 1/m, rayleigh_height: 1000 km, mie_scattering: 0, "
    "mie_extinction: 0, ozone_absorption: 0, tolerance: 0.1}";

/* Mean radiance of a view of the fire, or past it. */
static double view_fire(const fixture *f, const char *atmosphere, const char *position, const char *look_at,
                        const char *fov) {
  neph_scene *scene = load(f, "", "refuse");
  set(scene, "sun.elevation", "-40 deg");
  set(scene, "atmosphere", atmosphere);
  set(scene, "render.light_degree", "11");
  set(scene, "render.light_residual", "0.0003");
  set(scene, "camera.position", position);
  set(scene, "camera.look_at", look_at);
  set(scene, "camera.fov", fov);
  neph_image *image = render(scene, NEPH_INTEGRATOR_MARCH);
  const double mean = compute_mean(image, "R");
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  return mean;
}

/* A fire of intensity I, which is a point from 200 m and more, lights a ray that passes it at a distance b, from 600 m
 * before it on: with u the place along the ray in units of b, β·I/b·∫ p/(1 + u²) du, p = 3/16π·(1 + u²/(1 + u²)). 8 %:
 * the fire is 20 m high, and its light is kept at places some 50 m apart, and beyond 320 m by a power of the
 * distance. */
static void fire_lights_the_air_as_a_point_does(void **state) {
  static const double passing_m[] = {200.0, 600.0};
  static const char *const positions[] = {"[200 m, -600 m, 310 m]", "[600 m, -600 m, 310 m]"},
                           *const ahead[] = {"[200 m, 0 m, 310 m]", "[600 m, 0 m, 310 m]"};
  const fixture *f = *state;
  const double seen = view_fire(f, "none", "[0 m, -600 m, 310 m]", "[0 m, 0 m, 310 m]", "6 deg"),
               intensity = seen * pow(2.0 * 600.0 * tan(0.5 * 6.0 * NP_DEGREE), 2.0);
  for (int i = 0; i < 2; i++) {
    const double b = passing_m[i], step = 0.001, found = view_fire(f, thin_air, positions[i], ahead[i], "1 deg");
    double integral = 0.0;
    for (double u = -600.0 / b; u < 50.0; u += step) integral += step * (1.0 + u * u / (1.0 + u * u)) / (1.0 + u * u);
    const double expected = 1e-5 * intensity / b * 3.0 / (16.0 * NP_PI) * integral;
    print_message("past the fire at %g m: %.4g, expected %.4g\n", b, found, expected);
    assert_near_relative(found, expected, 0.08);
  }
}

/* Packets have the same light: of 6 wavelengths to 15 %, which is what six samples of so steep a spectrum leave. Both
 * pictures are of the same rays. */
static void fire_alone_is_the_same_light_in_packets(void **state) {
  const fixture *f = *state;
  double means[2];
  neph_scene *scene = load(f, "", "refuse");
  set(scene, "camera.resolution", "[8, 8]");
  set(scene, "sun.irradiance", "0");
  set(scene, "render.multiple_scattering", "none");
  set(scene, "output.color_space", "rec709");
  for (int n = 0; n < 2; n++) {
    set(scene, "render.wavelengths", n ? "30" : "6");
    neph_image *image = render(scene, NEPH_INTEGRATOR_MARCH);
    means[n] = compute_mean(image, "emission.G");
    neph_image_destroy(image);
  }
  print_message("6 wavelengths %.4g, 30 %.4g\n", means[0], means[1]);
  assert_near_relative(means[0], means[1], 0.15);
  neph_scene_destroy(scene);
}

/* In three bands a body has the colour that 60 wavelengths give it, in all that the smoke lets through, for that hides
 * all bands alike: 1 of ΔE, to which thin air and the smoke's own light of 60 wavelengths come. Both pictures are of
 * the same rays, so that no noise is in it: two rows through the flame are enough. */
static void fire_has_its_colour(void **state) {
  static const char *const temperatures[] = {"1200 K", "1500 K", "1900 K", "4000 K"};
  const fixture *f = *state;
  for (size_t t = 0; t < sizeof temperatures / sizeof *temperatures; t++) {
    char emission[64];
    double rgb[2][3];
    (void)snprintf(emission, sizeof emission, "temperature: none, offset: %s", temperatures[t]);
    for (int n = 0; n < 2; n++) {
      neph_scene *scene = load(f, emission, "refuse");
      set(scene, "render.samples", "1");
      assert_int_equal(neph_scene_set(scene, "sun.irradiance", "0"), NEPH_OK);
      assert_int_equal(neph_scene_set(scene, "render.multiple_scattering", "none"), NEPH_OK);
      assert_int_equal(neph_scene_set(scene, "output.color_space", "rec709"), NEPH_OK);
      assert_int_equal(neph_scene_set(scene, "render.wavelengths", n ? "60" : "3"), NEPH_OK);
      neph_image *image = render_tile(scene, NEPH_INTEGRATOR_MARCH, 10);
      for (int c = 0; c < 3; c++) {
        const char name[] = {'e', 'm', 'i', 's', 's', 'i', 'o', 'n', '.', "RGB"[c], '\0'};
        rgb[n][c] = compute_mean(image, name);
      }
      neph_image_destroy(image);
      neph_scene_destroy(scene);
    }
    color_difference d = {.count = 0};
    color_difference_add(&d, rgb[0], rgb[1]);
    print_message("%s: dE %.2f\n", temperatures[t], d.max);
    assert_true(d.count == 1 && d.max < 1.0);
  }
}

/* ---- What no fire can be ---- */

static void assert_refused(fixture *f, const char *emission, const char *message) {
  neph_scene *scene = load(f, emission, "refuse");
  neph_image *image = NULL;
  test_log_clear(&f->log);
  assert_int_not_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  assert_one_error(&f->log, message);
  assert_null(image);
  neph_scene_destroy(scene);
}

/* Said, and all finite, none negative. */
static void assert_repaired(fixture *f, const char *grid) {
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_scene *scene = load(f, "", "repair"); /* anew: a second picture of one scene reuses its volumes */
    assert_int_equal(neph_scene_set(scene, "atmosphere", "none"), NEPH_OK);
    assert_int_equal(neph_scene_set(scene, "render.samples", "4"), NEPH_OK);
    test_log_clear(&f->log);
    neph_image *image = render(scene, i);
    assert_non_null(strstr(f->log.text, grid));
    assert_non_null(strstr(f->log.text, "taken as "));
    for (unsigned c = 0; c < neph_image_get_channel_count(image); c++) {
      const char *name = neph_image_get_channel_name(image, c);
      const float *values = neph_image_get_channel(image, name);
      for (size_t p = 0; p < 400; p++) assert_true(values[p] >= 0.0f && (isfinite(values[p]) || *name == 'Z'));
    }
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
}

static void bad_values_are_refused_or_repaired(void **state) {
  fixture *f = *state;
  static const struct {
    float value;
    const char *name;
  } poisons[] = {{NAN, "NaN"}, {INFINITY, "infinite"}, {-INFINITY, "infinite"}, {-300.0f, "negative"}};
  for (int g = 0; g < 3; g++)
    for (size_t i = 0; i < sizeof poisons / sizeof *poisons; i++) {
      recipe all[] = {smoke, flame, heat};
      all[g].poison = poisons[i].value;
      write_grids(f->context, f->path, all, 3);
      assert_refused(f, "", poisons[i].name);
      assert_repaired(f, all[g].name);
    }
}

static void missing_grids_are_named(void **state) {
  fixture *f = *state;
  assert_refused(f, "temperature: heat", "no grid 'heat': found 'density' (float), 'flame' (float), 'temperature'");
  assert_refused(f, "temperature: heat", "; clouds[].emission.temperature names one");
  assert_refused(f, "flame: fire", "; clouds[].emission.flame names one");
  const recipe alone[] = {smoke};
  write_grids(f->context, f->path, alone, 1);
  assert_refused(f, "", "no grid 'temperature'");
}

/* 3e7 K of a file in thousandths of a kelvin, or a scale given twice. */
static void enormous_temperatures_are_refused(void **state) {
  fixture *f = *state;
  assert_refused(f, "kelvin: 1000 K", "must be at most 100000 K");
  recipe all[] = {smoke, flame, heat};
  all[2].poison = 3e38f;
  write_grids(f->context, f->path, all, 3);
  assert_refused(f, "", "must be at most 100000 K");
}

/* A file whose temperatures go from 0 to 1, taken for kelvin: dark, and said to be. */
static void cold_fire_is_warned_of(void **state) {
  fixture *f = *state;
  test_log_clear(&f->log);
  assert_true(measure(f, "kelvin: 0.001 K", NEPH_INTEGRATOR_MARCH, "emission.R") == 0.0);
  assert_non_null(strstr(f->log.text, "too cold to be seen to glow: emission.kelvin says what a value of 1 is"));
}

/* The first frame of a simulation has no fire yet, and the air's temperature where its grid ends. */
static void a_fire_that_has_not_begun_is_dark(void **state) {
  fixture *f = *state;
  const recipe nothing = {.name = "flame"}, air = {.name = "temperature", .background = 293.0f};
  const recipe all[] = {smoke, nothing, air};
  write_grids(f->context, f->path, all, 3);
  assert_true(measure(f, "", NEPH_INTEGRATOR_MARCH, "emission.R") == 0.0);
  assert_true(measure(f, "", NEPH_INTEGRATOR_PATH, "emission.R") == 0.0);
}

/* Hot smoke whose flames have gone out glows by what it absorbs, as without a grid of flames; and that is said. */
static void an_empty_flame_leaves_what_is_hot(void **state) {
  fixture *f = *state;
  const recipe nothing = {.name = "flame"}, hot = {"temperature", 1900.0f, {11.5, 11.5, 14.0}, 20.0, 0.0f, 0.0f};
  const recipe all[] = {smoke, nothing, hot};
  write_grids(f->context, f->path, all, 3);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    test_log_clear(&f->log);
    const double empty = measure(f, "", i, "emission.R"), none = measure(f, "flame: none", i, "emission.R");
    assert_true(empty > 0.0);
    assert_near_relative(empty, none, 1e-6); /* the same samples */
    assert_non_null(strstr(f->log.text, "fire.vdb: grid 'flame' is empty: it has no active voxels"));
  }
  /* One temperature everywhere says of no place that it is hot: then flames alone would be. */
  assert_true(measure(f, "temperature: none, offset: 1500 K", NEPH_INTEGRATOR_MARCH, "emission.R") == 0.0);
}

/* Fire before there is smoke: the flame glows all the same, where the smoke will put it once there is any. */
static void flames_need_no_smoke(void **state) {
  fixture *f = *state;
  const recipe nothing = {.name = "density"};
  const recipe all[] = {nothing, flame, heat};
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_scene *scene = load(f, "", "refuse");
    set(scene, "camera.position", "[0 m, -60 m, 14 m]"); /* the file's place is on the ground */
    set(scene, "camera.look_at", "[0 m, 0 m, 12 m]");
    assert_int_equal(neph_scene_set(scene, "clouds[0]", "{vdb: fire.vdb, extinction: 0, emission: {}}"), NEPH_OK);
    assert_int_equal(neph_scene_set(scene, "clouds[0].vdb", f->path), NEPH_OK);
    write_grids(f->context, f->path, (const recipe[]){smoke, flame, heat}, 3);
    neph_image *image = render(scene, i);
    const double clear = compute_mean(image, "emission.R");
    neph_image_destroy(image);
    write_grids(f->context, f->path, all, 3);
    image = render(scene, i);
    assert_near_relative(compute_mean(image, "emission.R"), clear,
                         0.02); /* the tracer's noise: others are its samples */
    assert_true(clear > 0.0);
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
}

/* `position` is that of the smoke's box, of which there is none. */
static void flames_without_a_place_are_left_out(void **state) {
  fixture *f = *state;
  const recipe nothing = {.name = "density"};
  const recipe all[] = {nothing, flame, heat};
  write_grids(f->context, f->path, all, 3);
  test_log_clear(&f->log);
  assert_true(measure(f, "", NEPH_INTEGRATOR_MARCH, "emission.R") == 0.0);
  assert_non_null(strstr(f->log.text, "cloud fire: its emission is left out of frame 1: position, voxel and "
                                      "optical_depth go by its density, which is empty"));
}

static void an_empty_temperature_is_warned_of(void **state) {
  fixture *f = *state;
  const recipe nothing = {.name = "temperature"};
  const recipe all[] = {smoke, flame, nothing};
  write_grids(f->context, f->path, all, 3);
  test_log_clear(&f->log);
  assert_true(measure(f, "offset: 1500 K", NEPH_INTEGRATOR_MARCH, "emission.R") > 0.0);
  assert_non_null(strstr(f->log.text, "fire.vdb: grid 'temperature' is empty"));
}

static void fire_in_a_bake_is_refused(void **state) {
  fixture *f = *state;
  neph_scene *scene = NULL;
  test_log_clear(&f->log);
  assert_int_equal(neph_scene_load_text(f->context, "clouds: [{bake: {}, emission: {}}]", "bake.yaml", &scene),
                   NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "clouds[0].emission goes with vdb alone");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(components_add_up_to_the_beauty, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(integrators_agree_on_emission, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(keys_mean_what_they_say, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(without_a_flame_the_cloud_emits_by_its_absorption, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_fire_is_a_group_of_lights, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(deep_pixels_hold_the_flame, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_second_light_does_not_light_the_fire_twice, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(fire_alone_lights_a_scene, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(fire_lights_the_air_as_a_point_does, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(fire_alone_is_the_same_light_in_packets, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(fire_has_its_colour, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(bad_values_are_refused_or_repaired, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(missing_grids_are_named, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(enormous_temperatures_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(cold_fire_is_warned_of, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_fire_that_has_not_begun_is_dark, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(an_empty_flame_leaves_what_is_hot, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(flames_need_no_smoke, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(flames_without_a_place_are_left_out, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(an_empty_temperature_is_warned_of, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(fire_in_a_bake_is_refused, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
