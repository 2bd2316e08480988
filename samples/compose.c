/* SPDX-License-Identifier: Apache-2.0 */
/* A scene without a file and without a key's name: clouds baked to memory, air, hills, sun and camera by typed calls,
 * and two pictures of it from one place by one renderer, of which the second takes over all that the first has built.
 *
 *     cc compose.c $(pkg-config --cflags --libs nephos) -lm -o compose && ./compose .
 */
#include <math.h>
#include <stdio.h>

#include <nephos/nephos.h>

static const double degree = 3.14159265358979323846 / 180.0;

/* One tall cumulus, and a small one beside it: the same volume, placed twice. */
static neph_result add_clouds(neph_context *context, neph_scene *scene) {
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  neph_placement_desc place = NEPH_PLACEMENT_DESC_DEFAULT;
  neph_volume *volume = NULL;
  neph_result result = neph_cloud_get_preset(context, "cumulus_congestus", &cloud);
  cloud.model = NEPH_CLOUD_MODEL_HERO;
  cloud.extent_m[0] = cloud.extent_m[1] = 3200.0;
  cloud.thickness_m = 2200.0;
  cloud.voxel_m = 40.0;
  if (!result) result = neph_cloud_bake(context, &cloud, NULL, &volume);
  if (!result) result = neph_scene_add_volume(scene, volume, &place, NULL);
  place.has_position = true;
  place.position_m[0] = 2400.0;
  place.position_m[1] = -1000.0;
  place.position_m[2] = 1300.0;
  place.rotation_rad = 130.0 * degree;
  place.scale = 0.5;
  if (!result) result = neph_scene_add_volume(scene, volume, &place, NULL);
  neph_volume_release(volume); /* the scene has it */
  return result;
}

static neph_result set_ground(neph_context *context, neph_scene *scene) {
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  neph_terrain *terrain = NULL;
  ridges.sample_count = 513;
  ridges.relief_m = 500.0;
  desc.ground_albedo[0] = 0.08;
  desc.ground_albedo[1] = 0.12;
  desc.ground_albedo[2] = 0.05;
  neph_result result = neph_terrain_create_ridges(context, &ridges, &desc, &terrain);
  if (!result) result = neph_scene_set_terrain(scene, terrain);
  neph_terrain_release(terrain);
  return result;
}

static neph_result set_air(neph_context *context, neph_scene *scene) {
  neph_atmosphere *atmosphere = NULL;
  neph_result result = neph_atmosphere_create(context, NULL, &atmosphere);
  if (!result) result = neph_scene_set_atmosphere(scene, atmosphere);
  neph_atmosphere_release(atmosphere);
  return result;
}

static neph_result build_scene(neph_context *context, neph_scene **out_scene) {
  neph_sun_desc sun = NEPH_SUN_DESC_DEFAULT;
  sun.elevation_rad = 28.0 * degree;
  sun.azimuth_rad = 300.0 * degree;
  neph_result result = neph_scene_create(context, out_scene);
  if (!result) result = neph_scene_set_sun(*out_scene, &sun);
  if (!result) result = set_air(context, *out_scene);
  if (!result) result = set_ground(context, *out_scene);
  return result ? result : add_clouds(context, *out_scene);
}

/* Prints the progress of the picture, on one line. */
static bool show_progress(void *user, const neph_progress *progress) {
  (void)user;
  fprintf(stderr, "\r%-40s %3.0f %%", progress->stage, 100.0 * progress->fraction);
  if (isfinite(progress->remaining_s)) fprintf(stderr, ", %.0f s left   ", progress->remaining_s);
  return true; /* false would cancel */
}

static neph_result save(const neph_image *image, const char *folder, int frame) {
  char path[1024];
  (void)snprintf(path, sizeof path, "%s/compose.%d.exr", folder, frame);
  neph_result result = neph_image_save_exr(image, path, NEPH_PIXEL_HALF);
  (void)snprintf(path, sizeof path, "%s/compose.%d.png", folder, frame);
  return result ? result : neph_image_save_png(image, path, NULL);
}

/* A wide picture, and a near one through a longer lens. Multiple scattering is solved on cells that are finer near the
 * camera: it is reused while the camera stays where it is. */
static neph_result render_frame(neph_renderer *renderer, neph_scene *scene, int frame, const char *folder) {
  neph_camera_desc camera = NEPH_CAMERA_DESC_DEFAULT;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image = NULL;
  camera.position_m[0] = camera.position_m[1] = -4500.0;
  camera.position_m[2] = 900.0;
  camera.look_at_m[0] = frame == 1 ? 500.0 : 0.0;
  camera.look_at_m[2] = frame == 1 ? 1900.0 : 2200.0;
  camera.fov_rad = (frame == 1 ? 55.0 : 28.0) * degree;
  camera.resolution[0] = 240;
  camera.resolution[1] = 135;
  neph_result result = neph_scene_set_camera(scene, &camera);
  if (!result) result = neph_scene_get_render_desc(scene, &desc);
  desc.frame = frame;
  desc.progress = show_progress;
  if (!result) result = neph_renderer_render(renderer, scene, &desc, &image);
  fputc('\n', stderr);
  if (!result) result = save(image, folder, frame);
  neph_image_destroy(image);
  return result;
}

int main(int argc, char **argv) {
  if (argc != 2) {
    fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  neph_context *context = NULL;
  neph_scene *scene = NULL;
  neph_renderer *renderer = NULL;
  neph_result result = neph_context_create(NULL, &context); /* errors are printed to stderr */
  if (!result) result = build_scene(context, &scene);
  if (!result) result = neph_renderer_create(context, &renderer);
  for (int frame = 1; frame <= 2 && !result; frame++) result = render_frame(renderer, scene, frame, argv[1]);
  neph_renderer_destroy(renderer);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return result ? 1 : 0;
}
