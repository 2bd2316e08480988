/* SPDX-License-Identifier: Apache-2.0 */
/* Multiple scattering: solved for, or, in a sequence under a sun that moves, between two solutions. */
#include <string.h>

#include "core/alloc.h"
#include "core/hash.h"
#include "core/text.h"
#include "plan/plan_choices.h"
#include "plan/plan_detail.h"
#include "scene/sequence.h"
#include "stages/light_anchors.h"
#include "stages/light_checkpoint.h"
#include "stages/stage_part.h"

/* The camera, on a lattice of an eighth of the clouds' box, so that a solution outlives some steps of it. */
static np_dvec3 get_viewer(const np_frame_clouds *clouds, np_dvec3 at) {
  const double step = 0.125 * np_dvec3_length(np_dvec3_subtract(clouds->high, clouds->low));
  return step > 0.0 ? np_dvec3_scale(np_dvec3_make(round(at.x / step), round(at.y / step), round(at.z / step)), step)
                    : at;
}

/* The camera, or the box of all its places where it moves. */
static void set_viewer(const np_ordinates_inputs *in, np_transport_desc *out) {
  const neph_scene *scene = in->scene;
  const double *near = scene->reach.camera_min_m, *far = scene->reach.camera_max_m;
  out->viewer = get_viewer(in->clouds, in->camera->origin);
  if (!scene->animation) return;
  out->viewer = np_dvec3_make(near[0], near[1], near[2]);
  out->viewer_reach = np_dvec3_make(far[0] - near[0], far[1] - near[1], far[2] - near[2]);
}

/* Clouds of files may be denser than the plan expects, whose savings depend on its expectation. */
static neph_result warn_of_limit(const np_ordinates_inputs *in, const np_scattering_desc *held) {
  const np_plan *plan = in->plan;
  np_scattering_desc wanted = *held;
  np_scattering_forecast kept, whole;
  if (!(plan->savings.light_bytes_max < plan->request.light_bytes) || plan->savings.text[0]) return NEPH_OK;
  np_scattering_desc_set_memory(&wanted, plan->request.light_bytes);
  neph_result result = np_scattering_desc_forecast(in->context, in->world, held, NULL, &kept);
  if (!result) result = np_scattering_desc_forecast(in->context, in->world, &wanted, NULL, &whole);
  if (!result && kept.cell_count < whole.cell_count)
    np_log(in->context, NEPH_LOG_WARNING,
           "to stay within %.3g GB of memory, multiple scattering is solved for on %.3g of %.3g million cells",
           1e-9 * (double)plan->request.desc.memory_max_bytes, 1e-6 * kept.cell_count, 1e-6 * whole.cell_count);
  return result;
}

/* Box of the clouds that are solved for; of all, where none are. A cloud that is seen, where the plan did not expect
 * it, is solved for after all. */
static void set_clouds(const np_ordinates_inputs *in, np_light_key *key) {
  const np_frame_clouds *clouds = in->clouds;
  uint64_t left_out = in->plan->decisions.left_out.clouds;
  np_dvec3 low = np_nowhere_low, high = np_nowhere_high;
  for (unsigned i = 0; i < clouds->count && left_out != UINT64_MAX; i++) {
    const np_cloud_parts *cloud = &clouds->at[i];
    const bool is_seen = np_cloud_parts_are_endless(cloud) ||
                         (cloud->low.x <= cloud->high.x && np_camera_sees_box(in->camera, cloud->low, cloud->high));
    if (is_seen) left_out &= ~(UINT64_C(1) << i);
    if (left_out >> i & 1u) continue;
    low = np_dvec3_min(low, cloud->low);
    high = np_dvec3_max(high, cloud->high);
  }
  const bool is_any = left_out != 0 && low.x <= high.x;
  np_plan_choose_cells(in->plan, in->scene, is_any ? low : clouds->low, is_any ? high : clouds->high, &key->desc);
  key->desc.left_out = left_out;
}

/* Adds what decides which cells are below ground. */
static neph_result hash_ground(const np_ordinates_inputs *in, char out[33]) {
  const np_world *world = in->world;
  const double level_m = world->water ? world->water->level_m : -(double)INFINITY;
  np_hash *hash = np_hash_create(in->context);
  const bool is_known = np_stage_add_heights_key(&in->part, hash);
  NP_HASH_ADD(hash, world->has_planet);
  NP_HASH_ADD(hash, world->planet_radius_m);
  NP_HASH_ADD(hash, level_m);
  const neph_result result = np_hash_finish(hash, out);
  if (!is_known) out[0] = '\0';
  return result;
}

/* Adds what decides the light around the clouds, beside them. The camera's part in it are the picture's colours. */
static neph_result hash_around(const np_ordinates_inputs *in, const np_light_key *key, char out[33]) {
  const np_world *world = in->world;
  const np_spectrum water = world->water ? world->water->albedo : np_spectrum_grey(0.0f);
  const np_spectrum night = world->night ? world->night->ground_irradiance : np_spectrum_grey(0.0f);
  const float depth_end = in->depth ? in->depth->depth_end : 0.0f;
  const unsigned frame = neph_scene_is_animated(in->scene) ? (unsigned)in->plan->request.desc.frame : 0;
  const unsigned words[] = {frame, in->slot, in->depth != NULL, np_stage_is_coarse(&in->part)};
  np_hash *hash = np_hash_create(in->context);
  const bool is_known = np_stage_add_scene_key(&in->part, hash) && np_stage_add_terrain_key(&in->part, hash);
  NP_HASH_ADD(hash, words);
  NP_HASH_ADD(hash, depth_end);
  NP_HASH_ADD(hash, key->desc.cells.bounds_min);
  NP_HASH_ADD(hash, key->desc.cells.bounds_max);
  NP_HASH_ADD(hash, world->to_sun);
  NP_HASH_ADD(hash, world->sun_irradiance);
  NP_HASH_ADD(hash, world->ground_albedo);
  NP_HASH_ADD(hash, world->terrain_albedo);
  NP_HASH_ADD(hash, world->terrain_basis);
  NP_HASH_ADD(hash, water);
  NP_HASH_ADD(hash, night);
  const neph_result result = np_hash_finish(hash, out);
  if (!is_known) out[0] = '\0';
  return result;
}

static neph_result make_light_key(const np_ordinates_inputs *in, np_light_key **out_key) {
  np_light_key *key = *out_key = np_alloc(in->context, 1, sizeof *key);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  set_clouds(in, key);
  key->desc.cells.has_viewer = np_camera_has_centre(in->camera);
  if (key->desc.cells.has_viewer) set_viewer(in, &key->desc.cells);
  key->has_depth = in->depth;
  key->desc.has_importance = in->plan->request.desc.integrator == NEPH_INTEGRATOR_PATH;
  const np_sun_optical_depths depths = np_stage_get_depths(in->world, in->depth);
  const np_sun_optical_depth_source source = np_sun_optical_depths_get_source(&depths);
  neph_result result = warn_of_limit(in, &key->desc);
  const np_stored_result *earlier = np_stores_search(in->job->stores, &np_stage_reuse_ordinates, in->slot);
  if (!result) result = hash_ground(in, key->ground);
  if (!result) result = hash_around(in, key, key->around);
  if (result) return result;
  return np_light_key_fill(in->context, in->world, &source, earlier ? earlier->key : NULL, key);
}

/* The solutions of a packet's light at both ends of the job's span; false: one is missing. */
static bool get_anchors(const np_ordinates_inputs *in, const np_light_solution *out[2]) {
  const np_light_anchors *anchors = in->job->stores->light;
  const int *frames = in->job->light_span.frames;
  if (!anchors || frames[0] == frames[1]) return false;
  for (int i = 0; i < 2; i++) {
    out[i] = NULL;
    for (unsigned k = 0; k < anchors->at[i].count; k++)
      if (anchors->at[i].solutions[k].slot == in->slot) out[i] = &anchors->at[i].solutions[k];
  }
  return out[0] && out[1] && np_scattering_field_can_blend(out[0]->field, out[1]->field);
}

/* A solution interpolated from two other frames serves this frame alone, and is not stored. */
static neph_result get_ordinates_key(const np_ordinates_inputs *in, void **out_key) {
  const np_light_solution *ends[2];
  if (get_anchors(in, ends)) return NEPH_OK;
  return make_light_key(in, (np_light_key **)out_key);
}

/* A solution borrows the phase tables of its picture; the next picture with the same clouds has equal tables. */
static neph_result adapt_solution(const np_ordinates_inputs *in, void *cached, const void *cached_key,
                                  char *out_reason) {
  if (np_scattering_field_get_quality(cached).is_cut)
    np_print(out_reason, NP_REASON_SIZE, "a time limit cut it short");
  else if (np_stage_takes_near(&in->part))
    np_light_key_compare_coarse(cached_key, in->key, out_reason, NP_REASON_SIZE);
  else
    np_light_key_compare(cached_key, in->key, np_stage_is_exact(&in->part), out_reason, NP_REASON_SIZE);
  if (out_reason[0]) return NEPH_OK;
  np_scattering_field_set_world(cached, in->world);
  in->schedule->solves_left--;
  return NEPH_OK;
}

static double sum_light(const np_light_key *key) {
  double sum = 0.0;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) sum += np_light_key_sum(key, b);
  return sum;
}

/* The share of the second of two solutions. Where the sun's part in the light changes much from one to the other, as
 * while it rises, by that part; else by the frame's place between theirs. */
static double choose_share(const np_light_solution *const ends[2], const np_light_key *key, double by_frame) {
  static const double little = 0.004, much = 0.02;
  const double a = np_light_key_get_sun_share(ends[0]->key), b = np_light_key_get_sun_share(ends[1]->key);
  const double own = np_light_key_get_sun_share(key), change = fabs(b - a);
  if (change <= little) return by_frame;
  /* (own − a) of the first light and (b − own) of the second give a sun of that share. */
  const double first = fmax((b - own) / (b - a), 0.0) * sum_light(ends[1]->key),
               second = fmax((own - a) / (b - a), 0.0) * sum_light(ends[0]->key);
  const double by_sun = first + second > 0.0 ? second / (first + second) : by_frame;
  const double weight = np_clamp((change - little) / (much - little), 0.0, 1.0);
  return by_frame + weight * (by_sun - by_frame);
}

/* A solution between two others, brought in each band to the brightness of all light in the frame. */
static neph_result blend_ordinates(const np_ordinates_inputs *in, const np_light_solution *const ends[2],
                                   np_scattering_field **out) {
  np_scattering_blend blend = {.fields = {ends[0]->field, ends[1]->field}};
  np_light_key *key;
  neph_result result = make_light_key(in, &key);
  const double share = blend.share = result ? 0.0 : choose_share(ends, key, in->job->light_span.share);
  for (unsigned b = 0; b < NP_BAND_COUNT && !result; b++) {
    const double between =
        (1.0 - share) * np_light_key_sum(ends[0]->key, b) + share * np_light_key_sum(ends[1]->key, b);
    blend.gain[b] = between > 0.0 ? np_light_key_sum(key, b) / between : 1.0;
  }
  np_alloc_free(in->context, key);
  in->schedule->solves_left--;
  if (result) return result;
  return np_scattering_field_blend(&blend, in->world, in->monitor, out);
}

static bool add_ordinates_key(const np_ordinates_inputs *in, np_hash *key) {
  const np_light_key *own = in->key;
  NP_HASH_ADD(key, own->clouds);
  NP_HASH_ADD(key, own->to_sun);
  NP_HASH_ADD(key, own->sun);
  NP_HASH_ADD(key, own->surroundings);
  NP_HASH_ADD(key, own->desc.cells.cell_count_max);
  if (in->plan->decisions.left_out.is_all) return false;
  return !isfinite(in->plan->request.desc.time_limit_s) && np_stage_add_terrain_key(&in->part, key);
}

static void save_solution(const np_ordinates_inputs *in, const np_scattering_field *field, np_cache_entry *entry) {
  (void)in;
  np_scattering_field_save(field, entry);
}

static neph_result load_solution(const np_ordinates_inputs *in, np_cache_entry *entry, np_scattering_field **out) {
  return np_scattering_field_load(in->context, in->world, entry, out);
}

static const char solution_kind[] = "light";

/* A solution that a time limit may cut is not kept. */
NP_STAGE_DISK(ordinates, task->light->scattering, solution_kind, true, add_ordinates_key, save_solution, load_solution,
              NP_LIGHT_STATE_KIND);

/* Solves for multiple scattering, from the light's checkpoint on if there is one. */
static neph_result solve_ordinates(const np_ordinates_inputs *in, np_light_checkpoint *checkpoint,
                                   np_scattering_field **out) {
  np_scattering_desc desc = ((const np_light_key *)in->key)->desc;
  desc.seconds_max = np_schedule_take_solve(in->schedule, in->monitor);
  desc.reused = in->spare;
  desc.keeper = checkpoint ? &checkpoint->keeper : NULL;
  const np_sun_optical_depths depths = np_stage_get_depths(in->world, in->depth);
  const np_sun_optical_depth_source source = np_sun_optical_depths_get_source(&depths);
  return np_scattering_field_build(in->context, in->world, &source, &desc, in->monitor, out);
}

/* The key of the solution on disk, under which its checkpoint is. */
static bool compute_checkpoint_key(const np_ordinates_inputs *in, char out[33]) {
  np_hash *key = np_hash_create(in->context);
  if (key) np_cache_key_begin(in->context, solution_kind, true, key);
  const bool is_kept = add_ordinates_key(in, key);
  return !np_hash_finish(key, out) && is_kept;
}

static neph_result make_ordinates(const np_ordinates_inputs *in, np_scattering_field **out) {
  const np_light_solution *ends[2];
  np_light_checkpoint checkpoint;
  char key[33];
  if (get_anchors(in, ends)) return blend_ordinates(in, ends, out);
  const bool is_kept = in->job->light_checkpoints.path && compute_checkpoint_key(in, key);
  if (!is_kept || !np_light_checkpoint_open(&in->part, key, &checkpoint)) return solve_ordinates(in, NULL, out);
  neph_result result = NEPH_OK;
  *out = np_light_checkpoint_load(&checkpoint, in->world);
  if (*out) {
    in->schedule->solves_left--;
  } else {
    result = solve_ordinates(in, &checkpoint, out);
    if (!result) np_light_checkpoint_save(&checkpoint, *out);
  }
  np_light_checkpoint_close(&checkpoint);
  return result;
}

static void destroy_solution(void *solution) { np_scattering_field_destroy(solution); }

NP_STAGE_REUSE(ordinates, task->light->scattering, NP_PER_PACKET_LIGHT, false, adapt_solution, destroy_solution,
               &ordinates_disk);

/* Cells are the same where clouds and ground are, their first collisions where the sun has not moved either. */
static void *take_cells(const np_stage_task *task, void *cached, const void *cached_key) {
  const np_light_key *own = cached_key, *wanted = task->in.part.key;
  const bool is_same = *wanted->ground && !strcmp(own->ground, wanted->ground) && !strcmp(own->clouds, wanted->clouds);
  const bool is_lit = np_vec3_is_equal(own->to_sun, wanted->to_sun);
  return is_same ? np_scattering_field_take_cells(cached, is_lit) : NULL;
}

static void destroy_cells(void *spare) { np_reused_cells_destroy(spare); }

const np_stage_salvage np_stage_salvage_ordinates = {take_cells, destroy_cells};
