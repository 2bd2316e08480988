/* SPDX-License-Identifier: Apache-2.0 */
/* Rays that meet the ground: of known shape, as every triangle says, and to their ends. */
#include "test_terrains.h"

#include <float.h>

#include "core/random.h"
#include "terrain/heightfield.h"

static np_vec3 aim(np_dvec3 from, np_dvec3 at) {
  return np_dvec3_to_float(np_dvec3_normalize(np_dvec3_subtract(at, from)));
}

static double get_uniform(np_random *random, double low, double high) {
  return low + (high - low) * np_random_double(random);
}

static np_vec3 get_random_direction(np_random *random) {
  const double z = get_uniform(random, -1, 1), azimuth = get_uniform(random, 0, 2 * NP_PI), r = sqrt(1 - z * z);
  return np_vec3_make((float)(r * cos(azimuth)), (float)(r * sin(azimuth)), (float)z);
}

/* ---- Known ground ---- */

static int be_flat(unsigned column, unsigned row) { return (void)column, (void)row, 0; }
static int slope_east(unsigned column, unsigned row) { return (void)row, 2 * (int)column; }
/* A paraboloid hill 1000 m high around the middle sample, reaching 400 samples. */
static int raise_hill(unsigned column, unsigned row) {
  const double x = (column - 600.0) / 400.0, y = (row - 600.0) / 400.0, r2 = x * x + y * y;
  return r2 < 1 ? (int)lround(1000 * (1 - r2)) : 0;
}

/* Ground at sea level, wherever a ray comes from: straight down from orbit, slanting, from 100 km beside the field. */
static void flat_ground_is_the_sphere(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_tile(f, be_flat);
  const np_dvec3 eyes[] = {{0, 0, 100}, {0, 0, 400e3}, {-300e3, 200e3, 400e3}, {100e3, -20e3, 3000}};
  for (int eye = 0; eye < 4; eye++)
    for (double x = -35e3; x <= 35e3; x += 7e3)
      for (double y = -50e3; y <= 50e3; y += 10e3) {
        const np_dvec3 target = {x, y, sqrt(radius_m * radius_m - x * x - y * y) - radius_m};
        const np_vec3 direction = aim(eyes[eye], target);
        const double cosine = -(double)np_vec3_dot(direction, np_zenith(target, radius_m));
        if (cosine < 0.01) continue; /* beyond the horizon, or touching it */
        np_terrain_hit hit;
        assert_true(np_terrain_intersect(terrain, eyes[eye], direction, INFINITY, &hit));
        const np_dvec3 point = np_dvec3_along(eyes[eye], direction, hit.distance);
        assert_near(np_altitude(point, radius_m), 0, surface_tolerance_m);
        assert_true(np_vec3_dot(hit.normal, np_zenith(point, radius_m)) > 0.999999f);
        /* A float direction errs by 6e-8, which a slanting ray stretches. */
        assert_near(np_dvec3_length(np_dvec3_subtract(point, target)), 0, (0.01 + 1.2e-7 * hit.distance) / cosine);
      }
  neph_terrain_release(terrain);
}

static void far_ground_lies_below_the_tangent_plane(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_tile(f, be_flat);
  np_terrain_hit hit;
  assert_true(np_terrain_intersect(terrain, (np_dvec3){0, 30e3, 1000}, np_vec3_make(0, 0, -1), INFINITY, &hit));
  assert_near(1000 - hit.distance, -70.755, surface_tolerance_m);
  neph_terrain_release(terrain);
}

/* 2 m per column of 3 arc seconds: the slope follows from the parallel's length at each hit. */
static void a_slope_has_its_normal(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_tile(f, slope_east);
  for (double y = -40e3; y <= 40e3; y += 8e3) {
    const np_dvec3 eye = {137.0, y, 20e3};
    np_terrain_hit hit;
    assert_true(np_terrain_intersect(terrain, eye, np_vec3_make(0, 0, -1), INFINITY, &hit));
    const np_dvec3 point = np_dvec3_along(eye, np_vec3_make(0, 0, -1), hit.distance);
    const double elevation = neph_terrain_get_elevation_m(terrain, eye.x, eye.y);
    assert_near(np_altitude(point, radius_m), elevation, surface_tolerance_m);
    const double latitude = 44.5 * NP_DEGREE + asin(y / radius_m);
    const double slope = 2.0 / (NP_DEGREE / 1200 * (radius_m + elevation) * cos(latitude));
    const np_vec3 up = np_zenith(point, radius_m);
    /* Along east; the zenith of x = 137 m is off by 2e-5, the vertices' rounding tilts by 4 mm in 66 m. */
    assert_near(-(double)(hit.facet.x / np_vec3_dot(hit.facet, up)), slope, 1e-4);
    assert_near(-(double)(hit.normal.x / np_vec3_dot(hit.normal, up)), slope, 1e-4);
  }
  neph_terrain_release(terrain);
}

/* Whole metres round the hill's heights by half a metre, and its slope by a hundredth. */
static void a_hill_stands_where_it_should(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_tile(f, raise_hill);
  assert_near(neph_terrain_get_elevation_m(terrain, 0, 0), 1000, 1e-3);
  const double reach_north = 400 * NP_DEGREE / 1200 * radius_m;
  for (double y = -30e3; y <= 30e3; y += 1e3) {
    const double expected = 1000 * (1 - y * y / (reach_north * reach_north));
    assert_near(neph_terrain_get_elevation_m(terrain, 0, y), expected, 0.7);
  }
  /* A level ray 500 m up meets the hill where it is that high above the curved sea: z = h − y²/2R. */
  np_terrain_hit hit;
  assert_true(np_terrain_intersect(terrain, (np_dvec3){0, -60e3, 500}, np_vec3_make(0, 1, 0), INFINITY, &hit));
  const double y = 60e3 - hit.distance;
  assert_near(1000 * (1 - y * y / (reach_north * reach_north)) - y * y / (2 * radius_m), 500, 0.7);
  neph_terrain_release(terrain);
}

/* Rays down from everywhere find what the elevation says. */
static void rays_and_elevations_agree(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_ridges(f->context, 257);
  np_random random = np_random_start(1, 0, 0, 0, 0);
  for (int i = 0; i < 10000; i++) {
    const np_dvec3 eye = {get_uniform(&random, -14.9e3, 14.9e3), get_uniform(&random, -14.9e3, 14.9e3), 400e3};
    np_terrain_hit hit;
    assert_true(np_terrain_intersect(terrain, eye, np_vec3_make(0, 0, -1), INFINITY, &hit));
    const double altitude = np_altitude((np_dvec3){eye.x, eye.y, eye.z - hit.distance}, radius_m);
    /* Vertices within 16 km are rounded by 0.5 mm; ground this steep (< 45°) moves it by as much again. */
    assert_near(altitude, neph_terrain_get_elevation_m(terrain, eye.x, eye.y), 0.003);
    assert_true(np_vec3_dot(hit.normal, hit.facet) > 0.5f && hit.normal.z > 0);
  }
  neph_terrain_release(terrain);
}

/* ---- Against every triangle in double ---- */

typedef struct triangle_soup {
  size_t count;
  np_dvec3 (*corners)[3];
} triangle_soup;

static triangle_soup make_soup(neph_context *context, unsigned samples) {
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  ridges.sample_count = samples;
  np_monitor monitor;
  np_monitor_start(&monitor, context, NULL, NULL);
  np_heightfield field;
  assert_int_equal(np_heightfield_make_ridges(context, &monitor, &ridges, &desc, &field), NEPH_OK);
  assert_int_equal(np_heightfield_join_sphere(context, NEPH_TERRAIN_EDGE_FADE, radius_m, &field), NEPH_OK);
  const np_globe globe = np_globe_make(radius_m, 0, 0);
  triangle_soup soup = {.corners = calloc(2 * (samples - 1) * (samples - 1), sizeof *soup.corners)};
  for (unsigned row = 0; row + 1 < samples; row++)
    for (unsigned column = 0; column + 1 < samples; column++) {
      np_dvec3 quad[4];
      for (unsigned i = 0; i < 4; i++) quad[i] = place_sample(&field, &globe, column + i % 2, row + i / 2);
      memcpy(soup.corners[soup.count++], quad, 3 * sizeof *quad);
      memcpy(soup.corners[soup.count++], quad + 1, 3 * sizeof *quad);
    }
  np_heightfield_destroy(context, &field);
  return soup;
}

/* Möller and Trumbore 1997. */
static double meet_triangle(const np_dvec3 corners[3], np_dvec3 origin, np_dvec3 direction) {
  const np_dvec3 e1 = np_dvec3_subtract(corners[1], corners[0]), e2 = np_dvec3_subtract(corners[2], corners[0]);
  const np_dvec3 p = np_dvec3_cross(direction, e2), s = np_dvec3_subtract(origin, corners[0]),
                 q = np_dvec3_cross(s, e1);
  const double determinant = np_dvec3_dot(e1, p);
  const double u = np_dvec3_dot(s, p) / determinant, v = np_dvec3_dot(direction, q) / determinant;
  const double t = np_dvec3_dot(e2, q) / determinant;
  return u >= 0 && v >= 0 && u + v <= 1 && t >= 0 ? t : (double)INFINITY;
}

static double meet_soup(const triangle_soup *soup, np_dvec3 origin, np_vec3 direction, double *out_cosine) {
  const np_dvec3 d = np_vec3_to_double(direction);
  double nearest = (double)INFINITY;
  for (size_t i = 0; i < soup->count; i++) {
    const double t = meet_triangle(soup->corners[i], origin, d);
    if (!(t < nearest)) continue;
    nearest = t;
    const np_dvec3 normal = np_dvec3_cross(np_dvec3_subtract(soup->corners[i][1], soup->corners[i][0]),
                                           np_dvec3_subtract(soup->corners[i][2], soup->corners[i][0]));
    *out_cosine = fabs(np_dvec3_dot(np_dvec3_normalize(normal), d));
  }
  return nearest;
}

/* Half of the rays start inside the box, a quarter 100 km off, a quarter in orbit; those aim at random points. The
 * plane differs by the vertices' rounding, 1 mm, along a ray as 1 over the cosine. A ray may pass a silhouette on the
 * other side by that millimetre, or by the 1e-7 of its way that Embree's floats lose: ridges of 1 km make that one ray
 * in 10⁵ or so; 10 in 10⁴ would be a fault. */
static void rays_agree_with_every_triangle(void **state) {
  test_fixture *f = *state;
  enum { SAMPLES = 33, RAYS = 10000 };
  neph_terrain *terrain = make_ridges(f->context, SAMPLES);
  triangle_soup soup = make_soup(f->context, SAMPLES);
  np_random random = np_random_start(2, 0, 0, 0, 0);
  int met = 0, different = 0;
  for (int i = 0; i < RAYS; i++) {
    const np_dvec3 target = {get_uniform(&random, -15e3, 15e3), get_uniform(&random, -15e3, 15e3),
                             get_uniform(&random, 0, 1400)};
    np_vec3 direction = get_random_direction(&random);
    np_dvec3 origin = target;
    if (i % 4 == 2) direction.z *= 0.1f;
    if (i % 4 == 3) direction.z = -fabsf(direction.z);
    direction = np_vec3_normalize(direction);
    if (i % 4 >= 2) origin = np_dvec3_along(target, direction, i % 4 == 2 ? -100e3 : -400e3);
    double cosine = 1;
    const double expected = meet_soup(&soup, origin, direction, &cosine);
    np_terrain_hit hit = {.distance = INFINITY};
    const bool is_hit = np_terrain_intersect(terrain, origin, direction, INFINITY, &hit);
    assert_int_equal(is_hit, isfinite(hit.distance));
    assert_int_equal(is_hit, np_terrain_is_occluded(terrain, origin, direction, INFINITY));
    met += is_hit;
    different += !(hit.distance == expected || fabs(hit.distance - expected) <= 0.002 / cosine);
  }
  assert_true(met > RAYS / 3);
  assert_in_range(different, 0, 10);
  free(soup.corners);
  neph_terrain_release(terrain);
}

/* ---- Rays' ends ---- */

static void distances_are_respected(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_tile(f, be_flat);
  const np_dvec3 eye = {10, 20, 100};
  const np_vec3 down = {0, 0, -1}, up = {0, 0, 1};
  np_terrain_hit hit;
  assert_true(np_terrain_intersect(terrain, eye, down, 100.1, &hit));
  assert_false(np_terrain_intersect(terrain, eye, down, 99.9, &hit));
  assert_true(np_terrain_is_occluded(terrain, eye, down, 100.1));
  assert_false(np_terrain_is_occluded(terrain, eye, down, 99.9));
  assert_false(np_terrain_intersect(terrain, eye, up, INFINITY, &hit));
  assert_false(np_terrain_is_occluded(terrain, (np_dvec3){1e6, 0, 100}, up, INFINITY));
  assert_true(np_terrain_intersect(terrain, (np_dvec3){10, 20, -100}, up, INFINITY, &hit));
  assert_true(hit.facet.z > 0 && hit.normal.z > 0); /* up, also when met from below */
  neph_terrain_release(terrain);
}

/* Lifted off the ground as the header says, a ray to the zenith is free, from wherever the ground was seen. */
static void lifted_rays_leave_the_ground(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_ridges(f->context, 257);
  np_random random = np_random_start(3, 0, 0, 0, 0);
  for (int i = 0; i < 20000; i++) {
    const np_dvec3 eye = {get_uniform(&random, -2e5, 2e5), get_uniform(&random, -2e5, 2e5), 4e5};
    const np_dvec3 target = {get_uniform(&random, -14e3, 14e3), get_uniform(&random, -14e3, 14e3), 0};
    np_terrain_hit hit;
    const np_vec3 direction = aim(eye, target);
    if (!np_terrain_intersect(terrain, eye, direction, INFINITY, &hit)) continue;
    const np_dvec3 point = np_dvec3_along(np_dvec3_along(eye, direction, hit.distance), hit.facet, NP_TERRAIN_LIFT_M);
    assert_false(np_terrain_is_occluded(terrain, point, np_zenith(point, radius_m), INFINITY));
    assert_true(np_terrain_is_occluded(terrain, point, np_vec3_scale(hit.facet, -1), 1.0));
  }
  neph_terrain_release(terrain);
}

/* Visibility is mutual. Floats may differ on a ray that touches a ridge within millimetres: 5 of
 * 5000 is a share that a fault would exceed. */
static void occlusion_is_mutual(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_ridges(f->context, 257);
  np_random random = np_random_start(4, 0, 0, 0, 0);
  int different = 0, occluded = 0;
  for (int i = 0; i < 5000; i++) {
    np_dvec3 ends[2];
    for (int k = 0; k < 2; k++) {
      ends[k] = (np_dvec3){get_uniform(&random, -14e3, 14e3), get_uniform(&random, -14e3, 14e3), 0};
      ends[k].z = neph_terrain_get_elevation_m(terrain, ends[k].x, ends[k].y) + get_uniform(&random, 1, 300);
    }
    const double distance = np_dvec3_length(np_dvec3_subtract(ends[1], ends[0]));
    const bool there = np_terrain_is_occluded(terrain, ends[0], aim(ends[0], ends[1]), distance);
    const bool back = np_terrain_is_occluded(terrain, ends[1], aim(ends[1], ends[0]), distance);
    occluded += there;
    different += there != back;
  }
  assert_in_range(occluded, 500, 4500);
  assert_in_range(different, 0, 5);
  neph_terrain_release(terrain);
}

/* Directions with zeros, infinities and NaN: no crash, and no hit where there is none. */
static void odd_rays_do_no_harm(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_ridges(f->context, 33);
  np_dvec3 low, high;
  np_terrain_get_bounds(terrain, &low, &high);
  np_terrain_hit hit;
  assert_false(np_terrain_intersect(terrain, (np_dvec3){low.x - 2, 0, 500}, np_vec3_make(0, 1, 0), INFINITY, &hit));
  assert_false(np_terrain_intersect(terrain, (np_dvec3){0, 0, NAN}, np_vec3_make(0, 0, -1), INFINITY, &hit));
  assert_false(np_terrain_intersect(terrain, (np_dvec3){0, 0, 500}, np_vec3_make(NAN, NAN, NAN), INFINITY, &hit));
  assert_false(np_terrain_is_occluded(terrain, (np_dvec3){0, 0, INFINITY}, np_vec3_make(0, 0, -1), INFINITY));
  assert_false(np_terrain_intersect(terrain, (np_dvec3){0, 0, 5000}, np_vec3_make(0, 0, -1), 0, &hit));
  assert_true(np_terrain_intersect(terrain, (np_dvec3){0, 0, 5000}, np_vec3_make(0, -0.0f, -1), INFINITY, &hit));
  neph_terrain_release(terrain);
}

/* The same hits, bit for bit, whatever the number of threads that built the tree. */
static void threads_do_not_change_hits(void **state) {
  test_fixture *f = *state;
  neph_context *single = test_context_create(1, NULL);
  neph_terrain *terrains[2] = {make_ridges(f->context, 257), make_ridges(single, 257)};
  np_random random = np_random_start(5, 0, 0, 0, 0);
  for (int i = 0; i < 10000; i++) {
    const np_dvec3 eye = {get_uniform(&random, -15e3, 15e3), get_uniform(&random, -15e3, 15e3), 1500};
    const np_vec3 direction = get_random_direction(&random);
    np_terrain_hit hits[2];
    memset(hits, 0, sizeof hits);
    bool is_hit[2];
    for (int k = 0; k < 2; k++) is_hit[k] = np_terrain_intersect(terrains[k], eye, direction, INFINITY, &hits[k]);
    assert_int_equal(is_hit[0], is_hit[1]);
    if (is_hit[0]) assert_memory_equal(&hits[0], &hits[1], sizeof hits[0]);
  }
  neph_terrain_release(terrains[0]);
  neph_terrain_release(terrains[1]);
  neph_context_destroy(single);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(flat_ground_is_the_sphere),  TEST(far_ground_lies_below_the_tangent_plane),
      TEST(a_slope_has_its_normal),     TEST(a_hill_stands_where_it_should),
      TEST(rays_and_elevations_agree),  TEST(rays_agree_with_every_triangle),
      TEST(distances_are_respected),    TEST(lifted_rays_leave_the_ground),
      TEST(occlusion_is_mutual),        TEST(odd_rays_do_no_harm),
      TEST(threads_do_not_change_hits),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
