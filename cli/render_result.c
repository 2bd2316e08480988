/* SPDX-License-Identifier: Apache-2.0 */
/* The line of a finished frame: its files, time, memory and error, as text or as JSON. */
#include <math.h>
#include <stdlib.h>

#include "print.h"
#include "render_job.h"

/* Attributes of a rendered picture, in degrees. */
static const char sun_elevation[] = "nephos:sunElevation", sun_azimuth[] = "nephos:sunAzimuth";

/* Prints shares as per cent, to two digits: "2.6", "12", "0.04". */
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

/* Prints the error of a picture: "error 2.6 % a pixel (noise 1.1, bias about 2.4)". */
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

static double get_number(const neph_image *image, const char *attribute) {
  const char *text = neph_image_get_attribute(image, attribute);
  return text ? strtod(text, NULL) : (double)NAN;
}

/* Prints the sun's position: "; sun at elevation -17.5°, azimuth 26.4°". */
static void print_sun(const neph_image *image) {
  const double elevation = get_number(image, sun_elevation);
  if (isnan(elevation)) return;
  printf("; sun at elevation %.1f°, azimuth %.1f°", elevation, get_number(image, sun_azimuth));
}

static const char *get_exposure_name(const render_job *job) {
  static const char *const names[] = {[NEPH_EXPOSURE_AUTO] = "auto",
                                      [NEPH_EXPOSURE_METER] = "meter",
                                      [NEPH_EXPOSURE_FIXED] = "fixed",
                                      [NEPH_EXPOSURE_CAMERA] = "camera"};
  return names[job->output.preview_desc.exposure];
}

/* Prints the exposure of a preview: "; preview +2.3 stops by meter, so that frames match". */
static void print_exposure(const render_job *job, const frame_facts *facts) {
  if (isnan(facts->preview_stops)) return;
  printf("; preview %+.1f stops by %s", facts->preview_stops, get_exposure_name(job));
  if (job->matched) printf(", so that %s match", job->matched);
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

/* Prints the predictions and the CPU time of one core from the header of a frame with a target error or a time
 * limit. */
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

static void print_json_light(const render_job *job, const frame_facts *facts) {
  const double elevation = get_number(facts->image, sun_elevation);
  if (!isnan(elevation))
    printf(", \"sun_elevation_deg\": %.4f, \"sun_azimuth_deg\": %.4f", elevation,
           get_number(facts->image, sun_azimuth));
  if (!isnan(facts->preview_stops))
    printf(", \"preview_stops\": %.3f, \"preview_exposure\": \"%s\"", facts->preview_stops, get_exposure_name(job));
}

static void print_json_facts(const render_job *job, const frame_facts *facts) {
  static const char *const sources[] = {"null", "\"model\"", "\"measured\""};
  printf(", \"seconds\": %.3f, \"memory_bytes\": %.0f", facts->seconds, cli_get_peak_memory_bytes());
  print_json_bounded("error", &facts->error.error);
  print_json_bounded("noise", &facts->error.noise);
  print_json_bounded("bias", &facts->error.bias);
  printf(", \"bias_source\": %s", sources[facts->error.bias_source]);
  print_json_predictions(facts->image);
  print_json_light(job, facts);
  if (facts->hash) print_json_text("hash", facts->hash);
  printf("}\n");
}

static void print_plain(const render_job *job, const render_targets *t, const frame_facts *facts) {
  const char *const names[] = {t->image, t->preview, t->deep}, *join = "";
  printf("frame %d: ", job->desc.frame);
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    if (!names[i]) continue;
    fputs(join, stdout);
    cli_show(names[i]);
    join = ", ";
  }
  printf(", %.2f s, ", facts->seconds);
  print_memory(cli_get_peak_memory_bytes());
  print_error(&facts->error);
  print_sun(facts->image);
  print_exposure(job, facts);
  printf("\n");
}

static void print_json(const render_job *job, const render_targets *t, const frame_facts *facts) {
  printf("{\"frame\": %d", job->desc.frame);
  if (t->image) print_json_text("image", t->image);
  if (t->preview) print_json_text("preview", t->preview);
  if (t->deep) print_json_text("deep", t->deep);
  print_json_facts(job, facts);
}

static const char *get_first_name(const render_targets *t) {
  return t->image ? t->image : t->preview ? t->preview : t->deep;
}

/* A perfect diffuser under the sun and sky of noon is near 1, at a scale of 2. */
void render_job_warn_of_lift(render_job *job, const frame_facts *facts) {
  static const double most_stops = 10.0, scale_of_noon = 2.0;
  const double scale = get_number(facts->image, "nephos:scale"), elevation = get_number(facts->image, sun_elevation);
  const double lift = facts->preview_stops - job->output.preview_desc.exposure_ev + log2(scale / scale_of_noon);
  char text[400], sun[80] = "";
  if (job->is_lift_told || job->output.preview_desc.exposure == NEPH_EXPOSURE_FIXED || !(lift > most_stops)) return;
  if (!isnan(elevation)) cli_print(sun, sizeof sun, " with the sun at elevation %.1f°", elevation);
  cli_print(text, sizeof text,
            "the preview is lifted by %.1f stops from the exposure of noon: the picture of frame %d is that dark%s; "
            "set output.exposure to a number of stops to see it as it is",
            lift, job->desc.frame, sun);
  cli_progress_log(&job->session->progress, NEPH_LOG_WARNING, text);
  job->is_lift_told = true;
}

void render_job_print_frame(render_job *job, const render_targets *t, const frame_facts *facts) {
  if (job->session->options->is_json)
    print_json(job, t, facts);
  else
    print_plain(job, t, facts);
  cli_progress_note(&job->session->progress, "frame %d: %s, %.2f s, %.0f MB", job->desc.frame, get_first_name(t),
                    facts->seconds, 1e-6 * cli_get_peak_memory_bytes());
}

void render_job_print_skipped(render_job *job, const render_targets *t) {
  const char *name = get_first_name(t);
  cli_progress_note(&job->session->progress, "frame %d: %s is there", job->desc.frame, name);
  if (!job->session->options->is_json) {
    cli_say("frame %d: %s is there", job->desc.frame, name);
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
  if (message) print_json_text("message", message);
  printf("}\n");
}
