/* SPDX-License-Identifier: Apache-2.0 */
/* Multiple scattering: solved for, or, in a sequence under a sun that moves, between two solutions. */
#include "core/alloc.h"
#include "core/text.h"
#include "plan/plan_choices.h"
#include "plan/plan_detail.h"
#include "scene/sequence.h"
#include "stages/light_anchors.h"
#include "stages/light_checkpoint.h"
#include "stages/stage_part.h"

/* The camera, on a lattice of an eighth of the clouds' box, so that a solution outlives some steps of it. */
static np_dvec3 get_viewer(const np_assembly *a) {
  const double step = 0.125 * np_dvec3_length(np_dvec3_subtract(a->clouds_max, a->clouds_min));
  const np_dvec3 at = a->camera.origin;
  return step > 0.0 ? np_dvec3_scale(np_dvec3_make(round(at.x / step), round(at.y / step), round(at.z / step)), step)
                    : at;
}

/* The camera, or the box of all its places where it moves. */
static void set_viewer(const neph_scene *scene, const np_assembly *a, np_transport_desc *out) {
  const double *near = scene->reach.camera_min_m, *far = scene->reach.camera_max_m;
  out->viewer = get_viewer(a);
  if (!scene->animation) return;
  out->viewer = np_dvec3_make(near[0], near[1], near[2]);
  out->viewer_reach = np_dvec3_make(far[0] - near[0], far[1] - near[1], far[2] - near[2]);
}

/* Clouds of files may be denser than the plan expects, whose savings go by its expectation. */
static neph_result warn_of_limit(const np_stage_part *in, const np_scattering_desc *held) {
  const np_plan *plan = in->plan;
  np_scattering_desc wanted = *held;
  np_scattering_forecast kept, whole;
  if (!(plan->savings.light_bytes_max < plan->request.light_bytes) || plan->savings.text[0]) return NEPH_OK;
  np_scattering_desc_set_memory(&wanted, plan->request.light_bytes);
  neph_result result = np_scattering_desc_forecast(in->made->context, &in->light->world, held, NULL, &kept);
  if (!result) result = np_scattering_desc_forecast(in->made->context, &in->light->world, &wanted, NULL, &whole);
  if (!result && kept.cell_count < whole.cell_count)
    np_log(in->made->context, NEPH_LOG_WARNING,
           "to stay within %.3g GB of memory, multiple scattering is solved for on %.3g of %.3g million cells",
           1e-9 * (double)plan->request.desc.memory_max_bytes, 1e-6 * kept.cell_count, 1e-6 * whole.cell_count);
  return result;
}

/* Box of the clouds that are solved for; of all, where none are. A cloud that is seen, where the plan did not expect
 * it, is solved for after all. */
static void set_clouds(const np_stage_part *in, np_light_key *key) {
  const np_assembly *a = in->made;
  uint64_t left_out = in->plan->decisions.left_out.clouds;
  np_dvec3 low = np_nowhere_low, high = np_nowhere_high;
  for (unsigned i = 0; i < a->cloud_count && left_out != UINT64_MAX; i++) {
    const np_cloud_parts *cloud = &a->clouds[i];
    const bool is_seen = cloud->low.x <= cloud->high.x && np_camera_sees_box(&a->camera, cloud->low, cloud->high);
    if (is_seen) left_out &= ~(UINT64_C(1) << i);
    if (left_out >> i & 1u) continue;
    low = np_dvec3_min(low, cloud->low);
    high = np_dvec3_max(high, cloud->high);
  }
  const bool is_any = left_out != 0 && low.x <= high.x;
  np_plan_choose_cells(in->plan, in->scene, is_any ? low : a->clouds_min, is_any ? high : a->clouds_max, &key->desc);
  key->desc.left_out = left_out;
}

static neph_result make_light_key(const np_stage_part *in, np_light_key **out_key) {
  const np_assembly *a = in->made;
  np_light_key *key = *out_key = np_alloc(a->context, 1, sizeof *key);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  set_clouds(in, key);
  key->desc.cells.has_viewer = np_camera_has_centre(&a->camera);
  if (key->desc.cells.has_viewer) set_viewer(in->scene, a, &key->desc.cells);
  key->desc.has_importance = in->plan->request.desc.integrator == NEPH_INTEGRATOR_PATH;
  const np_sun_optical_depths depths = np_stage_get_depths(in, in->light);
  const np_sun_optical_depth_source source = np_sun_optical_depths_get_source(&depths);
  const neph_result result = warn_of_limit(in, &key->desc);
  return result ? result : np_light_key_fill(a->context, &in->light->world, &source, key);
}

/* The solutions of a light of a packet at both ends of the job's block; false where either has none. */
static bool get_anchors(const np_stage_part *in, const np_light_solution *out[2]) {
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
static neph_result get_ordinates_key(const np_stage_part *in, void **out_key) {
  const np_light_solution *ends[2];
  if (get_anchors(in, ends)) return NEPH_OK;
  return make_light_key(in, (np_light_key **)out_key);
}

/* A solution borrows the phase tables of its picture; the next picture with the same clouds has equal tables. */
static neph_result adapt_solution(const np_stage_part *in, void *cached, const void *cached_key, char *out_reason) {
  if (np_scattering_field_get_quality(cached).is_cut)
    np_print(out_reason, NP_REASON_SIZE, "a time limit cut it short");
  else
    np_light_key_compare(cached_key, in->key, np_scene_is_sequence(in->scene), out_reason, NP_REASON_SIZE);
  if (out_reason[0]) return NEPH_OK;
  np_scattering_field_set_world(cached, &in->light->world);
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
static neph_result blend_ordinates(const np_stage_part *in, const np_light_solution *const ends[2]) {
  np_scattering_blend blend = {.fields = {ends[0]->field, ends[1]->field}};
  np_light_key *key;
  neph_result result = make_light_key(in, &key);
  const double share = blend.share = result ? 0.0 : choose_share(ends, key, in->job->light_span.share);
  for (unsigned b = 0; b < NP_BAND_COUNT && !result; b++) {
    const double between =
        (1.0 - share) * np_light_key_sum(ends[0]->key, b) + share * np_light_key_sum(ends[1]->key, b);
    blend.gain[b] = between > 0.0 ? np_light_key_sum(key, b) / between : 1.0;
  }
  np_alloc_free(in->made->context, key);
  in->schedule->solves_left--;
  if (result) return result;
  return np_scattering_field_blend(&blend, &in->light->world, in->monitor, &in->light->scattering);
}

static bool add_ordinates_key(const np_stage_part *in, np_hash *key) {
  const np_light_key *own = in->key;
  NP_HASH_ADD(key, own->clouds);
  NP_HASH_ADD(key, own->to_sun);
  NP_HASH_ADD(key, own->sun);
  NP_HASH_ADD(key, own->surroundings);
  NP_HASH_ADD(key, own->desc.cells.cell_count_max);
  if (in->plan->decisions.left_out.is_all) return false;
  return !isfinite(in->plan->request.desc.time_limit_s) && np_stage_add_terrain_key(in, key);
}

static void save_solution(const np_stage_part *in, np_cache_entry *entry) {
  np_scattering_field_save(in->light->scattering, entry);
}

static neph_result load_solution(const np_stage_part *in, np_cache_entry *entry) {
  return np_scattering_field_load(in->made->context, &in->light->world, entry, &in->light->scattering);
}

/* A solution that a time limit may cut is not kept. */
static const np_stage_disk ordinates_disk = {"light",       true,          add_ordinates_key,
                                             save_solution, load_solution, NP_LIGHT_STATE_KIND};

/* Goes on from where the light's checkpoint is. */
static neph_result solve_ordinates(const np_stage_part *in, np_light_checkpoint *checkpoint) {
  np_scattering_desc desc = ((const np_light_key *)in->key)->desc;
  desc.seconds_max = np_schedule_take_solve(in->schedule, in->monitor);
  desc.keeper = checkpoint ? &checkpoint->keeper : NULL;
  const np_sun_optical_depths depths = np_stage_get_depths(in, in->light);
  const np_sun_optical_depth_source source = np_sun_optical_depths_get_source(&depths);
  return np_scattering_field_build(in->made->context, &in->light->world, &source, &desc, in->monitor,
                                   &in->light->scattering);
}

static neph_result make_ordinates(const np_stage_part *in) {
  const np_light_solution *ends[2];
  np_light_checkpoint checkpoint;
  if (get_anchors(in, ends)) return blend_ordinates(in, ends);
  if (!np_light_checkpoint_open(in, &ordinates_disk, &checkpoint)) return solve_ordinates(in, NULL);
  neph_result result = NEPH_OK;
  in->light->scattering = np_light_checkpoint_load(&checkpoint, &in->light->world);
  if (in->light->scattering) {
    in->schedule->solves_left--;
  } else {
    result = solve_ordinates(in, &checkpoint);
    if (!result) np_light_checkpoint_save(&checkpoint, in->light->scattering);
  }
  np_light_checkpoint_close(&checkpoint);
  return result;
}

static void destroy_solution(void *solution) { np_scattering_field_destroy(solution); }

NP_STAGE_REUSE(ordinates, in->light->scattering, NP_PER_PACKET_LIGHT, false, adapt_solution, destroy_solution,
               &ordinates_disk);
