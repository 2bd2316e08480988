/* SPDX-License-Identifier: Apache-2.0 */
/* A scene's settings: plain data in SI units, written by the key table (scene_keys.c) alone. */
#ifndef NP_SCENE_SCENE_PRIVATE_H
#define NP_SCENE_SCENE_PRIVATE_H

#include <nephos/atmosphere.h>
#include <nephos/cloud.h>
#include <nephos/render.h>
#include <nephos/scene.h>
#include <nephos/terrain.h>
#include <nephos/volume.h>

#include "atmosphere/haze.h"
#include "core/context_private.h"
#include "core/math.h"
#include "core/time_text.h"
#include "image/aov.h"
#include "image/color_space.h"
#include "optics/multiple_scattering.h"
#include "optics/phase.h"
#include "scene/quality.h"
#include "scene/scene_camera.h"
#include "scene/scene_node.h"
#include "terrain/terrain_source.h"

/* An imported camera. */
typedef struct np_scene_motion {
  bool is_enabled;
  char *file;   /* resolved path; NULL: none */
  char *camera; /* name of the camera in the file; NULL: the file's only camera */
  bool is_z_up;
  unsigned order;     /* order of rotations (camera_motion.c) */
  double unit_m;      /* metres per length unit of the file */
  double first_frame; /* offset added to frames of the file */
  bool is_read;       /* its tracks are in the animation */
} np_scene_motion;

/* Motion blur: exposure over a part of a frame. */
typedef struct np_scene_motion_blur {
  bool is_enabled;
  double shutter; /* open time in frames; infinite: from camera.shutter and frame_rate */
  double offset;  /* offset in frames from the frame to the middle of the exposure */
} np_scene_motion_blur;

/* A date and time. */
typedef struct np_scene_moment {
  char *text; /* the given text; NULL: not set, or animated */
  bool is_given;
  np_time at;
} np_scene_moment;

typedef struct np_scene_sun {
  double elevation_rad, azimuth_rad; /* without refraction; used if no time is set */
  np_scene_moment time;
  double frame_time_s;                     /* time between frames, counted from frame 1 */
  bool has_angular_radius, has_irradiance; /* set by keys; false: derived from the planet's distance to the sun */
  double angular_radius_rad;
  double irradiance_w_m2_nm[3];
  bool has_limb_darkening;
} np_scene_sun;

typedef enum np_air_preset { NP_AIR_NONE, NP_AIR_EARTH, NP_AIR_EARTH_HAZY, NP_AIR_MARS, NP_AIR_EMPTY } np_air_preset;

/* A tabulated profile: all altitudes, then all densities. */
typedef struct np_scene_rows {
  double *values;
  unsigned count;
} np_scene_rows;

/* An additional layer of the air; `desc` is completed from the other members. */
typedef struct np_scene_layer {
  neph_atmosphere_layer desc;
  np_scene_rows rows;
  double cornette_shanks[3], henyey_greenstein[3], forward[3], haze[3];
} np_scene_layer;

/* The air's keys: preset, three constituents, and a list of layers. */
typedef struct np_scene_air {
  np_air_preset preset;
  np_haze haze;
  bool has_visibility, has_asymmetry; /* set by keys */
  double visibility_m;
  double sun_distance_au;
  neph_atmosphere *given; /* replaces all other members; owned by the document; NULL: none */
  neph_atmosphere_layer molecules, aerosol, ozone;
  double aerosol_extinction_per_m[3];
  unsigned layer_count;
  np_scene_layer *layers;
} np_scene_air;

typedef struct np_scene_moon {
  bool is_enabled;
  bool has_angles, has_azimuth; /* set by keys; false: computed from the sun's time */
  double elevation_rad, azimuth_rad;
  double brightness;
  bool has_earthshine;
  char *map; /* resolved path; NULL: uniform */
} np_scene_moon;

typedef struct np_scene_stars {
  bool is_enabled;
  char *catalogue; /* resolved path; NULL: the built-in catalogue */
  char *map;       /* resolved path; NULL: none */
  double map_radiance;
  double faintest; /* limiting magnitude */
  bool has_sidereal;
  double sidereal_rad; /* if not set, computed from the sun's time */
  double twinkling;
} np_scene_stars;

typedef struct np_scene_airglow {
  bool is_enabled;
  double magnitude; /* V magnitude per square arc second at the zenith */
  double altitude_m;
} np_scene_airglow;

/* Uniform environment light, for tests and studio scenes. */
typedef struct np_scene_environment {
  double radiance_w_m2_sr_nm[3];
  bool is_upper_only;
  bool has_planet; /* false for `planet: none`, without planet and air */
} np_scene_environment;

typedef enum np_density_unit {
  NP_DENSITY_EXTINCTION,     /* density_value: extinction of a value of 1, 1/m */
  NP_DENSITY_MEAN_FREE_PATH, /* density_value: mean free path of a value of 1, m */
  NP_DENSITY_OPTICAL_DEPTH,  /* density_value: optical depth of the densest world-vertical column */
  NP_DENSITY_LIQUID_WATER,   /* values in g/m³; density_value: effective radius in m */
  NP_DENSITY_OF_FILE         /* each file states its unit */
} np_density_unit;

typedef enum np_axis_up { NP_UP_Z, NP_UP_Y } np_axis_up;

/* Emission from a cloud's file. */
typedef struct np_scene_emission {
  bool is_enabled;
  char *temperature, *flame; /* grid names; "none"; NULL: the usual name, for a flame only if the file has it */
  char *color;               /* grid of radiances; "none"; NULL: the usual names */
  double kelvin_per_value, offset_k;
  double absorption_per_m; /* absorption of a flame value of 1 */
  double strength;
} np_scene_emission;

/* Key names for messages about missing grids. */
#define NP_TEMPERATURE_KEY "clouds[].emission.temperature"
#define NP_FLAME_KEY "clouds[].emission.flame"

/* Subvoxel detail of a cloud: none, where voxels are larger than pixels, or by the scene's keys. */
typedef enum np_detail_kind {
  NP_DETAIL_BAKES, /* default: automatic for bakes, none for files */
  NP_DETAIL_NONE,
  NP_DETAIL_AUTO,
  NP_DETAIL_GIVEN
} np_detail_kind;

/* Procedural detail finer than a cloud's voxels. */
typedef struct np_scene_detail {
  np_detail_kind kind;
  double strength;
  double size_m; /* size of the largest billows; 0: two of the largest voxel edges */
  uint64_t seed;
} np_scene_detail;

/* Point of a cloud that is placed at its position. */
typedef enum np_pivot { NP_PIVOT_BASE, NP_PIVOT_CENTER, NP_PIVOT_ORIGIN, NP_PIVOT_POINT } np_pivot;

/* Handling of frames whose file is missing from a sequence. */
typedef enum np_missing { NP_MISSING_EMPTY, NP_MISSING_HOLD, NP_MISSING_LOOP, NP_MISSING_ERROR } np_missing;

/* A place of a cloud: the cloud is rotated and scaled about its pivot, tilted, and moved with the pivot to the
 * position. */
typedef struct np_cloud_place {
  double position_m[3], rotation_rad, scale;
  double tilt_rad[2]; /* rotation vector along x and y */
} np_cloud_place;

/* Repetition of a cloud from a file along x and y, without end. */
typedef enum np_repeat { NP_REPEAT_NONE, NP_REPEAT_FILE, NP_REPEAT_LENGTHS } np_repeat;

/* Quantity of a measured map. */
typedef enum np_map_quantity {
  NP_MAP_OPTICAL_DEPTH,
  NP_MAP_REFLECTANCE,    /* π·L/(μ₀·F₀) */
  NP_MAP_RADIANCE_FACTOR /* π·L/F₀ */
} np_map_quantity;

typedef enum np_map_top_quantity { NP_MAP_TOP_HEIGHT, NP_MAP_TOP_TEMPERATURE } np_map_top_quantity;

/* A measured map of a baked cloud. */
typedef struct np_scene_map {
  char *file; /* resolved file pattern; NULL: none */
  np_map_quantity quantity;
  unsigned band;                   /* number of the band; 0: the only band */
  bool has_elevation, has_azimuth; /* the sun's angles are set by keys; false: taken from the file */
  double sun_rad[2], view_rad[2];  /* elevation and azimuth of sun and viewer */
  bool has_ground_albedo;          /* set by a key; false: the scene's ground albedo */
  double ground_albedo, threshold, depth_max;
  char *top_file; /* resolved file pattern; NULL: none */
  np_map_top_quantity top_quantity;
  unsigned top_band;
  double ground_temperature_k; /* temperature at sea level of the standard profile */
} np_scene_map;

/* Repetition of a baked cloud. */
typedef enum np_bake_repeat {
  NP_BAKE_REPEAT_AUTO, /* default: a sheet to the horizon, where nothing prevents it */
  NP_BAKE_REPEAT_NONE,
  NP_BAKE_REPEAT_GIVEN
} np_bake_repeat;

typedef struct np_scene_cloud {
  char *name;
  neph_volume *volume;      /* set by an API call, owned by the document; NULL: read from a file or baked */
  char *vdb;                /* resolved file pattern, of .vdb, .nvdb or NetCDF; NULL if only baked */
  bool has_reference_frame; /* set by a key; false: the first requested frame that is not empty */
  double reference_frame;   /* infinite: all files of the sequence */
  np_missing missing;
  double frame_offset, frame_speed; /* map from frames to numbers of files */
  char *grid;                       /* NULL: neph_volume_load chooses */
  char *velocity;                   /* velocity grid; "none"; NULL: the usual names */
  double velocity_scale;
  char *color; /* colour grid; "none"; NULL: the usual names */
  neph_import_policy policy;
  double level_set_voxels;
  neph_volume_ramp ramp;
  neph_volume_model model; /* import settings of NetCDF, with the time step of the scene's frame */
  bool is_model;           /* the file is named by clouds[].netcdf */
  double model_step;       /* time step of the key; infinite: the number of the frame */
  neph_precision precision;
  neph_interpolation interpolation;
  np_repeat repeat;
  double repeat_m[2];    /* periods, if they are lengths */
  double repeat_reach_m; /* derived: distance at which the field ends; 0: no end */
  bool is_baked;
  np_bake_repeat bake_repeat; /* whether the range of its tiles, bake.repeat_m, is derived */
  char *preset;               /* bake preset; NULL: none */
  neph_cloud_desc bake;       /* its map_file, of the scene's frame, is owned */
  char *map_image;            /* resolved file pattern of the weather map; NULL: none */
  np_scene_map map;           /* its source in the bake, of the scene's frame, is owned */
  char bake_name[24];         /* key of the bake in messages: "clouds[0].bake" */
  bool has_mesh_shape, has_height_shape;
  unsigned level_count; /* levels of detail of a bake in memory */
  double level_px;      /* least size in pixels of a voxel, except in the finest level */
  bool has_top;         /* set: the thickness of the bake follows from it */
  double top_m;
  bool has_frame_time; /* set by a key; false: derived from the frame rate */
  double frame_time_s; /* time between frames of the bake */
  bool has_up;         /* set by a key; false: z */
  np_axis_up up;
  double voxel_m;      /* largest voxel edge; 0: the file's transform */
  double scale[3];     /* along east, north and up, before the rotation; negative: mirrored */
  double tilt_rad[2];  /* about world x, then y, before the rotation */
  double rotation_rad; /* about world z, counter-clockwise seen from above */
  bool has_position;
  double position_m[3]; /* position of the pivot */
  char *places;         /* resolved file of places; NULL: a single place */
  unsigned place_count; /* number of places in the file; 0: a single place */
  np_cloud_place *place;
  np_pivot pivot;
  double pivot_point[3]; /* in the file's unit */
  np_density_unit density_unit;
  double density_value;
  double albedo[3];
  np_phase_source phase_source;
  bool has_phase;    /* set by a key; false: by the preset */
  bool has_diameter; /* the diameter of droplets is set by a key; false: the file may have sizes */
  char *sizes;       /* grid of effective radii; NULL: by its usual name */
  char *phase_table; /* resolved path */
  np_phase phase;    /* resolved from its source; isotropic for a table until it is read */
  np_scene_emission emission;
  np_scene_detail detail;
  bool is_held_out; /* holdout: hides the background and is invisible */
} np_scene_cloud;

typedef struct np_scene_terrain {
  np_terrain_kind kind;
  neph_terrain *given; /* owned by the document; NULL: none */
  char *heightfield;   /* resolved path */
  char *crs;           /* coordinate system; NULL: stated in the file */
  char *albedo_image;  /* resolved path; NULL: none */
  char *mesh_file;     /* resolved path; NULL: none */
  neph_mesh_desc mesh;
  neph_terrain_desc desc;
  neph_ridges_desc ridges;
  bool is_held_out; /* the ground, even the sphere, is a holdout: it hides the background and is invisible */
} np_scene_terrain;

static inline np_terrain_source np_scene_terrain_get_source(const np_scene_terrain *terrain) {
  return (np_terrain_source){.kind = terrain->kind, .file = terrain->heightfield, .ridges = &terrain->ridges};
}

/* Description of the terrain. It is built on demand: scenes are moved in memory, so that they hold no pointers into
 * themselves. */
static inline neph_terrain_desc np_scene_terrain_get_desc(const np_scene_terrain *terrain) {
  neph_terrain_desc desc = terrain->desc;
  desc.mesh = &terrain->mesh;
  return desc;
}

typedef struct np_scene_water {
  bool is_enabled;
  double level_m, wind_m_s, albedo[3];
} np_scene_water;

/* Source of the march's sun optical depth. */
typedef enum np_sun_optical_depth_method {
  NP_SUN_OPTICAL_DEPTH_AUTO,
  NP_SUN_OPTICAL_DEPTH_VOLUME,
  NP_SUN_OPTICAL_DEPTH_MARCH
} np_sun_optical_depth_method;

/* Whether clouds and terrain cast shadows into the air in front of the camera. */
typedef enum np_air_shadows { NP_AIR_SHADOWS_AUTO, NP_AIR_SHADOWS_FALSE, NP_AIR_SHADOWS_TRUE } np_air_shadows;

/* Reuse of pixels from the previous frame. */
typedef enum np_history_method { NP_HISTORY_NONE, NP_HISTORY_REPROJECT } np_history_method;

typedef struct np_scene_render {
  np_quality quality; /* quality preset for the following fields whose keys are not set */
  neph_integrator integrator;
  unsigned wavelength_count; /* 3: the bands of the scene */
  unsigned sample_count, sample_count_max;
  double target_error, time_limit_s; /* infinite: none */
  uint64_t seed;
  neph_multiple_scattering multiple_scattering;
  neph_render_atmosphere atmosphere;
  neph_path_guiding path_guiding;
  np_approximation approximation;
  unsigned scattering_max;
  double light_memory_bytes; /* limit for the solution of multiple scattering; infinite: a quarter of the machine's
                                memory */
  double tolerance;          /* error of the march's steps, relative to a ray's radiance */
  double step_voxels;        /* longest step of the march, in voxels */
  double transmittance_end;  /* transmittance below which a ray ends */
  np_sun_optical_depth_method sun_optical_depth;
  np_air_shadows air_shadows;
  double detail_px;       /* least size in pixels of a baked voxel, or of two procedural heights; 0: no limit */
  double light_detail_px; /* least size in pixels of a cell of multiple scattering */
  double light_depth;     /* optical depth of the largest cell, (1−g)·σ·edge */
  unsigned light_degree;  /* highest degree of the angular expansion */
  double light_residual;
  double light_reuse_rad; /* rotation of the sun over which light is interpolated; 0: none */
  np_history_method history;
  unsigned history_update; /* a frame renders one pixel of this many … */
  double history_weight;   /* … with at least this weight against its history */
  unsigned history_frames; /* number of frames after which history restarts */
  unsigned upsample;       /* edge in pixels of the squares in which one pixel is rendered */
} np_scene_render;

/* Coverage in the channel A. */
typedef enum np_scene_alpha { NP_ALPHA_CLOUDS, NP_ALPHA_CLOUDS_AND_GROUND, NP_ALPHA_SCENE } np_scene_alpha;

/* Place of the light from the air in front of clouds: in the layer of the clouds, or in a separate layer. */
typedef enum np_cloud_air { NP_CLOUD_AIR_KEPT, NP_CLOUD_AIR_APART } np_cloud_air;

typedef struct np_scene_output {
  char *image, *preview, *deep; /* resolved file patterns; NULL: none */
  neph_pixel_type pixel_type;
  double scale; /* power of two; 0: the default of the colour space */
  np_color_space color_space;
  bool has_beauty; /* channels R, G, B */
  unsigned aovs;   /* bits of np_aov */
  np_scene_alpha alpha;
  np_cloud_air cloud_air;
  bool has_background; /* film.background: sky and disks in the picture */
  bool has_disks;      /* film.disks: disks of sun and moon in the background */
  double exposure_ev;
  neph_exposure exposure;
  neph_view view;
  char *ocio_config, *ocio_display, *ocio_view, *ocio_input; /* names of view ocio; NULL: not given */
  double glare;                                              /* share of light that the lens scatters */
  unsigned preview_bits;
} np_scene_output;

struct np_node;
struct np_animation;

/* Extent of the camera over all frames. Cells of light and voxels are chosen by it, so that they are the same in all
 * frames. For a still camera it is the camera. */
typedef struct np_scene_reach {
  double camera_min_m[3], camera_max_m[3]; /* box of its positions */
  np_scene_camera narrowest;               /* the camera with its narrowest angle of view */
} np_scene_reach;

struct neph_scene {
  neph_context *context;
  char *file; /* file name for messages and relative paths; NULL: none */
  char *text; /* text that the scene was read from; NULL: none */
  size_t text_size;
  const neph_scene *base;         /* original of an evaluated scene (scene_eval.h) */
  struct np_node *document;       /* keys, animated ones too; all members below derive from it (scene_apply.c) */
  struct np_node *source;         /* keys as given; NULL: equal to the document, without animated keys */
  struct np_animation *animation; /* tracks of keys; NULL: none */
  double frame;
  double frame_rate; /* 0: not set */
  unsigned version;
  bool has_place;
  double latitude_rad, longitude_rad;
  np_scene_camera camera;
  np_scene_reach reach;
  np_scene_motion motion;
  np_scene_motion_blur motion_blur;
  np_scene_sun sun;
  np_scene_moon moon;
  np_scene_stars stars;
  np_scene_airglow airglow;
  bool has_atmosphere;
  bool has_ground_albedo; /* atmosphere.ground_albedo is set; false: the terrain's albedo is used */
  np_scene_air air;
  neph_atmosphere_layer *layers;   /* layers of the whole air, derived from `air` */
  neph_atmosphere_desc atmosphere; /* uses these layers */
  np_scene_environment environment;
  unsigned cloud_count;
  np_scene_cloud *clouds;
  np_scene_terrain terrain;
  np_scene_water water;
  np_scene_render render;
  np_scene_output output;
};

/* Keys as given, without animated nodes. */
static inline const struct np_node *np_scene_get_source(const neph_scene *scene) {
  return scene->source ? scene->source : scene->document;
}

/* neph_scene_check without its warnings; runs before each plan too. */
neph_result np_scene_check(const neph_scene *scene);

/* Whether a cloud reads a separate file for each frame, and is not baked to it. */
bool np_scene_cloud_is_sequence(const np_scene_cloud *cloud);

/* Whether a cloud reads the time step of each frame from a model's file. */
bool np_scene_cloud_has_steps(const np_scene_cloud *cloud);

/* Whether a grid name is "none". */
static inline bool np_scene_is_none(const char *name) { return name && !strcmp(name, "none"); }

enum { NP_ICE_LEVELS_MAX = 4 }; /* each level has two parts (volume/volume_ice.h) */

/* Whether the cold part of a baked cloud, its anvil above all, is of ice: where no key sets the phase function, and its
 * volume has no other parts. */
static inline bool np_scene_cloud_has_ice(const np_scene_cloud *cloud) {
  return cloud->is_baked && !cloud->has_phase && cloud->bake.anvil > 0.0 && cloud->level_count <= NP_ICE_LEVELS_MAX &&
         !(cloud->bake.repeat_m > 0.0);
}

/* Whether a cloud's droplets may have the sizes of its file. */
static inline bool np_scene_cloud_has_sizes(const np_scene_cloud *cloud) {
  const bool is_one_size = cloud->sizes ? np_scene_is_none(cloud->sizes) : cloud->has_diameter;
  return !cloud->is_baked && cloud->phase_source.kind == NEPH_PHASE_DROPLETS && !is_one_size;
}

/* Whether a cloud's placement and scale depend on all files of a sequence. */
static inline bool np_scene_cloud_goes_by_all(const np_scene_cloud *cloud) { return isinf(cloud->reference_frame); }

/* Largest factor of a cloud's scale. */
double np_scene_cloud_get_scale(const np_scene_cloud *cloud);

/* The bake of a cloud as it is in a frame; 1 is at the bake's own time. */
/* Number of a sequence's file in a frame; independent of the speed in frame 1. */
double np_scene_cloud_get_number(const np_scene_cloud *cloud, double frame);

const char *np_scene_cloud_search_move(const np_scene_cloud *cloud);
neph_cloud_desc np_scene_cloud_get_frame(const np_scene_cloud *cloud, int frame);

/* Factor on radiances in pictures. Defaults: 1 for bands, 2 for colours, for which a perfect diffuser under sun and sky
 * at noon is near 1. */
double np_scene_get_scale(const neph_scene *scene);

/* Radiance R, G, B that a preview shows as neutral. In bands it is the sun's, normalised to green; otherwise, without
 * light in every band and in colour spaces with their own white, it is (1, 1, 1). */
void np_scene_get_white(const neph_scene *scene, double out_white[3]);

/* Whether the scene has water, which needs a planet. */
static inline bool np_scene_has_water(const neph_scene *scene) {
  return scene->water.is_enabled && scene->environment.has_planet;
}

/* Albedo of the planet: the terrain's, unless it is set. */
const double *np_scene_get_ground_albedo(const neph_scene *scene);

/* Unit vector towards the sun, from angles (azimuth clockwise from north) or from time and place. */
np_dvec3 np_scene_get_sun_direction(const neph_scene *scene, double latitude_rad, double longitude_rad);

/* Checks that a cloud's file of one frame can be opened; errors refer to the cloud's key vdb. neph_scene_check_files
 * checks the files that are the same in all frames. */
neph_result np_scene_check_cloud_file(const neph_scene *scene, unsigned index, const char *path);

/* Fails if neither a cloud's keys nor its file (`extinction_per_value` in the header) state the unit of its values. */
neph_result np_scene_check_cloud_unit(const neph_scene *scene, unsigned index, const char *path,
                                      double extinction_per_value);

#endif
