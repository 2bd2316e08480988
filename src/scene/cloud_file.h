/* SPDX-License-Identifier: Apache-2.0 */
/* Files of clouds by frame. */
#ifndef NP_SCENE_CLOUD_FILE_H
#define NP_SCENE_CLOUD_FILE_H

#include "core/hash.h"
#include "scene/scene_private.h"
#include "volume/volume_facts.h"

typedef struct np_cloud_file {
  char *path;    /* owned; NULL: the sequence has no file there, and the frame is empty */
  double number; /* of a sequence */
} np_cloud_file;

/* The file of a cloud that has one, in a frame. Of a sequence it goes by frame_offset and frame_speed and, where the
 * file is not there, by missing. It is not there on return where missing is error, and where the sequence has none. */
neph_result np_cloud_file_get(neph_context *context, const np_scene_cloud *cloud, int frame, np_cloud_file *out_file);

/* Describes by the keys of a cloud how its density is read. */
neph_volume_load_desc np_cloud_file_describe_load(const np_scene_cloud *cloud);

/* Pattern of the files of a cloud that is a sequence; NULL: it has one file. */
const char *np_cloud_file_get_sequence(const np_scene_cloud *cloud);

/* The grids that a scene takes of a cloud's file. */
np_file_use np_cloud_file_describe_use(const neph_scene *scene, const np_scene_cloud *cloud);

/* Adds to a key the keys by which a file is read, scaled and turned upright. */
void np_cloud_file_add_to_hash(np_hash *hash, const np_scene_cloud *cloud);

/* Warns of a frame without a file. */
void np_cloud_file_warn(neph_context *context, const np_scene_cloud *cloud, int frame, const np_cloud_file *file);

#endif
