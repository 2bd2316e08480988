/* SPDX-License-Identifier: Apache-2.0 */
/* Lights and camera of a scene as a USD layer.
 *
 * The stage is Z up, in metres. A DomeLight's latitude-longitude texture follows OpenEXR: +Z of its own space in the
 * middle, +X a quarter in, +Y at the top (UsdLux, DomeLight). A quarter turn about x puts the middle south and the
 * quarter east, where pictures of skies have them by default; other middles turn it about the vertical. Its values are
 * radiances times the picture's scale, and so are the irradiances of lights. A DistantLight whose `normalize` is set
 * has the irradiance of its colour; it shines along its −Z.
 */
#include <nephos/render.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/text.h"
#include "core/units.h"
#include "image/image_private.h"
#include "scene/camera.h"

static bool read_numbers(const neph_image *sky, const char *light, const char *what, int count, double *out) {
  char key[48];
  np_print(key, sizeof key, "nephos:%s%s", light, what);
  const char *text = neph_image_get_attribute(sky, key);
  char *rest = NULL;
  for (int i = 0; text && i < count; i++, text = rest) out[i] = strtod(text, &rest);
  return text;
}

/* Row vectors: the images of x, y and z, and of the origin. */
static void add_transform(np_text *out, np_vec3 x, np_vec3 y, np_vec3 z, np_dvec3 origin) {
  const np_vec3 rows[3] = {x, y, z};
  np_text_add(out, "    matrix4d xformOp:transform = (");
  for (int i = 0; i < 3; i++)
    np_text_add(out, " (%.9g, %.9g, %.9g, 0),", (double)rows[i].x, (double)rows[i].y, (double)rows[i].z);
  np_text_add(out, " (%.12g, %.12g, %.12g, 1) )\n", origin.x, origin.y, origin.z);
  np_text_add(out, "    uniform token[] xformOpOrder = [\"xformOp:transform\"]\n");
}

/* A path between @, which it must not hold. */
static void add_dome(np_text *out, const char *texture, double center_rad) {
  np_text_add(out, "  def DomeLight \"Sky\"\n  {\n");
  np_text_add(out, "    asset inputs:texture:file = @%s@\n", texture);
  np_text_add(out, "    token inputs:texture:format = \"latlong\"\n    float inputs:intensity = 1\n");
  np_text_add(out, "    float xformOp:rotateZ = %.6g\n    float xformOp:rotateX = 90\n",
              remainder(NP_PI - center_rad, 2.0 * NP_PI) / NP_DEGREE);
  np_text_add(out, "    uniform token[] xformOpOrder = [\"xformOp:rotateZ\", \"xformOp:rotateX\"]\n  }\n\n");
}

static void add_distant(np_text *out, const neph_image *sky, const char *light, const char *name) {
  double color[3], direction[3], radius, scale = 1.0;
  if (!read_numbers(sky, light, "NormalIrradiance", 3, color) || !read_numbers(sky, light, "Direction", 3, direction) ||
      !read_numbers(sky, light, "AngularRadius", 1, &radius))
    return;
  (void)read_numbers(sky, "", "scale", 1, &scale);
  const np_vec3 z = np_dvec3_to_float(np_dvec3_make(direction[0], direction[1], direction[2]));
  np_vec3 x, y;
  np_frame_around(z, &x, &y);
  np_text_add(out, "  def DistantLight \"%s\"\n  {\n", name);
  np_text_add(out, "    float inputs:angle = %.6g\n", 2.0 * radius / NP_DEGREE);
  np_text_add(out, "    color3f inputs:color = (%.6g, %.6g, %.6g)\n", scale * color[0], scale * color[1],
              scale * color[2]);
  np_text_add(out, "    float inputs:intensity = 1\n    bool inputs:normalize = 1\n");
  add_transform(out, x, y, z, np_dvec3_make(0, 0, 0));
  np_text_add(out, "  }\n\n");
}

/* Lengths of film and lens are in tenths of the stage's unit. */
static void add_film(np_text *out, const np_scene_camera *camera, double width_m) {
  const double height_m = width_m * camera->resolution[1] / camera->resolution[0], tenths = 10.0;
  np_text_add(out, "    float horizontalAperture = %.9g\n", tenths * width_m);
  np_text_add(out, "    float verticalAperture = %.9g\n", tenths * height_m);
  np_text_add(out, "    float horizontalApertureOffset = %.9g\n", tenths * camera->shift[0] * width_m);
  np_text_add(out, "    float verticalApertureOffset = %.9g\n", tenths * camera->shift[1] * width_m);
}

static void add_lens(np_text *out, const np_scene_camera *camera, const np_camera *frame) {
  np_text_add(out, "    float focalLength = %.9g\n", 10.0 * np_scene_camera_get_focal_length_m(camera));
  if (!camera->has_lens) return;
  np_text_add(out, "    float fStop = %.6g\n    float focusDistance = %.9g\n", camera->f_stop, (double)frame->focus_m);
}

static void add_camera(np_text *out, const np_scene_camera *camera, const np_camera *frame) {
  if (!frame->row->is_flat) return;
  const bool is_parallel = camera->kind == NEPH_CAMERA_ORTHOGRAPHIC;
  np_text_add(out, "  def Camera \"Camera\"\n  {\n");
  np_text_add(out, "    token projection = \"%s\"\n", is_parallel ? "orthographic" : "perspective");
  add_film(out, camera, is_parallel ? camera->orthographic_width_m : camera->sensor_m);
  if (!is_parallel) add_lens(out, camera, frame);
  np_text_add(out, "    float2 clippingRange = (%.6g, %.6g)\n", fmax(camera->near_m, 0.1), fmin(camera->far_m, 1e7));
  add_transform(out, frame->right, frame->up, frame->back, frame->origin);
  np_text_add(out, "  }\n");
}

static neph_result print_layer(const neph_scene *scene, const neph_image *sky, const char *texture, char **out_text) {
  np_camera frame;
  const unsigned *size = scene->camera.resolution;
  neph_result result = np_camera_init(scene, size[0], size[1], NEPH_EYE_CENTRE, &frame);
  if (result) return result;
  double center_rad = NP_PI;
  (void)read_numbers(sky, "", "centerAzimuth", 1, &center_rad);
  const char *disks = neph_image_get_attribute(sky, "nephos:disks");
  np_text out = {.context = scene->context};
  np_text_add(&out, "#usda 1.0\n(\n  defaultPrim = \"World\"\n  metersPerUnit = 1\n  upAxis = \"Z\"\n)\n\n");
  np_text_add(&out, "def Xform \"World\"\n{\n");
  add_dome(&out, texture, center_rad);
  if (!disks || strcmp(disks, "include") != 0) {
    add_distant(&out, sky, "sun", "Sun");
    add_distant(&out, sky, "moon", "Moon");
  }
  add_camera(&out, &scene->camera, &frame);
  np_text_add(&out, "}\n");
  return np_text_finish(&out, out_text);
}

neph_result neph_scene_save_usd(const neph_scene *scene, const neph_image *sky, const char *texture, const char *path) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), sky, texture, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  if (strpbrk(texture, "@\n"))
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "texture is %s, must hold neither @ nor a line break",
                   texture);
  char *text = NULL;
  neph_result result = print_layer(scene, sky, texture, &text);
  if (!result) result = np_file_write_all(scene->context, path, text, strlen(text));
  np_alloc_free(scene->context, text);
  return result;
}
