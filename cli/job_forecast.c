/* SPDX-License-Identifier: Apache-2.0 */
#include "job_forecast.h"

#include <math.h>

/* Margin on predicted memory: measured peaks are 0.48 to 1.25 times the prediction, and the machine of the farm may
 * have another C library and more threads. */
static const double memory_factor = 1.5, memory_more = 256e6;

/* Margin on predicted time, which is within a factor of two or three on the machine that prints the job. A task that
 * reaches its limit resumes from its checkpoint. */
static const double time_factor = 4.0, time_more_s = 600.0;

/* Demands of a merge, which reads and writes, and holds the picture and its parts. */
static const double merge_films = 4.0, merge_frame_s = 60.0;

static const double mib = 1048576.0, minutes_max = 525600.0;

static farm_demand make_demand(double bytes, double seconds) {
  const double minutes = ceil((time_factor * seconds + time_more_s) / 60.0);
  return (farm_demand){.predicted_bytes = bytes,
                       .predicted_s = seconds,
                       .memory_mib = (unsigned long long)ceil((memory_factor * bytes + memory_more) / mib),
                       .minutes = (unsigned long long)fmin(minutes, minutes_max)};
}

cli_exit farm_job_forecast(farm_job *job, render_job *render) {
  neph_memory_estimate memory = NEPH_MEMORY_ESTIMATE_DEFAULT;
  double first_s = 0.0, next_s = 0.0;
  render->desc.frame = job->frames[0];
  if (job->tile_count > 1) render->desc.tile_count = job->tile_count;
  neph_result result = neph_render_estimate_memory(render->scene, &render->desc, &memory);
  if (!result) result = neph_render_estimate_time(render->scene, &render->desc, &first_s, &next_s);
  if (result) return cli_exit_of(result);
  const double eyes = neph_scene_is_stereo(render->scene) ? 2.0 : 1.0, length = (double)farm_job_get_chunk_length(job);
  const unsigned threads = job->thread_count ? job->thread_count : 1;
  job->render = make_demand((double)memory.total_bytes, (first_s + (eyes * length - 1.0) * next_s) / threads);
  const double film = (double)memory.film_bytes * (job->tile_count > 1 ? job->tile_count : 1);
  job->merge = make_demand((double)memory.program_bytes + merge_films * film, eyes * length * merge_frame_s);
  return CLI_DONE;
}
