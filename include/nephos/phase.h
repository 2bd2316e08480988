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
  NEPH_PHASE_HAZE,              /**< air only: three lobes with an aureole, `asymmetry` of their sum, 0.5 to 0.95 */
  NEPH_PHASE_DRAINE,            /**< clouds only: `asymmetry`, `draine_alpha` */
  NEPH_PHASE_DROPLETS,          /**< clouds only: fit to Mie theory, `droplet_diameter_m` */
  NEPH_PHASE_TABLE,             /**< clouds only: values by angle in a file, `phase_table` */
  NEPH_PHASE_MIE,               /**< clouds only: Mie theory in each band, `effective_radius_m`, `effective_variance` */
  NEPH_PHASE_RAIN,              /**< clouds only: raindrops in each band, `rain_mode_diameter_m` */
  NEPH_PHASE_ICE                /**< clouds only: hexagonal prisms of ice in each band, `ice_habit` */
} neph_phase;

/** Shape of ice crystals: hexagonal prisms in all orientations. */
typedef enum neph_ice_habit {
  NEPH_ICE_MIXED,  /**< half of the scattering by columns, half by plates */
  NEPH_ICE_COLUMN, /**< twice as long as wide */
  NEPH_ICE_PLATE   /**< a fifth as long as wide */
} neph_ice_habit;

#ifdef __cplusplus
}
#endif

#endif
