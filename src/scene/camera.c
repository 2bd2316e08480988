/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras: rays for film positions.
 *
 * A camera looks along −back; `right` and `up` span the picture. Directions depend on these axes alone, never on world
 * positions, which keeps precision everywhere in the world. A perspective camera with an aperture is a thin lens: all
 * rays of a film position meet in the plane of focus, and leave the lens within the aperture. An equirectangular
 * picture stays level for any view direction: only its centre follows the azimuth. */
#include "scene/camera.h"

#include "core/units.h"

/* ---- Axes ---- */

/* Unit vector from look_at to position; np_scene_check has verified that they differ. */
static np_dvec3 compute_back(const np_scene_camera *camera) {
  const double *p = camera->position_m, *q = camera->look_at_m;
  return np_dvec3_normalize(np_dvec3_make(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
}

/* Horizontal unit vector to the right. For a vertical view, which has none, the top of the picture is north (looking
 * down) or south (looking up), as for a camera that was facing north and then tilted. */
static np_dvec3 compute_level_right(np_dvec3 back) {
  double horizontal = hypot(back.x, back.y);
  if (horizontal < 1e-9) return np_dvec3_make(1, 0, 0);
  return np_dvec3_make(-back.y / horizontal, back.x / horizontal, 0);
}

static void set_frame(const np_scene_camera *camera, np_camera *out) {
  np_dvec3 back = compute_back(camera), level_right = compute_level_right(back);
  if (camera->kind == NEPH_CAMERA_EQUIRECTANGULAR) back = np_dvec3_cross(level_right, np_dvec3_make(0, 0, 1));
  np_dvec3 level_up = np_dvec3_cross(back, level_right);
  const double roll = camera->kind == NEPH_CAMERA_EQUIRECTANGULAR ? 0.0 : camera->roll_rad;
  double c = cos(roll), s = sin(roll);
  np_dvec3 right = np_dvec3_subtract(np_dvec3_scale(level_right, c), np_dvec3_scale(level_up, s));
  np_dvec3 up = np_dvec3_add(np_dvec3_scale(level_right, s), np_dvec3_scale(level_up, c));
  out->origin = np_dvec3_make(camera->position_m[0], camera->position_m[1], camera->position_m[2]);
  out->right = np_dvec3_to_float(right);
  out->up = np_dvec3_to_float(up);
  out->back = np_dvec3_to_float(back);
}

/* ---- Initialisation ---- */

/* Sets the frustum of a perspective camera, and its lens. */
static void set_perspective(const np_scene_camera *camera, np_camera *out) {
  const double tan_half_width = tan(0.5 * np_scene_camera_get_fov_rad(camera));
  out->tan_half_width = (float)tan_half_width;
  out->tan_half_height = (float)(tan_half_width * out->height / out->width);
  for (int a = 0; a < 2; a++) out->shift[a] = (float)(2.0 * tan_half_width * camera->shift[a]);
  if (!camera->has_lens) return;
  const double focus = camera->focus_distance_m;
  out->lens_radius_m = (float)(0.5 * np_scene_camera_get_focal_length_m(camera) / camera->f_stop);
  out->focus_m = (float)(isfinite(focus) ? focus : np_scene_camera_get_target_m(camera));
  out->blade_count = camera->blade_count;
}

static void set_orthographic(const np_scene_camera *camera, np_camera *out) {
  out->half_width_m = (float)(0.5 * camera->orthographic_width_m);
  out->half_height_m = (float)(0.5 * camera->orthographic_width_m * out->height / out->width);
  for (int a = 0; a < 2; a++) out->shift[a] = (float)(camera->orthographic_width_m * camera->shift[a]);
}

/* Moves the camera to an eye. Both eyes look straight ahead; their pictures are shifted to coincide at the convergence
 * distance. */
static void set_eye(const np_scene_camera *camera, neph_eye eye, np_camera *out) {
  if (!camera->is_stereo || eye == NEPH_EYE_CENTRE) return;
  const double aside = (eye == NEPH_EYE_LEFT ? -0.5 : 0.5) * camera->interaxial_m;
  const double convergence =
      isfinite(camera->convergence_m) ? camera->convergence_m : np_scene_camera_get_target_m(camera);
  out->origin = np_dvec3_along(out->origin, out->right, aside);
  out->shift[0] -= (float)(aside / convergence);
}

neph_result np_camera_init(const neph_scene *scene, unsigned width, unsigned height, neph_eye eye,
                           np_camera *out_camera) {
  return np_camera_make(scene->context, &scene->camera, width, height, eye, out_camera);
}

neph_result np_camera_make(neph_context *context, const np_scene_camera *camera, unsigned width, unsigned height,
                           neph_eye eye, np_camera *out_camera) {
  if (width < 1 || height < 1 || width > 65536 || height > 65536)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "the picture is %u x %u pixels, must be 1 to 65536 each way",
                   width, height);
  *out_camera = (np_camera){.row = np_camera_get_row(camera->kind),
                            .kind = camera->kind,
                            .near_m = camera->near_m,
                            .far_m = camera->far_m,
                            .width = width,
                            .height = height};
  set_frame(camera, out_camera);
  if (camera->kind == NEPH_CAMERA_PERSPECTIVE) set_perspective(camera, out_camera);
  if (camera->kind == NEPH_CAMERA_ORTHOGRAPHIC) set_orthographic(camera, out_camera);
  out_camera->half_angle = (float)(0.5 * camera->fisheye_fov_rad);
  out_camera->radius = 0.5f * (float)(width < height ? width : height);
  set_eye(camera, eye, out_camera);
  return NEPH_OK;
}

/* ---- Rays ---- */

/* Uniform point on a disk (Shirley and Chiu 1997, "A Low Distortion Map between Disk and Square"). */
static void sample_disk(float u, float v, float out[2]) {
  const float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f;
  const bool is_wide = fabsf(a) > fabsf(b);
  const float r = is_wide ? a : b, other = is_wide ? b : a;
  const float angle = r == 0.0f ? 0.0f : 0.25f * NP_PI_F * (other / r);
  out[0] = r * (is_wide ? cosf(angle) : sinf(angle));
  out[1] = r * (is_wide ? sinf(angle) : cosf(angle));
}

/* Uniform point on a regular polygon whose first corner is up: chooses one of its triangles around the centre, then a
 * point in it. */
static void sample_polygon(unsigned corners, float u, float v, float out[2]) {
  const float turn = u * (float)corners, first = floorf(turn), part = turn - first, r = sqrtf(v);
  const float step = 2.0f * NP_PI_F / (float)corners, a = first * step, b = a + step;
  out[0] = r * ((1.0f - part) * sinf(a) + part * sinf(b));
  out[1] = r * ((1.0f - part) * cosf(a) + part * cosf(b));
}

void np_camera_sample_aperture(const np_camera *camera, float u, float v, float out[2]) {
  if (camera->blade_count)
    sample_polygon(camera->blade_count, u, v, out);
  else
    sample_disk(u, v, out);
}

/* Moves the origin of a ray from the lens centre to a point of the lens, keeping its point in focus. */
static void sample_lens(const np_camera *camera, float u, float v, np_film_ray *ray) {
  float at[2];
  np_camera_sample_aperture(camera, u, v, at);
  const np_vec3 offset = np_vec3_add(np_vec3_scale(camera->right, camera->lens_radius_m * at[0]),
                                     np_vec3_scale(camera->up, camera->lens_radius_m * at[1]));
  const float reach = -camera->focus_m / np_vec3_dot(ray->direction, camera->back);
  ray->origin = np_dvec3_add(ray->origin, np_vec3_to_double(offset));
  ray->direction = np_vec3_normalize(np_vec3_subtract(np_vec3_scale(ray->direction, reach), offset));
}

bool np_camera_start_ray(const np_camera *camera, float x, float y, float u, float v, np_film_ray *out_ray) {
  *out_ray = (np_film_ray){.origin = camera->origin, .direction = np_vec3_scale(camera->back, -1.0f)};
  if (!camera->row->start(camera, x, y, &out_ray->origin, &out_ray->direction)) return false;
  if (camera->lens_radius_m > 0.0f) sample_lens(camera, u, v, out_ray);
  const double depth = np_camera_get_depth(camera, out_ray->direction, 1.0);
  out_ray->near_m = camera->near_m / depth;
  out_ray->far_m = camera->far_m / depth;
  return true;
}

double np_camera_get_depth(const np_camera *camera, np_vec3 direction, double distance_m) {
  if (isinf(distance_m) || !camera->row->is_flat) return distance_m;
  return -distance_m * (double)np_vec3_dot(direction, camera->back);
}

double np_camera_get_confusion(const np_camera *camera, double depth_m) {
  const double pixels_per_tangent = 0.5 * camera->width / (double)camera->tan_half_width;
  if (!(camera->lens_radius_m > 0.0f)) return 0.0;
  return 2.0 * (double)camera->lens_radius_m * fabs(1.0 / (double)camera->focus_m - 1.0 / depth_m) * pixels_per_tangent;
}
