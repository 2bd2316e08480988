/* SPDX-License-Identifier: Apache-2.0 */
#include "render/schedule.h"

/* Of what is left of a limit, at the most and, unless nothing is left, at the least. */
static const double solving_share = 0.6, solving_share_min = 0.1;

/* Bytes of film that a second makes into files, on two cores: half of it to an .exr, half to a .png. */
static const double written_bytes_per_s = 8e7;

static bool needs(const np_plan *plan, np_stage stage) { return plan->stages[stage].is_needed; }

static double count_pixels(const np_plan *plan) {
  const neph_render_desc *desc = &plan->desc;
  return (double)(desc->crop_max[0] - desc->crop_min[0]) * (desc->crop_max[1] - desc->crop_min[1]);
}

static double count_air_rays(const np_plan *plan) {
  return plan->air_ray_spacing ? count_pixels(plan) / ((double)plan->air_ray_spacing * plan->air_ray_spacing) : 0.0;
}

/* Of one sample; where there are clouds and no volume of depths the march goes towards the sun from every step. */
static double guess_ray(const np_plan *plan) {
  if (plan->desc.integrator == NEPH_INTEGRATOR_PATH) return 1e-4;
  return needs(plan, NP_STAGE_VOLUMES) && !needs(plan, NP_STAGE_SUN_DEPTH) ? 3e-5 : 4e-6;
}

/* On two cores, within a factor of two or three of what the sample scenes take. */
static void guess_seconds(const np_plan *plan, unsigned cloud_count, double out[NP_WORK_COUNT]) {
  const double clouds = fmax(cloud_count, 1.0);
  out[NP_WORK_TERRAIN] = 0.8;
  out[NP_WORK_CLOUD] = 0.1 + (2e-8 * plan->bake_voxel_count + 5e-8 * plan->cloud_voxel_count) / clouds;
  out[NP_WORK_ATMOSPHERE] = 0.1;
  out[NP_WORK_SKIES] = 0.1;
  out[NP_WORK_EMISSION] = 0.2;
  out[NP_WORK_SUN_DEPTH] = 0.1 + 1e-7 * plan->cloud_voxel_count;
  out[NP_WORK_ORDINATES] = fmin(0.3 + 4e-6 * plan->cloud_voxel_count, 8.0);
  out[NP_WORK_GROUND_CLOUDS] = 0.2;
  out[NP_WORK_AIR_SHADOWS] = 0.1 + 3e-5 * count_air_rays(plan);
  out[NP_WORK_PIXELS] = guess_ray(plan) * (double)plan->ray_count;
}

/* How often each is done. */
static void count_work(const np_plan *plan, unsigned cloud_count, double packets, double lights,
                       double out[NP_WORK_COUNT]) {
  const bool has_skies = needs(plan, NP_STAGE_CAMERA_SKY) || needs(plan, NP_STAGE_CLOUD_SKY);
  out[NP_WORK_TERRAIN] = needs(plan, NP_STAGE_TERRAIN) ? 1.0 : 0.0;
  out[NP_WORK_CLOUD] = needs(plan, NP_STAGE_VOLUMES) ? cloud_count : 0.0;
  out[NP_WORK_ATMOSPHERE] = needs(plan, NP_STAGE_ATMOSPHERE) ? packets : 0.0;
  out[NP_WORK_SKIES] = has_skies ? packets * lights : 0.0;
  out[NP_WORK_EMISSION] = needs(plan, NP_STAGE_EMISSION) ? packets : 0.0;
  out[NP_WORK_SUN_DEPTH] = needs(plan, NP_STAGE_SUN_DEPTH) ? lights : 0.0;
  out[NP_WORK_ORDINATES] = needs(plan, NP_STAGE_ORDINATES) ? packets * lights : 0.0;
  out[NP_WORK_GROUND_CLOUDS] = needs(plan, NP_STAGE_GROUND_CLOUDS) ? packets * lights : 0.0;
  out[NP_WORK_AIR_SHADOWS] = needs(plan, NP_STAGE_AIR_SHADOWS) ? packets * lights : 0.0;
  out[NP_WORK_PIXELS] = 1.0;
}

/* Half of the grace is for files; what they take beyond it comes off the limit. */
static void set_limits(const np_plan *plan, np_schedule *s) {
  const double limit_s = plan->desc.time_limit_s, grace_s = fmax(0.1 * limit_s, 1.0);
  const double files_s = (double)plan->film_bytes / written_bytes_per_s;
  s->limit_s = s->first_samples_s = s->deadline_s = HUGE_VAL;
  if (!isfinite(limit_s)) return;
  s->limit_s = fmax(limit_s - fmax(files_s - 0.5 * grace_s, 0.0), 0.0);
  s->first_samples_s = s->limit_s + 0.25 * grace_s;
  s->deadline_s = s->limit_s + 0.5 * grace_s;
}

void np_schedule_make(const np_plan *plan, unsigned cloud_count, np_schedule *out) {
  const bool has_moon = needs(plan, NP_STAGE_MOON), has_sun = plan->has_sun || !has_moon;
  const double packets = plan->packet_count, lights = (has_moon ? 1.0 : 0.0) + (has_sun ? 1.0 : 0.0);
  double counts[NP_WORK_COUNT];
  *out = (np_schedule){.all_s = 0.0};
  guess_seconds(plan, cloud_count, out->seconds);
  out->seconds[NP_WORK_PIXELS] *= packets * lights;
  count_work(plan, cloud_count, packets, lights, counts);
  for (int w = 0; w < NP_WORK_COUNT; w++) out->all_s += counts[w] * out->seconds[w];
  out->indispensable_s = packets * lights * guess_ray(plan) * count_pixels(plan);
  for (int w = NP_WORK_GROUND_CLOUDS; w < NP_WORK_PIXELS; w++) out->indispensable_s += counts[w] * out->seconds[w];
  out->solves_left = (unsigned)counts[NP_WORK_ORDINATES];
  set_limits(plan, out);
}

/* What was kept from the frame before takes no time, and leaves its part behind all the same. */
void np_schedule_begin(np_schedule *s, np_monitor *monitor, np_work work) {
  const double all_s = fmax(s->all_s, 1e-9), begin = fmin(s->begun_s / all_s, 1.0);
  s->begun_s += s->seconds[work];
  const double end = work == NP_WORK_PIXELS ? 1.0 : fmin(s->begun_s / all_s, 1.0);
  np_monitor_set_part(monitor, np_monitor_whole, begin, end);
}

/* A machine that has taken longer than was guessed, being slow or shared, does so further on. */
double np_schedule_take_solve(np_schedule *s, const np_monitor *monitor) {
  if (!isfinite(s->limit_s)) return HUGE_VAL;
  const double now_s = np_monitor_get_seconds(monitor), left_s = fmax(s->limit_s - now_s, 0.0);
  const double slowness = s->begun_s > 0.0 ? fmax(now_s / s->begun_s, 1.0) : 1.0;
  const double spared_s = left_s - slowness * s->indispensable_s;
  const unsigned solves = s->solves_left > 1 ? s->solves_left : 1;
  s->solves_left = solves - 1;
  return fmin(fmax(spared_s, solving_share_min * left_s), solving_share * left_s) / solves;
}
