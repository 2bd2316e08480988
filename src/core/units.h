/* SPDX-License-Identifier: Apache-2.0 */
/* Constants and conversions. Everything inside is SI and radians. */
#ifndef NP_CORE_UNITS_H
#define NP_CORE_UNITS_H

#define NP_PI 3.14159265358979323846
#define NP_PI_F 3.14159265358979323846f
#define NP_LN2_F 0.693147180559945f
#define NP_DEGREE (NP_PI / 180.0) /* radians in one degree */
#define NP_KILOMETRE 1000.0       /* metres */

#endif
