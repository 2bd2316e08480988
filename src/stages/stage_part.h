/* SPDX-License-Identifier: Apache-2.0 */
/* The parts in which stages are built, cleared and reused: functions for the rows of the stage table. */
#ifndef NP_STAGES_STAGE_PART_H
#define NP_STAGES_STAGE_PART_H

#include "core/cache_lock.h"
#include "core/disk_cache.h"
#include "plan/stage_rules.h"
#include "scene/cloud_file.h"
#include "scene/sequence.h"
#include "stages/build_job.h"
#include "stages/stage_inputs.h"

/* A part under work: the inputs of its maker, and the places of results. */
typedef struct np_stage_task {
  np_stage_inputs in;
  np_assembly *picture;
  np_cloud_parts *cloud;   /* the part's cloud; NULL: the part is of no cloud */
  np_light_caches *caches; /* caches of the part's light, or of the first light */
  np_packet *packet;       /* the part's packet of bands, or the first packet */
  np_packet_light *light;  /* the part's light in that packet, or the first light */
} np_stage_task;

/* Fills the inputs of a stage for a task whose part and places are set. */
void np_stage_inputs_fill(np_stage stage, np_stage_task *at);

typedef neph_result np_stage_build_fn(const np_stage_task *task);

/* Results are cleared whether they were built whole, in part or not at all. */
typedef void np_stage_clear_fn(const np_stage_task *task);

/* Completes a stage whose parts are built, and revises the plan where it has turned out to be less than planned. */
typedef neph_result np_stage_finish_fn(const neph_scene *scene, np_assembly *picture, np_plan *plan);

enum { NP_REASON_SIZE = 128 };

/* Keeping of a stage's results on disk, for other processes. */
typedef struct np_stage_disk {
  const char *kind;
  bool has_isa; /* their bits depend on the instruction set */

  /* Adds to a key all that the bits of a result depend on; false: it is not to be kept. */
  bool (*add_key)(const np_stage_task *task, np_hash *key);
  void (*save)(const np_stage_task *task, np_cache_entry *entry);        /* the result in its place */
  neph_result (*load)(const np_stage_task *task, np_cache_entry *entry); /* … to its place, if the entry is whole */
  const char *state_kind; /* kind of cache entries that hold unfinished results; NULL: none */
} np_stage_disk;

/* Reuse of a stage's results by later pictures. The walk takes them from the stores and gives them back; changes are
 * measured against the key with which a result was built, so that small steps do not add up unseen. */
typedef struct np_stage_reuse {
  np_part_kind kind;
  bool is_of_content; /* any part's result serves any other of equal key */

  /* Creates, as one block, the key of all that the result depends on; leaves it NULL where the result must not be
   * cached. */
  neph_result (*get_key)(const np_stage_task *task, void **out_key);

  /* Adapts a cached result to the part's key, or fills the reason why it cannot; it was built for `cached_key`. */
  neph_result (*adapt)(const np_stage_task *task, void *cached, const void *cached_key,
                       char out_reason[NP_REASON_SIZE]);

  /* Stores a result, or NULL, for a part, and returns the previous one. */
  void *(*exchange)(const np_stage_task *task, void *result);

  np_stage_build_fn *make;       /* where none was cached */
  void (*destroy)(void *result); /* frees a result; does nothing for NULL */
  const np_stage_disk *disk;     /* NULL: kept in memory alone */
} np_stage_reuse;

/* Use of parts of a result that is out of date. */
typedef struct np_stage_salvage {
  /* Takes parts that are the same for the part's key; NULL: none are. */
  void *(*take)(const np_stage_task *task, void *cached, const void *cached_key);
  void (*destroy)(void *spare);
} np_stage_salvage;

extern const np_stage_salvage np_stage_salvage_ordinates;

/* The functions of a stage are given its inputs and the place of its result, and nothing else of the picture.
 * NP_STAGE_BUILD defines the function of a row by build_WHAT, … */
#define NP_STAGE_BUILD(what, stage, place)                                                                             \
  neph_result np_stage_build_##what(const np_stage_task *task) { return build_##what(&task->in.stage, &(place)); }

/* … NP_STAGE_DISK the keeping on disk, by `add_key`, `save` and `load`, … */
#define NP_STAGE_DISK(stage, place, kind, has_isa, add_key, save, load, state_kind)                                    \
  static bool add_key_of_##stage(const np_stage_task *task, np_hash *key) { return add_key(&task->in.stage, key); }    \
  static void save_##stage(const np_stage_task *task, np_cache_entry *entry) { save(&task->in.stage, place, entry); }  \
  static neph_result load_##stage(const np_stage_task *task, np_cache_entry *entry) {                                  \
    return load(&task->in.stage, entry, &(place));                                                                     \
  }                                                                                                                    \
  static const np_stage_disk stage##_disk = {kind, has_isa, add_key_of_##stage, save_##stage, load_##stage, state_kind}

/* … and NP_STAGE_REUSE the reuse, by get_STAGE_key, make_STAGE, `adapt` and `destroy`. */
#define NP_STAGE_REUSE(stage, place, kind, is_of_content, adapt, destroy, disk)                                        \
  static neph_result get_key_of_##stage(const np_stage_task *task, void **out_key) {                                   \
    return get_##stage##_key(&task->in.stage, out_key);                                                                \
  }                                                                                                                    \
  static neph_result adapt_part_of_##stage(const np_stage_task *task, void *cached, const void *cached_key,            \
                                           char out_reason[NP_REASON_SIZE]) {                                          \
    return adapt(&task->in.stage, cached, cached_key, out_reason);                                                     \
  }                                                                                                                    \
  static void *exchange_##stage(const np_stage_task *task, void *result) {                                             \
    void *old = place;                                                                                                 \
    place = result;                                                                                                    \
    return old;                                                                                                        \
  }                                                                                                                    \
  static neph_result make_part_of_##stage(const np_stage_task *task) {                                                 \
    return make_##stage(&task->in.stage, &(place));                                                                    \
  }                                                                                                                    \
  const np_stage_reuse np_stage_reuse_##stage = {                                                                      \
      kind,    is_of_content, get_key_of_##stage, adapt_part_of_##stage, exchange_##stage, make_part_of_##stage,       \
      destroy, disk}

/* Whether the picture has fewer pixels than the one whose detail it has. */
static inline bool np_stage_is_coarse(const np_stage_part *in) { return np_request_is_coarse(&in->plan->request); }

/* Whether light that is gathered in the air and on the ground may be coarse: of first pictures and of drafts. */
static inline bool np_stage_has_rough_light(const np_stage_part *in) {
  return np_stage_is_coarse(in) || in->scene->render.light_residual >= NP_SCATTERING_ROUGH;
}

/* Whether results of earlier pictures serve this one that are near its own. */
static inline bool np_stage_takes_near(const np_stage_part *in) { return in->plan->request.takes_near; }

/* Whether results of earlier pictures serve this one only where its own would have the same bits: in sequences, and in
 * pictures behind coarse ones. */
static inline bool np_stage_is_exact(const np_stage_part *in) {
  return np_scene_is_sequence(in->scene) || in->plan->request.desc.detail_height == in->plan->request.desc.height;
}

extern const np_stage_reuse np_stage_reuse_terrain, np_stage_reuse_volumes, np_stage_reuse_atmosphere,
    np_stage_reuse_camera_sky, np_stage_reuse_cloud_sky, np_stage_reuse_water_sky, np_stage_reuse_sun_optical_depth,
    np_stage_reuse_ordinates, np_stage_reuse_viewer_light, np_stage_reuse_ground_clouds, np_stage_reuse_relief_light;

/* Loads a part's result from the disk cache; false: it has no key, or no entry. */
bool np_stage_disk_load(const np_stage_reuse *reuse, const np_stage_task *task);

/* Locks a part's result on disk: other processes that need it wait for the release. Waits for a process that has the
 * lock. */
neph_result np_stage_disk_lock(const np_stage_reuse *reuse, const np_stage_task *task, np_cache_lock *out_lock);

/* Saves a part's result on disk, where the context has a cache. */
void np_stage_disk_save(const np_stage_reuse *reuse, const np_stage_task *task);

/* Adds the keys of the scene but those of the camera and of files. False: a program has given it objects, whose
 * contents have no name. */
bool np_stage_add_scene_key(const np_stage_part *in, np_hash *hash);

/* Adds the terrain, or its heights without their cover, to a key; false: calls have built it, and it has no key. */
bool np_stage_add_terrain_key(const np_stage_part *in, np_hash *key);
bool np_stage_add_heights_key(const np_stage_part *in, np_hash *key);

/* Albedo of the planet, in the scene's reference bands; `terrain` may be NULL. */
void np_stage_get_ground_albedo(const np_stage_part *in, const neph_terrain *terrain, const np_picture_lights *lights,
                                double out[NP_BAND_COUNT]);

/* The file of a part's cloud in the frame, its path to be freed; without one: it has none, or none as coarse. */
neph_result np_stage_get_cloud_file(const np_stage_part *in, np_cloud_file *out_file);

np_stage_build_fn np_stage_build_packets, np_stage_build_lights, np_stage_build_packet_lights, np_stage_build_cloud,
    np_stage_build_color_fit, np_stage_build_star_map, np_stage_build_catalogue, np_stage_build_visibility,
    np_stage_build_emission, np_stage_build_airglow, np_stage_build_approximation, np_stage_build_motion,
    np_stage_build_stars, np_stage_build_instances, np_stage_build_world, np_stage_build_sky_guide,
    np_stage_build_air_shadow, np_stage_build_lighting;

np_stage_clear_fn np_stage_clear_packets, np_stage_clear_lights, np_stage_clear_cloud, np_stage_clear_star_map,
    np_stage_clear_catalogue, np_stage_clear_visibility, np_stage_clear_emission, np_stage_clear_approximation,
    np_stage_clear_motion, np_stage_clear_stars, np_stage_clear_instances, np_stage_clear_air_shadow;

np_stage_finish_fn np_stage_finish_volumes;

/* Sun optical depths of a world's light, cached where the plan has a cache. */
static inline np_sun_optical_depths np_stage_get_depths(const np_world *world, const np_sun_optical_depth *depth) {
  return (np_sun_optical_depths){&world->clouds, depth};
}

/* Creates the camera's sky for a light in a packet's bands; with all orders of scattering if the picture traces air and
 * has no tables. NULL: the light is dark. */
neph_result np_stage_create_sky(const np_color_fit_inputs *in, neph_sky **out_sky);

#endif
