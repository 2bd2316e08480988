/* SPDX-License-Identifier: Apache-2.0 */
/* The pinhole camera.
 *
 * It looks along −back; `right` and `up` span the picture, whose width fills the horizontal angle of view. Directions
 * are formed from the frame alone, never from world positions, so that no place in the world costs precision.
 */
#include "scene/scene_private.h"

/* Unit; `look_at` differs from `position`, which np_scene_check has seen to. */
static np_dvec3 compute_back(const np_scene_camera *camera) {
  const double *p = camera->position_m, *q = camera->look_at_m;
  return np_dvec3_normalize(np_dvec3_make(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
}

/* Horizontal and unit. Straight up or down, where no direction is to the right, the top of the picture is north (down)
 * or south (up), as when the camera had been tilted there while facing north. */
static np_dvec3 compute_level_right(np_dvec3 back) {
  double horizontal = hypot(back.x, back.y);
  if (horizontal < 1e-9) return np_dvec3_make(1, 0, 0);
  return np_dvec3_make(-back.y / horizontal, back.x / horizontal, 0);
}

neph_result np_camera_init(const neph_scene *scene, unsigned width, unsigned height, np_camera *out_camera) {
  const np_scene_camera *camera = &scene->camera;
  if (width < 1 || height < 1 || width > 65536 || height > 65536)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "the picture is %u x %u pixels, must be 1 to 65536 each way", width, height);
  np_dvec3 back = compute_back(camera), level_right = compute_level_right(back);
  np_dvec3 level_up = np_dvec3_cross(back, level_right);
  double c = cos(camera->roll_rad), s = sin(camera->roll_rad);
  np_dvec3 right = np_dvec3_subtract(np_dvec3_scale(level_right, c), np_dvec3_scale(level_up, s));
  np_dvec3 up = np_dvec3_add(np_dvec3_scale(level_right, s), np_dvec3_scale(level_up, c));
  double tan_half_width = tan(0.5 * camera->fov_rad);
  *out_camera = (np_camera){
      .origin = np_dvec3_make(camera->position_m[0], camera->position_m[1], camera->position_m[2]),
      .right = np_dvec3_to_float(right),
      .up = np_dvec3_to_float(up),
      .back = np_dvec3_to_float(back),
      .tan_half_width = (float)tan_half_width,
      .tan_half_height = (float)(tan_half_width * height / width),
      .width = width,
      .height = height,
  };
  return NEPH_OK;
}

np_vec3 np_camera_direction(const np_camera *camera, float x, float y) {
  float across = (2.0f * x / (float)camera->width - 1.0f) * camera->tan_half_width;
  float upward = (1.0f - 2.0f * y / (float)camera->height) * camera->tan_half_height;
  np_vec3 direction = np_vec3_add(np_vec3_scale(camera->right, across), np_vec3_scale(camera->up, upward));
  return np_vec3_normalize(np_vec3_subtract(direction, camera->back));
}

/* ---- What is seen ---- */

/* A plane adds one corner to a polygon that is convex, and half as many as there are to one that rounding has bent. */
enum { FACE_CORNERS = 4, PLANES = 4, POLYGON_CORNERS = 20 };

/* A convex polygon in camera space: x to the right, y up, z along the view. */
typedef struct polygon {
  int count;
  np_dvec3 corner[POLYGON_CORNERS];
} polygon;

/* Above 0 on the picture's side of one of the four planes that bound it. */
static double get_side(const np_camera *camera, int plane, np_dvec3 p) {
  const double extent = (double)(plane < 2 ? camera->tan_half_width : camera->tan_half_height) * p.z;
  const double at = plane < 2 ? p.x : p.y;
  return plane % 2 ? extent - at : extent + at;
}

/* Cuts off what is beyond a plane (Sutherland and Hodgman 1974). */
static polygon clip(const np_camera *camera, int plane, const polygon *in) {
  polygon out = {0};
  for (int i = 0; i < in->count; i++) {
    const np_dvec3 from = in->corner[i], to = in->corner[(i + 1) % in->count];
    const double side = get_side(camera, plane, from), next = get_side(camera, plane, to);
    if (side >= 0.0) out.corner[out.count++] = from;
    if ((side > 0.0 && next < 0.0) || (side < 0.0 && next > 0.0))
      out.corner[out.count++] = np_dvec3_add(from, np_dvec3_scale(np_dvec3_subtract(to, from), side / (side - next)));
  }
  return out;
}

static np_dvec3 to_camera_space(const np_camera *camera, np_dvec3 p) {
  const np_dvec3 d = np_dvec3_subtract(p, camera->origin), right = np_vec3_to_double(camera->right),
                 up = np_vec3_to_double(camera->up), back = np_vec3_to_double(camera->back);
  return np_dvec3_make(np_dvec3_dot(d, right), np_dvec3_dot(d, up), -np_dvec3_dot(d, back));
}

/* The face of a box across an axis, on its low or its high side. */
static bool is_face_seen(const np_camera *camera, const double box[2][3], int axis, int side) {
  polygon face = {.count = FACE_CORNERS};
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (int i = 0; i < FACE_CORNERS; i++) {
    double at[3];
    at[axis] = box[side][axis];
    at[u] = box[i == 1 || i == 2][u];
    at[v] = box[i >= 2][v];
    face.corner[i] = to_camera_space(camera, np_dvec3_make(at[0], at[1], at[2]));
  }
  for (int plane = 0; plane < PLANES; plane++) face = clip(camera, plane, &face);
  return face.count > 0;
}

/* The view has no end: a box that it meets is met in a face, from outside and from within. */
bool np_camera_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high) {
  const double box[2][3] = {{low.x, low.y, low.z}, {high.x, high.y, high.z}};
  for (int face = 0; face < 6; face++)
    if (is_face_seen(camera, box, face / 2, face % 2)) return true;
  return false;
}

/* ---- For the file's header ---- */

/* OpenEXR (ImfStandardAttributes.h) wants a left-handed camera space: x right, y up, z along the view. NDC runs from
 * (0, 0) at the upper left to (1, 1) at the lower right of the display window; z is left as it is, w is the depth. */
void np_camera_get_matrices(const np_camera *camera, float out_world_to_camera[16], float out_world_to_ndc[16]) {
  const np_vec3 axes[3] = {camera->right, camera->up, np_vec3_scale(camera->back, -1.0f)};
  double to_camera[4][4] = {{0}};
  for (int column = 0; column < 3; column++) {
    np_dvec3 axis = np_vec3_to_double(axes[column]);
    to_camera[0][column] = axis.x;
    to_camera[1][column] = axis.y;
    to_camera[2][column] = axis.z;
    to_camera[3][column] = -np_dvec3_dot(camera->origin, axis);
  }
  to_camera[3][3] = 1;
  for (int row = 0; row < 4; row++) {
    const double *p = to_camera[row];
    const float ndc[4] = {(float)(0.5 * (p[0] / (double)camera->tan_half_width + p[2])),
                          (float)(0.5 * (p[2] - p[1] / (double)camera->tan_half_height)), (float)p[2], (float)p[2]};
    for (int column = 0; column < 4; column++) {
      out_world_to_camera[4 * row + column] = (float)p[column];
      out_world_to_ndc[4 * row + column] = ndc[column];
    }
  }
}
