/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "command_files.h"
#include "print.h"
#include "verbs.h"

/* One line for each measure; the JSON names are those of neph_image_difference. */
typedef struct measure {
  const char *name, *label;
  double value;
  bool is_optional; /* NaN prints no line */
} measure;

static void print_measures(const cli_session *session, const measure *measures, size_t count,
                           const neph_image_difference *difference) {
  const bool is_json = session->options->is_json;
  const unsigned long long values = difference->value_count, differing = difference->differing_count;
  for (size_t i = 0; i < count; i++) {
    const double value = measures[i].value;
    if (!is_json && measures[i].is_optional && (isnan(value) || !differing)) continue;
    if (is_json && isfinite(value))
      printf("\"%s\": %.9g, ", measures[i].name, value);
    else if (is_json)
      printf("\"%s\": null, ", measures[i].name);
    else
      printf("%-22s %.6g\n", measures[i].label, value);
  }
  if (is_json)
    printf("\"value_count\": %llu, \"differing_count\": %llu}\n", values, differing);
  else
    printf("%-22s %llu\n%-22s %llu\n", "values compared", values, "values that differ", differing);
}

/* Prints the value of a figure with its bounds. */
static void print_bounded(bool is_json, const char *name, const char *label, const neph_bounded *figure) {
  const struct {
    const char *ending;
    double value;
  } parts[] = {{"", figure->value}, {"_min", figure->min}, {"_max", figure->max}};
  for (size_t i = 0; is_json && i < sizeof parts / sizeof *parts; i++)
    if (isfinite(parts[i].value))
      printf("\"%s%s\": %.9g, ", name, parts[i].ending, parts[i].value);
    else
      printf("\"%s%s\": null, ", name, parts[i].ending);
  if (is_json) return;
  if (isnan(figure->value))
    printf("%-22s unknown\n", label);
  else if (isnan(figure->min))
    printf("%-22s %.3g %%\n", label, 100.0 * figure->value);
  else
    printf("%-22s %.3g %% (%.3g to %.3g)\n", label, 100.0 * figure->value, 100.0 * figure->min, 100.0 * figure->max);
}

/* Explains a 0, or an error or bias that is unknown although the noise is known. */
static void print_clamped(const neph_image_difference *difference) {
  const neph_bounded *error = &difference->pixel_error, *bias = &difference->pixel_bias;
  if (!difference->differing_count) return;
  if (isnan(error->value) || (isnan(bias->value) && !isnan(difference->pixel_noise.value)))
    printf("%-22s %s\n", "unknown",
           "the differences are less than the stated noise: pictures share it, or it is too large");
  else if (error->value == 0.0 || bias->value == 0.0)
    printf("%-22s %s\n", "0 %", "the noise hides it: it is between the bounds");
}

/* States for each measure whether the reference's noise is included. */
static void print_reference_noise(bool is_json, const neph_image_difference *difference) {
  static const char *const names[] = {"null", "\"header\"", "\"pixel\""};
  static const char *const origins[] = {"", "its header", "its standard errors"};
  const neph_noise_source source = difference->reference_noise_source;
  print_bounded(is_json, "reference_noise", "noise of the reference", &difference->reference_noise);
  if (is_json)
    printf("\"reference_noise_source\": %s, ", names[source]);
  else if (source == NEPH_NOISE_UNKNOWN)
    printf("%-22s in every measure; the bias below has it in its interval alone\n", "");
  else
    printf("%-22s by %s: taken off the errors a pixel, in the measures below; the bias has it in its interval alone\n",
           "", origins[source]);
}

static void print_errors(const cli_session *session, const neph_image_difference *difference) {
  const bool is_json = session->options->is_json;
  print_bounded(is_json, "pixel_error", "error a pixel", &difference->pixel_error);
  print_bounded(is_json, "pixel_noise", "error a pixel: noise", &difference->pixel_noise);
  print_bounded(is_json, "pixel_bias", "error a pixel: bias", &difference->pixel_bias);
  if (!is_json) print_clamped(difference);
  if (is_json || difference->differing_count) print_reference_noise(is_json, difference);
  if (is_json) printf("\"pixel_count\": %llu, ", (unsigned long long)difference->pixel_count);
}

static void print_difference(const cli_session *session, const neph_image_difference *difference) {
  const measure measures[] = {
      {"relative_mse", "relative MSE", difference->relative_mse, false},
      {"rmse", "RMSE", difference->rmse, false},
      {"bias", "bias", difference->bias, false},
      {"bias_interval", "bias, 95 % within +-", difference->bias_interval, false},
      {"block_rms", "block rms", difference->block_rms, false},
      {"noise_rmse", "noise: RMSE", difference->noise_rmse, true},
      {"noise_bias", "noise: bias", difference->noise_bias, true},
      {"noise_block_rms", "noise: block rms", difference->noise_block_rms, true},
      {"p999_relative", "99.9 % relative", difference->p999_relative, false},
      {"max_absolute", "largest difference", difference->max_absolute, false},
  };
  if (session->options->is_json) printf("{");
  print_errors(session, difference);
  print_measures(session, measures, sizeof measures / sizeof *measures, difference);
}

static cli_exit judge(const cli_options *options, const neph_image_difference *difference) {
  if (options->is_exact && difference->differing_count) {
    cli_complain("%s and %s differ in %llu values", options->files[0], options->files[1],
                 (unsigned long long)difference->differing_count);
    return CLI_DIFFERENT;
  }
  if (options->has_relative_mse_max && !(difference->relative_mse <= options->relative_mse_max)) {
    cli_complain("the relative MSE is %.6g, above %.6g", difference->relative_mse, options->relative_mse_max);
    return CLI_DIFFERENT;
  }
  return CLI_DONE;
}

static neph_result save_difference(cli_session *session, const neph_image *image, const neph_image *reference,
                                   const char *path) {
  neph_image *picture;
  cli_catch_interrupts();
  neph_result result = neph_image_create_difference(session->context, image, reference, &picture);
  if (!result) result = neph_image_save_exr(picture, path, NEPH_PIXEL_FLOAT);
  neph_image_destroy(picture);
  return result;
}

static cli_exit check_target(const cli_session *session) {
  const cli_exit exit = cli_check_target(session, session->options->outputs[0]);
  return exit ? exit : cli_files_check_output(session);
}

static cli_exit check_output(const cli_session *session) {
  const cli_options *options = session->options;
  if (!options->output_count) return CLI_DONE;
  if (options->output_count == 1 && cli_has_extension(options->outputs[0], ".exr")) return check_target(session);
  cli_complain("--output of nephos compare must be one .exr");
  return CLI_USAGE;
}

static cli_exit compare_images(cli_session *session, const neph_image *image, const neph_image *second,
                               const neph_image *reference) {
  const cli_options *options = session->options;
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  neph_result result = second ? neph_image_compare_seeds(session->context, image, second, reference, &difference)
                              : neph_image_compare(session->context, image, reference, &difference);
  if (!result && options->output_count) result = save_difference(session, image, reference, options->outputs[0]);
  if (result) return cli_exit_of(result);
  print_difference(session, &difference);
  return judge(options, &difference);
}

static cli_exit run_compare(cli_session *session) {
  const cli_options *options = session->options;
  neph_image *image = NULL, *second = NULL, *reference = NULL;
  cli_exit exit = check_output(session);
  if (exit) return exit;
  neph_result result = neph_image_load_exr(session->context, options->files[0], &image);
  if (!result) result = neph_image_load_exr(session->context, options->files[1], &reference);
  if (!result && options->second) result = neph_image_load_exr(session->context, options->second, &second);
  exit = result ? cli_exit_of(result) : compare_images(session, image, second, reference);
  neph_image_destroy(image);
  neph_image_destroy(second);
  neph_image_destroy(reference);
  return exit;
}

const cli_verb cli_verb_compare = {
    .name = "compare",
    .arguments = "PICTURE REFERENCE",
    .summary = "measure the difference of an OpenEXR picture from a reference",
    .argument_min = 2,
    .argument_max = 2,
    .run = run_compare,
    .files = "exr",
    .exits = CLI_MAY(CLI_NOT_FOUND) | CLI_MAY(CLI_DIFFERENT),
    .description =
        "Prints measures of the difference. The error a pixel is the relative rms difference of luminance over "
        "the pixels brighter than a hundredth of the mean, with 95 % bounds; noise and bias are told apart by "
        "--second, by the picture's channels `standard_error.*`, or by its header. The reference's own noise, by its "
        "channels `standard_error.*` or its header, is taken off these three. The other measures have it in them; "
        "lines that begin with `noise:` give its part.",
    .options = {{"--output", "write a picture of the difference to FILE, an .exr", .files = "exr"},
                {"--second"},
                {"--exact"},
                {"--max-rel-mse"}},
    .examples = {{"nephos compare frame.exr reference.exr", "print the measures"},
                 {"nephos compare frame.exr reference.exr --max-rel-mse 0.01", "fail where the pictures differ much"}},
};
