/* SPDX-License-Identifier: Apache-2.0 */
/* The parts in which stages are built, cleared and reused: functions for the rows of the stage table. */
#ifndef NP_STAGES_STAGE_PART_H
#define NP_STAGES_STAGE_PART_H

#include "core/cache_lock.h"
#include "core/disk_cache.h"
#include "plan/stage_rules.h"
#include "scene/cloud_file.h"
#include "stages/build_job.h"
#include "stages/packet.h"

/* The argument of a row's functions: a part of its stage. They read the results of the stages that their row names, and
 * write the result of the part alone, in the place of its kind. */
typedef struct np_stage_part {
  const neph_scene *scene; /* NULL when parts are cleared, and the four below */
  const np_plan *plan;
  np_monitor *monitor;
  const np_build_job *job;
  np_schedule *schedule; /* shares of a time limit */
  const np_assembly *made;
  unsigned slot;           /* the part's place among those that later pictures reuse */
  np_assembly *picture;    /* place of the result of a part per picture; else NULL, as is each below */
  unsigned cloud;          /* number of the cloud of a part per cloud, … */
  np_cloud_parts *parts;   /* … and place of its result */
  np_light_caches *caches; /* place of the result of a part per light */
  np_packet *packet;       /* place of the result of a part per packet; the packet of a part per light of a packet */
  np_packet_light *light;  /* place of the result of a part per light of a packet */
  void *key;               /* key by which later pictures may reuse the part; NULL: they may not */
} np_stage_part;

typedef neph_result np_stage_build_fn(const np_stage_part *in);

/* Results are cleared whether they were built whole, in part or not at all. */
typedef void np_stage_clear_fn(const np_stage_part *in);

/* Completes a stage whose parts are built, and revises the plan where it has turned out to be less than planned. */
typedef neph_result np_stage_finish_fn(const neph_scene *scene, np_assembly *made, np_plan *plan);

enum { NP_REASON_SIZE = 128 };

/* Keeping of a stage's results on disk, for other processes. */
typedef struct np_stage_disk {
  const char *kind;
  bool has_isa; /* their bits depend on the instruction set */

  /* Adds to a key all that the bits of a result depend on; false: it is not to be kept. */
  bool (*add_key)(const np_stage_part *in, np_hash *key);
  void (*save)(const np_stage_part *in, np_cache_entry *entry); /* the result in its place */
  neph_result (*load)(const np_stage_part *in,
                      np_cache_entry *entry); /* loads it to its place, if the entry is whole */
  const char *state_kind; /* kind of entries of the same key with an unfinished result; NULL: there are none */
} np_stage_disk;

/* Reuse of a stage's results by later pictures. The walk takes them from the stores and gives them back; changes are
 * measured against the key with which a result was built, so that small steps do not add up unseen. */
typedef struct np_stage_reuse {
  np_part_kind kind;
  bool is_of_content; /* any part's result serves any other of equal key */

  /* Creates, as one block, the key of all that the result depends on; leaves it NULL where the result must not be
   * cached. */
  neph_result (*get_key)(const np_stage_part *in, void **out_key);

  /* Adapts a cached result to `in->key`, or fills the reason why it cannot; it was built for `cached_key`. */
  neph_result (*adapt)(const np_stage_part *in, void *cached, const void *cached_key, char out_reason[NP_REASON_SIZE]);

  void *(*exchange)(const np_stage_part *in, void *result); /* puts a result, or NULL, in its place; returns the old */
  np_stage_build_fn *make;                                  /* where none was cached */
  void (*destroy)(void *result);                            /* NULL changes nothing */
  const np_stage_disk *disk;                                /* NULL: kept in memory alone */
} np_stage_reuse;

/* Defines the reuse of a stage whose result is at `place` of its part, by the functions get_NAME_key and make_NAME. */
#define NP_STAGE_REUSE(name, place, kind, is_of_content, adapt, destroy, disk)                                         \
  static void *exchange_##name(const np_stage_part *in, void *result) {                                                \
    void *old = place;                                                                                                 \
    place = result;                                                                                                    \
    return old;                                                                                                        \
  }                                                                                                                    \
  const np_stage_reuse np_stage_reuse_##name = {                                                                       \
      kind, is_of_content, get_##name##_key, adapt, exchange_##name, make_##name, destroy, disk}

extern const np_stage_reuse np_stage_reuse_terrain, np_stage_reuse_volumes, np_stage_reuse_atmosphere,
    np_stage_reuse_camera_sky, np_stage_reuse_cloud_sky, np_stage_reuse_water_sky, np_stage_reuse_sun_optical_depth,
    np_stage_reuse_ordinates, np_stage_reuse_viewer_light, np_stage_reuse_ground_clouds;

/* Takes a part's result from disk to its place, where it is kept there; a part whose key is not known has none. */
bool np_stage_disk_load(const np_stage_reuse *reuse, const np_stage_part *part);

/* The key of a part's result on disk; false: it is not to be kept. */
bool np_stage_disk_compute_key(const np_stage_disk *disk, const np_stage_part *part, char out_key[33]);

/* Locks a part's result on disk: other processes that need it wait for the release. Waits for a process that has the
 * lock. */
neph_result np_stage_disk_lock(const np_stage_reuse *reuse, const np_stage_part *part, np_cache_lock *out_lock);

/* Saves a part's result on disk, where the context has a cache. */
void np_stage_disk_save(const np_stage_reuse *reuse, const np_stage_part *part);

/* Adds the terrain to a key; false: calls have built it, and it has no key. */
bool np_stage_add_terrain_key(const np_stage_part *in, np_hash *key);

/* The file of a part's cloud in the frame, its path to be freed; without one: it has none, or none as coarse. */
neph_result np_stage_get_cloud_file(const np_stage_part *in, np_cloud_file *out_file);

/* Albedo of the planet, in the scene's reference bands. */
void np_stage_get_ground_albedo(const np_stage_part *in, double out[NP_BAND_COUNT]);

np_stage_build_fn np_stage_build_packets, np_stage_build_lights, np_stage_build_packet_lights, np_stage_build_cloud,
    np_stage_build_color_fit, np_stage_build_star_map, np_stage_build_catalogue, np_stage_build_visibility,
    np_stage_build_emission, np_stage_build_airglow, np_stage_build_approximation, np_stage_build_motion,
    np_stage_build_stars, np_stage_build_instances, np_stage_build_world, np_stage_build_sky_guide,
    np_stage_build_relief_light, np_stage_build_air_shadow, np_stage_build_lighting;

np_stage_clear_fn np_stage_clear_packets, np_stage_clear_lights, np_stage_clear_cloud, np_stage_clear_star_map,
    np_stage_clear_catalogue, np_stage_clear_visibility, np_stage_clear_emission, np_stage_clear_approximation,
    np_stage_clear_motion, np_stage_clear_stars, np_stage_clear_instances, np_stage_clear_relief_light,
    np_stage_clear_air_shadow;

np_stage_finish_fn np_stage_finish_volumes;

/* Sun optical depths of a light, cached where the plan has a cache. */
np_sun_optical_depths np_stage_get_depths(const np_stage_part *in, const np_packet_light *light);

/* The camera's sky by a part's light in its packet's bands, with all of the light in the air, where the picture traces
 * that and has no tables of it. NULL: the light is dark. */
neph_result np_stage_create_sky(const np_stage_part *in, neph_sky **out_sky);

#endif
