/* SPDX-License-Identifier: Apache-2.0 */
/* Textures of a scene, read back: containers, seams, and values against the library's own answers. */
#include <nephos/nephos.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "atmosphere/atmosphere_tables.h"
#include "core/alloc.h"
#include "core/half.h"
#include "core/json.h"
#include "core/random.h"
#include "export/distance_transform.h"
#include "export/texture_cloud.h"
#include "test_support.h"

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

static const char scene_text[] =
    "version: 1\n"
    "sun: {elevation: 20 deg, azimuth: 90 deg}\n"
    "clouds:\n"
    "  - {name: low, bake: {preset: cumulus_humilis, seed: 6, extent: 1 km, voxel: 40 m, coverage: 0.5}}\n";

static neph_scene *load(const test_fixture *f, const char *text) {
  neph_scene *scene = NULL;
  char *path = test_path(f->folder, "scene.yaml");
  assert_int_equal(neph_scene_load_text(f->context, text, path, &scene), NEPH_OK);
  free(path);
  return scene;
}

/* ---- Reading ---- */

/* A texture that was read: floats, channels interleaved, before their scale. */
typedef struct texels {
  unsigned size[3], channels;
  bool is_float;
  float *values;
} texels;

static uint64_t get_number(const uint8_t *at, unsigned bytes) {
  uint64_t value = 0;
  for (unsigned i = 0; i < bytes; i++) value |= (uint64_t)at[i] << 8 * i;
  return value;
}

/* Reads texels of `bytes`, of which there must be just as many as the size says. */
static void decode(const uint8_t *bytes, uint64_t count, unsigned channel_bytes, texels *out) {
  const size_t values = (size_t)out->size[0] * out->size[1] * out->size[2] * out->channels;
  assert_int_equal(count, values * channel_bytes);
  out->values = malloc(values * sizeof *out->values);
  assert_non_null(out->values);
  for (size_t i = 0; i < values; i++)
    out->values[i] =
        out->is_float ? np_half_to_float((uint16_t)get_number(bytes + 2 * i, 2)) : (float)bytes[i] / 255.0f;
}

/* Reads a KTX 2.0 file by its specification, checking every field of its header. */
static texels read_ktx2(const test_fixture *f, const char *name) {
  static const uint8_t identifier[12] = {0xab, 0x4b, 0x54, 0x58, 0x20, 0x32, 0x30, 0xbb, 0x0d, 0x0a, 0x1a, 0x0a};
  static const unsigned formats[][4] = {{9, 1, 1, 0}, {37, 4, 1, 0}, {76, 1, 2, 1}, {83, 2, 2, 1}, {97, 4, 2, 1}};
  char *path = test_path(f->folder, name);
  const test_file file = test_file_read(path);
  const uint8_t *b = file.bytes;
  texels out = {.channels = 0};
  unsigned bytes = 0;
  free(path);
  assert_true(file.size > 104);
  assert_memory_equal(b, identifier, 12);
  for (size_t i = 0; i < 5; i++)
    if (formats[i][0] == get_number(b + 12, 4))
      out.channels = formats[i][1], bytes = formats[i][2], out.is_float = formats[i][3];
  assert_int_not_equal(out.channels, 0);
  assert_int_equal(get_number(b + 16, 4), bytes);
  for (int a = 0; a < 3; a++) out.size[a] = (unsigned)get_number(b + 20 + 4 * a, 4);
  if (!out.size[2]) out.size[2] = 1;
  const uint64_t rest[] = {0, 1, 1, 0}; /* layers, faces, levels, supercompression */
  for (int i = 0; i < 4; i++) assert_int_equal(get_number(b + 32 + 4 * i, 4), rest[i]);
  /* The descriptor: one basic block with a sample for each channel. */
  const uint64_t dfd = get_number(b + 48, 4), dfd_bytes = get_number(b + 52, 4);
  assert_int_equal(dfd, 104);
  assert_int_equal(dfd_bytes, 4 + 24 + 16 * out.channels);
  assert_int_equal(get_number(b + dfd, 4), dfd_bytes);
  assert_int_equal(get_number(b + dfd + 4, 4), 0);
  assert_int_equal(get_number(b + dfd + 8, 2), 2);
  assert_int_equal(get_number(b + dfd + 10, 2), dfd_bytes - 4);
  assert_int_equal(b[dfd + 20], out.channels * bytes);
  for (unsigned c = 0; c < out.channels; c++) {
    const uint8_t *sample = b + dfd + 28 + 16 * c;
    assert_int_equal(get_number(sample, 2), 8 * bytes * c);
    assert_int_equal(sample[2], 8 * bytes - 1);
    assert_int_equal(sample[3], (c == 3 ? 15 : c) | (out.is_float ? 0xc0 : 0));
  }
  const uint64_t kvd = get_number(b + 56, 4);
  assert_int_equal(kvd, dfd + dfd_bytes);
  assert_memory_equal(b + kvd + 4, "KTXwriter\0nephos", 17);
  assert_int_equal(get_number(b + 64, 8), 0);
  assert_int_equal(get_number(b + 72, 8), 0);
  const uint64_t texel = get_number(b + 80, 8), count = get_number(b + 88, 8);
  const unsigned edge = out.channels * bytes > 4 ? out.channels * bytes : 4; /* the least common multiple with 4 */
  assert_int_equal(texel, (kvd + get_number(b + 60, 4) + edge - 1) / edge * edge);
  assert_int_equal(count, get_number(b + 96, 8));
  assert_int_equal(texel + count, file.size);
  decode(b + texel, count, bytes, &out);
  free(file.bytes);
  return out;
}

static float get(const texels *t, unsigned x, unsigned y, unsigned z, unsigned channel) {
  return t->values[(((size_t)z * t->size[1] + y) * t->size[0] + x) * t->channels + channel];
}

/* Entry of a texture in the JSON file; `*out_json` is destroyed by the caller. */
static const np_json_value *read_entry(const test_fixture *f, const char *name, np_json_value **out_json) {
  char *path = test_path(f->folder, "textures.json");
  test_file file = test_file_read(path);
  free(path);
  file.bytes = realloc(file.bytes, file.size + 1);
  file.bytes[file.size] = '\0';
  *out_json = np_json_read((const char *)file.bytes);
  free(file.bytes);
  assert_non_null(*out_json);
  for (size_t i = 0;; i++) {
    const np_json_value *entry = np_json_get_element(*out_json, "textures", i);
    assert_non_null(entry);
    if (!strcmp(np_json_get_text(entry, "name"), name)) return entry;
  }
}

static void read_reals(const test_fixture *f, const char *name, const char *key, size_t count, double *out) {
  np_json_value *json;
  const np_json_value *entry = read_entry(f, name, &json);
  assert_true(np_json_get_reals(entry, key, out, count));
  np_json_value_destroy(json);
}

/* Quantity over value of a channel: of its greatest. */
static double read_scale(const test_fixture *f, const char *name, const texels *t, unsigned channel) {
  np_json_value *json;
  const np_json_value *entry = read_entry(f, name, &json);
  double range[2];
  float greatest = 0.0f;
  assert_true(np_json_get_reals(np_json_get_element(entry, "channels", channel), "range", range, 2));
  for (size_t i = 0; i < (size_t)t->size[0] * t->size[1] * t->size[2]; i++)
    greatest = fmaxf(greatest, t->values[i * t->channels + channel]);
  np_json_value_destroy(json);
  return range[1] / (double)greatest;
}

static void export_scene(const test_fixture *f, const char *text, unsigned size) {
  neph_textures_desc desc = NEPH_TEXTURES_DESC_DEFAULT;
  neph_scene *scene = load(f, text);
  desc.size = size;
  assert_int_equal(neph_scene_export_textures(scene, 1, &desc, f->folder), NEPH_OK);
  neph_scene_destroy(scene);
}

/* ---- Noise ---- */

/* Greatest difference of neighbours along an axis, inside and across the seam. */
static void measure_seam(const texels *t, int axis, unsigned channel, float *out_inside, float *out_seam) {
  *out_inside = *out_seam = 0.0f;
  for (unsigned z = 0; z < t->size[2]; z++)
    for (unsigned y = 0; y < t->size[1]; y++)
      for (unsigned x = 0; x < t->size[0]; x++) {
        unsigned at[3] = {x, y, z};
        const bool is_seam = ++at[axis] == t->size[axis];
        if (is_seam) at[axis] = 0;
        float *most = is_seam ? out_seam : out_inside;
        *most = fmaxf(*most, fabsf(get(t, x, y, z, channel) - get(t, at[0], at[1], at[2], channel)));
      }
}

static void noises_repeat_and_are_the_librarys(void **state) {
  static const char *const names[] = {"noise_base.ktx2", "noise_detail.ktx2", "noise_curl.ktx2"};
  test_fixture *f = *state;
  export_scene(f, "version: 1\natmosphere: none\n", 16);
  for (size_t i = 0; i < 3; i++) {
    texels t = read_ktx2(f, names[i]);
    for (unsigned c = 0; c < (i < 2 ? 4u : 3u); c++)
      for (int axis = 0; axis < 3; axis++) {
        float inside, seam;
        measure_seam(&t, axis, c, &inside, &seam);
        assert_true(seam <= inside * 1.05f);
      }
    free(t.values);
  }
  for (int kind = 0; kind < 2; kind++) {
    neph_noise_texture *noise;
    texels t = read_ktx2(f, names[kind]);
    assert_int_equal(neph_noise_texture_create(f->context, (neph_noise_texture_kind)kind, 0, &noise), NEPH_OK);
    assert_int_equal(neph_noise_texture_get_size(noise), t.size[0]);
    const size_t count = (size_t)t.size[0] * t.size[1] * t.size[2];
    for (size_t n = 0; n < count; n++)
      assert_near((double)t.values[4 * n + (kind ? 3 : 0)], (double)neph_noise_texture_get_values(noise)[n],
                  0.5 / 255 + 1e-6);
    neph_noise_texture_destroy(noise);
    free(t.values);
  }
}

/* Blue noise has hardly any power at low frequencies: here at |k| ≤ 6 of 32. */
static void blue_noise_is_blue(void **state) {
  enum { EDGE = 64, LOW = 6 };
  test_fixture *f = *state;
  export_scene(f, "version: 1\natmosphere: none\n", 16);
  texels t = read_ktx2(f, "blue_noise.ktx2");
  unsigned histogram[256] = {0};
  double low = 0.0, all = 0.0;
  unsigned count = 0;
  assert_int_equal(t.size[0], EDGE);
  for (size_t i = 0; i < (size_t)EDGE * EDGE; i++) {
    histogram[(int)(t.values[i] * 255.0f + 0.5f)]++;
    all += pow((double)t.values[i] - 0.5, 2);
  }
  for (int i = 0; i < 256; i++) assert_int_equal(histogram[i], EDGE * EDGE / 256);
  for (int ky = -LOW; ky <= LOW; ky++)
    for (int kx = -LOW; kx <= LOW; kx++) {
      double re = 0.0, im = 0.0;
      if ((!kx && !ky) || kx * kx + ky * ky > LOW * LOW) continue;
      for (int y = 0; y < EDGE; y++)
        for (int x = 0; x < EDGE; x++) {
          const double angle = 2.0 * NP_PI * (kx * x + ky * y) / EDGE, v = (double)t.values[y * EDGE + x] - 0.5;
          re += v * cos(angle);
          im += v * sin(angle);
        }
      low += (re * re + im * im) / (EDGE * EDGE);
      count++;
    }
  /* White noise would have its share in each frequency. */
  assert_true(low / count < 0.02 * all / (EDGE * EDGE));
  free(t.values);
}

/* ---- Sky ---- */

static void skies_are_the_librarys(void **state) {
  test_fixture *f = *state;
  neph_atmosphere *air;
  neph_sky *sky;
  export_scene(f,
               "version: 1\nsun: {elevation: 20 deg, azimuth: 90 deg}\n"
               "camera: {position: [0 m, 0 m, 100 m], look_at: [0 m, 1000 m, 100 m]}\n",
               16);
  double irradiance[3], observer[3], sun[3], horizon, radius, top;
  read_reals(f, "sky_view", "sun_irradiance_w_m2_nm", 3, irradiance);
  read_reals(f, "sky_view", "observer_m", 3, observer);
  read_reals(f, "sky_view", "sun_direction", 3, sun);
  assert_near(sun[2], sin(20.0 * NP_PI / 180.0), 1e-6);
  neph_atmosphere_desc air_desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
  assert_int_equal(neph_atmosphere_create(f->context, &air_desc, &air), NEPH_OK);
  neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
  memcpy(desc.sun_direction, sun, sizeof sun);
  memcpy(desc.sun_irradiance_w_m2_nm, irradiance, sizeof irradiance);
  memcpy(desc.observer_m, observer, sizeof observer);
  assert_int_equal(neph_sky_create(air, &desc, &sky), NEPH_OK);
  radius = air_desc.planet_radius_m, top = radius + air_desc.top_altitude_m;

  /* Transmittance by Bruneton's map, on the vertical above the origin. */
  texels t = read_ktx2(f, "sky_transmittance.ktx2");
  const double whole = sqrt(top * top - radius * radius);
  for (unsigned y = 0; y < t.size[1]; y += 7)
    for (unsigned x = 0; x < t.size[0]; x += 17) {
      const double rho = whole * y / (t.size[1] - 1), r = sqrt(rho * rho + radius * radius);
      const double d = top - r + x * (rho + whole - (top - r)) / (t.size[0] - 1);
      const double cosine = fmin(d > 0 ? (whole * whole - rho * rho - d * d) / (2 * r * d) : 1.0, 1.0);
      double expected[3];
      if (cosine < -sqrt(fmax(1 - radius * radius / (r * r), 0)) + 1e-4) continue; /* grazes the ground */
      neph_atmosphere_get_transmittance(air, (const double[3]){0, 0, r - radius},
                                        (const double[3]){sqrt(1 - cosine * cosine), 0, cosine}, expected);
      for (unsigned b = 0; b < 3; b++) assert_near((double)get(&t, x, y, 0, b), expected[b], 0.002);
    }
  free(t.values);

  /* Multiple scattering by Hillaire's map: a 4π-th of all light that arrives. */
  t = read_ktx2(f, "sky_multiple_scattering.ktx2");
  for (unsigned b = 0; b < 3; b++) {
    const double scale = read_scale(f, "sky_multiple_scattering", &t, b);
    for (unsigned y = 0; y < t.size[1]; y += 3)
      for (unsigned x = 0; x < t.size[0]; x += 2) {
        const double altitude_m = (top - radius) * y / (t.size[1] - 1), sun_cosine = 2.0 * x / (t.size[0] - 1) - 1.0;
        const np_bands all = np_moment_table_total(&air->moments, altitude_m, (float)sun_cosine);
        assert_near(scale * (double)get(&t, x, y, 0, b), (double)all[b] / (4.0 * NP_PI), 1e-3 * scale);
      }
  }
  free(t.values);

  /* The sky by Hillaire's map. */
  t = read_ktx2(f, "sky_view.ktx2");
  const double toward = hypot(sun[0], sun[1]);
  double error = 0.0, sum = 0.0, scales[3];
  for (unsigned b = 0; b < 3; b++) scales[b] = read_scale(f, "sky_view", &t, b);
  horizon = NP_PI - asin(radius / (radius + fmax(observer[2], 0.0)));
  for (unsigned y = 0; y < t.size[1]; y += 5)
    for (unsigned x = 0; x < t.size[0]; x += 15) {
      const double u = (double)x / (t.size[0] - 1), v = (double)y / (t.size[1] - 1);
      const double zenith =
          v < 0.5 ? horizon * (1 - pow(1 - 2 * v, 2)) : horizon + (NP_PI - horizon) * pow(2 * v - 1, 2);
      const double c = 1 - 2 * u * u, s = sqrt(fmax(1 - c * c, 0)), sine = sin(zenith);
      const double direction[3] = {sine * (c * sun[0] - s * sun[1]) / toward, sine * (c * sun[1] + s * sun[0]) / toward,
                                   cos(zenith)};
      double expected[3];
      neph_sky_get_radiance(sky, direction, expected);
      for (unsigned b = 0; b < 3; b++) {
        error += pow((double)get(&t, x, y, 0, b) * scales[b] - expected[b], 2);
        sum += expected[b] * expected[b];
      }
    }
  assert_true(sqrt(error / sum) < 0.005);
  free(t.values);
  neph_sky_destroy(sky);
  neph_atmosphere_release(air);
}

/* ---- Weather map ---- */

static void weather_map_is_the_models(void **state) {
  enum { COLUMNS = 96, HEIGHTS = 40 };
  test_fixture *f = *state;
  export_scene(f, scene_text, 32);
  texels t = read_ktx2(f, "low.weather.ktx2");
  double origin[3], covered = 0.0, mean = 0.0, base_error = 0.0, top_error = 0.0, compared = 0.0;
  neph_scene *scene = load(f, scene_text);
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(f->context, "cumulus_humilis", &desc), NEPH_OK);
  desc.seed = 6;
  desc.extent_m[0] = desc.extent_m[1] = 1000.0;
  desc.voxel_m = 40.0;
  desc.coverage = 0.5;
  read_reals(f, "low.weather", "origin_m", 3, origin);
  assert_near(origin[0], -500.0, 1e-9);
  assert_near(origin[2], desc.base_altitude_m, 1e-9);
  double *positions = malloc(sizeof(double) * COLUMNS * COLUMNS * HEIGHTS * 3);
  float *extinction = malloc(sizeof(float) * COLUMNS * COLUMNS * HEIGHTS);
  size_t n = 0;
  for (int y = 0; y < COLUMNS; y++)
    for (int x = 0; x < COLUMNS; x++)
      for (int h = 0; h < HEIGHTS; h++, n++) {
        positions[3 * n] = origin[0] + (x + 0.5) / COLUMNS * 1000.0;
        positions[3 * n + 1] = origin[1] + (y + 0.5) / COLUMNS * 1000.0;
        positions[3 * n + 2] = origin[2] + (h + 0.5) / HEIGHTS * desc.thickness_m;
      }
  assert_int_equal(neph_cloud_eval(f->context, &desc, 6360000.0, n, positions, extinction), NEPH_OK);
  for (size_t c = 0; c < (size_t)COLUMNS * COLUMNS; c++) {
    int low = -1, high = -1;
    for (int h = 0; h < HEIGHTS; h++)
      if (extinction[c * HEIGHTS + h] > 0.0f) high = h, low = low < 0 ? h : low;
    covered += (low >= 0) / (double)(COLUMNS * COLUMNS);
    const unsigned x = (unsigned)((2 * (c % COLUMNS) + 1) * t.size[0] / (2 * COLUMNS));
    const unsigned y = (unsigned)((2 * (c / COLUMNS) + 1) * t.size[1] / (2 * COLUMNS));
    const double base = (double)get(&t, x, y, 0, 2), top = base + (double)get(&t, x, y, 0, 3);
    /* Inside a cloud, columns beside each other hardly differ. */
    if (low < 0 || get(&t, x, y, 0, 0) < 1.0f) continue;
    base_error += fabs(base - low / (double)HEIGHTS);
    top_error += fabs(top - (high + 1) / (double)HEIGHTS);
    compared++;
  }
  for (size_t i = 0; i < (size_t)t.size[0] * t.size[1]; i++) {
    mean += (double)t.values[4 * i] / (t.size[0] * t.size[1]);
    assert_near((double)t.values[4 * i + 1], desc.type, 1e-3);
    assert_true(!(t.values[4 * i] > 0.0f) || t.values[4 * i + 3] > 0.0f);
  }
  assert_near(mean, desc.coverage, 0.01);
  assert_near(mean, covered, 0.02);
  assert_true(compared > 1000);
  /* A bake's values are means over the height of a voxel, whose half is 0.05 of the thickness here. */
  assert_true(base_error / compared < 0.05);
  assert_true(top_error / compared < 0.08);
  free(positions);
  free(extinction);
  free(t.values);
  neph_scene_destroy(scene);
}

/* ---- Distances ---- */

/* Random samples on a lattice of unequal edges, against every pair. */
static void distances_are_exact(void **state) {
  enum { X = 19, Y = 7, Z = 23, COUNT = X * Y * Z };
  static const unsigned size[3] = {X, Y, Z};
  static const double edge_m[3] = {2.0, 3.0, 0.5};
  test_fixture *f = *state;
  static float values[COUNT];
  static bool inside[COUNT];
  np_random random = np_random_start(7, 0, 0, 0, 0);
  for (int i = 0; i < COUNT; i++) inside[i] = np_random_bits(&random) % 37 == 0;
  for (int i = 0; i < COUNT; i++) values[i] = inside[i] ? -NP_DISTANCE_NONE : NP_DISTANCE_NONE;
  assert_int_equal(np_distance_transform(f->context, NULL, size, edge_m, values), NEPH_OK);
  for (int i = 0; i < COUNT; i++) {
    double least = INFINITY;
    for (int j = 0; j < COUNT; j++) {
      const double d[3] = {edge_m[0] * (i % X - j % X), edge_m[1] * (i / X % Y - j / X % Y),
                           edge_m[2] * (i / (X * Y) - j / (X * Y))};
      if (inside[i] != inside[j]) least = fmin(least, d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    }
    assert_near_relative((double)values[i], inside[i] ? -least : least, 1e-5);
  }
}

/* A lattice of a test, and the set that writes its textures. */
typedef struct lattice_case {
  neph_textures_desc desc;
  np_monitor monitor;
  np_texture_set set;
  np_scene_cloud cloud;
  np_texture_cloud textures;
} lattice_case;

static void start_lattice(const test_fixture *f, unsigned edge, double edge_m, lattice_case *c) {
  static char name[] = "test";
  *c = (lattice_case){.desc = NEPH_TEXTURES_DESC_DEFAULT};
  np_monitor_start(&c->monitor, f->context, NULL, NULL);
  c->set = (np_texture_set){.context = f->context, .folder = f->folder, .desc = &c->desc, .monitor = &c->monitor};
  c->cloud.name = name;
  c->textures = (np_texture_cloud){.set = &c->set, .cloud = &c->cloud, .extinction_factor = 1.0};
  c->textures.in_frame.desc = (neph_cloud_desc)NEPH_CLOUD_DESC_DEFAULT;
  np_texture_lattice *lattice = &c->textures.lattice;
  lattice->to_world = np_affine_identity();
  for (int a = 0; a < 3; a++) {
    lattice->size[a] = edge;
    lattice->edge_m[a] = edge_m;
  }
  lattice->extinction = np_alloc(f->context, (size_t)edge * edge * edge, sizeof *lattice->extinction);
  assert_non_null(lattice->extinction);
  assert_int_equal(np_texture_set_begin(&c->set), NEPH_OK);
  np_json_begin_array(c->set.json, "textures");
}

static void end_lattice(const test_fixture *f, lattice_case *c) {
  assert_int_equal(np_texture_depth_add(&c->textures), NEPH_OK);
  assert_int_equal(np_texture_distance_add(&c->textures), NEPH_OK);
  np_json_end(c->set.json);
  assert_int_equal(np_texture_set_commit(&c->set), NEPH_OK);
  np_texture_set_end(&c->set);
  np_alloc_free(f->context, c->textures.lattice.extinction);
}

static void distance_to_a_ball(void **state) {
  enum { EDGE = 64 };
  const double edge_m = 5.0, radius_m = 100.0, center = (EDGE - 1) / 2.0;
  test_fixture *f = *state;
  lattice_case c;
  double worst = 0.0, slope = 0.0, count = 0.0;
  start_lattice(f, EDGE, edge_m, &c);
  for (unsigned i = 0; i < EDGE * EDGE * EDGE; i++) {
    const double d[3] = {i % EDGE - center, i / EDGE % EDGE - center, i / (EDGE * EDGE) - center};
    const bool is_inside = edge_m * sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) < radius_m;
    c.textures.lattice.extinction[i] = is_inside ? 0.5f : 0.0f;
  }
  c.textures.lattice.greatest = 0.5f;
  end_lattice(f, &c);
  texels t = read_ktx2(f, "test.distance.ktx2");
  for (unsigned z = 1; z < EDGE - 1; z++)
    for (unsigned y = 1; y < EDGE - 1; y++)
      for (unsigned x = 1; x < EDGE - 1; x++) {
        const double d[3] = {x - center, y - center, z - center};
        const double away_m = edge_m * sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - radius_m;
        const double value = (double)get(&t, x, y, z, 0);
        worst = fmax(worst, fabs(value - away_m));
        if (fabs(away_m) < 2 * edge_m || away_m < -0.8 * radius_m) continue;
        const double g[3] = {(double)(get(&t, x + 1, y, z, 0) - get(&t, x - 1, y, z, 0)),
                             (double)(get(&t, x, y + 1, z, 0) - get(&t, x, y - 1, z, 0)),
                             (double)(get(&t, x, y, z + 1, 0) - get(&t, x, y, z - 1, 0))};
        slope += fabs(sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]) / (2 * edge_m) - 1.0);
        count++;
      }
  assert_true(worst < 0.75 * edge_m); /* the ball's own voxels are off by up to half of a diagonal */
  assert_true(slope / count < 0.03);
  free(t.values);
}

/* A box of uniform extinction: optical depths are lengths times it. */
static void depths_of_a_box(void **state) {
  enum { EDGE = 16, LOW = 3, HIGH = 11 };
  test_fixture *f = *state;
  lattice_case c;
  start_lattice(f, EDGE, 10.0, &c);
  for (unsigned i = 0; i < EDGE * EDGE * EDGE; i++) {
    const unsigned at[3] = {i % EDGE, i / EDGE % EDGE, i / (EDGE * EDGE)};
    bool is_inside = true;
    for (int a = 0; a < 3; a++) is_inside = is_inside && at[a] >= LOW && at[a] <= HIGH;
    c.textures.lattice.extinction[i] = is_inside ? 0.03125f : 0.0f;
  }
  c.textures.lattice.greatest = 0.03125f;
  end_lattice(f, &c);
  texels xy = read_ktx2(f, "test.depth_xy.ktx2"), z = read_ktx2(f, "test.depth_z.ktx2");
  for (unsigned i = 0; i < EDGE; i++) {
    const double up = 10.0 * 0.03125 * (HIGH + 0.5 - fmax(fmin(i, HIGH + 0.5), LOW - 0.5));
    const double down = 10.0 * 0.03125 * (HIGH - LOW + 1) - up;
    assert_near((double)get(&xy, i, 7, 7, 0), up, 2e-3);
    assert_near((double)get(&xy, i, 7, 7, 1), down, 2e-3);
    assert_near((double)get(&xy, 7, i, 7, 2), up, 2e-3);
    assert_near((double)get(&xy, 7, i, 7, 3), down, 2e-3);
    assert_near((double)get(&z, 7, 7, i, 0), up, 2e-3);
    assert_near((double)get(&z, 7, 7, i, 1), down, 2e-3);
    assert_near((double)get(&xy, i, 1, 7, 0), 0.0, 0.0);
  }
  free(xy.values);
  free(z.values);
}

/* Optical depths of a cloud, against a march through the volume that the library bakes. */
static void depths_are_those_of_the_bake(void **state) {
  test_fixture *f = *state;
  double origin[3], error = 0.0, sum = 0.0;
  neph_volume *volume = NULL;
  char *path = test_path(f->folder, "low.vdb");
  export_scene(f, scene_text, 48);
  texels z = read_ktx2(f, "low.depth_z.ktx2");
  read_reals(f, "low.depth_z", "origin_m", 3, origin);
  const double voxel_m = 1000.0 / (48 - 3); /* parts of the field's longest edge */
  const double top_m = origin[2] + z.size[2] * voxel_m;
  neph_scene *scene = load(f, scene_text);
  char voxel[64];
  (void)snprintf(voxel, sizeof voxel, "%.12g m", voxel_m);
  assert_int_equal(neph_scene_set(scene, "clouds[0].bake.voxel", voxel), NEPH_OK);
  assert_int_equal(neph_scene_bake_file(scene, 0, 1, NULL, path), NEPH_OK);
  neph_volume_load_desc load_desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  load_desc.precision = NEPH_PRECISION_FLOAT;
  assert_int_equal(neph_volume_load(f->context, path, &load_desc, &volume), NEPH_OK);
  for (unsigned y = 0; y < z.size[1]; y += 3)
    for (unsigned x = 0; x < z.size[0]; x += 3)
      for (unsigned k = 0; k < z.size[2]; k += 2) {
        enum { STEPS = 400 };
        static double positions[3 * STEPS];
        float values[STEPS];
        const double bottom_m = origin[2] + (k + 0.5) * voxel_m, step_m = (top_m - bottom_m) / STEPS;
        double depth = 0.0;
        for (int i = 0; i < STEPS; i++) {
          positions[3 * i] = origin[0] + (x + 0.5) * voxel_m;
          positions[3 * i + 1] = origin[1] + (y + 0.5) * voxel_m;
          positions[3 * i + 2] = bottom_m + (i + 0.5) * step_m;
        }
        neph_volume_sample(volume, STEPS, positions, values);
        for (int i = 0; i < STEPS; i++) depth += (double)values[i] * step_m;
        error += pow((double)get(&z, x, y, k, 0) - depth, 2);
        sum += depth * depth;
      }
  assert_true(sum > 0.0);
  assert_true(sqrt(error / sum) < 0.02);
  neph_volume_release(volume);
  neph_scene_destroy(scene);
  free(z.values);
  free(path);
}

/* A weather map of a field that repeats has no seam. */
static void repeating_fields_repeat(void **state) {
  test_fixture *f = *state;
  export_scene(
      f,
      "version: 1\natmosphere: none\n"
      "clouds: [{name: low, bake: {preset: cumulus_humilis, seed: 1, extent: 2 km, voxel: 50 m, repeat: 20 km, "
      "coverage: 0.6}}]\n",
      32);
  texels t = read_ktx2(f, "low.weather.ktx2");
  for (int axis = 0; axis < 2; axis++) {
    double sums[2] = {0.0, 0.0}, counts[2] = {0.0, 0.0};
    for (unsigned y = 0; y < t.size[1]; y++)
      for (unsigned x = 0; x < t.size[0]; x++) {
        unsigned at[2] = {x, y};
        const bool is_seam = ++at[axis] == t.size[axis];
        if (is_seam) at[axis] = 0;
        sums[is_seam] += (double)fabsf(get(&t, x, y, 0, 0) - get(&t, at[0], at[1], 0, 0));
        counts[is_seam]++;
      }
    assert_true(sums[0] > 0.0);
    assert_true(sums[1] / counts[1] < 2.0 * sums[0] / counts[0]);
  }
  free(t.values);

  /* A field that no bake accepts has no textures. */
  neph_scene *scene = load(f, "version: 1\natmosphere: none\n"
                              "clouds: [{name: low, bake: {preset: nimbostratus, repeat: 20 km}}]\n");
  test_log_clear(&f->log);
  assert_int_equal(neph_scene_export_textures(scene, 1, NULL, f->folder), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "repeat is 20000 m, so that precipitation must be 0");
  neph_scene_destroy(scene);
}

/* Keys that move and scale a cloud move and scale its textures: heights, edges and billows of a cloud twice as large.
 */
static void textures_are_in_the_clouds_place(void **state) {
  test_fixture *f = *state;
  double origins[2][3], heights[2], ranges[2][2], depths[2][2];
  for (int i = 0; i < 2; i++) {
    char text[600];
    (void)snprintf(text, sizeof text,
                   "version: 1\natmosphere: none\n"
                   "clouds: [{name: low, pivot: origin, scale: %d, rotation: 90 deg, position: [%d m, 0 m, 0 m], "
                   "bake: {preset: cumulus_humilis, seed: 6, extent: 1 km, voxel: 50 m, coverage: 0.5}}]\n",
                   i + 1, 5000 * i);
    export_scene(f, text, 24);
    np_json_value *json;
    const np_json_value *entry = read_entry(f, "low.weather", &json);
    assert_true(np_json_get_reals(np_json_get_element(entry, "channels", 3), "range", ranges[i], 2));
    np_json_value_destroy(json);
    entry = read_entry(f, "low.depth_z", &json);
    assert_true(np_json_get_reals(np_json_get_element(entry, "channels", 0), "range", depths[i], 2));
    np_json_value_destroy(json);
    read_reals(f, "low.weather", "origin_m", 3, origins[i]);
    heights[i] = ranges[i][1];
  }
  /* A quarter turn puts the field's corner (−500, −500) at (500, −500). */
  assert_near(origins[0][0], 500.0, 1e-6);
  assert_near(origins[0][1], -500.0, 1e-6);
  assert_near(origins[1][0], 6000.0, 1e-6);
  assert_near(origins[1][2], 2.0 * origins[0][2], 1e-6);
  assert_near_relative(heights[1], 2.0 * heights[0], 1e-6);
  assert_near_relative(depths[1][1], 2.0 * depths[0][1], 1e-3);
}

/* ---- All or none ---- */

static bool cancel(void *user, const neph_progress *progress) { return !strstr(progress->stage, (const char *)user); }

static void nothing_stays_of_a_failure(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, scene_text);
  static char stages[][32] = {"noise textures", "building the sky", "distance textures", "profile"};
  neph_textures_desc desc = NEPH_TEXTURES_DESC_DEFAULT;
  desc.progress = cancel;
  for (size_t i = 0; i < sizeof stages / sizeof *stages; i++) {
    desc.progress_user = stages[i];
    assert_int_equal(neph_scene_export_textures(scene, 1, &desc, f->folder), NEPH_ERROR_CANCELLED);
    assert_int_equal(test_folder_count(f->folder), 0);
  }
  test_log_clear(&f->log);
  desc.progress = NULL;
  desc.size = 15;
  assert_int_equal(neph_scene_export_textures(scene, 1, &desc, f->folder), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "size is 15, must be in [16, 1024]");
  desc.size = 16;
  desc.format = (neph_texture_format)9;
  assert_int_equal(neph_scene_export_textures(scene, 1, &desc, f->folder), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "format is 9, must be KTX2 (0) or raw (1)");
  desc.format = NEPH_TEXTURE_RAW;
  assert_int_equal(neph_scene_export_textures(scene, 1, &desc, "missing"), NEPH_ERROR_IO);
  assert_one_error(&f->log, "missing/noise_base.raw: cannot be written");
  assert_int_equal(test_folder_count(f->folder), 0);
  neph_scene_destroy(scene);
}

static void any_number_of_threads_gives_the_same_bits(void **state) {
  static const char *const names[] = {"low.weather.raw",  "low.profile.raw", "low.distance.raw",
                                      "low.depth_xy.raw", "noise_base.raw",  "sky_view.raw"};
  test_fixture *f = *state;
  test_file files[2][6];
  for (unsigned i = 0; i < 2; i++) {
    neph_context *context = test_context_create(i ? 5 : 1, NULL);
    neph_scene *scene = NULL;
    neph_textures_desc desc = NEPH_TEXTURES_DESC_DEFAULT;
    desc.format = NEPH_TEXTURE_RAW;
    desc.size = 32;
    assert_int_equal(neph_scene_load_text(context, scene_text, "scene.yaml", &scene), NEPH_OK);
    assert_int_equal(neph_scene_export_textures(scene, 1, &desc, f->folder), NEPH_OK);
    for (int n = 0; n < 6; n++) {
      char *path = test_path(f->folder, names[n]);
      files[i][n] = test_file_read(path);
      free(path);
    }
    neph_scene_destroy(scene);
    neph_context_destroy(context);
  }
  for (int n = 0; n < 6; n++) {
    assert_int_equal(files[0][n].size, files[1][n].size);
    assert_memory_equal(files[0][n].bytes, files[1][n].bytes, files[0][n].size);
    free(files[0][n].bytes);
    free(files[1][n].bytes);
  }
}

/* The place of a cloud goes by its own bake, whatever the voxels of its textures: a weather map has one place. */
static void places_do_not_go_by_the_size(void **state) {
  test_fixture *f = *state;
  double first[3], second[3];
  static const char text[] = "version: 1\nclouds: [{name: low, position: [700 m, -300 m, 0 m], bake: {preset: "
                             "cumulus_mediocris, seed: 91, extent: [2 km, 1300 m], voxel: 40 m, coverage: 0.4}}]\n";
  export_scene(f, text, 16);
  read_reals(f, "low.weather", "origin_m", 3, first);
  export_scene(f, text, 64);
  read_reals(f, "low.weather", "origin_m", 3, second);
  for (int a = 0; a < 3; a++) assert_near(first[a], second[a], 1e-6);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(noises_repeat_and_are_the_librarys, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(blue_noise_is_blue, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(skies_are_the_librarys, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(weather_map_is_the_models, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(distances_are_exact, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(distance_to_a_ball, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(depths_of_a_box, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(depths_are_those_of_the_bake, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(repeating_fields_repeat, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(textures_are_in_the_clouds_place, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(places_do_not_go_by_the_size, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(nothing_stays_of_a_failure, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(any_number_of_threads_gives_the_same_bits, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
