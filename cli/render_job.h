/* SPDX-License-Identifier: Apache-2.0 */
/* A run of `nephos render`: its scene, its frames and their files. */
#ifndef NEPHOS_CLI_RENDER_JOB_H
#define NEPHOS_CLI_RENDER_JOB_H

#include "failures.h"
#include "session.h"

/* The files of one frame; NULL: no such file. */
typedef struct render_targets {
  char *image, *preview, *deep;
  bool is_part;                /* `image` is the file of a part */
  char *checkpoint, *snapshot; /* NULL: no checkpoint; no snapshot */
} render_targets;

/* The frames of a batch. */
typedef struct frame_batch {
  unsigned count, begun_count;
  double first_s, next_s; /* predicted seconds of the first frame, and of each later one */
  cli_failures failures;
  bool is_stopped; /* results cannot be written, so that the remaining frames are not rendered */
} frame_batch;

/* Facts of a finished frame. */
typedef struct frame_facts {
  double seconds;
  neph_image_error error;
  const neph_image *image;
  const char *hash;     /* hash of the picture; NULL: it has none */
  double preview_stops; /* exposure of the preview; NAN: there is no preview */
} frame_facts;

typedef struct render_job {
  cli_session *session;
  neph_scene *scene;
  neph_renderer *renderer; /* one renderer for all frames */
  neph_render_desc desc;
  neph_machine machine; /* speed for predictions of time */
  neph_output output;
  frame_batch batch;
  neph_files *files;    /* table of files during the check of targets; NULL otherwise */
  const char *snapshot; /* snapshot of the current frame; NULL: none can be taken */
  const char *matched;  /* reason for which previews share the meter's exposure; NULL: they do not */
  bool is_lift_told;    /* a warning has been given that a preview brightens the dark */
} render_job;

/* Chooses resolution, pixels, machine and effort from the scene and the options. */
cli_exit render_job_choose_settings(render_job *job);

/* Chooses output files from --output or the scene. Names must differ between eyes and frames. Returns CLI_USAGE, after
 * a message, where there is no file, or names coincide. */
cli_exit render_job_choose_outputs(render_job *job);

/* Names the files of the job's current frame and eye; the caller frees them. */
neph_result render_job_name_targets(const render_job *job, render_targets *out);
void render_job_free_targets(const render_job *job, render_targets *t);

/* Exposes previews of parts, and of frames, by the light on the scene in place of the automatic exposure, so that they
 * match. */
void render_job_choose_exposure(render_job *job, bool is_part);

/* Calls `step` for each frame, or each eye's picture of one, until one fails or the process is interrupted. */
cli_exit render_job_for_each_frame(render_job *job, cli_exit (*step)(render_job *job));
cli_exit render_job_for_each_eye(render_job *job, cli_exit (*step)(render_job *job));

/* Sets the names and options of a frame's part, checkpoint and snapshots, where they have names; `desc` borrows
 * them. */
neph_result render_job_set_restart(render_job *job, render_targets *t);

/* Removes the checkpoint of a frame that is finished, unless it is the part itself. */
void render_job_remove_checkpoint(const render_targets *t);

/* Whether all files of the frame exist and hold this picture. */
neph_result render_job_check_done(const render_job *job, const render_targets *t, bool *out_is_done);

/* Exit code of a run that may have been stopped and keeps checkpoints. */
cli_exit render_job_end_restart(const render_job *job, cli_exit exit);

/* Warns once where a preview brightens a dark scene. */
void render_job_warn_of_lift(render_job *job, const frame_facts *facts);

/* Prints the line of a frame that is finished, existed already, or failed, on standard output. */
void render_job_print_frame(render_job *job, const render_targets *t, const frame_facts *facts);
void render_job_print_skipped(render_job *job, const render_targets *t);
void render_job_print_failed(render_job *job, cli_exit exit);

/* Adds the files of a frame to the table. */
cli_exit render_job_add_targets(const render_job *job, const render_targets *t);

/* Names the checkpoint and the snapshot, where they are enabled. */
neph_result render_job_name_restart(const render_job *job, render_targets *t);

/* Checks that the files of the job's frame, and of its clouds that are baked to files, can be written. Adds them to the
 * table. */
cli_exit render_job_check_targets(render_job *job);

#endif
