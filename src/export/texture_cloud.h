/* SPDX-License-Identifier: Apache-2.0 */
/* Textures of one baked cloud. */
#ifndef NP_EXPORT_TEXTURE_CLOUD_H
#define NP_EXPORT_TEXTURE_CLOUD_H

#include "cloud/bake_field.h"
#include "export/texture_set.h"
#include "stages/cloud_bake.h"

/* A cloud on a dense lattice, a margin of one clear voxel around it. */
typedef struct np_texture_lattice {
  unsigned size[3];
  double edge_m[3];   /* edges of a voxel in the world */
  np_affine to_world; /* texture coordinates to the world */
  float greatest;     /* greatest extinction, 1/m; 0: the cloud is empty */
  float *extinction;  /* 1/m, x fastest */
} np_texture_lattice;

typedef struct np_texture_cloud {
  np_texture_set *set;
  const neph_scene *scene; /* the scene in its frame */
  const np_scene_cloud *cloud;
  np_cloud_in_frame in_frame;
  np_affine bake_to_world;  /* scale, rotation and position in the scene, relative to the bake's own position */
  double extinction_factor; /* extinction in the scene relative to the bake's */
  np_texture_lattice lattice;
} np_texture_cloud;

/* Adds one texture, its name the cloud's with `.ending`, and the cloud's own facts in its entry. */
neph_result np_texture_cloud_add_one(const np_texture_cloud *cloud, const char *ending, np_texture *texture);

/* Prepares the model of the cloud for one cloud type, or its own model for a negative type. np_bake_end frees it. */
neph_result np_texture_cloud_start_model(const np_texture_cloud *cloud, double type, np_bake *out_bake);

/* Bakes the lattice, and sets the cloud's place. */
neph_result np_texture_lattice_make(np_texture_cloud *cloud);

/* Add textures to the set. In a dry run there is no lattice. */
neph_result np_texture_weather_add(const np_texture_cloud *cloud);
neph_result np_texture_profile_add(const np_texture_cloud *cloud);
neph_result np_texture_distance_add(const np_texture_cloud *cloud);
neph_result np_texture_depth_add(const np_texture_cloud *cloud);

/* A column of a model: its lowest and highest height with cloud, in metres above the base. */
typedef struct np_texture_column {
  bool has_cloud;
  float base_m, top_m;
} np_texture_column;

/* Searches a column of the field for cloud. */
np_texture_column np_texture_column_measure(const np_cloud_model *model, float x_m, float y_m);

#endif
