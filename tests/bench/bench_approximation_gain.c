/* SPDX-License-Identifier: Apache-2.0 */
/* Calibrates the gain of the approximations of multiple scattering: prints src/integrate/approximation_gain_table.c.
 *
 * Usage: bench_approximation_gain [RAYS]
 *
 * A lumpy cumulus and torn billows, 600 m across, in vacuum under the sun at 15°, 45° and 80°. Rays from all sides, as
 * many at each sin(θ/2) of the angle θ between them and the sunlight (RAYS of them per cloud and sun, 600 by default),
 * are integrated by the march with its solution and with each method at the defaults of its keys. A gain is the ratio
 * of the sums, weighted by solid angle and by how near a ray is to the node of the table, so that the mean with
 * interpolated gains is that of the solution.
 */
#include <stdio.h>
#include <stdlib.h>

#include "integrate/approximation_gain.h"
#include "plan/integrator_choice.h"
#include "scene/scene_private.h"
#include "test_world.h"

enum { EDGE = 40, METHODS = 5, FIELDS = 2, SUNS = 3 };

static const double step_m = 15.0, radius_m = 0.5 * EDGE * 15.0 * 1.1;

static const struct {
  neph_multiple_scattering method;
  const char *name;
} methods[METHODS] = {{NEPH_MULTIPLE_SCATTERING_OCTAVES, "octaves"},
                      {NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER, "softened_beer"},
                      {NEPH_MULTIPLE_SCATTERING_POWDER, "powder"},
                      {NEPH_MULTIPLE_SCATTERING_DERIVATIVE, "derivative"},
                      {NEPH_MULTIPLE_SCATTERING_NONE, "none"}};

/* ---- Clouds ---- */

/* Lumps on lumps over a flat base, denser upwards. */
static float cumulus(double x, double y, double z) {
  const double lumps = 2.5 * sin(0.45 * x + 0.3 * z) * cos(0.5 * y - 0.2 * x) * sin(0.4 * z + 0.35 * y) +
                       1.5 * sin(1.1 * x - 0.4 * y) * sin(0.9 * y + 0.6 * z) * cos(1.2 * z);
  const double r = sqrt(x * x + y * y + (z > 0.0 ? 1.0 : 1.6) * z * z) - 3.0 * lumps;
  const double base = np_clamp((z + 12.0) / 2.0, 0.0, 1.0);
  const double edge = np_clamp((18.5 - fmax(fabs(x), fmax(fabs(y), fabs(z)))) / 2.0, 0.0, 1.0);
  return (float)(base * edge * np_clamp((15.0 - r) / 3.0, 0.0, 1.0) * (0.7 + 0.3 * (z + 12.0) / 30.0));
}

/* Value noise of −1 to 1, one lump to a unit. */
static double noise(double x, double y, double z) {
  const double place[3] = {floor(x), floor(y), floor(z)}, rest[3] = {x - place[0], y - place[1], z - place[2]};
  double sum = 0.0;
  for (int corner = 0; corner < 8; corner++) {
    uint32_t seed[3];
    double weight = 1.0;
    for (int a = 0; a < 3; a++) {
      const int upper = corner >> a & 1;
      const double smooth = rest[a] * rest[a] * (3.0 - 2.0 * rest[a]);
      seed[a] = (uint32_t)((int)place[a] + upper + 1000);
      weight *= upper ? smooth : 1.0 - smooth;
    }
    np_random random = np_random_start(7, seed[0], seed[1], seed[2], 0);
    sum += weight * (2.0 * np_random_double(&random) - 1.0);
  }
  return sum;
}

/* Fractal billows whose rim is torn. */
static float billows(double x, double y, double z) {
  double lumps = 0.0;
  for (double size = 12.0, height = 7.0; size > 2.0; size *= 0.5, height *= 0.6)
    lumps += height * noise(x / size, y / size, z / size);
  const double r = sqrt(x * x + y * y + (z > 0.0 ? 1.2 : 1.8) * z * z) - lumps;
  const double edge = np_clamp((19.0 - fmax(fabs(x), fmax(fabs(y), fabs(z)))) / 2.0, 0.0, 1.0);
  return (float)(edge * np_clamp((z + 12.0) / 2.0, 0.0, 1.0) * np_clamp((13.0 - r) / 4.0, 0.0, 1.0));
}

static const test_field fields[FIELDS] = {cumulus, billows};

/* ---- Sums ---- */

typedef struct sums {
  double solved[NP_GAIN_ALBEDOS][NP_GAIN_ANGLES], method[METHODS][NP_GAIN_ALBEDOS][NP_GAIN_ANGLES];
} sums;

static void add(const np_integrator_sample *sample, double place, double weight,
                double out[NP_GAIN_ALBEDOS][NP_GAIN_ANGLES]) {
  const int node = (int)fmin(place, NP_GAIN_ANGLES - 2);
  for (int b = 0; b < NP_GAIN_ALBEDOS; b++) {
    const double value = weight * test_sum_components(sample, b);
    out[b][node] += value * (1.0 - (place - node));
    out[b][node + 1] += value * (place - node);
  }
}

/* A parallel ray through the cloud's sphere that flies at the angle θ from where the sunlight comes from. */
static np_camera_ray make_ray(np_vec3 to_sun, double sine_half, np_random *random) {
  const double versine = 2.0 * sine_half * sine_half, azimuth = 2.0 * NP_PI * np_random_double(random);
  const double r = radius_m * sqrt(np_random_double(random)), turn = 2.0 * NP_PI * np_random_double(random);
  np_vec3 u, v;
  np_frame_around(to_sun, &u, &v);
  const double sine = sqrt(fmax(0.0, versine * (2.0 - versine)));
  const np_vec3 d = np_vec3_add(
      np_vec3_scale(to_sun, (float)(1.0 - versine)),
      np_vec3_add(np_vec3_scale(u, (float)(sine * cos(azimuth))), np_vec3_scale(v, (float)(sine * sin(azimuth)))));
  np_frame_around(d, &u, &v);
  np_dvec3 origin = np_dvec3_along(np_dvec3_make(0, 0, 0), d, -2.0 * radius_m);
  origin = np_dvec3_along(np_dvec3_along(origin, u, r * cos(turn)), v, r * sin(turn));
  return (np_camera_ray){.origin = origin, .direction = d, .jitter = np_random_float(random)};
}

static void add_ray(test_world *w, const np_integrator_settings *chosen, double sine_half, np_random *random,
                    sums *out) {
  const np_camera_ray ray = make_ray(w->world.to_sun, sine_half, random);
  const double place = sine_half * (NP_GAIN_ANGLES - 1);
  np_integrator_sample sample;
  w->settings = chosen[METHODS];
  test_world_march(w, &ray, random, &sample);
  add(&sample, place, sine_half, out->solved);
  w->lighting.scattering = NULL;
  for (int k = 0; k < METHODS; k++) {
    w->settings = chosen[k];
    test_world_march(w, &ray, random, &sample);
    add(&sample, place, sine_half, out->method[k]);
  }
  w->lighting.scattering = w->scattering;
}

/* ---- Cases ---- */

/* Settings of a scene with every key at its default, by method, and of the solution. */
static void choose_settings(neph_context *context, np_integrator_settings out[METHODS + 1]) {
  neph_scene *scene;
  assert_int_equal(neph_scene_create(context, &scene), NEPH_OK);
  for (int k = 0; k <= METHODS; k++)
    np_integrator_choice_make(&scene->render, k < METHODS ? methods[k].method : NEPH_MULTIPLE_SCATTERING_ORDINATES,
                              &out[k]);
  neph_scene_destroy(scene);
}

static void light(test_world *w, int sun) {
  static const double elevations[SUNS] = {15.0, 45.0, 80.0};
  const double elevation = elevations[sun] * NP_DEGREE, azimuth = 0.7 + 2.0 * sun;
  w->world.to_sun = np_vec3_make((float)(cos(elevation) * cos(azimuth)), (float)(cos(elevation) * sin(azimuth)),
                                 (float)sin(elevation));
  w->world.sun_irradiance = np_spectrum_grey(1.0f);
}

static void measure(test_field field, double depth, double asymmetry, int sun, int rays, sums *out) {
  test_world w;
  np_integrator_settings chosen[METHODS + 1];
  test_cloud cloud = test_cloud_make(field, 1.0f, np_phase_henyey_greenstein((float)asymmetry));
  cloud.edge = EDGE;
  cloud.step_m = np_dvec3_make(step_m, step_m, step_m);
  test_world_create(&w, 2, cloud);
  w.placed[0].extinction_per_value = (float)depth / np_cloud_gain_compute_depth(&w.placed[0]);
  w.placed[0].albedo =
      np_spectrum_make((float)np_gain_albedos[0], (float)np_gain_albedos[1], (float)np_gain_albedos[2]);
  w.placed[0].bottom_m = -12.0 * step_m;
  w.placed[0].top_m = 18.0 * step_m;
  w.desc.cells.cell_count_max = 150000;
  light(&w, sun);
  choose_settings(w.context, chosen);
  assert_int_equal(test_world_solve(&w), NEPH_OK);
  np_random random = np_random_start(1, (uint32_t)sun, 0, 0, 0);
  for (int i = 0; i < rays; i++) add_ray(&w, chosen, (i + np_random_double(&random)) / rays, &random, out);
  test_world_destroy(&w);
}

/* ---- Output ---- */

static sums results[NP_GAIN_ASYMMETRIES][NP_GAIN_DEPTHS];

static void print_row(const sums *s, int method) {
  printf("     {");
  for (int b = 0; b < NP_GAIN_ALBEDOS; b++) {
    printf("{");
    for (int a = 0; a < NP_GAIN_ANGLES; a++)
      printf("%s%#.3gf", a ? ", " : "", s->solved[b][a] / s->method[method][b][a]);
    printf(b + 1 < NP_GAIN_ALBEDOS ? "},\n      " : "}");
  }
  printf("}");
}

static void print_table(int method) {
  printf("\nconst np_gain_table np_gain_table_%s = {\n", methods[method].name);
  for (int g = 0; g < NP_GAIN_ASYMMETRIES; g++) {
    printf("    {\n");
    for (int d = 0; d < NP_GAIN_DEPTHS; d++) {
      print_row(&results[g][d], method);
      printf(",\n");
    }
    printf("    },\n");
  }
  printf("};\n");
}

int main(int count, char **arguments) {
  const int rays = count > 1 ? atoi(arguments[1]) : 600;
  for (int g = 0; g < NP_GAIN_ASYMMETRIES; g++)
    for (int d = 0; d < NP_GAIN_DEPTHS; d++) {
      const double depth = np_gain_depth_first * pow(np_gain_depth_ratio, d);
      for (int f = 0; f < FIELDS; f++)
        for (int s = 0; s < SUNS; s++) measure(fields[f], depth, np_gain_asymmetries[g], s, rays, &results[g][d]);
      fprintf(stderr, "asymmetry %g, optical depth %g\n", np_gain_asymmetries[g], depth);
    }
  printf("/* SPDX-License-Identifier: Apache-2.0 */\n"
         "/* Gains by method, asymmetry, optical depth, albedo and angle. Printed by a benchmark:\n"
         " *\n"
         " *   bench_approximation_gain >src/integrate/approximation_gain_table.c\n"
         " */\n"
         "#include \"integrate/approximation_gain.h\"\n\n"
         "/* clang-format off */\n");
  for (int k = 0; k < METHODS; k++) print_table(k);
  return 0;
}
