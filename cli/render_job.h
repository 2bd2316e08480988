/* SPDX-License-Identifier: Apache-2.0 */
/* A run of `nephos render`: its scene, its frames and their files. */
#ifndef NEPHOS_CLI_RENDER_JOB_H
#define NEPHOS_CLI_RENDER_JOB_H

#include "failures.h"
#include "session.h"

/* The files of one frame; NULL: not wanted. */
typedef struct render_targets {
  char *image, *preview, *deep;
  bool is_part;                /* `image` is the file of a part */
  char *checkpoint, *snapshot; /* NULL: none is kept; none can be taken */
} render_targets;

/* The frames of a batch. */
typedef struct frame_batch {
  unsigned count, begun_count;
  double first_s, next_s; /* predicted, of the first frame, and of those that follow it */
  cli_failures failures;
  bool is_stopped; /* the rest would fail as well: what is done cannot be written */
} frame_batch;

/* A frame that is done. */
typedef struct frame_facts {
  double seconds;
  neph_image_error error;
  const neph_image *image;
  const char *hash;     /* of the picture; NULL: it has none */
  double preview_stops; /* of its exposure; NAN: there is no preview */
} frame_facts;

typedef struct render_job {
  cli_session *session;
  neph_scene *scene;
  neph_render_desc desc;
  neph_machine machine; /* what time is predicted by */
  neph_output output;
  frame_batch batch;
  neph_files *files;    /* while they are checked: the table that a check of targets adds to */
  const char *snapshot; /* of the frame under way; NULL: none can be taken */
  const char *matched;  /* what the previews share an exposure of the meter with; NULL: it was not chosen for that */
  bool is_lift_told;    /* that a preview is lifted, in a warning */
} render_job;

/* Resolution, pixels, machine and effort, by the scene and the options. */
cli_exit render_job_choose_settings(render_job *job);

/* Output files, by --output or the scene, whose names tell eyes and frames apart; CLI_USAGE, after a message, where
 * there is none, or they do not. */
cli_exit render_job_choose_outputs(render_job *job);

/* The names of the job's frame and eye, to be freed. */
neph_result render_job_name_targets(const render_job *job, render_targets *out);
void render_job_free_targets(const render_job *job, render_targets *t);

/* Exposes previews of parts, and of frames, by the light on the scene where they would be by the picture, so that they
 * match. */
void render_job_choose_exposure(render_job *job, bool is_part);

/* Calls `step` for each frame, or each eye's picture of one, until one fails or the process is interrupted. */
cli_exit render_job_for_each_frame(render_job *job, cli_exit (*step)(render_job *job));
cli_exit render_job_for_each_eye(render_job *job, cli_exit (*step)(render_job *job));

/* Names and settings of a frame's part, checkpoint and snapshots, for the names that it has; `desc` borrows them. */
neph_result render_job_set_restart(render_job *job, render_targets *t);

/* Removes the checkpoint of a frame that is finished, unless it is the part itself. */
void render_job_remove_checkpoint(const render_targets *t);

/* Whether the frame's files are all there, and those of the same picture. */
neph_result render_job_check_done(const render_job *job, const render_targets *t, bool *out_is_done);

/* The exit code of a run that keeps checkpoints, of one that may have been stopped. */
cli_exit render_job_end_restart(const render_job *job, cli_exit exit);

/* Warns once of a preview that shows the dark as bright. */
void render_job_warn_of_lift(render_job *job, const frame_facts *facts);

/* The line of a frame that is done, is there already, or failed, on standard output. */
void render_job_print_frame(render_job *job, const render_targets *t, const frame_facts *facts);
void render_job_print_skipped(render_job *job, const render_targets *t);
void render_job_print_failed(render_job *job, cli_exit exit);

/* Adds the files of a frame to the table. */
cli_exit render_job_add_targets(const render_job *job, const render_targets *t);

/* Names the checkpoint and the snapshot, where they are kept. */
neph_result render_job_name_restart(const render_job *job, render_targets *t);

/* Whether the files of the job's frame can be written, and of its clouds that are baked to files. Adds them to the
 * table. */
cli_exit render_job_check_targets(render_job *job);

#endif
