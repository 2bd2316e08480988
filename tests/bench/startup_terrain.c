/* SPDX-License-Identifier: Apache-2.0 */
/* An SRTM tile in Embree, without nephos, and 48 × 27 rays down on it: the least program that does what the distance of
 * hills needs. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <embree3/rtcore.h>

enum { SIDE = 1201, WIDTH = 48, HEIGHT = 27 };

static const float spacing_m = 90.0f;

static float *read_vertices(const char *path) {
  float *vertices = malloc((3 * (size_t)SIDE * SIDE + 1) * sizeof *vertices);
  FILE *file = fopen(path, "rb");
  if (!vertices || !file) return NULL;
  for (size_t i = 0; i < (size_t)SIDE * SIDE; i++) {
    const int high = getc(file), low = getc(file);
    if (low < 0) return NULL;
    vertices[3 * i] = spacing_m * (float)(i % SIDE);
    vertices[3 * i + 1] = -spacing_m * (float)(i / SIDE);
    vertices[3 * i + 2] = (float)(short)(high << 8 | low);
  }
  fclose(file);
  return vertices;
}

static RTCScene build(RTCDevice device, float *vertices) {
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0, 3 * sizeof(float),
                             (size_t)SIDE * SIDE);
  struct RTCGrid *grid =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(struct RTCGrid), 1);
  *grid = (struct RTCGrid){0, SIDE, SIDE, SIDE};
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

static float shoot(RTCScene scene, int column, int row) {
  struct RTCIntersectContext context;
  struct RTCRayHit ray = {.ray = {.org_x = spacing_m * SIDE * ((float)column + 0.5f) / WIDTH,
                                  .org_y = -spacing_m * SIDE * ((float)row + 0.5f) / HEIGHT,
                                  .org_z = 9000.0f,
                                  .dir_z = -1.0f,
                                  .tfar = INFINITY,
                                  .mask = 0xffffffffu},
                          .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray);
  return ray.ray.tfar;
}

int main(int count, char **words) {
  float *vertices = count == 3 ? read_vertices(words[1]) : NULL;
  FILE *out = count == 3 ? fopen(words[2], "wb") : NULL;
  if (!vertices || !out) return 1;
  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene scene = build(device, vertices);
  for (int i = 0; i < WIDTH * HEIGHT; i++) {
    const float distance = shoot(scene, i % WIDTH, i / WIDTH);
    if (fwrite(&distance, sizeof distance, 1, out) != 1) return 1;
  }
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  free(vertices);
  return fclose(out) ? 1 : 0;
}
