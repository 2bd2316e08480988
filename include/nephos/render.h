/* SPDX-License-Identifier: Apache-2.0 */
/* Rendering: a scene to an image. */
#ifndef NEPHOS_RENDER_H
#define NEPHOS_RENDER_H

#include <math.h>

#include <nephos/cloud.h>
#include <nephos/machine.h>
#include <nephos/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum neph_integrator {
  NEPH_INTEGRATOR_MARCH, /**< fast; biased, its bias in docs/accuracy.md */
  NEPH_INTEGRATOR_PATH   /**< unbiased */
} neph_integrator;

/** Treatment of air and ground by the integrator path. The march always uses tables. */
typedef enum neph_render_atmosphere {
  NEPH_RENDER_ATMOSPHERE_TRACED, /**< paths continue through the air and from the ground; the default */
  NEPH_RENDER_ATMOSPHERE_TABLES  /**< paths end in tables where they leave the clouds: faster, without clouds' shadows
                                      in the air and their light on the ground (docs/transport.md) */
} neph_render_atmosphere;

/** Guiding, splitting and Russian roulette of paths in clouds. */
typedef enum neph_path_guiding {
  NEPH_PATH_GUIDING_NONE,    /**< no guiding: analogue sampling, with Russian roulette by throughput; the default */
  NEPH_PATH_GUIDING_ADJOINT, /**< guiding, splitting and Russian roulette by the adjoint solution of the march: for
                                  optical depths of tens and more, and for absorbing media. Samples may be negative;
                                  their mean equals that of NEPH_PATH_GUIDING_NONE */
  NEPH_PATH_GUIDING_AUTO     /**< neph_probe_slab alone: pilots choose the method that takes less time to the same
                                  error */
} neph_path_guiding;

/** Method of the march for multiple scattering in clouds. All but the ordinates are approximations, with errors of tens
 * of per cent (docs/results/approximations.md). */
typedef enum neph_multiple_scattering {
  NEPH_MULTIPLE_SCATTERING_NONE,          /**< single scattering alone: for comparisons */
  NEPH_MULTIPLE_SCATTERING_OCTAVES,       /**< damped octaves of the single scattering */
  NEPH_MULTIPLE_SCATTERING_ORDINATES,     /**< discrete ordinates on coarse cells; the default */
  NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER, /**< transmittance that falls more slowly with depth than Beer's law */
  NEPH_MULTIPLE_SCATTERING_POWDER,        /**< the softened law, darkened in thin and in low places */
  NEPH_MULTIPLE_SCATTERING_DERIVATIVE     /**< one look-up towards the sun: the slope of the density shades like a
                                               surface */
} neph_multiple_scattering;

/** Eye of a stereo camera from which a picture is rendered. */
typedef enum neph_eye {
  NEPH_EYE_CENTRE, /**< the camera's position; the default */
  NEPH_EYE_LEFT,   /**< half the interaxial distance to the left of the position of a stereo camera */
  NEPH_EYE_RIGHT
} neph_eye;

/** Part of an unfinished picture. Valid only during the callback. */
typedef struct neph_tile {
  unsigned min[2], max[2]; /**< first pixel of the tile in `image`, from the top left, and one past its last */
  unsigned pass_index;     /**< number of the pass, 0 first; with a time limit, pictures get better from pass to pass */
  bool is_final;           /**< values are those of the finished picture */
  const neph_image *image; /**< pixels outside of this pass's tiles may still be 0, or change while they are read */
} neph_tile;

/** Delivers finished tiles of a picture, and can cancel.
 *
 * Called on the thread of the library call, several times a second, with all tiles finished since the last call. Each
 * pass covers each pixel once; a pass that a time limit cuts is not delivered.
 * @return false to cancel, as a neph_progress_fn.
 */
typedef bool (*neph_tile_fn)(void *user, const neph_tile *tile);

/** No target error, no time limit. */
#define NEPH_UNLIMITED HUGE_VAL

/** Samples up to the last. */
#define NEPH_SAMPLES_ALL 0xffffffffu

/** No limit on the number of scatterings along a path. */
#define NEPH_SCATTERINGS_ALL 0xffffffffu

typedef struct neph_render_desc {
  size_t struct_size;
  neph_integrator integrator;
  unsigned width, height;    /**< size of the whole picture, pixels, 1 to 65536 */
  unsigned crop_min[2];      /**< first pixel to render, from the top left (default 0, 0) */
  unsigned crop_max[2];      /**< one past the last; 0 < crop_max ≤ size */
  unsigned sample_count;     /**< samples a pixel, 1 to 2²⁴; with a target error: the least number */
  unsigned sample_count_max; /**< greatest number with a target error; ≥ 16 (default 65536) */
  double target_error;       /**< target of the error a pixel (docs/error.md): samples are added,
                                  pixel by pixel, until the noise is no more than the expected bias
                                  leaves of it; > 0 (default NEPH_UNLIMITED) */
  double time_limit_s;       /**< limit of the whole call, ≥ 0: the call ends within 1.1 times that,
                                  or one second more where that is longer, with the samples it has;
                                  the attributes nephos:sampling and nephos:lightSolve then state the
                                  cuts; NEPH_ERROR_LIMIT where a pixel has no sample (default
                                  NEPH_UNLIMITED) */
  uint64_t seed;             /**< seed of all random numbers */
  int frame;                 /**< number that replaces '#' in names; it also seeds */
  neph_multiple_scattering multiple_scattering; /**< method of the march */
  neph_render_atmosphere atmosphere;            /**< air and ground of the integrator path */
  neph_path_guiding path_guiding;               /**< guiding of the integrator path */
  unsigned scattering_max;   /**< scatterings in cloud along one path, or NEPH_SCATTERINGS_ALL; a limit loses light, and
                                  the integrator path reports how much */
  neph_progress_fn progress; /**< default NULL */
  void *progress_user;       /**< default NULL */
  neph_tile_fn tile;         /**< default NULL */
  void *tile_user;           /**< default NULL */
  neph_eye eye;              /**< eye of a stereo camera: neph_scene_get_render_desc sets camera.stereo.eye, or the left
                                  where that is both; other cameras have NEPH_EYE_CENTRE */
  uint64_t memory_max_bytes; /**< limit on the memory that neph_render_estimate_memory predicts. A render above it has
                                  its volumes in halves, its multiple scattering on coarser cells, and the voxels of
                                  files twice as long, as far as needed, with a warning and `nephos:memorySavings`;
                                  where that is not enough, it and its bakes fail with NEPH_ERROR_LIMIT (default
                                  NEPH_MEMORY_UNLIMITED) */
  unsigned tile_index;       /**< index of the tile to render among the crop's tiles, bands of whole rows from the top;
                                  ≥ 0 (default 0) */
  unsigned tile_count;       /**< number of tiles; 1 to the crop's rows (default 1) */
  uint32_t sample_begin;     /**< first sample to take, a multiple of 16 (default 0) */
  uint32_t sample_end;       /**< one past the last sample: a multiple of 16, or sample_count, which NEPH_SAMPLES_ALL
                                  stands for too (default NEPH_SAMPLES_ALL). A range of samples excludes a target error,
                                  a time limit and deep pixels */
  const char *part_path;     /**< file for the rendered part of the whole picture, for neph_parts_merge; excludes deep
                                  pixels and a time limit (default NULL) */
  const char *checkpoint_path;  /**< file for the pixels rendered so far; not removed. It may be part_path. The light
                                     solved so far is kept in the context's cache, or without one in files of this name
                                     and ".light…", which neph_checkpoint_clear_light removes (default NULL) */
  double checkpoint_interval_s; /**< seconds from one checkpoint to the next; one is written in any case when the call
                                   is cancelled (default NEPH_UNLIMITED) */
  bool is_resumed;              /**< pixels in the checkpoint of the same picture are not rendered again; a checkpoint
                                     that is missing, damaged or of another picture is ignored (default false) */
  const neph_machine *machine;  /**< speed for predictions of time; NULL: the machine on which the constants were
                                     measured (default NULL) */
  bool has_next_frame;          /**< `next_frame` is rendered next: the system reads its clouds' files into its page
                                     cache while this one's pixels are rendered (default false) */
  int next_frame;
  unsigned detail_height; /**< height in pixels of the picture for which voxels, heights and cells of light are
                               chosen, by the scene's samples: a picture with fewer pixels or samples shares terrain,
                               clouds, air and light with the scene's in a renderer, and takes near light and voxels
                               of earlier pictures; 0: the picture's own (default 0) */
} neph_render_desc;

#define NEPH_RENDER_DESC_DEFAULT                                                                                       \
  {                                                                                                                    \
    .struct_size = sizeof(neph_render_desc), .integrator = NEPH_INTEGRATOR_MARCH, .width = 960, .height = 540,         \
    .crop_min = {0, 0}, .crop_max = {960, 540}, .sample_count = 4, .sample_count_max = 65536,                          \
    .target_error = NEPH_UNLIMITED, .time_limit_s = NEPH_UNLIMITED, .seed = 0, .frame = 1,                             \
    .multiple_scattering = NEPH_MULTIPLE_SCATTERING_ORDINATES, .atmosphere = NEPH_RENDER_ATMOSPHERE_TRACED,            \
    .path_guiding = NEPH_PATH_GUIDING_NONE, .scattering_max = NEPH_SCATTERINGS_ALL, .progress = NULL,                  \
    .progress_user = NULL, .tile = NULL, .tile_user = NULL, .eye = NEPH_EYE_CENTRE,                                    \
    .memory_max_bytes = NEPH_MEMORY_UNLIMITED, .tile_index = 0, .tile_count = 1, .sample_begin = 0,                    \
    .sample_end = NEPH_SAMPLES_ALL, .part_path = NULL, .checkpoint_path = NULL,                                        \
    .checkpoint_interval_s = NEPH_UNLIMITED, .is_resumed = false, .machine = NULL, .has_next_frame = false,            \
    .next_frame = 0, .detail_height = 0                                                                                \
  }

/** The scene's own render settings, as a start.
 *
 * @param out_desc  starts from NEPH_RENDER_DESC_DEFAULT; unchanged on failure.
 */
NEPH_API neph_result neph_scene_get_render_desc(const neph_scene *scene, neph_render_desc *out_desc) NEPH_NODISCARD;

/** Warns of settings by which frames rendered apart, such as tasks of a farm, differ from frames of one batch: imported
 * sequences that are placed or scaled by a frame without naming it (clouds[].reference_frame).
 */
NEPH_API void neph_scene_warn_of_tasks(const neph_scene *scene);

/** Settings chosen for a target error or a time limit, and predictions for the picture with them. */
typedef struct neph_effort {
  size_t struct_size;
  const char *quality; /**< chosen render.quality; NULL: the scene gives it, or there is neither target nor limit */
  neph_integrator integrator;
  double samples;            /**< predicted mean samples a pixel; with a target, pilots decide */
  double seconds;            /**< predicted seconds on the context's threads */
  uint64_t bytes;            /**< predicted peak memory of the process, as by neph_render_estimate_memory */
  double error, noise, bias; /**< predicted error a pixel (docs/error.md) */
  double bias_floor;         /**< least bias that the march can have, with a target; otherwise 0 */
  double cpu_seconds;        /**< predicted seconds of one core */
  char settings[256];        /**< chosen keys, in the form of --set, separated by spaces */
} neph_effort;

#define NEPH_EFFORT_DEFAULT                                                                                            \
  { .struct_size = sizeof(neph_effort) }

/** Chooses settings of a scene for `desc->target_error` and `desc->time_limit_s`, as `nephos render` does, and sets
 * them: render.quality, render.integrator and render.samples, and, where another value than that of the quality is
 * better, the keys that the quality chooses and atmosphere.tolerance. Keys that the scene gives stay. For a target it
 * chooses the settings with the least predicted time, the integrator path where no march reaches it; for a limit those
 * with the least predicted error, of the march unless there is a target for paths. The limit wins over the target.
 * Afterwards call neph_scene_get_render_desc again.
 *
 * @param desc        picture, target, limit and machine; NULL: the scene's own.
 * @param out_effort  starts from NEPH_EFFORT_DEFAULT; unchanged on failure.
 */
NEPH_API neph_result neph_scene_choose_effort(neph_scene *scene, const neph_render_desc *desc,
                                              neph_effort *out_effort) NEPH_NODISCARD;

/** Renders one picture, and keeps nothing for the next: a neph_renderer does. Threads may render one scene at once.
 *
 * Frames of an imported sequence are placed and scaled by one of them: the scene's reference_frame, else the frame
 * itself, or, of a neph_renderer, the first frame that it rendered or explained and that holds anything.
 *
 * @param desc       NULL: the scene's own settings.
 * @param out_image  R, G, B, A, Z and the wanted AOVs; owned by the caller; NULL on failure. Its header states the
 *                   colour space: linear light of a space, or radiances in three bands.
 */
NEPH_API neph_result neph_render_image(const neph_scene *scene, const neph_render_desc *desc,
                                       neph_image **out_image) NEPH_NODISCARD;

/** The plan of a render, with the stages that it needs and leaves out, and why, as text; free it with
 * neph_text_destroy. Opens every file that the frame is rendered from, and fails where one is missing, damaged at its
 * head, or of another kind. */
NEPH_API neph_result neph_render_explain(const neph_scene *scene, const neph_render_desc *desc, neph_text_format format,
                                         char **out_text) NEPH_NODISCARD;

/** Memory that a process has at its peak while it renders a picture. */
typedef struct neph_memory_estimate {
  size_t struct_size;
  uint64_t total_bytes;   /**< sum of the members below */
  uint64_t program_bytes; /**< the library, and OpenVDB where a file is read or written */
  uint64_t terrain_bytes; /**< heights and the ray-tracing structure; 0 for one that a call has set */
  uint64_t volume_bytes;  /**< bricks, and, where light takes less, grids from which they are built */
  uint64_t light_bytes;   /**< multiple scattering while it is solved, sun optical depth, air shadows */
  uint64_t film_bytes;    /**< the picture's channels */
} neph_memory_estimate;

#define NEPH_MEMORY_ESTIMATE_DEFAULT                                                                                   \
  { .struct_size = sizeof(neph_memory_estimate) }

/** Predicts the memory of a render from its plan, before anything is loaded or built. Measured peaks are 0.48 to 1.25
 * times as large (docs/results/memory.md).
 *
 * @param desc          NULL: the scene's own settings.
 * @param out_estimate  starts from NEPH_MEMORY_ESTIMATE_DEFAULT; unchanged on failure.
 */
NEPH_API neph_result neph_render_estimate_memory(const neph_scene *scene, const neph_render_desc *desc,
                                                 neph_memory_estimate *out_estimate) NEPH_NODISCARD;

/** Predicts the time of a render from its plan, headers of cloud files and trials of bakes, as `--explain` does: in
 * seconds of one core, within a factor of two or three. Files that are not there count as no cloud.
 *
 * @param desc              NULL: the scene's own settings.
 * @param out_seconds       seconds of this picture alone, with the earlier frames that its history needs; unchanged
 *                          on failure.
 * @param out_next_seconds  seconds of the next frame by the same neph_renderer, which reuses its caches; NULL is
 *                          allowed.
 */
NEPH_API neph_result neph_render_estimate_time(const neph_scene *scene, const neph_render_desc *desc,
                                               double *out_seconds, double *out_next_seconds) NEPH_NODISCARD;

/** Disks of sun and moon in a picture of the sky. */
typedef enum neph_sky_disks {
  NEPH_SKY_DISKS_LAYER,   /**< channels of their own, disk.R, disk.G and disk.B; the default */
  NEPH_SKY_DISKS_INCLUDE, /**< part of R, G and B, which are the only channels */
  NEPH_SKY_DISKS_NONE     /**< left out: R, G and B of the sky alone */
} neph_sky_disks;

typedef struct neph_sky_image_desc {
  size_t struct_size;
  unsigned width, height;    /**< size of the latitude-longitude picture, ≥ 2 (default 1024 × 512) */
  neph_progress_fn progress; /**< default NULL */
  void *progress_user;       /**< default NULL */
  neph_sky_disks disks;      /**< default NEPH_SKY_DISKS_LAYER */
  double center_azimuth_rad; /**< azimuth of the picture's middle, clockwise from north (default π: south) */
} neph_sky_image_desc;

#define NEPH_SKY_IMAGE_DESC_DEFAULT                                                                                    \
  {                                                                                                                    \
    .struct_size = sizeof(neph_sky_image_desc), .width = 1024, .height = 512, .progress = NULL, .progress_user = NULL, \
    .disks = NEPH_SKY_DISKS_LAYER, .center_azimuth_rad = 3.14159265358979323846                                        \
  }

/** The scene's sky from its camera as a latitude-longitude picture: azimuth grows to the right, by default from north
 * at the left edge, with east a quarter of the width to its right, zenith at the top; channels R, G, B, and the disks
 * of sun and moon, averaged over each pixel, as `disks` says. The header has the attribute envmap.
 *
 * Text attributes hold the direction of the sun and of a moon that shines, their angular radius and their irradiance on
 * a plane that faces them (nephos:sunDirection, nephos:sunAngularRadius, nephos:sunNormalIrradiance and so on),
 * irradiances on a level surface at the camera (nephos:sunIrradiance, nephos:skyIrradiance: three numbers, where there
 * is air) and spherical harmonics of order 2 of the sky without the disks (nephos:skyHarmonics: nine coefficients of R,
 * G, B each, real and orthonormal without the Condon-Shortley phase, in the order 1, y, z, x, xy, yz, 3z²−1, xz, x²−y²;
 * x east, y north, z up). These are not multiplied by output.scale, as pixels are.
 */
NEPH_API neph_result neph_render_sky(const neph_scene *scene, const neph_sky_image_desc *desc,
                                     neph_image **out_image) NEPH_NODISCARD;

/** Lights and camera of a scene as a USD layer (.usda): a DomeLight with a picture of the sky, DistantLights for sun
 * and moon where the picture has not their disks, and the camera where it has a counterpart, a perspective or an
 * orthographic one. Z up, metres.
 *
 * @param sky       the picture of neph_render_sky, or its header.
 * @param texture   asset path of that picture in the layer.
 * @param path      file to write, replaced when all of it is there.
 */
NEPH_API neph_result neph_scene_save_usd(const neph_scene *scene, const neph_image *sky, const char *texture,
                                         const char *path) NEPH_NODISCARD;

/** A table of an atmosphere or of a sky. */
typedef enum neph_sky_table {
  NEPH_SKY_TABLE_TRANSMITTANCE, /**< transmittance to the top of the air */
  NEPH_SKY_TABLE_SCATTERING,    /**< light from all directions, at every altitude under every sun */
  NEPH_SKY_TABLE_AEROSOL,       /**< share of the multiple scattering that aerosols scatter */
  NEPH_SKY_TABLE_VIEW,          /**< the sky in all directions */
  NEPH_SKY_TABLE_AERIAL,        /**< light scattered before every distance */
  NEPH_SKY_TABLE_COUNT
} neph_sky_table;

/** "transmittance", "multiple_scattering", "aerosol_source", "sky_view", "aerial_perspective". */
NEPH_API const char *neph_sky_table_get_name(neph_sky_table table);

/** One table of the scene's air or of its camera's sky as a picture for viewing, per unit of the sun's irradiance;
 * NEPH_SKY_TABLE_SCATTERING by its logarithm, 0 to 1 over four decades. docs/atmosphere.md has the axes.
 *
 * @param out_image  R, G, B; owned by the caller; NULL on failure, which it is when the scene has no air.
 */
NEPH_API neph_result neph_render_sky_table(const neph_scene *scene, neph_sky_table table,
                                           neph_image **out_image) NEPH_NODISCARD;

typedef struct neph_sky_verify_desc {
  size_t struct_size;
  unsigned path_count;       /**< paths traced for each of 24 directions; ≥ 1 (default 4096) */
  uint64_t seed;             /**< seed of the tracer (default 0) */
  neph_progress_fn progress; /**< default NULL */
  void *progress_user;       /**< default NULL */
} neph_sky_verify_desc;

#define NEPH_SKY_VERIFY_DESC_DEFAULT                                                                                   \
  {                                                                                                                    \
    .struct_size = sizeof(neph_sky_verify_desc), .path_count = 4096, .seed = 0, .progress = NULL,                      \
    .progress_user = NULL                                                                                              \
  }

/** Measures the tables of the scene's sky against integrals and the tracer, and describes their errors.
 *
 * @param desc      NULL for the defaults.
 * @param out_text  free it with neph_text_destroy; NULL on failure, which it is when the scene has no air.
 */
NEPH_API neph_result neph_render_sky_verify(const neph_scene *scene, const neph_sky_verify_desc *desc,
                                            neph_text_format format, char **out_text) NEPH_NODISCARD;

/** Bakes one procedural cloud of a scene to a .vdb or .nvdb file, as it is in a frame: frame 1 is at the cloud's
 * `time`, every further one `frame_time` later.
 *
 * @param desc  NULL for the defaults; the planet and the levels of detail (lod_count and so on) are the scene's in any
 *              case, the latter for its own resolution.
 */
NEPH_API neph_result neph_scene_bake_file(const neph_scene *scene, unsigned cloud_index, int frame,
                                          const neph_bake_desc *desc, const char *path) NEPH_NODISCARD;

/** Writes the weather map of a procedural cloud of a scene from above, as it is in a frame, as neph_cloud_save_map
 * does. */
NEPH_API neph_result neph_scene_save_map(const neph_scene *scene, unsigned cloud_index, int frame, const char *path,
                                         neph_map_picture *out_picture) NEPH_NODISCARD;

typedef struct neph_export_desc {
  size_t struct_size;
  neph_precision precision;       /**< precision of values in the file (default NEPH_PRECISION_FLOAT) */
  neph_progress_fn progress;      /**< default NULL */
  void *progress_user;            /**< default NULL */
  unsigned level_count;           /**< levels of detail, 1 to NEPH_BAKE_LEVELS_MAX (default 1: `path` alone) */
  bool is_dry_run;                /**< opens the cloud's file, checks that it has the grids that the scene requires, and
                                       writes nothing (default false) */
  struct neph_renderer *renderer; /**< keeps the frame that places and scales a sequence from one call to the next, as
                                       it does for pictures; NULL: each call goes by its own frame (default NULL) */
} neph_export_desc;

#define NEPH_EXPORT_DESC_DEFAULT                                                                                       \
  {                                                                                                                    \
    .struct_size = sizeof(neph_export_desc), .precision = NEPH_PRECISION_FLOAT, .progress = NULL,                      \
    .progress_user = NULL, .level_count = 1, .is_dry_run = false, .renderer = NULL                                     \
  }

/** Optional grids of an exported file beside its density; bits. */
typedef enum neph_export_fields {
  NEPH_EXPORT_VELOCITY = 1,    /**< `vel`, a vector in m/s */
  NEPH_EXPORT_COLOR = 2,       /**< `Cd`, a vector: factor on the albedo in red, green and blue */
  NEPH_EXPORT_LIGHT = 4,       /**< `Ce`, a vector: emitted light in W m⁻³ sr⁻¹ nm⁻¹ */
  NEPH_EXPORT_TEMPERATURE = 8, /**< `temperature` in K */
  NEPH_EXPORT_FLAME = 16,      /**< `flame`: absorption of what burns, 1/m */
  NEPH_EXPORT_SIZES = 32       /**< `effective_radius` of droplets in um */
} neph_export_fields;

/** One cloud in one exported frame. */
typedef struct neph_exported_cloud {
  size_t struct_size;
  const char *name; /**< name of the cloud in its scene; valid as long as the scene stays unchanged */
  const char *path; /**< path of the file; the caller's pointer, not copied */
  int frame;
  bool is_empty;                           /**< the cloud holds nothing in that frame: no file was written */
  bool is_half;                            /**< values are halves */
  double bounds_min_m[3], bounds_max_m[3]; /**< world box of its active voxels */
  double extinction_per_value;             /**< 1/m where the file holds 1: 1 in floats, a power of two in halves */
  unsigned fields;                         /**< bits of neph_export_fields: the optional grids of the file */
} neph_exported_cloud;

#define NEPH_EXPORTED_CLOUD_DEFAULT                                                                                    \
  { .struct_size = sizeof(neph_exported_cloud) }

/** Writes a cloud of a scene to a .vdb or .nvdb file as it stands in a frame: one fog volume "density" in the world's
 * place, z up, in metres, of the extinction in 1/m. Its units, and what a value of 1 is, go with it (`units`,
 * `nephos:extinction_per_value`), and so does the box of a model's domain (`nephos:domain_min`, `nephos:domain_max`).
 * Halves are scaled by a power of two that puts the largest in [1, 2). The velocities, colours and sizes of droplets of
 * its file go with it, and, where the cloud has emission, temperature, flame and emitted light, in the
 * world and in the units of the keys' defaults.
 *
 * Level k of detail, from 1, is a file of its own beside `path`, "cloud.lod1.vdb" beside "cloud.vdb", and holds the
 * whole cloud: "density" alone, its voxels twice as long as those of the level before, each the mean of eight, so that
 * optical depth is kept.
 *
 * @param desc       NULL for the defaults.
 * @param out_cloud  starts from NEPH_EXPORTED_CLOUD_DEFAULT; a dry run sets name, path and frame alone.
 */
NEPH_API neph_result neph_scene_export_cloud(const neph_scene *scene, unsigned cloud_index, int frame,
                                             const neph_export_desc *desc, const char *path,
                                             neph_exported_cloud *out_cloud) NEPH_NODISCARD;

/** Writes a USD layer (.usda) of exported clouds: a Volume with one OpenVDBAsset for each, extents, Z up, metres; of
 * several frames, with time samples. Files below the layer's folder are named from there.
 *
 * @param clouds  array of `count` clouds; entries of one name in order of frames.
 */
NEPH_API neph_result neph_scene_save_volumes_usd(const neph_scene *scene, const neph_exported_cloud *clouds,
                                                 size_t count, const char *path) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
