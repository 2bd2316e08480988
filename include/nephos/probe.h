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

typedef struct neph_probe_field_desc {
  size_t struct_size;
  neph_integrator integrator; /**< default NEPH_INTEGRATOR_PATH */
  int frame;                  /**< frame of the scene (default 1) */
  unsigned height_count;      /**< ≥ 1 */
  const double *heights_m;    /**< height_count heights of planes; copied */
  double box_min_m[2]; /**< rectangle of the planes along x and y, in which fluxes are means; of no width (default
                            0 to 0): the box of the clouds, or one period of clouds that repeat; a square metre
                            where there is no cloud */
  double box_max_m[2];
  unsigned path_count;       /**< camera rays for each number, ≥ 1, rounded up to a multiple of 64 (default 65536) */
  double target_error;       /**< relative standard error to reach, > 0, by a pilot of 16384 rays; never more rays than
                                  path_count; NEPH_UNLIMITED (default): path_count rays */
  uint64_t seed;             /**< seed of all random numbers (default 0) */
  neph_progress_fn progress; /**< default NULL */
  void *progress_user;       /**< default NULL */
} neph_probe_field_desc;

#define NEPH_PROBE_FIELD_DESC_DEFAULT                                                                                  \
  {                                                                                                                    \
    .struct_size = sizeof(neph_probe_field_desc), .integrator = NEPH_INTEGRATOR_PATH, .frame = 1, .height_count = 0,   \
    .heights_m = NULL, .box_min_m = {0, 0}, .box_max_m = {0, 0}, .path_count = 65536, .target_error = NEPH_UNLIMITED,  \
    .seed = 0, .progress = NULL, .progress_user = NULL                                                                 \
  }

/** Light through level planes of a scene: upward and downward irradiance in each, and light that clouds absorb between
 * each and the next, at 680, 550 and 440 nm, in W m⁻² nm⁻¹ of the rectangle, with standard errors.
 *
 * Rows are incoming (light on a level plane above the air), up and down of each height, and absorbed of each layer
 * (docs/cli.md).
 *
 * @param desc      planes, at least one.
 * @param out_text  comma-separated values; free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_probe_field(const neph_scene *scene, const neph_probe_field_desc *desc,
                                      char **out_text) NEPH_NODISCARD;

/** Light of the step cloud and of the Landsat cloud of the Intercomparison of 3D Radiation Codes, phase 1 (cases 1 and
 * 3), beside the consensus of its participants.
 *
 * Each file I3RC_cons_res_caseC_expE_Q.txt in the folder is one row of the answer: the domain mean of Q with its
 * standard error, the mean of the file, what noise is in it, and how far columns differ (docs/cli.md). Case 3 needs
 * scene43.tau.128x128 and scene43.dz.128x128 beside them. A row of H, 1 − R − T − A, follows where R and T are there.
 * path_guiding is ignored.
 *
 * @param folder    folder of the files.
 * @param desc      NULL for the defaults.
 * @param out_text  comma-separated values; free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_probe_i3rc(neph_context *context, const char *folder, const neph_probe_desc *desc,
                                     char **out_text) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
