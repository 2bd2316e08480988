/* SPDX-License-Identifier: Apache-2.0 */
/* A scene as its keys leave it: plain data in SI units. The key table in scene_keys.c is the only writer. */
#ifndef NP_SCENE_SCENE_PRIVATE_H
#define NP_SCENE_SCENE_PRIVATE_H

#include <nephos/atmosphere.h>
#include <nephos/cloud.h>
#include <nephos/render.h>
#include <nephos/scene.h>
#include <nephos/terrain.h>
#include <nephos/volume.h>

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

/* A camera of another program. */
typedef struct np_scene_motion {
  bool is_enabled;
  char *file;   /* resolved; NULL: none */
  char *camera; /* name of that one in the file; NULL: the only one */
  bool is_z_up;
  unsigned order;     /* of rotations (camera_motion.c) */
  double unit_m;      /* of its lengths */
  double first_frame; /* added to its frames */
  bool is_read;       /* its tracks are in the animation */
} np_scene_motion;

/* Exposure over a part of a frame. */
typedef struct np_scene_motion_blur {
  bool is_enabled;
  double shutter; /* frames that it is open; infinite: as camera.shutter and frame_rate say */
  double offset;  /* frames from the frame's time to the middle of the exposure */
} np_scene_motion_blur;

/* A moment of a key. */
typedef struct np_scene_moment {
  char *text; /* as it was given; NULL: not given, or animated */
  bool is_given;
  np_time at;
} np_scene_moment;

typedef struct np_scene_sun {
  double elevation_rad, azimuth_rad; /* airless; used without a time */
  np_scene_moment time;
  double frame_time_s;                     /* from frame to frame, since frame 1 */
  bool has_angular_radius, has_irradiance; /* given: else the preset's distance from the sun tells */
  double angular_radius_rad;
  double irradiance_w_m2_nm[3];
  bool has_limb_darkening;
} np_scene_sun;

typedef enum np_air_preset { NP_AIR_NONE, NP_AIR_EARTH, NP_AIR_EARTH_HAZY, NP_AIR_MARS, NP_AIR_EMPTY } np_air_preset;

/* A profile by rows: all altitudes, then as many densities. */
typedef struct np_scene_rows {
  double *values;
  unsigned count;
} np_scene_rows;

/* A layer of the air beyond the preset's. `desc` is completed by the rest. */
typedef struct np_scene_layer {
  neph_atmosphere_layer desc;
  np_scene_rows rows;
  double cornette_shanks[3], henyey_greenstein[3], forward[3];
} np_scene_layer;

/* The air as its preset, the keys of its three constituents and its list of layers leave it. */
typedef struct np_scene_air {
  np_air_preset preset;
  double sun_distance_au;
  neph_atmosphere *given; /* stands for all of this; the document's; NULL: none */
  neph_atmosphere_layer molecules, aerosol, ozone;
  double aerosol_extinction_per_m[3];
  unsigned layer_count;
  np_scene_layer *layers;
} np_scene_air;

typedef struct np_scene_moon {
  bool is_enabled;
  bool has_angles, has_azimuth; /* else where it stands at the sun's time */
  double elevation_rad, azimuth_rad;
  double brightness;
  bool has_earthshine;
  char *map; /* file, resolved; NULL: plain */
} np_scene_moon;

typedef struct np_scene_stars {
  bool is_enabled;
  char *catalogue; /* file, resolved; NULL: the built-in one */
  char *map;       /* file, resolved; NULL: none */
  double map_radiance;
  double faintest; /* magnitude */
  bool has_sidereal;
  double sidereal_rad; /* else by the sun's time */
  double twinkling;
} np_scene_stars;

typedef struct np_scene_airglow {
  bool is_enabled;
  double magnitude; /* in V, of a square arc second at the zenith */
  double altitude_m;
} np_scene_airglow;

/* Uniform light from infinitely far away, for tests and studios. */
typedef struct np_scene_environment {
  double radiance_w_m2_sr_nm[3];
  bool is_upper_only;
  bool has_planet; /* `planet: none` removes sphere and air */
} np_scene_environment;

typedef enum np_density_unit {
  NP_DENSITY_EXTINCTION,     /* density_value: 1/m for a value of 1 */
  NP_DENSITY_MEAN_FREE_PATH, /* m for a value of 1 */
  NP_DENSITY_OPTICAL_DEPTH,  /* of the densest world-vertical column */
  NP_DENSITY_LIQUID_WATER,   /* values in g/m³; density_value: effective radius in m */
  NP_DENSITY_OF_FILE         /* as each file states it: no key does */
} np_density_unit;

typedef enum np_axis_up { NP_UP_Z, NP_UP_Y } np_axis_up;

/* The emission of a cloud's file. */
typedef struct np_scene_emission {
  bool is_enabled;
  char *temperature, *flame; /* names of grids; "none"; NULL: the usual name, a flame only where there is one */
  char *color;               /* of radiances; "none"; NULL: the usual names */
  double kelvin_per_value, offset_k;
  double absorption_per_m; /* where the flame's grid holds 1 */
  double strength;
} np_scene_emission;

/* For messages about a file that lacks what they name. */
#define NP_TEMPERATURE_KEY "clouds[].emission.temperature"
#define NP_FLAME_KEY "clouds[].emission.flame"

/* Detail that a cloud's values do not hold. */
typedef struct np_scene_detail {
  bool is_enabled;
  double strength;
  double size_m; /* of its largest billows; 0: two of the largest edges of a voxel */
  uint64_t seed;
} np_scene_detail;

/* The point of a cloud that stands at its position. */
typedef enum np_pivot { NP_PIVOT_BASE, NP_PIVOT_CENTER, NP_PIVOT_ORIGIN, NP_PIVOT_POINT } np_pivot;

/* The meaning of a frame whose file a sequence lacks. */
typedef enum np_missing { NP_MISSING_EMPTY, NP_MISSING_HOLD, NP_MISSING_LOOP, NP_MISSING_ERROR } np_missing;

/* A place of a cloud: its pivot there, turned about it and enlarged; then tilted. */
typedef struct np_cloud_place {
  double position_m[3], rotation_rad, scale;
  double tilt_rad[2]; /* a rotation vector along x and y */
} np_cloud_place;

typedef struct np_scene_cloud {
  char *name;
  neph_volume *volume;      /* given, the document's; NULL: from a file or baked */
  char *vdb;                /* file pattern, resolved; NULL when only baked */
  bool has_reference_frame; /* by number; else the first asked for that holds anything */
  double reference_frame;   /* infinite: all files of the sequence */
  np_missing missing;
  double frame_offset, frame_speed; /* from frames to numbers of files */
  char *grid;                       /* NULL: chosen by neph_volume_load */
  char *velocity;                   /* name of the grid of velocities; "none"; NULL: the usual names */
  double velocity_scale;
  char *color; /* name of the grid of colours; "none"; NULL: the usual names */
  neph_import_policy policy;
  double level_set_voxels;
  neph_volume_ramp ramp;
  neph_precision precision;
  bool is_baked;
  char *preset; /* of the bake; NULL: none */
  neph_cloud_desc bake; /* its map_file is that of the scene's frame, owned */
  char *map_image;      /* file pattern of its weather map, resolved; NULL: none */
  char bake_name[24]; /* its key, for messages: "clouds[0].bake" */
  bool has_mesh_shape, has_height_shape;
  unsigned level_count; /* of detail, of a bake in memory */
  double level_px;      /* that a voxel covers at least where it is not the smallest */
  bool has_top;         /* then the thickness of the bake follows from it */
  double top_m;
  bool has_frame_time; /* given: else by the frame rate */
  double frame_time_s; /* of the bake, from frame to frame */
  bool has_up; /* given: else z */
  np_axis_up up;
  double voxel_m;      /* largest edge; 0: the file's transform */
  double scale[3];     /* along east, north and up, before it is turned; below 0: mirrored */
  double tilt_rad[2];  /* about world x, then y, before the rotation */
  double rotation_rad; /* about world z, counter-clockwise seen from above */
  bool has_position;
  double position_m[3]; /* of the pivot */
  char *places;         /* file of many, resolved; NULL: it stands once */
  unsigned place_count; /* as read from it: 0, it stands once */
  np_cloud_place *place;
  np_pivot pivot;
  double pivot_point[3]; /* in the file's unit */
  np_density_unit density_unit;
  double density_value;
  double albedo[3];
  np_phase_source phase_source;
  char *phase_table; /* file, resolved */
  np_phase phase;    /* of the source; isotropic for a table, until it is read */
  np_scene_emission emission;
  np_scene_detail detail;
  bool is_held_out; /* hides, and does not show */
} np_scene_cloud;

typedef struct np_scene_terrain {
  np_terrain_kind kind;
  neph_terrain *given; /* the document's; NULL: none */
  char *heightfield;   /* file, resolved */
  char *crs;           /* NULL: the file's */
  char *albedo_image;  /* file, resolved; NULL: none */
  char *mesh_file;     /* file, resolved; NULL: none */
  neph_mesh_desc mesh;
  neph_terrain_desc desc;
  neph_ridges_desc ridges;
  bool is_held_out; /* the ground, the sphere's too: hides, and does not show */
} np_scene_terrain;

static inline np_terrain_source np_scene_terrain_get_source(const np_scene_terrain *terrain) {
  return (np_terrain_source){.kind = terrain->kind, .file = terrain->heightfield, .ridges = &terrain->ridges};
}

/* Its description. A scene's own points into it nowhere, since scenes are swapped. */
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

/* Whether clouds and hills cast shadows into the air before the camera. */
typedef enum np_air_shadows { NP_AIR_SHADOWS_AUTO, NP_AIR_SHADOWS_FALSE, NP_AIR_SHADOWS_TRUE } np_air_shadows;

/* Pixels that a frame takes from the frame before it. */
typedef enum np_history_method { NP_HISTORY_NONE, NP_HISTORY_REPROJECT } np_history_method;

typedef struct np_scene_render {
  np_quality quality; /* of which the fields below follow that no key was given for */
  neph_integrator integrator;
  unsigned wavelength_count; /* 3: the bands that the scene is given in */
  unsigned sample_count, sample_count_max;
  double target_error, time_limit_s; /* infinite: none */
  uint64_t seed;
  neph_multiple_scattering multiple_scattering;
  neph_render_atmosphere atmosphere;
  neph_path_guiding path_guiding;
  np_approximation approximation;
  unsigned scattering_max;
  double light_memory_bytes; /* while the multiple scattering is solved for; infinite: a quarter of the machine's */
  double tolerance;          /* of the march's steps, as a share of a ray's light */
  double step_voxels;        /* longest step of the march, in voxels */
  double transmittance_end;  /* a ray ends below this */
  np_sun_optical_depth_method sun_optical_depth;
  np_air_shadows air_shadows;
  double detail_px;       /* pixels that a baked voxel, or two made heights, cover at least; 0: none are left out */
  double light_detail_px; /* the same of a cell of multiple scattering */
  double light_depth;     /* of such a cell, (1−g)·σ·edge */
  unsigned light_degree;  /* most that angles are resolved into */
  double light_residual;
  double light_reuse_rad; /* turn of the sun over which light is interpolated; 0: none is */
  np_history_method history;
  unsigned history_update; /* of so many pixels a frame renders one, … */
  double history_weight;   /* … which counts so much at least against its history */
  unsigned history_frames; /* after which it starts anew */
  unsigned upsample;       /* edge of the squares of pixels of which one is rendered */
} np_scene_render;

/* Coverage in the channel A. */
typedef enum np_scene_alpha { NP_ALPHA_CLOUDS, NP_ALPHA_CLOUDS_AND_GROUND, NP_ALPHA_SCENE } np_scene_alpha;

/* The light that the air before them adds to the layer of the clouds: in it, or in a layer of its own alone. */
typedef enum np_cloud_air { NP_CLOUD_AIR_KEPT, NP_CLOUD_AIR_APART } np_cloud_air;

typedef struct np_scene_output {
  char *image, *preview, *deep; /* patterns, resolved; NULL: none */
  neph_pixel_type pixel_type;
  double scale; /* power of two; 0: the colour space's own */
  np_color_space color_space;
  bool has_beauty; /* R, G, B */
  unsigned aovs;   /* of np_aov */
  np_scene_alpha alpha;
  np_cloud_air cloud_air;
  bool has_background; /* film.background: sky and disk in the picture */
  bool has_disks;      /* film.disks: of sun and moon, in the background */
  double exposure_ev;
  neph_exposure exposure;
  neph_view view;
  unsigned preview_bits;
} np_scene_output;

struct np_node;
struct np_animation;

/* The camera over all key frames, by which cells of light and voxels are chosen, so that they are the same in all
 * frames. Of a camera that stands still it is the camera. */
typedef struct np_scene_reach {
  double camera_min_m[3], camera_max_m[3]; /* box of its positions */
  np_scene_camera narrowest;               /* with the narrowest of its angles of view */
} np_scene_reach;

struct neph_scene {
  neph_context *context;
  char *file;                     /* name for messages and relative paths; NULL: none */
  const neph_scene *base;         /* of an evaluated scene, the one that it was evaluated from (scene_eval.h) */
  struct np_node *document;       /* the keys, animated ones too; everything below follows from it (scene_apply.c) */
  struct np_node *source;         /* the keys that were given; NULL: the document, since no key is animated */
  struct np_animation *animation; /* tracks of keys; NULL: none */
  double frame;
  double frame_rate; /* 0: not given */
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
  bool has_ground_albedo; /* atmosphere.ground_albedo was set: else the terrain's feeds the atmosphere */
  np_scene_air air;
  neph_atmosphere_layer *layers;   /* of all the air, as they follow from that */
  neph_atmosphere_desc atmosphere; /* with those layers */
  np_scene_environment environment;
  unsigned cloud_count;
  np_scene_cloud *clouds;
  np_scene_terrain terrain;
  np_scene_water water;
  np_scene_render render;
  np_scene_output output;
};

/* The keys as they were given. */
static inline const struct np_node *np_scene_get_source(const neph_scene *scene) {
  return scene->source ? scene->source : scene->document;
}

/* neph_scene_check without its warnings: before each plan, too. */
neph_result np_scene_check(const neph_scene *scene);

/* Whether a cloud has a file of its own for each frame, and is not baked to it. */
bool np_scene_cloud_is_sequence(const np_scene_cloud *cloud);

/* Whether a key that names a grid says that there is none. */
static inline bool np_scene_is_none(const char *name) { return name && !strcmp(name, "none"); }

/* Whether all files of a sequence place and scale each of them. */
static inline bool np_scene_cloud_goes_by_all(const np_scene_cloud *cloud) { return isinf(cloud->reference_frame); }

/* The greatest of the factors by which a cloud is enlarged. */
double np_scene_cloud_get_scale(const np_scene_cloud *cloud);

/* The bake of a cloud as it is in a frame; 1 is at the bake's own time. */
/* Number of the file of a sequence in a frame. Frame 1 stays what it is at every speed. */
double np_scene_cloud_get_number(const np_scene_cloud *cloud, double frame);

neph_cloud_desc np_scene_cloud_get_frame(const np_scene_cloud *cloud, int frame);

/* Factor on radiances in pictures: unless it is given, 1 for bands and 2 for colours, by which a perfect diffuser in
 * the sun and sky of noon is near 1. */
double np_scene_get_scale(const neph_scene *scene);

/* Radiance of R, G, B that a preview shows as neutral: the sun's in bands, green being 1; (1, 1, 1) where nothing, or
 * not all of it, shines, and in a space that has its own white. */
void np_scene_get_white(const neph_scene *scene, double out_white[3]);

/* Water lies on a planet. */
static inline bool np_scene_has_water(const neph_scene *scene) {
  return scene->water.is_enabled && scene->environment.has_planet;
}

/* Albedo of the planet: the terrain's, unless it was given. */
const double *np_scene_get_ground_albedo(const neph_scene *scene);

/* Unit vector towards the sun, from angles (azimuth clockwise from north) or from time and place. */
np_dvec3 np_scene_get_sun_direction(const neph_scene *scene, double latitude_rad, double longitude_rad);

/* Whether a cloud's file of one frame can be opened; fails at the cloud's vdb in the scene. neph_scene_check_files is
 * the same of the files that have one name in all frames. */
neph_result np_scene_check_cloud_file(const neph_scene *scene, unsigned index, const char *path);

/* Fails for a cloud without a key for the unit of its values where its file, `extinction_per_value` by its header, does
 * not state one either. */
neph_result np_scene_check_cloud_unit(const neph_scene *scene, unsigned index, const char *path,
                                      double extinction_per_value);

#endif
