/* SPDX-License-Identifier: Apache-2.0 */
/* The kinds of camera: film positions to rays, and back.
 *
 * perspective a plane in front of the eye: tangents are linear in pixels
 *
 * orthographic parallel rays from a plane through the eye
 *
 * equirectangular longitude and latitude are linear in pixels; the whole sphere
 *
 * fisheye equidistant: the angle from the view axis is linear in the distance from the picture's centre */
#include "scene/camera_kinds.h"

#include "core/units.h"
#include "scene/camera_boxes.h"

/* World vector from components along right, up and the view axis. */
static np_vec3 combine(const np_camera *camera, float right, float up, float ahead) {
  const np_vec3 across = np_vec3_add(np_vec3_scale(camera->right, right), np_vec3_scale(camera->up, up));
  return np_vec3_subtract(across, np_vec3_scale(camera->back, ahead));
}

/* −1 at the left or bottom edge, 1 at the opposite one. */
static float get_across(const np_camera *camera, float x) { return 2.0f * x / (float)camera->width - 1.0f; }
static float get_upward(const np_camera *camera, float y) { return 1.0f - 2.0f * y / (float)camera->height; }

static void set_film(const np_camera *camera, double across, double upward, double out_film[2]) {
  out_film[0] = 0.5 * (1.0 + across) * camera->width;
  out_film[1] = 0.5 * (1.0 - upward) * camera->height;
}

/* ---- Perspective ---- */

static bool start_perspective(const np_camera *camera, float x, float y, np_dvec3 *origin, np_vec3 *out_direction) {
  (void)origin;
  const float across = get_across(camera, x) * camera->tan_half_width + camera->shift[0];
  const float upward = get_upward(camera, y) * camera->tan_half_height + camera->shift[1];
  np_vec3 direction = np_vec3_add(np_vec3_scale(camera->right, across), np_vec3_scale(camera->up, upward));
  *out_direction = np_vec3_normalize(np_vec3_subtract(direction, camera->back));
  return true;
}

static bool project_perspective(const np_camera *camera, np_dvec3 p, bool is_infinite, double out_film[2]) {
  (void)is_infinite;
  if (p.z <= 1e-6 * np_dvec3_length(p)) return false;
  set_film(camera, (p.x / p.z - (double)camera->shift[0]) / (double)camera->tan_half_width,
           (p.y / p.z - (double)camera->shift[1]) / (double)camera->tan_half_height, out_film);
  return true;
}

/* Pixels lie on a plane: their solid angle falls with the cube of the cosine. */
static double get_perspective_sr(const np_camera *camera, int x, int y) {
  np_vec3 direction;
  (void)np_camera_get_direction(camera, (float)x + 0.5f, (float)y + 0.5f, &direction);
  const double cosine = -(double)np_vec3_dot(direction, camera->back);
  return 4.0 * (double)camera->tan_half_width * (double)camera->tan_half_height * cosine * cosine * cosine /
         ((double)camera->width * camera->height);
}

static void fill_perspective_ndc(const np_camera *camera, const double p[4], float out[4]) {
  const double width = (double)camera->tan_half_width, height = (double)camera->tan_half_height;
  out[0] = (float)(0.5 * (p[0] / width + p[2] * (1.0 - (double)camera->shift[0] / width)));
  out[1] = (float)(0.5 * (p[2] * (1.0 + (double)camera->shift[1] / height) - p[1] / height));
  out[2] = out[3] = (float)p[2];
}

/* ---- Orthographic ---- */

static bool start_orthographic(const np_camera *camera, float x, float y, np_dvec3 *origin, np_vec3 *out_direction) {
  const float across = get_across(camera, x) * camera->half_width_m + camera->shift[0];
  const float upward = get_upward(camera, y) * camera->half_height_m + camera->shift[1];
  *origin = np_dvec3_add(*origin, np_vec3_to_double(combine(camera, across, upward, 0.0f)));
  *out_direction = np_vec3_scale(camera->back, -1.0f);
  return true;
}

static bool project_orthographic(const np_camera *camera, np_dvec3 p, bool is_infinite, double out_film[2]) {
  if (is_infinite || p.z < 0.0) return false;
  set_film(camera, (p.x - (double)camera->shift[0]) / (double)camera->half_width_m,
           (p.y - (double)camera->shift[1]) / (double)camera->half_height_m, out_film);
  return true;
}

static double get_no_sr(const np_camera *camera, int x, int y) {
  (void)camera, (void)x, (void)y;
  return 0.0;
}

static void fill_orthographic_ndc(const np_camera *camera, const double p[4], float out[4]) {
  const double width = (double)camera->half_width_m, height = (double)camera->half_height_m;
  out[0] = (float)(0.5 * (p[0] / width + p[3] * (1.0 - (double)camera->shift[0] / width)));
  out[1] = (float)(0.5 * (p[3] * (1.0 + (double)camera->shift[1] / height) - p[1] / height));
  out[2] = (float)p[2];
  out[3] = (float)p[3];
}

/* ---- Equirectangular ---- */

static bool start_equirectangular(const np_camera *camera, float x, float y, np_dvec3 *origin, np_vec3 *out_direction) {
  (void)origin;
  const float longitude = NP_PI_F * get_across(camera, x), latitude = 0.5f * NP_PI_F * get_upward(camera, y);
  const float level = cosf(latitude);
  *out_direction = np_vec3_normalize(combine(camera, level * sinf(longitude), sinf(latitude), level * cosf(longitude)));
  return true;
}

static bool project_equirectangular(const np_camera *camera, np_dvec3 p, bool is_infinite, double out_film[2]) {
  (void)is_infinite;
  set_film(camera, atan2(p.x, p.z) / NP_PI, 2.0 * atan2(p.y, hypot(p.x, p.z)) / NP_PI, out_film);
  return true;
}

static double get_equirectangular_sr(const np_camera *camera, int x, int y) {
  (void)x;
  const double height = camera->height;
  return 2.0 * NP_PI / camera->width * (cos(NP_PI * y / height) - cos(NP_PI * (y + 1.0) / height));
}

/* ---- Fisheye ---- */

static bool start_fisheye(const np_camera *camera, float x, float y, np_dvec3 *origin, np_vec3 *out_direction) {
  (void)origin;
  const float across = (x - 0.5f * (float)camera->width) / camera->radius;
  const float upward = (0.5f * (float)camera->height - y) / camera->radius;
  const float r = sqrtf(across * across + upward * upward), angle = r * camera->half_angle;
  const float part = r > 0.0f ? sinf(angle) / r : 0.0f;
  *out_direction = np_vec3_normalize(combine(camera, part * across, part * upward, cosf(angle)));
  return r <= 1.0f;
}

static bool project_fisheye(const np_camera *camera, np_dvec3 p, bool is_infinite, double out_film[2]) {
  (void)is_infinite;
  const double aside = hypot(p.x, p.y), angle = atan2(aside, p.z), r = angle / (double)camera->half_angle;
  if (r > 1.0) return false;
  const double pixels = aside > 0.0 ? r * (double)camera->radius / aside : 0.0;
  out_film[0] = 0.5 * camera->width + pixels * p.x;
  out_film[1] = 0.5 * camera->height - pixels * p.y;
  return true;
}

static double get_fisheye_sr(const np_camera *camera, int x, int y) {
  const double across = x + 0.5 - 0.5 * camera->width, upward = y + 0.5 - 0.5 * camera->height;
  const double step = (double)camera->half_angle / (double)camera->radius, angle = hypot(across, upward) * step;
  if (angle > (double)camera->half_angle) return 0.0;
  return step * step * (angle > 0.0 ? sin(angle) / angle : 1.0);
}

/* ---- Dispatch ---- */

bool np_camera_get_direction(const np_camera *camera, float x, float y, np_vec3 *out_direction) {
  np_dvec3 origin = camera->origin;
  *out_direction = np_vec3_scale(camera->back, -1.0f);
  return camera->row->start(camera, x, y, &origin, out_direction);
}

const np_camera_row *np_camera_get_row(neph_camera_kind kind) {
  static const np_camera_row rows[] = {
      [NEPH_CAMERA_PERSPECTIVE] = {true, start_perspective, project_perspective, get_perspective_sr,
                                   np_camera_perspective_sees_box, fill_perspective_ndc},
      [NEPH_CAMERA_ORTHOGRAPHIC] = {true, start_orthographic, project_orthographic, get_no_sr,
                                    np_camera_orthographic_sees_box, fill_orthographic_ndc},
      [NEPH_CAMERA_EQUIRECTANGULAR] = {false, start_equirectangular, project_equirectangular, get_equirectangular_sr,
                                       np_camera_sphere_sees_box, NULL},
      [NEPH_CAMERA_FISHEYE] = {false, start_fisheye, project_fisheye, get_fisheye_sr, np_camera_fisheye_sees_box, NULL},
  };
  return &rows[kind];
}

static np_dvec3 to_camera_space(const np_camera *camera, np_dvec3 d) {
  const np_dvec3 right = np_vec3_to_double(camera->right), up = np_vec3_to_double(camera->up),
                 back = np_vec3_to_double(camera->back);
  return np_dvec3_make(np_dvec3_dot(d, right), np_dvec3_dot(d, up), -np_dvec3_dot(d, back));
}

bool np_camera_project_direction(const np_camera *camera, np_dvec3 direction, double out_film[2]) {
  return camera->row->project(camera, to_camera_space(camera, direction), true, out_film);
}

bool np_camera_project(const np_camera *camera, np_dvec3 point, double out_film[2], double *out_depth_m) {
  const np_dvec3 p = to_camera_space(camera, np_dvec3_subtract(point, camera->origin));
  *out_depth_m = camera->row->is_flat ? p.z : np_dvec3_length(p);
  return camera->row->project(camera, p, false, out_film);
}

double np_camera_get_pixel_sr(const np_camera *camera, int x, int y) { return camera->row->get_pixel_sr(camera, x, y); }

bool np_camera_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high) {
  return camera->row->sees_box(camera, low, high);
}

/* ---- Header attributes ---- */

/* OpenEXR (ImfStandardAttributes.h) uses a left-handed camera space: x right, y up, z along the view. NDC goes from (0,
 * 0) at the upper left to (1, 1) at the lower right of the display window; z is unchanged, and w is the depth, or 1 for
 * parallel rays. */
bool np_camera_get_matrices(const np_camera *camera, float out_world_to_camera[16], float out_world_to_ndc[16]) {
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
    for (int column = 0; column < 4; column++) out_world_to_camera[4 * row + column] = (float)to_camera[row][column];
    if (camera->row->fill_ndc) camera->row->fill_ndc(camera, to_camera[row], &out_world_to_ndc[4 * row]);
  }
  return camera->row->fill_ndc;
}
