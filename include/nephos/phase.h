/* SPDX-License-Identifier: Apache-2.0 */
/* Phase functions by kind, for clouds and for layers of air alike. Their parameters are members of the description that
 * names the kind.
 */
#ifndef NEPHOS_PHASE_H
#define NEPHOS_PHASE_H

#ifdef __cplusplus
extern "C" {
#endif

/** Kind of a phase function. */
typedef enum neph_phase {
  NEPH_PHASE_RAYLEIGH,          /**< molecules */
  NEPH_PHASE_ISOTROPIC,         /**< 1/4π in every direction */
  NEPH_PHASE_HENYEY_GREENSTEIN, /**< one lobe: `asymmetry` */
  NEPH_PHASE_TWO_LOBE,          /**< two Henyey-Greenstein lobes: `asymmetry`, `second_asymmetry`, `second_weight` */
  NEPH_PHASE_CORNETTE_SHANKS,   /**< one lobe: `asymmetry` */
  NEPH_PHASE_DRAINE,            /**< clouds only: `asymmetry`, `draine_alpha` */
  NEPH_PHASE_DROPLETS,          /**< clouds only: fit to Mie theory, `droplet_diameter_m` */
  NEPH_PHASE_TABLE              /**< clouds only: values by angle in a file, `phase_table` */
} neph_phase;

#ifdef __cplusplus
}
#endif

#endif
