/* SPDX-License-Identifier: Apache-2.0 */
/* The line that each frame ends with: its files, time, memory and error, for people or as JSON. */
#include <math.h>
#include <sys/resource.h>

#include "render_job.h"

/* Most memory that the process has had so far. */
static double get_memory_bytes(void) {
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * (double)usage.ru_maxrss;
}

/* "2.6", "12", "0.04": shares as per cent, to two digits. */
static void print_percent(double share) {
  const double percent = 100.0 * share;
  printf(percent >= 9.95 || percent == 0.0 ? "%.0f" : percent >= 0.995 ? "%.1f" : "%.2g", percent);
}

static void print_memory(double bytes) {
  if (bytes >= 1e9)
    printf("%.1f GB", 1e-9 * bytes);
  else
    printf("%.0f MB", 1e-6 * bytes);
}

static void print_bias(const neph_image_error *error) {
  if (error->bias.value == 0.0) {
    printf("no bias)");
    return;
  }
  printf("bias about ");
  print_percent(error->bias.value);
  printf("%s%s)", isnan(error->error.value) ? " %" : "", error->bias_source == NEPH_BIAS_BY_MODEL ? " by model" : "");
}

/* "error 2.6 % a pixel (noise 1.1, bias about 2.4)" */
static void print_error(const neph_image_error *error) {
  if (isnan(error->bias.value)) return;
  printf("; error ");
  if (isnan(error->error.value)) {
    printf("unknown (noise unknown, ");
  } else {
    print_percent(error->error.value);
    printf(" %% a pixel (noise ");
    print_percent(error->noise.value);
    printf(", ");
  }
  print_bias(error);
}

static void print_json_bounded(const char *name, const neph_bounded *figure) {
  const struct {
    const char *ending;
    double value;
  } parts[] = {{"", figure->value}, {"_min", figure->min}, {"_max", figure->max}};
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
    if (isnan(parts[i].value))
      printf(", \"%s%s\": null", name, parts[i].ending);
    else
      printf(", \"%s%s\": %.4g", name, parts[i].ending, parts[i].value);
}

/* Predictions, and CPU time of one core, that the header has of a frame with a target error or a time limit. */
static void print_json_predictions(const neph_image *image) {
  static const struct {
    const char *attribute, *name;
  } rows[] = {{"nephos:predictedSeconds", "predicted_seconds"},
              {"nephos:predictedBytes", "predicted_bytes"},
              {"nephos:predictedError", "predicted_error"},
              {"nephos:pilotSeconds", "pilot_seconds"},
              {"nephos:pilotError", "pilot_error"},
              {"nephos:cpuSeconds", "cpu_seconds"}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    const char *value = neph_image_get_attribute(image, rows[i].attribute);
    if (value) printf(", \"%s\": %s", rows[i].name, value);
  }
}

static void print_json_text(const char *name, const char *text) {
  printf(", \"%s\": ", name);
  cli_print_json_text(text);
}

static void print_json_facts(const frame_facts *facts) {
  static const char *const sources[] = {"null", "\"model\"", "\"measured\""};
  printf(", \"seconds\": %.3f, \"memory_bytes\": %.0f", facts->seconds, get_memory_bytes());
  print_json_bounded("error", &facts->error.error);
  print_json_bounded("noise", &facts->error.noise);
  print_json_bounded("bias", &facts->error.bias);
  printf(", \"bias_source\": %s", sources[facts->error.bias_source]);
  print_json_predictions(facts->image);
  if (facts->hash) print_json_text("hash", facts->hash);
  printf("}\n");
}

static void print_plain(const render_job *job, const render_targets *t, const frame_facts *facts) {
  const char *const names[] = {t->image, t->preview, t->deep}, *join = "";
  printf("frame %d: ", job->desc.frame);
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    if (!names[i]) continue;
    printf("%s%s", join, names[i]);
    join = ", ";
  }
  printf(", %.2f s, ", facts->seconds);
  print_memory(get_memory_bytes());
  print_error(&facts->error);
  printf("\n");
}

static void print_json(const render_job *job, const render_targets *t, const frame_facts *facts) {
  printf("{\"frame\": %d", job->desc.frame);
  if (t->image) print_json_text("image", t->image);
  if (t->preview) print_json_text("preview", t->preview);
  if (t->deep) print_json_text("deep", t->deep);
  print_json_facts(facts);
}

static const char *get_first_name(const render_targets *t) {
  return t->image ? t->image : t->preview ? t->preview : t->deep;
}

void render_job_print_frame(render_job *job, const render_targets *t, const frame_facts *facts) {
  if (job->session->options->is_json)
    print_json(job, t, facts);
  else
    print_plain(job, t, facts);
  cli_progress_note(&job->session->progress, "frame %d: %s, %.2f s, %.0f MB", job->desc.frame, get_first_name(t),
                    facts->seconds, 1e-6 * get_memory_bytes());
}

void render_job_print_skipped(render_job *job, const render_targets *t) {
  const char *name = get_first_name(t);
  cli_progress_note(&job->session->progress, "frame %d: %s is there", job->desc.frame, name);
  if (!job->session->options->is_json) {
    printf("frame %d: %s is there\n", job->desc.frame, name);
    return;
  }
  printf("{\"frame\": %d", job->desc.frame);
  print_json_text("image", name);
  printf(", \"skipped\": true}\n");
}

void render_job_print_failed(render_job *job, cli_exit exit) {
  const char *message = job->session->progress.message;
  cli_progress_note(&job->session->progress, "frame %d: failed, exit code %d", job->desc.frame, (int)exit);
  if (!job->session->options->is_json) return;
  printf("{\"frame\": %d, \"exit\": %d", job->desc.frame, (int)exit);
  if (*message) print_json_text("message", message);
  printf("}\n");
}
