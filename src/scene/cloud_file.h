/* SPDX-License-Identifier: Apache-2.0 */
/* The files of a cloud, frame by frame. */
#ifndef NP_SCENE_CLOUD_FILE_H
#define NP_SCENE_CLOUD_FILE_H

#include "core/hash.h"
#include "scene/scene_private.h"
#include "volume/volume_facts.h"

typedef struct np_cloud_file {
  char *path;    /* owned; NULL: the sequence has no file for this frame, and the cloud is empty */
  double number; /* number of the file in its sequence */
} np_cloud_file;

/* Gets the file of a cloud in a frame. A sequence applies frame_offset and frame_speed and, for a missing file,
 * `missing`. With `missing: error` the path is returned even if there is no file, and so it is for a sequence without
 * any files. */
neph_result np_cloud_file_get(neph_context *context, const np_scene_cloud *cloud, int frame, np_cloud_file *out_file);

/* Load description of a cloud's density, from its keys. */
neph_volume_load_desc np_cloud_file_describe_load(const np_scene_cloud *cloud);

/* Pattern of a cloud's sequence of files; NULL: it has one file. */
const char *np_cloud_file_get_sequence(const np_scene_cloud *cloud);

/* Grids of a cloud's file that the scene uses. */
np_file_use np_cloud_file_describe_use(const neph_scene *scene, const np_scene_cloud *cloud);

/* Adds the keys that control reading, scaling and orientation of a file to a cache key. */
void np_cloud_file_add_to_hash(np_hash *hash, const np_scene_cloud *cloud);

/* Adds the keys of clouds[].netcdf, and the time step of the scene's frame. */
void np_cloud_file_add_model_to_hash(np_hash *hash, const np_scene_cloud *cloud);

/* Adds to a hash the keys of np_cloud_file_add_to_hash and the keys that place a cloud and scale its density. */
void np_cloud_file_add_placement_to_hash(np_hash *hash, const np_scene_cloud *cloud);

/* Warns of a frame without a file. */
void np_cloud_file_warn(neph_context *context, const np_scene_cloud *cloud, int frame, const np_cloud_file *file);

#endif
