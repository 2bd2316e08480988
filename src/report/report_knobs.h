/* SPDX-License-Identifier: Apache-2.0 */
/* Knobs of a report: settings of a scene that trade error for time. A new one is a row in report_knobs.c. */
#ifndef NP_REPORT_KNOBS_H
#define NP_REPORT_KNOBS_H

#include "plan/plan.h"

/* Integrators whose pictures a knob changes. */
typedef enum np_knob_integrator { NP_KNOB_OF_MARCH, NP_KNOB_OF_PATH } np_knob_integrator;

enum { NP_KNOB_VALUE_SIZE = 40 };

typedef struct np_knob {
  const char *name;
  const char *key;    /* key in the syntax of --set; clouds[] means every baked cloud */
  const char *unit;   /* written behind a number, with its leading space; NULL: none */
  const char *few;    /* values of a quick report, separated by spaces */
  const char *more;   /* further values of a full report; NULL: none */
  bool is_word;       /* values have no order */
  bool is_factor;     /* values are factors on the scene's own */
  bool is_whole;      /* the value sets samples and integrator too, unless the scene has keys for them */
  double order;       /* theoretical order of the error in the value, negative where more is better; 0: none */
  const char *theory; /* its reason */
  np_knob_integrator of;
  uint32_t stages; /* bit mask of stages: the knob has an effect if the plan needs one of them; 0: always */

  /* Further condition for the knob to have an effect; NULL: none. */
  bool (*is_applicable)(const neph_scene *scene, const np_plan *plan);

  /* The scene's own value: a number in the key's unit, or, of words, a word. */
  double (*get_number)(const neph_scene *scene, const np_plan *plan);
  const char *(*get_word)(const neph_scene *scene, const np_plan *plan);
} np_knob;

unsigned np_knob_count(void);
const np_knob *np_knob_at(unsigned index);

/* Whether it is the number of samples, which share their stages. */
bool np_knob_is_of_samples(const np_knob *knob);

/* Whether a knob changes pictures of a scene, by the plan of its integrator. */
bool np_knob_applies(const np_knob *knob, const neph_scene *scene, const np_plan *plan);

/* The `index`-th value, as the scene's key takes it, its number (NaN: a word), and whether a quick report has it.
 * False: there are no more. */
typedef struct np_knob_value {
  char text[NP_KNOB_VALUE_SIZE];
  double number;
  bool is_quick;
} np_knob_value;

bool np_knob_get_value(const np_knob *knob, const neph_scene *scene, const np_plan *plan, unsigned index,
                       np_knob_value *out_value);

/* The scene's own value. */
np_knob_value np_knob_get_own(const np_knob *knob, const neph_scene *scene, const np_plan *plan);

/* Sets a knob of a scene. */
neph_result np_knob_set(const np_knob *knob, neph_scene *scene, const char *value);

#endif
