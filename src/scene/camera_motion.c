/* SPDX-License-Identifier: Apache-2.0 */
/* Converts a camera file to tracks, linear between its frames. glTF files are read by mesh/camera_file.c.
 *
 * Nuke's .chan has lines "frame tx ty tz rx ry rz [vfov]", in degrees, without a header. A CSV names its columns:
 * frame, x, y, z, then rx, ry, rz or look_x, look_y, look_z and roll, then fov or vfov. The camera looks along its -z,
 * with +y up. With `up: y` (Nuke, and files that Blender writes for it) x is east, y up, -z north; with `up: z` the
 * axes are the scene's. Rotations are about fixed axes, in the order named by `order`: "zxy" is first about z, then x,
 * then y, the default of Nuke's camera. */
#include "scene/camera_motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/csv.h"
#include "core/file.h"
#include "core/text.h"
#include "core/units.h"
#include "mesh/camera_file.h"
#include "scene/scene_edit.h"
#include "scene/scene_keys.h"

/* Distance of look_at along the view direction. */
static const double target_m = 1000.0;

enum { CHAN_FIELDS = 8 };

/* A camera pose in one frame of a file. */
typedef struct shot_pose {
  double frame;
  np_dvec3 at;
  bool has_target;
  np_dvec3 turn_or_target; /* rotation in degrees about x, y and z; or look_at */
  bool has_axes;
  np_dvec3 forward, up; /* used instead of a rotation or a target */
  double roll_deg;      /* used with a target */
  double fov_deg;       /* 0: none */
  bool is_vertical;     /* fov_deg is vertical */
} shot_pose;

typedef struct shot {
  const neph_scene *scene;
  unsigned count;
  shot_pose *poses;
} shot;

static neph_result fail_line(const shot *s, size_t line, const char *what) {
  return np_fail(s->scene->context, NEPH_ERROR_BAD_FILE, "%s:%zu: %s", s->scene->motion.file, line, what);
}

static shot_pose *add_pose(shot *s) {
  if ((s->count & (s->count - 1)) == 0) { /* doubles the capacity */
    shot_pose *more = np_alloc_resize(s->scene->context, s->poses, s->count ? 2 * s->count : 1, sizeof *more);
    if (!more) return NULL;
    s->poses = more;
  }
  return &s->poses[s->count++];
}

static neph_result check_order(const shot *s, size_t line) {
  if (s->count < 2 || s->poses[s->count - 1].frame > s->poses[s->count - 2].frame) return NEPH_OK;
  return fail_line(s, line, "the frame is not behind that of the line before: frames must rise");
}

/* ---- .chan ---- */

/* Parses the numbers of a line, at most CHAN_FIELDS; −1: the line contains something else. */
static int split_line(const char *line, const char *end, double out[CHAN_FIELDS]) {
  int count = 0;
  for (;;) {
    line += strspn(line, " \t\r");
    if (line >= end) return count;
    char *stop;
    const double value = strtod(line, &stop);
    if (stop == line || stop > end || count == CHAN_FIELDS || !isfinite(value)) return -1;
    out[count++] = value;
    line = stop;
  }
}

static neph_result read_chan_line(shot *s, size_t number, const char *line, const char *end) {
  double v[CHAN_FIELDS] = {0};
  if (line[strspn(line, " \t\r")] == '#') return NEPH_OK;
  const int count = split_line(line, end, v);
  if (count == 0) return NEPH_OK;
  if (count < 7)
    return fail_line(s, number, "a line must have 7 or 8 numbers: frame, position, rotation, and an angle");
  shot_pose *pose = add_pose(s);
  if (!pose) return NEPH_ERROR_OUT_OF_MEMORY;
  *pose = (shot_pose){.frame = v[0],
                      .at = np_dvec3_make(v[1], v[2], v[3]),
                      .turn_or_target = np_dvec3_make(v[4], v[5], v[6]),
                      .fov_deg = v[7],
                      .is_vertical = true};
  return check_order(s, number);
}

static neph_result read_chan(shot *s) {
  void *bytes;
  size_t size, number = 1;
  neph_result result = np_file_read(s->scene->context, s->scene->motion.file, &bytes, &size);
  if (result) return result;
  for (const char *line = bytes; !result && *line; number++) {
    const char *end = line + strcspn(line, "\n");
    result = read_chan_line(s, number, line, end);
    line = *end ? end + 1 : end;
  }
  np_alloc_free(s->scene->context, bytes);
  return result;
}

/* ---- CSV ---- */

enum { FRAME, X, Y, Z, RX, RY, RZ, LOOK_X, LOOK_Y, LOOK_Z, ROLL, FOV, VFOV, COLUMNS };
static const char *const names[COLUMNS] = {"frame",  "x",      "y",      "z",    "rx",  "ry",  "rz",
                                           "look_x", "look_y", "look_z", "roll", "fov", "vfov"};

static neph_result read_row(shot *s, const np_csv *csv, size_t row, const int columns[COLUMNS]) {
  double v[COLUMNS] = {0};
  neph_result result = NEPH_OK;
  for (int i = 0; i < COLUMNS && !result; i++)
    if (columns[i] != NP_CSV_NO_COLUMN) result = np_csv_get_real(csv, row, columns[i], -1e9, 1e9, &v[i]);
  shot_pose *pose = result ? NULL : add_pose(s);
  if (!pose) return result ? result : NEPH_ERROR_OUT_OF_MEMORY;
  const bool has_target = columns[LOOK_X] != NP_CSV_NO_COLUMN;
  const int turn = has_target ? LOOK_X : RX;
  *pose = (shot_pose){.frame = v[FRAME],
                      .at = np_dvec3_make(v[X], v[Y], v[Z]),
                      .has_target = has_target,
                      .turn_or_target = np_dvec3_make(v[turn], v[turn + 1], v[turn + 2]),
                      .roll_deg = v[ROLL],
                      .is_vertical = columns[FOV] == NP_CSV_NO_COLUMN};
  pose->fov_deg = pose->is_vertical ? v[VFOV] : v[FOV];
  return check_order(s, csv->rows[row].line);
}

static neph_result read_csv(shot *s) {
  np_csv csv;
  int columns[COLUMNS];
  neph_result result = np_csv_load(s->scene->context, s->scene->motion.file, &csv);
  if (result) return result;
  const bool has_target = np_csv_search_column(&csv, names[LOOK_X]) != NP_CSV_NO_COLUMN;
  const unsigned needed = 1u << FRAME | 7u << X | 7u << (has_target ? LOOK_X : RX);
  result = np_csv_search_columns(&csv, names, COLUMNS, needed, columns);
  for (size_t row = 0; row < csv.row_count && !result; row++) result = read_row(s, &csv, row, columns);
  np_csv_clear(&csv);
  return result;
}

/* ---- glTF ---- */

static neph_result read_gltf(shot *s) {
  const np_scene_motion *motion = &s->scene->motion;
  np_camera_file file;
  neph_result result =
      np_camera_file_load(s->scene->context, motion->file, motion->camera, s->scene->frame_rate, &file);
  for (size_t i = 0; i < file.count && !result; i++) {
    const np_camera_pose *from = &file.poses[i];
    shot_pose *pose = add_pose(s);
    if (!pose) result = NEPH_ERROR_OUT_OF_MEMORY;
    if (pose)
      *pose = (shot_pose){.frame = from->frame,
                          .at = from->at,
                          .has_axes = true,
                          .forward = from->forward,
                          .up = from->up,
                          .fov_deg = file.vertical_fov_rad / NP_DEGREE,
                          .is_vertical = true};
  }
  np_camera_file_clear(&file);
  return result;
}

/* ---- File kinds ---- */

static const struct {
  const char *ending;
  neph_result (*read)(shot *s);
} kinds[] = {{".chan", read_chan}, {".csv", read_csv}, {".gltf", read_gltf}, {".glb", read_gltf}};

/* Reads a camera file; any other extension is read as .chan, which has no header. */
static neph_result read_file(shot *s) {
  const char *dot = strrchr(s->scene->motion.file, '.');
  size_t kind = 0;
  for (size_t i = 1; dot && i < sizeof kinds / sizeof *kinds; i++)
    if (!strcasecmp(dot, kinds[i].ending)) kind = i;
  return kinds[kind].read(s);
}

/* ---- Conversion to the scene ---- */

static np_dvec3 turn_axes(const np_scene_motion *motion, np_dvec3 v) {
  return motion->is_z_up ? v : np_dvec3_make(v.x, -v.z, v.y);
}

static np_dvec3 rotate(np_dvec3 v, char axis, double rad) {
  const double c = cos(rad), s = sin(rad);
  if (axis == 'x') return np_dvec3_make(v.x, c * v.y - s * v.z, s * v.y + c * v.z);
  if (axis == 'y') return np_dvec3_make(c * v.x + s * v.z, v.y, c * v.z - s * v.x);
  return np_dvec3_make(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
}

/* Rotates a direction of the camera to the world of its file. */
static np_dvec3 rotate_all(const np_scene_motion *motion, np_dvec3 degrees, np_dvec3 v) {
  static const char *const orders[] = {"zxy", "xyz", "xzy", "yxz", "yzx", "zyx"};
  const double angle[3] = {degrees.x * NP_DEGREE, degrees.y * NP_DEGREE, degrees.z * NP_DEGREE};
  for (const char *axis = orders[motion->order]; *axis; axis++) v = rotate(v, *axis, angle[*axis - 'x']);
  return v;
}

/* Roll, clockwise from level. For a vertical view the top of a level picture is south or north. */
static double compute_roll(np_dvec3 forward, np_dvec3 up) {
  const double level = hypot(forward.x, forward.y);
  const np_dvec3 right =
      level < 1e-9 ? np_dvec3_make(1, 0, 0) : np_dvec3_make(forward.y / level, -forward.x / level, 0);
  return atan2(np_dvec3_dot(up, right), np_dvec3_dot(up, np_dvec3_cross(right, forward)));
}

/* A camera pose as values of scene keys. */
typedef struct shot_keys {
  double position[3], look_at[3], roll, fov;
} shot_keys;

static void set_vector(np_dvec3 v, double out[3]) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }

static shot_keys convert(const neph_scene *scene, const shot_pose *pose) {
  const np_scene_motion *motion = &scene->motion;
  const double aspect = (double)scene->camera.resolution[0] / scene->camera.resolution[1];
  const np_dvec3 at = np_dvec3_scale(turn_axes(motion, pose->at), motion->unit_m);
  shot_keys keys = {.roll = pose->roll_deg * NP_DEGREE, .fov = pose->fov_deg * NP_DEGREE};
  set_vector(at, keys.position);
  if (pose->is_vertical) keys.fov = 2.0 * atan(tan(0.5 * keys.fov) * aspect);
  if (pose->has_target) {
    set_vector(np_dvec3_scale(turn_axes(motion, pose->turn_or_target), motion->unit_m), keys.look_at);
    return keys;
  }
  const np_dvec3 turn = pose->turn_or_target, ahead = np_dvec3_make(0, 0, -1), above = np_dvec3_make(0, 1, 0);
  const np_dvec3 forward = turn_axes(motion, pose->has_axes ? pose->forward : rotate_all(motion, turn, ahead));
  const np_dvec3 up = turn_axes(motion, pose->has_axes ? pose->up : rotate_all(motion, turn, above));
  set_vector(np_dvec3_add(at, np_dvec3_scale(forward, target_m)), keys.look_at);
  keys.roll = compute_roll(forward, up);
  return keys;
}

/* ---- Tracks ---- */

/* Adds full turns to an angle to bring it nearest to the previous one. */
static double unwind(double angle, double before) {
  return angle + 2.0 * NP_PI * round((before - angle) / (2.0 * NP_PI));
}

static void put_values(np_track *track, unsigned at, const double *values) {
  memcpy(&track->values[at * track->value_count], values, track->value_count * sizeof *values);
}

static bool is_given(const neph_scene *scene, const char *path) {
  const np_node *source = np_scene_get_source(scene);
  return np_scene_get_node(source, path) ||
         (!strcmp(path, "camera.fov") && np_scene_get_node(source, "camera.focal_length"));
}

enum { POSITION, LOOK_AT, TRACK_ROLL, TRACK_FOV, TRACKS };

static neph_result fill_tracks(const shot *s, np_track tracks[TRACKS]) {
  static const char *const paths[TRACKS] = {"camera.position", "camera.look_at", "camera.roll", "camera.fov"};
  neph_result result = NEPH_OK;
  for (int i = 0; i < TRACKS && !result; i++) {
    const np_key *key = np_key_search_path(paths[i]);
    tracks[i] = (np_track){.key = key, .component = NP_TRACK_ALL, .interpolation = NP_INTERPOLATION_LINEAR};
    np_print(tracks[i].path, sizeof tracks[i].path, "%s", paths[i]);
    tracks[i].value_count = np_key_count_values(key);
    result = np_track_alloc(s->scene->context, &tracks[i], s->count);
  }
  double roll = 0.0;
  for (unsigned k = 0; k < s->count && !result; k++) {
    const shot_keys keys = convert(s->scene, &s->poses[k]);
    roll = unwind(keys.roll, roll);
    for (int i = 0; i < TRACKS; i++) tracks[i].frames[k] = s->poses[k].frame + s->scene->motion.first_frame;
    put_values(&tracks[POSITION], k, keys.position);
    put_values(&tracks[LOOK_AT], k, keys.look_at);
    put_values(&tracks[TRACK_ROLL], k, &roll);
    put_values(&tracks[TRACK_FOV], k, &keys.fov);
  }
  return result;
}

static bool has_angles(const shot *s) {
  for (unsigned k = 0; k < s->count; k++)
    if (!(s->poses[k].fov_deg > 0.0 && s->poses[k].fov_deg < 170.0)) return false;
  return true;
}

/* Keeps the tracks of keys that the scene does not set, and clears the others. */
static unsigned choose_tracks(const shot *s, np_track tracks[TRACKS]) {
  unsigned count = 0;
  for (int i = 0; i < TRACKS; i++) {
    if (is_given(s->scene, tracks[i].path) || (i == TRACK_FOV && !has_angles(s)))
      np_track_clear(s->scene->context, &tracks[i]);
    else
      tracks[count++] = tracks[i];
  }
  return count;
}

neph_result np_camera_motion_load(const neph_scene *scene, np_animation *animation) {
  shot s = {.scene = scene};
  np_track tracks[TRACKS] = {{.key = NULL}};
  const char *file = scene->motion.file;
  locale_t saved = np_values_enter();
  neph_result result = read_file(&s);
  np_values_leave(saved);
  if (!result && s.count == 0)
    result = np_fail(scene->context, NEPH_ERROR_BAD_FILE, "%s: it has no frame, must have at least one", file);
  if (!result) result = fill_tracks(&s, tracks);
  const unsigned count = result ? 0 : choose_tracks(&s, tracks);
  if (!result) result = np_animation_put_first(scene->context, animation, count, tracks);
  for (int i = 0; result && i < TRACKS; i++) np_track_clear(scene->context, &tracks[i]);
  np_alloc_free(scene->context, s.poses);
  return result;
}
