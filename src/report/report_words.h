/* SPDX-License-Identifier: Apache-2.0 */
/* Words of a report for settings, state and machine. */
#ifndef NP_REPORT_REPORT_WORDS_H
#define NP_REPORT_REPORT_WORDS_H

#include "report/report_private.h"

const char *np_setting_get_knob(const np_setting *setting);
const char *np_setting_get_integrator(const np_setting *setting);

/* "cancelled …", "… before any setting was measured": for a report that is incomplete. */
const char *np_report_get_state(const neph_report *report);

typedef struct np_machine {
  char processor[96], system[96];
} np_machine;

/* "unknown" where the system does not say. */
void np_machine_describe(np_machine *out_machine);

#endif
