/* SPDX-License-Identifier: Apache-2.0 */
/* Keys of a cloud's shape. */
#include "scene/scene_key_rows.h"

#define CLOUD(member)                                                                                                  \
  { offsetof(np_scene_cloud, member), sizeof(((np_scene_cloud *)0)->member) }

/* clang-format off */
static const np_key keys[] = {
    {.path = "clouds[].bake.shape", .type = NP_KEY_SECTION,
     .meaning = "shape that replaces thermals and carries billows; it is cut off below the base"},
    {.path = "clouds[].bake.shape.spheres", .type = NP_KEY_POINTS, .unit = NP_UNIT_METRE,
     .field = CLOUD(bake.shape.spheres),
     .meaning = "spheres, each [x, y, z, radius]: x and y from the centre of the field, z above the base"},
    {.path = "clouds[].bake.shape.curves", .type = NP_KEY_CURVES, .unit = NP_UNIT_METRE,
     .field = CLOUD(bake.shape.curves),
     .meaning = "curves, each a list of such points: a smooth line through them, with their radii as thickness"},
    {.path = "clouds[].bake.shape.mesh", .type = NP_KEY_SECTION, .tag = CLOUD(has_mesh_shape), .tag_value = true,
     .group = GROUP_SHAPE, .alternative = 1, .meaning = "a closed mesh"},
    {.path = "clouds[].bake.shape.mesh.file", .type = NP_KEY_FILE, .is_input = true,
     .field = CLOUD(bake.shape.mesh_file), .meaning = "glTF, OBJ, PLY, STL, FBX or COLLADA"},
    {.path = "clouds[].bake.shape.mesh.up", .type = NP_KEY_CHOICE, .choices = np_mesh_ups,
     .field = CLOUD(bake.shape.mesh_up), .fallback = "file",
     .meaning = "up axis of the file; file: y for glTF; other formats need y or z"},
    {.path = "clouds[].bake.shape.mesh.unit", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = CLOUD(bake.shape.mesh_unit_m), .tag = CLOUD(bake.shape.has_mesh_unit), .tag_value = true, .range = SIZE,
     .meaning = "length of the file's unit; default: the mesh fills the field, with room for billows"},
    {.path = "clouds[].bake.shape.mesh.rotation", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE,
     .field = CLOUD(bake.shape.mesh_rotation_rad), .range = WITHIN(-360, 360), .fallback = "0 deg",
     .meaning = "rotation about the vertical, counter-clockwise seen from above"},
    {.path = "clouds[].bake.shape.mesh.position", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = CLOUD(bake.shape.mesh_position_m), .range = WITHIN(-1e6, 1e6), .fallback = "0 m, 0 m, 0 m",
     .meaning = "position of the centre of its bottom, relative to the centre of the field's base"},
    {.path = "clouds[].bake.shape.height_map", .type = NP_KEY_SECTION, .tag = CLOUD(has_height_shape),
     .tag_value = true, .group = GROUP_SHAPE, .alternative = 2,
     .meaning = "image of tops: 0 is clear sky, 1 the highest top"},
    {.path = "clouds[].bake.shape.height_map.image", .type = NP_KEY_FILE, .is_input = true,
     .field = CLOUD(bake.shape.height_map), .meaning = "EXR or PNG, north up"},
    {.path = "clouds[].bake.shape.height_map.channel", .type = NP_KEY_TEXT, .field = CLOUD(bake.shape.height_channel),
     .meaning = "channel of the image; default: the first"},
    {.path = "clouds[].bake.shape.height_map.size", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = CLOUD(bake.shape.height_size_m), .tag = CLOUD(bake.shape.has_height_size), .tag_value = true,
     .is_grey_allowed = true, .range = WITHIN(1e-6, 1e7),
     .meaning = "size of the image along x and y, centred on the field; default: the field"},
    {.path = "clouds[].bake.shape.height_map.height", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = CLOUD(bake.shape.height_m), .tag = CLOUD(bake.shape.has_height), .tag_value = true,
     .range = WITHIN(1e-6, 1e5),
     .meaning = "height of a value of 1 above the base; default: the thickness, less room for billows"},
};
/* clang-format on */

const np_key_table np_keys_shape = {keys, sizeof keys / sizeof *keys};
