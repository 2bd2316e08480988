/* SPDX-License-Identifier: Apache-2.0 */
/* Probes: benchmark cases with reference results, computed by the integrators of renders. */
#ifndef NEPHOS_PROBE_H
#define NEPHOS_PROBE_H

#include <nephos/render.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct neph_probe_desc {
  size_t struct_size;
  neph_integrator integrator;     /**< default NEPH_INTEGRATOR_PATH */
  neph_path_guiding path_guiding; /**< guiding of the integrator path; NEPH_PATH_GUIDING_AUTO (default): each number is
                                       computed with guiding where pilots of up to 4096 rays predict that it takes less
                                       than 0.8 of the variance times time without */
  unsigned path_count;       /**< camera rays for each number, ≥ 1, rounded up to a multiple of 64 (default 65536) */
  double target_error;       /**< relative standard error to reach, > 0: pilots of 4096 rays and more predict the
                                  number of rays, and a fifth is added; again where the error comes out a quarter
                                  larger; never more rays than path_count; NEPH_UNLIMITED (default): path_count rays */
  uint64_t seed;             /**< seed of all random numbers (default 0) */
  neph_progress_fn progress; /**< default NULL */
  void *progress_user;       /**< default NULL */
} neph_probe_desc;

#define NEPH_PROBE_DESC_DEFAULT                                                                                        \
  {                                                                                                                    \
    .struct_size = sizeof(neph_probe_desc), .integrator = NEPH_INTEGRATOR_PATH,                                        \
    .path_guiding = NEPH_PATH_GUIDING_AUTO, .path_count = 65536, .target_error = NEPH_UNLIMITED, .seed = 0,            \
    .progress = NULL, .progress_user = NULL                                                                            \
  }

/** Light reflected and transmitted by plane-parallel slabs of cloud, case by case.
 *
 * Cases are rows of comma-separated values with the columns quantity (flux, radiance_top_up, radiance_bottom_down), g,
 * albedo, tau, mu0 (or diffuse) and, for radiance, mu_view and phi_deg: docs/cli.md says what each means. The answer
 * repeats every column and adds R_out, T_out, R_se, T_se to fluxes and L_out, L_se to radiances, each with its standard
 * error: inf, with a warning, where too few rays met light for an estimate (docs/cli.md), and 0 where nothing scatters.
 *
 * @param cases_path  a file, or "-" for standard input.
 * @param desc        NULL for the defaults.
 * @param out_text    comma-separated values; free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_probe_slab(neph_context *context, const char *cases_path, const neph_probe_desc *desc,
                                     char **out_text) NEPH_NODISCARD;

typedef enum neph_sky_method {
  NEPH_SKY_METHOD_LUT,   /**< tables alone, as in pictures */
  NEPH_SKY_METHOD_MARCH, /**< integration along the ray: order 1 to 1e-5; later orders from the sources in the tables */
  NEPH_SKY_METHOD_TRACE  /**< Monte Carlo in double precision; order 1 and transmittances by quadrature */
} neph_sky_method;

typedef struct neph_probe_sky_desc {
  size_t struct_size;
  neph_sky_method method;    /**< default NEPH_SKY_METHOD_LUT */
  unsigned path_count;       /**< paths of the tracer for each row, ≥ 1, rounded up to a multiple of 64 (default
                                  65536) */
  uint64_t seed;             /**< seed of all random numbers (default 0) */
  neph_progress_fn progress; /**< default NULL */
  void *progress_user;       /**< default NULL */
} neph_probe_sky_desc;

#define NEPH_PROBE_SKY_DESC_DEFAULT                                                                                    \
  {                                                                                                                    \
    .struct_size = sizeof(neph_probe_sky_desc), .method = NEPH_SKY_METHOD_LUT, .path_count = 65536, .seed = 0,         \
    .progress = NULL, .progress_user = NULL                                                                            \
  }

/** Light of clear skies, case by case.
 *
 * Cases are rows of comma-separated values with the columns quantity, earth, max_order, h_km, mu, sun_zenith_deg,
 * view_zenith_deg, rel_azimuth_deg, distance_km: docs/cli.md says what each means, and which may be left out. The
 * answer repeats every column and adds r, g, b, at 680, 550 and 440 nm, and their standard errors r_se, g_se, b_se,
 * which are 0 where the method has none.
 *
 * @param cases_path  a file, or "-" for standard input.
 * @param desc        NULL for the defaults.
 * @param out_text    comma-separated values; free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_probe_sky(neph_context *context, const char *cases_path, const neph_probe_sky_desc *desc,
                                    char **out_text) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
