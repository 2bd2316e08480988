/* SPDX-License-Identifier: Apache-2.0 */
/* The reference of a report: pictures of the integrator path by many seeds, in two halves that know nothing of each
 * other; or a file. The standard error that a picture states is that of independent samples; those of a pixel are
 * spread evenly, and err by less. So the reference's own error is taken from the difference of its halves. */
#include <math.h>

#include "image/image_private.h"
#include "report/report_private.h"

/* Samples of the first two pictures. Each later picture doubles the samples of its half, until the time is used. */
enum { FIRST_SAMPLES = 4, SAMPLES_MAX = 4096, ROUNDS_MAX = 64 };

/* ---- Making ---- */

/* State while the two halves of the reference are rendered. */
typedef struct making {
  neph_report *report;
  neph_scene *scene;
  double seconds, sample_s; /* wall time: the allowed total, and the measured time of one sample of each half */
  unsigned round_count;
} making;

static neph_result render_half(making *m, unsigned half, unsigned samples) {
  np_report_reference *reference = &m->report->reference;
  neph_render_desc desc;
  neph_image *picture = NULL;
  np_setting cost = {.run_count = 0};
  neph_result result = np_report_describe_run(m->scene, NEPH_INTEGRATOR_PATH, samples, &desc);
  desc.seed = 2 * m->round_count + half;
  if (!result) result = np_report_render(m->report, m->scene, &desc, &cost, &picture);
  if (result) return result;
  reference->cpu_s += cost.cpu_s[0];
  if (!reference->halves[half]) {
    reference->halves[half] = picture;
    return NEPH_OK;
  }
  np_report_average(reference->halves[half], reference->sample_count / 2, picture, samples);
  neph_image_destroy(picture);
  return NEPH_OK;
}

/* Samples of the next picture of each half: 0 when time is up. */
static unsigned choose_samples(const making *m) {
  const unsigned done = m->report->reference.sample_count / 2;
  if (done == 0) return FIRST_SAMPLES;
  const double left_s = m->seconds - np_report_get_seconds(m->report), fitting = left_s / m->sample_s;
  if (m->round_count == ROUNDS_MAX || !(fitting >= FIRST_SAMPLES)) return 0;
  return (unsigned)fmin(fmin(done, SAMPLES_MAX), fitting);
}

static neph_result make_halves(making *m) {
  neph_result result = NEPH_OK;
  for (unsigned samples; !result && (samples = choose_samples(m)) > 0; m->round_count++) {
    const double before_s = np_report_get_seconds(m->report);
    result = render_half(m, 0, samples);
    if (!result) result = render_half(m, 1, samples);
    if (!result) m->report->reference.sample_count += 2 * samples;
    m->sample_s = (np_report_get_seconds(m->report) - before_s) / samples;
  }
  return result;
}

/* Mean of the halves, whose standard error is half their difference: of one pixel a guess, of many right in the mean of
 * squares. */
neph_result np_report_join_halves(neph_report *report) {
  static const char *const names[] = {"R", "G", "B", "standard_error.R", "standard_error.G", "standard_error.B"};
  np_report_reference *reference = &report->reference;
  const neph_image *first = reference->halves[0], *second = reference->halves[1];
  neph_result result = neph_image_create(report->context, first->width, first->height, 6, names, &reference->picture);
  for (int c = 0; !result && c < 3; c++) {
    const float *a = neph_image_get_values(first, names[c]), *b = neph_image_get_values(second, names[c]);
    float *mean = neph_image_get_channel(reference->picture, names[c]);
    float *error = neph_image_get_channel(reference->picture, names[c + 3]);
    for (size_t i = 0; i < (size_t)first->width * first->height; i++) {
      mean[i] = 0.5f * (a[i] + b[i]);
      error[i] = 0.5f * fabsf(a[i] - b[i]);
    }
  }
  if (!result) reference->picture->header = first->header;
  for (unsigned i = 0; !result && i < first->attribute_count; i++)
    result = neph_image_set_attribute(reference->picture, first->attributes[i].name, first->attributes[i].value);
  return result;
}

static neph_result make(neph_report *report, double seconds) {
  making m = {.report = report, .seconds = seconds};
  neph_result result = np_report_load(report, NULL, &m.scene);
  if (result) return result;
  m.scene->render.detail_px = 0.0; /* whatever is left out of quick pictures */
  report->stage = "reference";
  np_report_clear_stores(report);
  result = make_halves(&m);
  np_report_clear_stores(report);
  neph_scene_destroy(m.scene);
  return result ? result : np_report_join_halves(report);
}

/* ---- Both ---- */

/* Measures the relative standard error of the reference's pixels. */
static neph_result measure_noise(neph_report *report) {
  np_report_reference *reference = &report->reference;
  neph_image_difference own = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  neph_result result = neph_image_compare(report->context, reference->picture, reference->picture, &own);
  reference->noise = own.pixel_noise;
  return result;
}

neph_result np_report_make_reference(neph_report *report, double seconds) {
  neph_result result = report->reference.is_given ? NEPH_OK : make(report, seconds);
  report->reference.wall_s = np_report_get_seconds(report);
  return result ? result : measure_noise(report);
}
