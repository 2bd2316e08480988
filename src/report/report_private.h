/* SPDX-License-Identifier: Apache-2.0 */
/* The inside of a report. */
#ifndef NP_REPORT_REPORT_PRIVATE_H
#define NP_REPORT_REPORT_PRIVATE_H

#include <nephos/report.h>

#include "report/report_fit.h"
#include "report/report_knobs.h"
#include "stages/stores.h"

/* Limits on the measurements of a setting, with two runs each. */
enum { NP_REPORT_VISITS_MAX = 5, NP_REPORT_RUNS_MAX = 2 * NP_REPORT_VISITS_MAX };

/* One point of the sweep: the scene's settings with one knob turned. */
typedef struct np_setting {
  const np_knob *knob; /* NULL: the scene's own */
  np_knob_value value;
  neph_integrator integrator;
  unsigned sample_count;
  unsigned family;    /* settings of equal number differ in samples alone, and share their stages */
  double predicted_s; /* the plan's forecast */
  char text[96];      /* key and value in the syntax of --set */
  unsigned run_count;
  double cpu_s[NP_REPORT_RUNS_MAX];
  double stage_s;          /* least time besides the samples: stages, and the estimate of the error */
  double visit_s;          /* longest wall time of a measurement */
  neph_image *pictures[2]; /* mean pictures of the first and of the second seed over all measurements; NULL: left out */
  unsigned visit_count;
  neph_bounded error, noise, bias, effect;
  neph_bounded stated; /* error by the picture's header */
  bool is_on_front;
} np_setting;

/* Curve of a knob: settings that differ in this knob alone, among them the scene's. */
typedef struct np_curve {
  const np_knob *knob;
  const np_setting *own; /* the scene's own, by the knob's integrator; NULL: not listed */
  np_knob_value own_value;
  neph_bounded own_effect;
  np_order_fit fit;
} np_curve;

enum { NP_REPORT_SETTINGS_MAX = 96, NP_REPORT_CURVES_MAX = 24, NP_REPORT_TARGETS = 4 };

/* The cheapest way to an error, by the noise, the bias and the time of a family. */
typedef struct np_target {
  double error;              /* target error */
  const np_setting *setting; /* NULL: none reaches it */
  unsigned sample_count;
  double cpu_s, cpu_min_s, cpu_max_s; /* 95 %; infinite: the bias may be above the error */
  bool is_extrapolated;               /* it has more than twice the samples that were measured */
} np_target;

typedef struct np_report_reference {
  neph_image *picture;   /* the picture, with standard_error.* where its error is known */
  neph_image *halves[2]; /* the two whose mean it is; NULL: given */
  bool is_given;
  unsigned sample_count; /* 0: not stated */
  double cpu_s, wall_s;
  neph_bounded noise; /* relative standard error of its pixels; NaN: not stated */
} np_report_reference;

struct neph_report {
  neph_context *context; /* retained */
  char *name, *reference_path;
  neph_report_desc desc; /* the caller's description, with copied texts */
  neph_integrator own_integrator;
  unsigned sample_counts[2]; /* samples of each integrator, where no knob says another */
  unsigned setting_count, family_count, curve_count;
  np_setting settings[NP_REPORT_SETTINGS_MAX];
  np_setting *guide; /* the march's setting without changed knobs except samples; it is measured first */
  np_curve curves[NP_REPORT_CURVES_MAX];
  np_target targets[NP_REPORT_TARGETS];
  np_report_reference reference;
  neph_scene *scene;              /* the scene of no setting, which lends the preview its texts */
  neph_preview_desc preview;      /* the preview of all pictures, by one exposure */
  neph_image *yardstick;          /* pixels that errors are relative to */
  np_stores stores;               /* stores of the family that was rendered last, or, in a quick report, of all */
  unsigned stored_family;         /* number of that family, from 1 */
  double stage_s[NP_STAGE_COUNT]; /* CPU time of these stages */
  unsigned round_count;
  double start_s, spent_s; /* wall time: start of the run, and its duration */
  double fraction;         /* reported last */
  const char *stage;       /* stage in the progress callback */
  double deadline_s;       /* time at which the current picture is abandoned */
  bool is_late;            /* the deadline was past */
  bool is_complete, is_cancelled;
};

/* ---- Sweep: report_sweep.c ---- */

/* Loads the scene, and changes it to a setting (NULL: none) at the report's size, with no other output than the
 * picture. The scene's baked clouds are baked in memory, so that no file of the user's is touched. */
neph_result np_report_load(const neph_report *report, const np_setting *setting, neph_scene **out_scene);

/* Render description of a setting's runs, without the scene's time limit. */
neph_result np_report_describe_run(const neph_scene *scene, neph_integrator integrator, unsigned sample_count,
                                   neph_render_desc *out_desc);

/* Lists the settings to measure, those of a quick report first. */
neph_result np_report_list(neph_report *report);

/* ---- Runs: report_run.c ---- */

/* One picture of a setting; adds its times to the setting unless that is NULL, and keeps its stages. */
neph_result np_report_render(neph_report *report, neph_scene *scene, const neph_render_desc *desc, np_setting *setting,
                             neph_image **out_image);

/* Wall time since the clock was started. */
void np_report_start_clock(neph_report *report);
double np_report_get_seconds(const neph_report *report);

/* Renders two pictures of a setting with two unused seeds. */
neph_result np_report_visit(neph_report *report, np_setting *setting, unsigned visit);

/* Forgets stored stages. */
void np_report_clear_stores(neph_report *report);

/* Adds a picture of weight `more` to the mean of `count` others. */
void np_report_average(neph_image *mean, unsigned count, const neph_image *picture, unsigned more);

/* Median CPU time of a picture, and the least or the most. NaN: it was left out. */
double np_setting_get_cpu_s(const np_setting *setting);
double np_setting_get_extreme_s(const np_setting *setting, bool is_most);

/* ---- Reference: report_reference.c ---- */

/* Makes it within `seconds` of wall time, unless it is given. */
neph_result np_report_make_reference(neph_report *report, double seconds);

/* The picture of the reference from its halves. */
neph_result np_report_join_halves(neph_report *report);

/* ---- Errors: report_errors.c ---- */

/* The pictures that errors are relative to, from the reference and two of the march. */
neph_result np_report_make_yardstick(neph_report *report, neph_image *const march[2]);

/* Error, noise and bias of a setting, by the means of its pictures. */
neph_result np_report_measure(const neph_report *report, np_setting *setting);

/* Effect of a setting: its difference from the finest value of its knob. */
neph_result np_report_measure_effect(const neph_report *report, const np_setting *finest, const np_setting *setting,
                                     neph_bounded *out_effect);

/* ---- Curves: report_curves.c ---- */

/* A measured value of a knob. */
typedef struct np_curve_point {
  unsigned index; /* number of its setting */
  double value;
} np_curve_point;

/* Lists the measured values of a knob, the scene's own among them; returns their number. There is room for
 * NP_REPORT_SETTINGS_MAX. */
unsigned np_curve_collect(const neph_report *report, const np_curve *curve, np_curve_point *out_points);

/* The value that costs most: the smallest, or, where more is better, the largest. */
double np_curve_get_finest(const np_curve *curve, const np_curve_point *points, unsigned count);

/* Error whose convergence is fitted: the noise for knobs of samples, else the difference from the finest value. */
neph_bounded np_curve_get_effect(const neph_report *report, const np_curve *curve, const np_curve_point *point);

/* Measures effects and fits orders. */
neph_result np_report_fit_curves(neph_report *report);

#endif
