/* SPDX-License-Identifier: Apache-2.0 */
/* Keys of the camera. */
#include "scene/scene_key_rows.h"

/* Keys that exclude each other. */
enum { GROUP_ANGLE = 1 };

static const np_choice kinds[] = {{"perspective", NEPH_CAMERA_PERSPECTIVE},
                                  {"orthographic", NEPH_CAMERA_ORTHOGRAPHIC},
                                  {"equirectangular", NEPH_CAMERA_EQUIRECTANGULAR},
                                  {"fisheye", NEPH_CAMERA_FISHEYE},
                                  {NULL, 0}};
static const np_choice ups[] = {{"y", 0}, {"z", 1}, {NULL, 0}};
static const np_choice orders[] = {{"zxy", 0}, {"xyz", 1}, {"xzy", 2}, {"yxz", 3}, {"yzx", 4}, {"zyx", 5}, {NULL, 0}};
static const np_choice absences[] = {{"none", 0}, {NULL, 0}};
static const np_choice eyes[] = {
    {"both", NEPH_EYE_CENTRE}, {"left", NEPH_EYE_LEFT}, {"right", NEPH_EYE_RIGHT}, {NULL, 0}};

/* clang-format off */
static const np_key keys[] = {
    {.path = "camera", .type = NP_KEY_SECTION, .meaning = "the camera; x points east, y north, z up"},
    {.path = "camera.kind", .type = NP_KEY_CHOICE, .choices = kinds, .field = SCENE(camera.kind),
     .fallback = "perspective",
     .meaning = "projection; equirectangular: longitude and latitude of the whole sphere; fisheye: an equidistant "
                "circle as high or wide as the picture"},
    {.path = "camera.position", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(camera.position_m),
     .range = ANYWHERE, .fallback = "0 m, -6 km, 400 m",
     .meaning = "x, y, z of the eye, or, for an orthographic camera, of the centre of the plane from which rays start"},
    {.path = "camera.look_at", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(camera.look_at_m),
     .range = ANYWHERE, .fallback = "0 m, 0 m, 1800 m",
     .meaning = "x, y, z of the point at the centre of the picture; an equirectangular picture stays level and uses "
                "its azimuth alone"},
    {.path = "camera.fov", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(camera.fov_rad),
     .tag = SCENE(camera.has_focal_length), .tag_value = false, .group = GROUP_ANGLE, .alternative = 1,
     .range = WITHIN(0.01, 170), .fallback = "50 deg", .meaning = "horizontal angle of view of a perspective camera"},
    {.path = "camera.focal_length", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(camera.focal_length_m), .tag = SCENE(camera.has_focal_length), .tag_value = true,
     .group = GROUP_ANGLE, .alternative = 2, .range = WITHIN(0.0005, 10),
     .meaning = "focal length; with the sensor it determines the angle of view"},
    {.path = "camera.sensor", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(camera.sensor_m),
     .range = WITHIN(0.0005, 10), .fallback = "0.036 m",
     .meaning = "width of the sensor, equal to the width of the picture"},
    {.path = "camera.orthographic_width", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(camera.orthographic_width_m), .range = WITHIN(0.001, 1e9), .fallback = "10 km",
     .meaning = "width of an orthographic picture in the world"},
    {.path = "camera.fisheye_fov", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE,
     .field = SCENE(camera.fisheye_fov_rad), .range = WITHIN(0.01, 360), .fallback = "180 deg",
     .meaning = "angle of view across the fisheye's circle"},
    {.path = "camera.shift", .type = NP_KEY_REAL, .field = SCENE(camera.shift), .range = WITHIN(-10, 10),
     .fallback = "0, 0", .meaning = "lens shift to the right and up, in widths of the picture"},
    {.path = "camera.roll", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(camera.roll_rad),
     .range = WITHIN(-360, 360), .fallback = "0 deg",
     .meaning = "clockwise rotation of the camera about its view axis; the picture rotates counter-clockwise"},
    {.path = "camera.near", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(camera.near_m),
     .range = WITHIN(0, 1e9), .fallback = "0 m",
     .meaning = "near clipping depth of clouds and ground, along the view axis, or from the eye in a panorama; "
                "clipped parts still cast shadows"},
    {.path = "camera.far", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(camera.far_m),
     .range = WITHIN(1e-3, 1e9), .fallback = "none", .word = "none", .word_value = INFINITY,
     .meaning = "far clipping depth of clouds and ground"},
    {.path = "camera.f_stop", .type = NP_KEY_REAL, .field = SCENE(camera.f_stop), .range = WITHIN(1e-6, 1e6),
     .fallback = "none", .choices = absences, .tag = SCENE(camera.has_lens), .tag_value = true,
     .meaning = "focal length over the diameter of the aperture, for depth of field; none is a pinhole"},
    {.path = "camera.focus_distance", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(camera.focus_distance_m), .range = WITHIN(0.001, 1e9), .fallback = "auto", .word = "auto",
     .word_value = INFINITY, .meaning = "depth of the plane in focus; auto: the depth of look_at"},
    {.path = "camera.blades", .type = NP_KEY_INTEGER, .field = SCENE(camera.blade_count), .range = WITHIN(3, 32),
     .fallback = "round", .word = "round", .word_value = 0,
     .meaning = "number of aperture blades: corners of the bokeh, the first one up"},
    {.path = "camera.shutter", .type = NP_KEY_REAL, .unit = NP_UNIT_SECOND, .field = SCENE(camera.shutter_s),
     .tag = SCENE(camera.has_shutter), .tag_value = true, .range = WITHIN(1e-6, 1e6),
     .meaning = "exposure time; f_stop, shutter and iso give the photographic exposure"},
    {.path = "camera.iso", .type = NP_KEY_REAL, .field = SCENE(camera.iso), .tag = SCENE(camera.has_iso),
     .tag_value = true, .range = WITHIN(0.1, 1e8), .meaning = "sensitivity of the film, ISO 12232"},
    {.path = "camera.stereo", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(camera.is_stereo),
     .tag = SCENE(camera.is_stereo), .tag_value = true,
     .meaning = "stereo: two parallel eyes side by side, with one picture each"},
    {.path = "camera.stereo.interaxial", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(camera.interaxial_m), .range = WITHIN(1e-6, 1e6), .fallback = "0.065 m",
     .meaning = "distance between the eyes"},
    {.path = "camera.stereo.convergence", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(camera.convergence_m), .range = WITHIN(0.001, 1e9), .fallback = "auto", .word = "auto",
     .word_value = INFINITY,
     .meaning = "depth at which both pictures coincide, by shift; auto: the depth of look_at"},
    {.path = "camera.stereo.eye", .type = NP_KEY_CHOICE, .choices = eyes, .field = SCENE(camera.eye),
     .fallback = "both",
     .meaning = "rendered eye; both: two files, for which %V in output names becomes left and right"},
    {.path = "camera.motion", .type = NP_KEY_SECTION, .tag = SCENE(motion.is_enabled), .tag_value = true,
     .meaning = "position, look_at, roll and fov by frame from a file, except for keys that the scene sets"},
    {.path = "camera.motion.file", .type = NP_KEY_FILE, .is_input = true, .field = SCENE(motion.file),
     .meaning = "glTF (.gltf, .glb), Nuke's .chan, or a .csv with columns frame, x, y, z, and rx, ry, rz or look_x, "
                "look_y, look_z, roll; fov or vfov"},
    {.path = "camera.motion.camera", .type = NP_KEY_TEXT, .field = SCENE(motion.camera),
     .meaning = "name of a camera of a glTF file that has several"},
    {.path = "camera.motion.up", .type = NP_KEY_CHOICE, .choices = ups, .field = SCENE(motion.is_z_up),
     .fallback = "y", .meaning = "up axis of the file; with y, -z is north"},
    {.path = "camera.motion.order", .type = NP_KEY_CHOICE, .choices = orders, .field = SCENE(motion.order),
     .fallback = "zxy",
     .meaning = "order of the file's rotations: zxy is first about z, the default of Nuke's cameras"},
    {.path = "camera.motion.unit", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(motion.unit_m),
     .range = WITHIN(1e-6, 1e6), .fallback = "1 m", .meaning = "length of the file's unit"},
    {.path = "camera.motion.offset", .type = NP_KEY_REAL, .field = SCENE(motion.first_frame),
     .range = WITHIN(-1e6, 1e6), .fallback = "0", .meaning = "offset added to the file's frame numbers"},
    {.path = "camera.motion_blur", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(motion_blur.is_enabled),
     .tag = SCENE(motion_blur.is_enabled), .tag_value = true,
     .meaning = "motion blur of camera and clouds"},
    {.path = "camera.motion_blur.shutter", .type = NP_KEY_REAL, .field = SCENE(motion_blur.shutter),
     .range = WITHIN(1e-6, 16), .fallback = "auto", .word = "auto", .word_value = INFINITY,
     .meaning = "open time of the shutter in frames: 0.5 is a 180 deg shutter; auto: camera.shutter times frame_rate, "
                "or 0.5 unless both are set"},
    {.path = "camera.motion_blur.offset", .type = NP_KEY_REAL, .field = SCENE(motion_blur.offset),
     .range = WITHIN(-16, 16), .fallback = "0",
     .meaning = "frames from the frame's time to the middle of the exposure: 0 is centred on the frame; half the "
                "shutter opens at the frame"},
    {.path = "camera.resolution", .type = NP_KEY_INTEGER, .field = SCENE(camera.resolution), .range = WITHIN(1, 65536),
     .fallback = "960, 540", .meaning = "width and height of the picture in pixels"},
    {.path = "camera.overscan", .type = NP_KEY_INTEGER, .field = SCENE(camera.overscan), .range = WITHIN(0, 8192),
     .fallback = "0",
     .meaning = "pixels rendered beyond each edge of the picture: the data window grows, the display window stays the "
                "same"},
};
/* clang-format on */

const np_key_table np_keys_camera = {keys, sizeof keys / sizeof *keys};
