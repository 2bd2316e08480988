/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes built call by call: typed values in SI units and radians, and assets without a file.
 *
 * Each call replaces the whole of its part of a scene, and changes nothing when it fails. It sets keys of
 * docs/scene-format.md: ranges are those of the keys, messages name them, neph_scene_describe lists them, and
 * neph_scene_set may change them one by one afterwards.
 */
#ifndef NEPHOS_SCENE_BUILD_H
#define NEPHOS_SCENE_BUILD_H

#include <math.h>

#include <nephos/atmosphere.h>
#include <nephos/phase.h>
#include <nephos/scene.h>
#include <nephos/terrain.h>
#include <nephos/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Projection of a camera. */
typedef enum neph_camera_kind {
  NEPH_CAMERA_PERSPECTIVE,     /**< a plane before the eye; the default */
  NEPH_CAMERA_ORTHOGRAPHIC,    /**< parallel rays, as of a satellite */
  NEPH_CAMERA_EQUIRECTANGULAR, /**< longitude and latitude of the whole sphere, level, look_at's azimuth in the middle
                                */
  NEPH_CAMERA_FISHEYE          /**< a circle as wide or high as the picture; angles go evenly with distances */
} neph_camera_kind;

/** No aperture; everything is in focus. */
#define NEPH_PINHOLE HUGE_VAL

/** Focus on the point at which the camera looks. */
#define NEPH_AT_TARGET HUGE_VAL

/** A camera, in world axes: x east, y north, z up. */
typedef struct neph_camera_desc {
  size_t struct_size;
  double position_m[3];        /**< position of the eye (default 0, −6000, 400) */
  double look_at_m[3];         /**< the point in the middle of the picture (default 0, 0, 1800) */
  double fov_rad;              /**< horizontal angle of view of a perspective (default 50°) */
  double roll_rad;             /**< clockwise about the view (default 0) */
  unsigned resolution[2];      /**< width and height of the picture in pixels (default 960 × 540) */
  neph_camera_kind kind;       /**< (default NEPH_CAMERA_PERSPECTIVE) */
  double fisheye_fov_rad;      /**< angle across a fisheye's circle (default 180°) */
  bool has_focal_length;       /**< focal_length_m replaces fov_rad (default false) */
  double focal_length_m;       /**< focal length; it and the sensor give the angle of view (default 0.05) */
  double sensor_m;             /**< width of the sensor (default 0.036) */
  double orthographic_width_m; /**< width of an orthographic picture in the world (default 10000) */
  double shift[2];             /**< shift of the picture in its plane, right and up, in units of its width (default 0,
                                    0) */
  double near_m, far_m;        /**< depths outside of which clouds and ground are clipped (default 0, HUGE_VAL) */
  double f_stop;               /**< focal length over the aperture's diameter (default NEPH_PINHOLE) */
  double focus_distance_m;     /**< depth of the plane in focus (default NEPH_AT_TARGET) */
  unsigned blade_count;        /**< blades of the aperture, 3 to 32; 0: it is round (default 0) */
  bool has_exposure;           /**< photographic exposure by shutter_s, iso and f_stop (default false) */
  double shutter_s, iso;       /**< (default 1/125, 100) */
  bool is_stereo;              /**< a picture for each of two eyes: neph_render_desc.eye (default false) */
  double interaxial_m;         /**< distance between the eyes (default 0.065) */
  double convergence_m;        /**< depth that both eyes see at the same place (default NEPH_AT_TARGET) */
} neph_camera_desc;

#define NEPH_CAMERA_DESC_DEFAULT                                                                                       \
  {                                                                                                                    \
    .struct_size = sizeof(neph_camera_desc), .position_m = {0, -6000, 400}, .look_at_m = {0, 0, 1800},                 \
    .fov_rad = 0.87266462599716477, .roll_rad = 0, .resolution = {960, 540}, .kind = NEPH_CAMERA_PERSPECTIVE,          \
    .fisheye_fov_rad = 3.1415926535897931, .has_focal_length = false, .focal_length_m = 0.05, .sensor_m = 0.036,       \
    .orthographic_width_m = 10000, .shift = {0, 0}, .near_m = 0, .far_m = HUGE_VAL, .f_stop = NEPH_PINHOLE,            \
    .focus_distance_m = NEPH_AT_TARGET, .blade_count = 0, .has_exposure = false, .shutter_s = 0.008, .iso = 100,       \
    .is_stereo = false, .interaxial_m = 0.065, .convergence_m = NEPH_AT_TARGET                                         \
  }

/** @param desc  NULL for the defaults. */
NEPH_API neph_result neph_scene_set_camera(neph_scene *scene, const neph_camera_desc *desc) NEPH_NODISCARD;

typedef struct neph_sun_desc {
  size_t struct_size;
  bool has_direction;           /**< `direction` is used, not the two angles (default false) */
  double direction[3];          /**< towards the sun, of any length above 0 (default 0, 0, 1) */
  double elevation_rad;         /**< above the horizontal at the world's origin (default 35°) */
  double azimuth_rad;           /**< clockwise from north (default 120°) */
  bool has_irradiance;          /**< whether the irradiance is given: otherwise the planet's (default false) */
  double irradiance_w_m2_nm[3]; /**< above the atmosphere, per band (default 1.474, 1.8504, 1.91198) */
  bool has_angular_radius;      /**< whether the radius is given: otherwise the planet's (default false) */
  double angular_radius_rad;    /**< radius of the disk (default 0.00467396) */
  bool has_limb_darkening;      /**< the disk darkens towards its edge (default true) */
} neph_sun_desc;

#define NEPH_SUN_DESC_DEFAULT                                                                                          \
  {                                                                                                                    \
    .struct_size = sizeof(neph_sun_desc), .has_direction = false, .direction = {0, 0, 1},                              \
    .elevation_rad = 0.61086523819801535, .azimuth_rad = 2.0943951023931953, .has_irradiance = false,                  \
    .irradiance_w_m2_nm = {1.474, 1.8504, 1.91198}, .has_angular_radius = false, .angular_radius_rad = 0.00467396,     \
    .has_limb_darkening = true                                                                                         \
  }

/** Sets the position of the sun, in place of sun.time too.
 *
 * @param desc  NULL for the defaults. */
NEPH_API neph_result neph_scene_set_sun(neph_scene *scene, const neph_sun_desc *desc) NEPH_NODISCARD;

/** Meaning of the values of a volume. */
typedef enum neph_density_unit {
  NEPH_DENSITY_EXTINCTION,     /**< density_value: extinction in 1/m of a value of 1 */
  NEPH_DENSITY_MEAN_FREE_PATH, /**< density_value: mean free path in m of a value of 1 */
  NEPH_DENSITY_OPTICAL_DEPTH,  /**< density_value: optical depth of the densest vertical column */
  NEPH_DENSITY_LIQUID_WATER    /**< values are g/m³ of water; density_value: effective radius of the droplets in m */
} neph_density_unit;

/** The place of a volume in the world, and the meaning of its values. */
typedef struct neph_placement_desc {
  size_t struct_size;
  const char *name;               /**< name in messages, copied; NULL: cloud0, cloud1, … (default NULL) */
  bool has_position;              /**< whether position_m is given: otherwise the volume's own transform places it
                                       (default false) */
  double position_m[3];           /**< place of the middle of the bottom of the volume's box (default 0, 0, 0) */
  double rotation_rad;            /**< rotation about the vertical, counter-clockwise seen from above (default 0) */
  double scale;                   /**< factor on the size; > 0 (default 1) */
  neph_density_unit density_unit; /**< (default NEPH_DENSITY_EXTINCTION) */
  double density_value;           /**< (default 1: values are extinction in 1/m, as baked clouds have them) */
  double albedo[3];               /**< single-scattering albedo (default 0.999995 each) */
  neph_phase phase;               /**< (default NEPH_PHASE_DROPLETS) */
  double droplet_diameter_m;      /**< (default 20e-6) */
  double asymmetry;               /**< g of the first or only lobe (default 0.85) */
  double second_asymmetry;        /**< g of the second lobe (default −0.25) */
  double second_weight;           /**< share of the light that the second lobe scatters, 0 to 1 (default 0.1) */
  double draine_alpha;            /**< 0 is Henyey-Greenstein, 1 Cornette-Shanks (default 1) */
  const char *phase_table;        /**< CSV file of NEPH_PHASE_TABLE, copied (default NULL) */
  double detail_strength;         /**< strength of billows at the edge finer than the voxels, added in the render, 0 to
                                       1; 0: none (default 0) */
  double detail_size_m;           /**< size of the largest of these billows, ≥ 0; 0: two voxels (default 0) */
  uint64_t detail_seed;           /**< seed of these billows (default 0) */
  double effective_radius_m;      /**< droplets of NEPH_PHASE_MIE, 1e-7 to 5e-5 (default 10e-6) */
  double effective_variance;      /**< droplets of NEPH_PHASE_MIE, 0 to 0.4; 0: one size (default 0.1) */
  double rain_mode_diameter_m;    /**< most frequent diameter of NEPH_PHASE_RAIN, 1e-4 to 2e-3 (default 5e-4) */
  neph_ice_habit ice_habit;       /**< shape of NEPH_PHASE_ICE (default NEPH_ICE_MIXED) */
} neph_placement_desc;

#define NEPH_PLACEMENT_DESC_DEFAULT                                                                                    \
  {                                                                                                                    \
    .struct_size = sizeof(neph_placement_desc), .name = NULL, .has_position = false, .position_m = {0, 0, 0},          \
    .rotation_rad = 0, .scale = 1, .density_unit = NEPH_DENSITY_EXTINCTION, .density_value = 1,                        \
    .albedo = {0.999995, 0.999995, 0.999995}, .phase = NEPH_PHASE_DROPLETS, .droplet_diameter_m = 20e-6,               \
    .asymmetry = 0.85, .second_asymmetry = -0.25, .second_weight = 0.1, .draine_alpha = 1, .phase_table = NULL,        \
    .detail_strength = 0, .detail_size_m = 0, .detail_seed = 0, .effective_radius_m = 10e-6,                           \
    .effective_variance = 0.1, .rain_mode_diameter_m = 5e-4, .ice_habit = NEPH_ICE_MIXED                               \
  }

/** Adds a volume of the same context as a cloud; the scene retains it.
 *
 * @param desc       NULL for the defaults.
 * @param out_index  index of the new cloud; NULL is allowed.
 */
NEPH_API neph_result neph_scene_add_volume(neph_scene *scene, neph_volume *volume, const neph_placement_desc *desc,
                                           unsigned *out_index) NEPH_NODISCARD;

/** Changes the placement of a cloud that neph_scene_add_volume added.
 *
 * @param desc  NULL for the defaults. */
NEPH_API neph_result neph_scene_set_placement(neph_scene *scene, unsigned index,
                                              const neph_placement_desc *desc) NEPH_NODISCARD;

/** Sets a terrain of the same context as the ground; the scene retains it; NULL: none. It stands on the planet of its
 * own description, which must be as large as the scene's. */
NEPH_API neph_result neph_scene_set_terrain(neph_scene *scene, neph_terrain *terrain) NEPH_NODISCARD;

/** Open water over all ground below its level. */
typedef struct neph_water_desc {
  size_t struct_size;
  double level_m;   /**< elevation, within ±10 km; from 0 up it covers the planet beyond the terrain (default 0) */
  double wind_m_s;  /**< wind that roughens the water, 0 to 40 (default 5) */
  double albedo[3]; /**< share of the entering light that comes back out (default 0.002, 0.008, 0.02) */
} neph_water_desc;

#define NEPH_WATER_DESC_DEFAULT                                                                                        \
  {                                                                                                                    \
    .struct_size = sizeof(neph_water_desc), .level_m = 0, .wind_m_s = 5, .albedo = { 0.002, 0.008, 0.02 }              \
  }

/** @param desc  NULL: no water. */
NEPH_API neph_result neph_scene_set_water(neph_scene *scene, const neph_water_desc *desc) NEPH_NODISCARD;

/** Sets an atmosphere of the same context as planet and air; the scene retains it; NULL: no air. Pictures of three
 * bands use its tables. */
NEPH_API neph_result neph_scene_set_atmosphere(neph_scene *scene, neph_atmosphere *atmosphere) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
