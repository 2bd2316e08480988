/* SPDX-License-Identifier: Apache-2.0 */
/* Parts, checkpoints, snapshots, and frames that exist already. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "render_job.h"

/* The frame's first name with another ending; the caller frees it. NULL: no memory. */
static char *name_beside(const render_targets *t, const char *ending) {
  const char *name = t->image ? t->image : t->preview ? t->preview : t->deep, *dot = strrchr(name, '.');
  char *named;
  return asprintf(&named, "%.*s%s", dot ? (int)(dot - name) : (int)strlen(name), name, ending) < 0 ? NULL : named;
}

static bool keeps_checkpoints(const cli_options *options) { return options->checkpoint_s > 0.0 || options->is_resumed; }

/* Saves a snapshot; unfinished tiles are black in it. */
static bool save_snapshot(void *user, const neph_tile *tile) {
  const render_job *job = user;
  if (!cli_take_snapshot() || neph_image_save_exr(tile->image, job->snapshot, job->output.pixel_type)) return true;
  cli_progress_log(&job->session->progress, NEPH_LOG_INFO, "a snapshot is written:");
  cli_progress_log(&job->session->progress, NEPH_LOG_INFO, job->snapshot);
  return true;
}

neph_result render_job_name_restart(const render_job *job, render_targets *t) {
  const cli_options *options = job->session->options;
  t->is_part = t->image && cli_has_extension(t->image, ".npart");
  if (keeps_checkpoints(options)) t->checkpoint = t->is_part ? strdup(t->image) : name_beside(t, ".npart");
  t->snapshot = name_beside(t, ".snapshot.exr");
  return t->snapshot && (t->checkpoint || !keeps_checkpoints(options)) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

neph_result render_job_set_restart(render_job *job, render_targets *t) {
  const cli_options *options = job->session->options;
  neph_render_desc *desc = &job->desc;
  const bool has_limit = desc->time_limit_s < NEPH_UNLIMITED;
  const neph_result result = render_job_name_restart(job, t);
  if (result) return result;
  desc->part_path = t->is_part ? t->image : NULL;
  desc->checkpoint_path = t->checkpoint;
  desc->checkpoint_interval_s = options->checkpoint_s > 0.0 ? options->checkpoint_s : NEPH_UNLIMITED;
  desc->is_resumed = options->is_resumed;
  job->snapshot = t->snapshot;
  desc->tile = has_limit ? NULL : save_snapshot; /* passes of a time limit would each call it, which takes time */
  desc->tile_user = job;
  return NEPH_OK;
}

void render_job_remove_checkpoint(const render_targets *t) {
  if (!t->checkpoint) return;
  if (!t->is_part) remove(t->checkpoint);
  neph_checkpoint_clear_light(t->checkpoint);
}

neph_result render_job_check_done(const render_job *job, const render_targets *t, bool *out_is_done) {
  *out_is_done = false;
  if (!t->image || (t->preview && access(t->preview, R_OK)) || (t->deep && access(t->deep, R_OK))) return NEPH_OK;
  return neph_render_is_done(job->scene, &job->desc, t->image, out_is_done);
}

cli_exit render_job_end_restart(const render_job *job, cli_exit exit) {
  const char *signal = cli_get_terminator();
  if (exit != CLI_INTERRUPTED || !signal || !keeps_checkpoints(job->session->options)) return exit;
  cli_progress_complain(&job->session->progress, "stopped by %s: --resume goes on", signal);
  return CLI_STOPPED;
}
