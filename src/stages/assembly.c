/* SPDX-License-Identifier: Apache-2.0 */
/* Walks the stages, forwards to build and backwards to clear. */
#include "stages/assembly.h"

#include <assert.h>

#include "core/alloc.h"
#include "stages/stage_makers.h"

/* ---- Parts ---- */

static np_part_counts count_parts(const np_assembly *a, np_stage stage) {
  const unsigned packets = a->packet_count + (np_stage_get_rule(stage)->is_of_probes ? a->probe_packet_count : 0);
  return np_part_counts_make(a->clouds.count, a->lights.count, packets);
}

/* The places of a part of a kind, and its number among those that later pictures reuse. */
static np_stage_task get_task(const np_stage_part *walk, np_assembly *a, np_part_kind kind, unsigned index) {
  const bool is_of_light = kind == NP_PER_LIGHT || kind == NP_PER_PACKET_LIGHT;
  assert(!is_of_light || a->lights.count > 0);
  const unsigned light = is_of_light ? index % a->lights.count : 0;
  const unsigned packet = kind == NP_PER_PACKET ? index : kind == NP_PER_PACKET_LIGHT ? index / a->lights.count : 0;
  np_stage_task task = {.in.part = *walk, .picture = a, .caches = &a->caches[light]};
  task.in.part.has_reused = a->has_reused;
  task.in.part.slot = index;
  if (is_of_light) {
    task.in.part.group = a->lights.group[light];
    task.in.part.slot = packet * NP_LIGHTS_MAX + task.in.part.group;
  }
  if (kind == NP_PER_CLOUD) {
    task.in.part.cloud = index;
    task.cloud = &a->clouds.at[index];
  }
  if (!a->packets) return task;
  assert(packet < a->packet_count + a->probe_packet_count && light < NP_LIGHTS_MAX);
  task.packet = &a->packets[packet];
  task.light = &task.packet->lights[light];
  return task;
}

/* A part to be built, with the inputs of its stage. */
static np_stage_task get_input_task(const np_stage_part *walk, np_assembly *a, np_stage stage, np_part_kind kind,
                                    unsigned index) {
  np_stage_task task = get_task(walk, a, kind, index);
  np_stage_inputs_fill(stage, &task);
  return task;
}

/* ---- Reuse ---- */

static void log_part(np_stage stage, const np_stage_part *part, const char *origin, const char *reason) {
  const bool is_cloud = np_stage_get_maker(stage)->reuse->kind == NP_PER_CLOUD;
  np_log(part->context, reason[0] ? NEPH_LOG_INFO : NEPH_LOG_DEBUG, "%s%s%s: %s%s%s", is_cloud ? "cloud " : "",
         is_cloud ? part->scene->clouds[part->cloud].name : np_stage_get_rule(stage)->name,
         part->group == NP_LIGHT_GROUP_MOON ? " by moonlight" : "", origin, reason[0] ? ": " : "", reason);
}

/* A result of another part whose key is the same; NULL: none. */
static np_stored_result *search_content(const np_stage_reuse *reuse, const np_stage_task *task) {
  np_stored_result *at = reuse->is_of_content ? task->in.part.job->stores->results : NULL;
  for (; at; at = at->next) {
    char reason[NP_REASON_SIZE] = "";
    if (at->stage != reuse || !at->result) continue;
    reuse->adapt(task, at->result, at->key, reason);
    if (!reason[0]) break;
  }
  return at;
}

/* Takes the result for a part of this picture from the stores; the log has the reason of a rebuild. */
static neph_result take_part(np_stage stage, const np_stage_task *task, bool *is_any_reused) {
  const np_stage_reuse *reuse = np_stage_get_maker(stage)->reuse;
  const np_stage_part *part = &task->in.part;
  np_stores *stores = part->job->stores;
  np_stage_task wanted = *task;
  void *key = NULL;
  neph_result result = reuse->get_key(task, &key);
  if (result) np_alloc_free(part->context, key);
  if (result || !key) return result;
  char reason[NP_REASON_SIZE] = "";
  np_stored_result *own = np_stores_search(stores, reuse, part->slot), *cached = own;
  wanted.in.part.key = key;
  if (own) result = reuse->adapt(&wanted, own->result, own->key, reason);
  if (reason[0]) cached = search_content(reuse, &wanted);
  if (cached && !result) {
    log_part(stage, part, "reused", "");
    if (part->job->times) part->job->times->is_reused[stage] = true;
    *is_any_reused = true;
    np_alloc_free(part->context, key);
    (void)reuse->exchange(task, cached->result);
    cached->result = NULL;
    if (cached != own && own) own->slot = cached->slot;
    cached->slot = part->slot;
    return NEPH_OK;
  }
  const bool is_loaded = !result && np_stage_disk_load(reuse, &wanted);
  const char *origin = own ? "rebuilt" : "built";
  log_part(stage, part, is_loaded ? "read from the cache" : origin, is_loaded ? "" : reason);
  if (own) own->slot = UINT32_MAX; /* free for another part */
  np_stored_result added = {.stage = reuse, .slot = part->slot, .key = key, .destroy = reuse->destroy};
  const np_stage_salvage *salvage = np_stage_get_maker(stage)->salvage;
  if (salvage && own && !is_loaded && !result) {
    added.spare = salvage->take(&wanted, own->result, own->key);
    added.destroy_spare = salvage->destroy;
  }
  const neph_result failed = np_stores_add(part->context, stores, added);
  return result ? result : failed;
}

static bool is_made(const np_stage_reuse *reuse, const np_stage_task *task) {
  void *result = reuse->exchange(task, NULL);
  (void)reuse->exchange(task, result);
  return result;
}

/* Makes a part, or loads the result of another process that has finished it meanwhile. */
static neph_result make_or_load(const np_stage_reuse *reuse, const np_stage_task *task) {
  np_cache_lock lock;
  neph_result result = np_stage_disk_lock(reuse, task, &lock);
  if (!result && !(lock.file >= 0 && np_stage_disk_load(reuse, task))) {
    result = reuse->make(task);
    if (!result && task->in.part.key && is_made(reuse, task)) np_stage_disk_save(reuse, task);
  }
  np_cache_lock_release(&lock);
  return result;
}

/* Makes the result of a part unless it was taken. */
static neph_result make_part(const np_stage_reuse *reuse, const np_stage_task *task) {
  if (is_made(reuse, task)) return NEPH_OK;
  np_stored_result *own = np_stores_search(task->in.part.job->stores, reuse, task->in.part.slot);
  np_stage_task keyed = *task;
  keyed.in.part.key = own ? own->key : NULL;
  keyed.in.part.spare = own ? own->spare : NULL;
  const neph_result result = make_or_load(reuse, &keyed);
  if (own) np_stored_result_clear_spare(own);
  return result;
}

/* Gives the result of a part back to the stores, or destroys it where it has no key. */
static void return_part(const np_stage_reuse *reuse, const np_stage_task *task) {
  void *result = reuse->exchange(task, NULL);
  np_stored_result *own = np_stores_search(task->in.part.job->stores, reuse, task->in.part.slot);
  if (own && !own->result)
    own->result = result;
  else
    reuse->destroy(result);
}

/* ---- Walks ---- */

/* Takes cached results. First the stores free results that this picture does not use, so that no more memory is needed
 * than for the picture alone. */
static neph_result take_cached(np_stage stage, const np_stage_part *walk, np_assembly *a) {
  const np_stage_reuse *reuse = np_stage_get_maker(stage)->reuse;
  neph_result result = NEPH_OK;
  np_stores_drop(a->context, a->stores, reuse, true);
  for (unsigned i = 0; i < count_parts(a, stage).of[reuse->kind] && !result; i++) {
    const np_stage_task task = get_input_task(walk, a, stage, reuse->kind, i);
    result = take_part(stage, &task, &a->has_reused);
  }
  np_stores_drop(a->context, a->stores, reuse, false);
  return result;
}

static neph_result build_part(const np_stage_maker *maker, np_part_kind kind, const np_stage_task *task) {
  const bool is_reused = maker->reuse && maker->reuse->kind == kind;
  neph_result result = is_reused ? make_part(maker->reuse, task) : NEPH_OK;
  return !result && maker->build[kind] ? maker->build[kind](task) : result;
}

static neph_result build_stage(np_stage stage, const np_stage_part *walk, np_assembly *a) {
  const np_stage_rule *rule = np_stage_get_rule(stage);
  const np_stage_maker *maker = np_stage_get_maker(stage);
  const np_part_counts before = count_parts(a, stage);
  const unsigned all = np_stage_count_parts(rule, &before);
  unsigned done = 0;
  if (all > 0) a->built |= 1u << stage;
  neph_result result = maker->reuse ? take_cached(stage, walk, a) : NEPH_OK;
  for (int kind = 0; kind < NP_PART_KINDS; kind++) {
    if (!np_stage_has_kind(rule, (np_part_kind)kind)) continue;
    for (unsigned i = 0; i < count_parts(a, stage).of[kind] && !result; i++) {
      const np_stage_task task = get_input_task(walk, a, stage, (np_part_kind)kind, i);
      np_schedule_begin(&a->schedule, walk->monitor, stage, done++, all);
      result = build_part(maker, (np_part_kind)kind, &task);
    }
  }
  return result;
}

static neph_result start(const neph_scene *scene, const np_plan *plan, const np_build_job *job, np_assembly *a) {
  *a = (np_assembly){.context = scene->context,
                     .stores = job->stores,
                     .clouds = {.count = scene->cloud_count,
                                .at = np_alloc(scene->context, scene->cloud_count, sizeof *a->clouds.at),
                                .low = np_nowhere_low,
                                .high = np_nowhere_high}};
  np_schedule_make(plan, job->progress, &a->schedule);
  if (!a->clouds.at) return NEPH_ERROR_OUT_OF_MEMORY;
  return np_camera_init(scene, plan->request.desc.width, plan->request.desc.height, plan->request.desc.eye, &a->camera);
}

neph_result np_assembly_build_some(const neph_scene *scene, np_plan *plan, uint32_t stages, const np_build_job *job,
                                   np_monitor *monitor, np_assembly *out_assembly) {
  np_stage_times *times = job->times;
  const np_stage_part walk = {.context = scene->context,
                              .scene = scene,
                              .plan = plan,
                              .monitor = monitor,
                              .job = job,
                              .schedule = &out_assembly->schedule,
                              .camera = &out_assembly->camera};
  neph_result result = start(scene, plan, job, out_assembly);
  for (int i = 0; i < NP_STAGE_COUNT && !result; i++) {
    if (!np_plan_needs(plan, (np_stage)i) || !(stages & 1u << i)) continue;
    const double start_s = times ? np_cpu_time_s() : 0.0;
    result = build_stage((np_stage)i, &walk, out_assembly);
    if (times) times->cpu_s[i] = np_cpu_time_s() - start_s;
    const np_stage_maker *maker = np_stage_get_maker((np_stage)i);
    if (!result && maker->finish) result = maker->finish(scene, out_assembly, plan);
  }
  if (result) np_assembly_clear(out_assembly);
  return result;
}

neph_result np_assembly_build(const neph_scene *scene, np_plan *plan, const np_build_job *job, np_monitor *monitor,
                              np_assembly *out_assembly) {
  return np_assembly_build_some(scene, plan, UINT32_MAX, job, monitor, out_assembly);
}

static void clear_part(const np_stage_maker *maker, np_part_kind kind, const np_stage_task *task) {
  if (maker->clear[kind]) maker->clear[kind](task);
  if (maker->reuse && maker->reuse->kind == kind) return_part(maker->reuse, task);
}

static void clear_stage(np_stage stage, np_assembly *a) {
  const np_build_job job = {.stores = a->stores};
  const np_stage_part walk = {.context = a->context, .job = &job};
  for (int kind = NP_PART_KINDS; kind-- > 0;) {
    for (unsigned i = count_parts(a, stage).of[kind]; i-- > 0;) {
      const np_stage_task task = get_task(&walk, a, (np_part_kind)kind, i);
      clear_part(np_stage_get_maker(stage), (np_part_kind)kind, &task);
    }
  }
}

void np_assembly_clear(np_assembly *assembly) {
  for (int i = NP_STAGE_COUNT; i-- > 0;)
    if (assembly->built & 1u << i) clear_stage((np_stage)i, assembly);
  np_alloc_free(assembly->context, assembly->clouds.at);
  *assembly = (np_assembly){0};
}
