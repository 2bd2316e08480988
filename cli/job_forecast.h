/* SPDX-License-Identifier: Apache-2.0 */
/* Memory and time of a job's tasks, from the prediction of nephos render --explain. */
#ifndef NEPHOS_CLI_JOB_FORECAST_H
#define NEPHOS_CLI_JOB_FORECAST_H

#include "job.h"
#include "render_job.h"

/* Fills the demands of a job's tasks. `render` has a scene, and the options and settings of a task. */
cli_exit farm_job_forecast(farm_job *job, render_job *render);

#endif
