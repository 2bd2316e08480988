/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/camera_boxes.h"

/* Clipping by a plane adds one corner to a convex polygon, and up to half its number to one bent by rounding. */
enum { FACE_CORNERS = 4, PLANES_MAX = 5, POLYGON_CORNERS = 31 };

/* A convex polygon in camera space: x to the right, y up, z along the view. */
typedef struct polygon {
  int count;
  np_dvec3 corner[POLYGON_CORNERS];
} polygon;

/* Signed distance to one of the planes that bound the picture, positive inside. */
typedef double side_fn(const np_camera *camera, int plane, np_dvec3 p);

/* Volume of space that a picture shows. */
typedef struct view_space {
  const np_camera *camera;
  side_fn *get_side;
  int plane_count;
} view_space;

static double get_perspective_side(const np_camera *camera, int plane, np_dvec3 p) {
  const double extent = (double)(plane < 2 ? camera->tan_half_width : camera->tan_half_height) * p.z;
  const double at = plane < 2 ? p.x - (double)camera->shift[0] * p.z : p.y - (double)camera->shift[1] * p.z;
  return plane % 2 ? extent - at : extent + at;
}

/* The last plane is the film plane, from which rays start. */
static double get_orthographic_side(const np_camera *camera, int plane, np_dvec3 p) {
  if (plane == 4) return p.z;
  const double extent = (double)(plane < 2 ? camera->half_width_m : camera->half_height_m);
  const double at = plane < 2 ? p.x - (double)camera->shift[0] : p.y - (double)camera->shift[1];
  return plane % 2 ? extent - at : extent + at;
}

/* Clips a polygon by a plane (Sutherland and Hodgman 1974). */
static polygon clip(const view_space *space, int plane, const polygon *in) {
  polygon out = {0};
  for (int i = 0; i < in->count; i++) {
    const np_dvec3 from = in->corner[i], to = in->corner[(i + 1) % in->count];
    const double side = space->get_side(space->camera, plane, from), next = space->get_side(space->camera, plane, to);
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

/* Whether the face of a box across an axis, on its low or high side, is visible. */
static bool is_face_seen(const view_space *space, const double box[2][3], int axis, int side) {
  polygon face = {.count = FACE_CORNERS};
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (int i = 0; i < FACE_CORNERS; i++) {
    double at[3];
    at[axis] = box[side][axis];
    at[u] = box[i == 1 || i == 2][u];
    at[v] = box[i >= 2][v];
    face.corner[i] = to_camera_space(space->camera, np_dvec3_make(at[0], at[1], at[2]));
  }
  for (int plane = 0; plane < space->plane_count; plane++) face = clip(space, plane, &face);
  return face.count > 0;
}

/* Whether a box is visible. The space has no far end, so that any box that overlaps it does so with a face. */
static bool is_box_seen(const view_space *space, np_dvec3 low, np_dvec3 high) {
  const double box[2][3] = {{low.x, low.y, low.z}, {high.x, high.y, high.z}};
  for (int face = 0; face < 6; face++)
    if (is_face_seen(space, box, face / 2, face % 2)) return true;
  return false;
}

bool np_camera_perspective_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high) {
  return is_box_seen(&(view_space){camera, get_perspective_side, PLANES_MAX - 1}, low, high);
}

bool np_camera_orthographic_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high) {
  return is_box_seen(&(view_space){camera, get_orthographic_side, PLANES_MAX}, low, high);
}

bool np_camera_sphere_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high) {
  (void)camera, (void)low, (void)high;
  return true;
}

bool np_camera_fisheye_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high) {
  const np_dvec3 middle = to_camera_space(camera, np_dvec3_scale(np_dvec3_add(low, high), 0.5));
  const double radius = 0.5 * np_dvec3_length(np_dvec3_subtract(high, low)), distance = np_dvec3_length(middle);
  if (distance <= radius) return true;
  return atan2(hypot(middle.x, middle.y), middle.z) - asin(radius / distance) <= (double)camera->half_angle;
}
