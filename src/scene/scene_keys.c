/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_keys.h"

#include <string.h>

#include "image/wavelengths.h"

#define SCENE(member) {offsetof(neph_scene, member), sizeof(((neph_scene *)0)->member)}
#define LAYER(member) {offsetof(np_scene_layer, member), sizeof(((np_scene_layer *)0)->member)}
#define CLOUD(member) {offsetof(np_scene_cloud, member), sizeof(((np_scene_cloud *)0)->member)}
#define MAP(quantity) CLOUD(bake.map_channels[NEPH_CLOUD_MAP_##quantity])

/* Lengths stay below a million kilometres, so that no square of one overflows a float. */
#define WITHIN(a, b) {a, b}
#define ANYWHERE {-1e9, 1e9}
#define SIZE {1e-6, 1e9}
#define ASYMMETRY {-0.999999, 0.999999}

/* Groups of keys that exclude each other. */
enum { GROUP_SUN = 1, GROUP_DENSITY, GROUP_PHASE, GROUP_TERRAIN, GROUP_PROFILE, GROUP_TOP };

static const np_choice booleans[] = {{"false", 0}, {"true", 1}, {NULL, 0}};
static const np_choice atmospheres[] = {{"earth", NP_AIR_EARTH}, {"earth-hazy", NP_AIR_EARTH_HAZY},
                                        {"mars", NP_AIR_MARS},   {"empty", NP_AIR_EMPTY},
                                        {"none", NP_AIR_NONE},   {NULL, 0}};
static const np_choice absorbers[] = {{"smooth", NEPH_LAYER_SMOOTH}, {"ozone", NEPH_LAYER_OZONE}, {NULL, 0}};
static const np_choice layer_phases[] = {{"rayleigh", NEPH_LAYER_RAYLEIGH}, {NULL, 0}};
static const np_choice absences[] = {{"none", 0}, {NULL, 0}};
static const np_choice hemispheres[] = {{"both", 0}, {"upper", 1}, {NULL, 0}};
static const np_choice planets[] = {{"sphere", 1}, {"none", 0}, {NULL, 0}};
static const np_choice axes[] = {{"z", NP_UP_Z}, {"y", NP_UP_Y}, {NULL, 0}};
static const np_choice policies[] = {{"refuse", NEPH_IMPORT_REFUSE}, {"repair", NEPH_IMPORT_REPAIR}, {NULL, 0}};
static const np_choice precisions[] = {{"half", NEPH_PRECISION_HALF}, {"float", NEPH_PRECISION_FLOAT}, {NULL, 0}};
static const np_choice phases[] = {{"rayleigh", NP_PHASE_RAYLEIGH}, {"isotropic", NP_PHASE_ISOTROPIC}, {NULL, 0}};
static const np_choice terrains[] = {{"none", NP_TERRAIN_NONE}, {NULL, 0}};
static const np_choice integrators[] = {{"march", NEPH_INTEGRATOR_MARCH}, {"path", NEPH_INTEGRATOR_PATH}, {NULL, 0}};
static const np_choice airs_of_paths[] = {
    {"traced", NEPH_RENDER_ATMOSPHERE_TRACED}, {"tables", NEPH_RENDER_ATMOSPHERE_TABLES}, {NULL, 0}};
static const np_choice scatterings[] = {
    {"ordinates", NEPH_MULTIPLE_SCATTERING_ORDINATES},
    {"octaves", NEPH_MULTIPLE_SCATTERING_OCTAVES},
    {"softened_beer", NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER},
    {"powder", NEPH_MULTIPLE_SCATTERING_POWDER},
    {"derivative", NEPH_MULTIPLE_SCATTERING_DERIVATIVE},
    {"none", NEPH_MULTIPLE_SCATTERING_NONE},
    {NULL, 0}};
static const np_choice sun_depths[] = {
    {"auto", NP_SUN_DEPTH_AUTO}, {"volume", NP_SUN_DEPTH_VOLUME}, {"march", NP_SUN_DEPTH_MARCH}, {NULL, 0}};
static const np_choice models[] = {
    {"cells", NEPH_CLOUD_MODEL_CELLS},
    {"slab", NEPH_CLOUD_MODEL_SLAB},
    {"hero", NEPH_CLOUD_MODEL_HERO},
    {NULL, 0}};
static const np_choice pixel_types[] = {{"half", NEPH_PIXEL_HALF}, {"float", NEPH_PIXEL_FLOAT}, {NULL, 0}};
static const np_choice color_spaces[] = {{"auto", NP_SCENE_COLOR_AUTO}, {"bands", NP_SCENE_BANDS},
                                         {"rec709", NP_SCENE_REC709},   {"acescg", NP_SCENE_ACESCG}, {NULL, 0}};
static const np_choice aovs[] = {
    {"background", NP_AOV_BACKGROUND}, {"terrain", NP_AOV_TERRAIN},   {"air", NP_AOV_AIR},
    {"sun", NP_AOV_SUN},               {"sky", NP_AOV_SKY},           {"ground", NP_AOV_GROUND},
    {"multiple", NP_AOV_MULTIPLE},     {"transmittance", NP_AOV_TRANSMITTANCE},
    {"distance", NP_AOV_DISTANCE},     {"depth", NP_AOV_DEPTH},
    {"standard_error", NP_AOV_STANDARD_ERROR},
    {"variance", NP_AOV_VARIANCE},     {"sample_count", NP_AOV_SAMPLE_COUNT},
    {"albedo", NP_AOV_ALBEDO},         {"mean_distance", NP_AOV_MEAN_DISTANCE},
    {"position", NP_AOV_POSITION},     {"emission", NP_AOV_EMISSION},
    {NULL, 0}};

/* clang-format off */
static const np_key keys[] = {
    {.path = "version", .type = NP_KEY_INTEGER, .field = SCENE(version), .range = WITHIN(1, 1), .fallback = "1",
     .meaning = "of the scene format"},

    {.path = "place", .type = NP_KEY_SECTION,
     .meaning = "where on Earth the world's origin lies; without it, at the centre of the height field"},
    {.path = "place.latitude", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(latitude_rad),
     .tag = SCENE(has_place), .tag_value = true, .range = WITHIN(-90, 90), .meaning = "north is positive"},
    {.path = "place.longitude", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(longitude_rad),
     .tag = SCENE(has_place), .tag_value = true, .range = WITHIN(-180, 180), .meaning = "east is positive"},

    {.path = "camera", .type = NP_KEY_SECTION, .meaning = "a pinhole; x points east, y north, z up"},
    {.path = "camera.position", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(camera.position_m),
     .range = ANYWHERE, .fallback = "0 m, -6 km, 400 m", .meaning = "x, y, z of the pinhole"},
    {.path = "camera.look_at", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(camera.look_at_m),
     .range = ANYWHERE, .fallback = "0 m, 0 m, 1800 m", .meaning = "x, y, z of the point in the middle of the picture"},
    {.path = "camera.fov", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(camera.fov_rad),
     .range = WITHIN(0.01, 170), .fallback = "50 deg", .meaning = "horizontal angle of view"},
    {.path = "camera.roll", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(camera.roll_rad),
     .range = WITHIN(-360, 360), .fallback = "0 deg",
     .meaning = "turns the camera clockwise about its view, and what it sees the other way"},
    {.path = "camera.resolution", .type = NP_KEY_INTEGER, .field = SCENE(camera.resolution), .range = WITHIN(1, 65536),
     .fallback = "960, 540", .meaning = "width and height of the picture in pixels"},

    {.path = "sun", .type = NP_KEY_SECTION, .meaning = "by elevation and azimuth, or by time"},
    {.path = "sun.elevation", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(sun.elevation_rad),
     .range = WITHIN(-90, 90), .fallback = "35 deg", .group = GROUP_SUN, .alternative = 1,
     .meaning = "above the horizontal at the world's origin, without refraction"},
    {.path = "sun.azimuth", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(sun.azimuth_rad),
     .range = WITHIN(-360, 360), .fallback = "120 deg", .group = GROUP_SUN, .alternative = 1,
     .meaning = "clockwise from north"},
    {.path = "sun.time", .type = NP_KEY_TIME, .field = SCENE(sun.time), .group = GROUP_SUN, .alternative = 2,
     .meaning = "puts the sun where it stands at the scene's place; UTC unless an offset is given"},
    {.path = "sun.angular_radius", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE,
     .field = SCENE(sun.angular_radius_rad), .tag = SCENE(sun.has_angular_radius), .tag_value = true,
     .range = WITHIN(0, 45), .fallback = "0.2678 deg", .meaning = "of the disk; by default as from the planet"},
    {.path = "sun.irradiance", .type = NP_KEY_REAL, .unit = NP_UNIT_IRRADIANCE,
     .field = SCENE(sun.irradiance_w_m2_nm), .tag = SCENE(sun.has_irradiance), .tag_value = true,
     .is_grey_allowed = true, .range = WITHIN(0, 1e9),
     .fallback = "1.474, 1.8504, 1.91198",
     .meaning = "above the atmosphere, on a plane facing the sun, at 680, 550 and 440 nm"},

    {.path = "sun.limb_darkening", .type = NP_KEY_CHOICE, .choices = booleans, .field = SCENE(sun.has_limb_darkening),
     .fallback = "true", .meaning = "whether its disk darkens towards the edge, as the sun's does"},

    {.path = "moon", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(moon.is_there),
     .tag = SCENE(moon.is_there), .tag_value = true,
     .meaning = "at the sun's time, or by elevation and azimuth; its phase follows from where the sun is"},
    {.path = "moon.elevation", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(moon.elevation_rad),
     .tag = SCENE(moon.has_angles), .tag_value = true, .range = WITHIN(-90, 90),
     .meaning = "above the horizontal at the world's origin, without refraction; goes with azimuth"},
    {.path = "moon.azimuth", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(moon.azimuth_rad),
     .tag = SCENE(moon.has_azimuth), .tag_value = true, .range = WITHIN(-360, 360),
     .meaning = "clockwise from north; goes with elevation"},
    {.path = "moon.brightness", .type = NP_KEY_REAL, .field = SCENE(moon.brightness), .range = WITHIN(0, 1e6),
     .fallback = "1", .meaning = "factor on its light, 1 being the moon's own"},
    {.path = "moon.earthshine", .type = NP_KEY_CHOICE, .choices = booleans, .field = SCENE(moon.has_earthshine),
     .fallback = "true", .meaning = "whether the Earth lights its dark side"},
    {.path = "moon.map", .type = NP_KEY_FILE, .field = SCENE(moon.map),
     .meaning = "OpenEXR picture of its albedo by longitude and latitude, longitude 0 in the middle, east to the "
                "right; changes the pattern, not the brightness"},

    {.path = "stars", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(stars.is_there),
     .tag = SCENE(stars.is_there), .tag_value = true,
     .meaning = "turned by the sun's time and place, or by sidereal_time"},
    {.path = "stars.catalogue", .type = NP_KEY_FILE, .field = SCENE(stars.catalogue),
     .meaning = "CSV with columns ra_deg, dec_deg, v_mag and b_v; without it, the brightest stars"},
    {.path = "stars.faintest", .type = NP_KEY_REAL, .field = SCENE(stars.faintest), .range = WITHIN(-2, 40),
     .fallback = "40", .meaning = "V magnitude beyond which stars are left out"},
    {.path = "stars.map", .type = NP_KEY_FILE, .field = SCENE(stars.map),
     .meaning = "OpenEXR picture of the whole sky in equatorial coordinates, right ascension 0 in the middle and "
                "growing to the left, beside the catalogue's stars"},
    {.path = "stars.map_radiance", .type = NP_KEY_REAL, .unit = NP_UNIT_RADIANCE, .field = SCENE(stars.map_radiance),
     .range = WITHIN(0, 1e9), .fallback = "1", .meaning = "of a value of 1 in that picture"},
    {.path = "stars.sidereal_time", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(stars.sidereal_rad),
     .tag = SCENE(stars.has_sidereal), .tag_value = true, .range = WITHIN(-360, 360),
     .meaning = "the right ascension on the meridian; needs the place's latitude"},
    {.path = "stars.twinkling", .type = NP_KEY_REAL, .field = SCENE(stars.twinkling), .range = WITHIN(0, 1),
     .fallback = "0", .meaning = "relative spread of a star's light at the zenith from frame to frame; more below"},

    {.path = "airglow", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(airglow.is_there),
     .tag = SCENE(airglow.is_there), .tag_value = true,
     .meaning = "the floor of the night sky: all that it holds beside single stars"},
    {.path = "airglow.magnitude", .type = NP_KEY_REAL, .field = SCENE(airglow.magnitude), .range = WITHIN(0, 40),
     .fallback = "22", .meaning = "in V, of a square arc second at the zenith; the colour is that of La Palma's sky"},
    {.path = "airglow.altitude", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(airglow.altitude_m),
     .range = WITHIN(1000, 1e7), .fallback = "90 km", .meaning = "of the layer that shines"},

    {.path = "atmosphere", .type = NP_KEY_SECTION, .choices = atmospheres, .field = SCENE(air.preset),
     .is_air_preset = true, .meaning = "the air"},
    {.path = "atmosphere.preset", .type = NP_KEY_CHOICE, .choices = atmospheres, .field = SCENE(air.preset),
     .is_air_preset = true, .fallback = "earth",
     .meaning = "planet and air to start from; empty has no air but what layers bring, none is a world without"},
    {.path = "atmosphere.planet_radius", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(atmosphere.planet_radius_m), .range = WITHIN(1000, 1e9), .fallback = "6360 km",
     .meaning = "of the sphere, on which clouds and terrain lie"},
    {.path = "atmosphere.top_altitude", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(atmosphere.top_altitude_m), .range = WITHIN(1, 1e7), .fallback = "100 km",
     .meaning = "where the air ends"},
    {.path = "atmosphere.rayleigh_scattering", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = SCENE(air.molecules.scattering_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1),
     .fallback = "5.802e-6 1/m, 13.558e-6 1/m, 33.1e-6 1/m", .meaning = "of air at sea level"},
    {.path = "atmosphere.rayleigh_height", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(air.molecules.height_m), .range = WITHIN(1, 1e7), .fallback = "8 km",
     .meaning = "over which air thins by a factor e"},
    {.path = "atmosphere.mie_scattering", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = SCENE(air.aerosol.scattering_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1),
     .fallback = "3.996e-6 1/m", .meaning = "of haze at sea level"},
    {.path = "atmosphere.mie_extinction", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = SCENE(air.aerosol_extinction_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1),
     .fallback = "4.44e-6 1/m",
     .meaning = "scattering and absorption of haze at sea level; not below its scattering"},
    {.path = "atmosphere.mie_height", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(air.aerosol.height_m), .range = WITHIN(1, 1e7), .fallback = "1.2 km",
     .meaning = "over which haze thins by a factor e"},
    {.path = "atmosphere.mie_asymmetry", .type = NP_KEY_REAL, .field = SCENE(air.aerosol.asymmetry),
     .is_grey_allowed = true, .range = WITHIN(-0.9999, 0.9999), .fallback = "0.8",
     .meaning = "g of haze, of the Cornette-Shanks phase function"},
    {.path = "atmosphere.ozone_absorption", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = SCENE(air.ozone.absorption_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1),
     .fallback = "0.65e-6 1/m, 1.881e-6 1/m, 0.085e-6 1/m", .meaning = "where the ozone layer is densest"},
    {.path = "atmosphere.ozone_center", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(air.ozone.center_m), .range = WITHIN(0, 1e7), .fallback = "25 km",
     .meaning = "altitude of the densest ozone"},
    {.path = "atmosphere.ozone_width", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(air.ozone.width_m), .range = WITHIN(1, 1e7), .fallback = "15 km",
     .meaning = "from there to where it ends, above and below"},
    {.path = "atmosphere.ground_albedo", .type = NP_KEY_REAL, .field = SCENE(atmosphere.ground_albedo),
     .tag = SCENE(has_ground_albedo), .tag_value = true, .is_grey_allowed = true, .range = WITHIN(0, 1),
     .fallback = "0.3", .meaning = "of the sphere; unless it is given, a terrain's takes its place"},
    {.path = "atmosphere.tolerance", .type = NP_KEY_REAL, .field = SCENE(atmosphere.tolerance),
     .range = WITHIN(0.003, 0.1), .fallback = "0.007",
     .meaning = "relative rms error that the sky's tables may make, by which they are sized and kept over a sequence"},
    {.path = "atmosphere.layers", .type = NP_KEY_LIST, .field = SCENE(air.layers),
     .meaning = "what else is in the air"},
    {.path = "atmosphere.layers[].exponential", .type = NP_KEY_SECTION, .tag = LAYER(desc.profile),
     .tag_value = NEPH_LAYER_EXPONENTIAL, .group = GROUP_PROFILE, .alternative = 1,
     .meaning = "a density that falls from 1 at the bottom; the default"},
    {.path = "atmosphere.layers[].exponential.height", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = LAYER(desc.height_m), .range = WITHIN(1, 1e7), .fallback = "1.2 km",
     .meaning = "over which it thins by a factor e"},
    {.path = "atmosphere.layers[].tent", .type = NP_KEY_SECTION, .tag = LAYER(desc.profile),
     .tag_value = NEPH_LAYER_TENT, .group = GROUP_PROFILE, .alternative = 2,
     .meaning = "a density that is 1 in the middle and falls evenly to either side"},
    {.path = "atmosphere.layers[].tent.center", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = LAYER(desc.center_m), .range = WITHIN(-1e7, 1e7), .fallback = "25 km", .meaning = "where it is densest"},
    {.path = "atmosphere.layers[].tent.width", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = LAYER(desc.width_m), .range = WITHIN(1, 1e7), .fallback = "15 km",
     .meaning = "from there to where it ends, above and below"},
    {.path = "atmosphere.layers[].table", .type = NP_KEY_ROWS, .unit = NP_UNIT_METRE, .field = LAYER(rows),
     .range = WITHIN(0, 1e9), .tag = LAYER(desc.profile), .tag_value = NEPH_LAYER_TABLE, .group = GROUP_PROFILE,
     .alternative = 3, .meaning = "altitudes and densities, linear between them and none beyond"},
    {.path = "atmosphere.layers[].bottom", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = LAYER(desc.bottom_m),
     .range = WITHIN(-1e7, 1e7), .fallback = "0 m", .meaning = "there is none of it below"},
    {.path = "atmosphere.layers[].top", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = LAYER(desc.top_m),
     .range = WITHIN(-1e7, 1e9), .fallback = "1000000 km", .meaning = "there is none of it above"},
    {.path = "atmosphere.layers[].scattering", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = LAYER(desc.scattering_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1), .fallback = "0 1/m",
     .meaning = "where the density is 1"},
    {.path = "atmosphere.layers[].absorption", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = LAYER(desc.absorption_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1), .fallback = "0 1/m",
     .meaning = "likewise"},
    {.path = "atmosphere.layers[].absorber", .type = NP_KEY_CHOICE, .choices = absorbers, .field = LAYER(desc.absorber),
     .fallback = "smooth", .meaning = "how absorption goes on at other wavelengths: as a power of them, or as ozone's"},
    {.path = "atmosphere.layers[].phase", .type = NP_KEY_SECTION, .choices = layer_phases, .field = LAYER(desc.phase),
     .meaning = "how it scatters: one of the keys below, or rayleigh in their place"},
    {.path = "atmosphere.layers[].phase.cornette_shanks", .type = NP_KEY_REAL, .field = LAYER(cornette_shanks),
     .tag = LAYER(desc.phase), .tag_value = NEPH_LAYER_CORNETTE_SHANKS, .is_grey_allowed = true,
     .range = WITHIN(-0.9999, 0.9999), .fallback = "0.8", .group = GROUP_PHASE, .alternative = 1,
     .meaning = "g of the Cornette-Shanks phase function; the default"},
    {.path = "atmosphere.layers[].phase.hg", .type = NP_KEY_REAL, .field = LAYER(henyey_greenstein),
     .tag = LAYER(desc.phase), .tag_value = NEPH_LAYER_HENYEY_GREENSTEIN, .is_grey_allowed = true,
     .range = WITHIN(-0.9999, 0.9999), .group = GROUP_PHASE, .alternative = 2,
     .meaning = "g of the Henyey-Greenstein phase function"},
    {.path = "atmosphere.layers[].phase.two_lobe", .type = NP_KEY_SECTION, .tag = LAYER(desc.phase),
     .tag_value = NEPH_LAYER_TWO_LOBE, .group = GROUP_PHASE, .alternative = 3, .meaning = "two of them, added"},
    {.path = "atmosphere.layers[].phase.two_lobe.forward", .type = NP_KEY_REAL, .field = LAYER(forward),
     .is_grey_allowed = true, .range = WITHIN(-0.9999, 0.9999), .fallback = "0.85", .meaning = "g of the first"},
    {.path = "atmosphere.layers[].phase.two_lobe.backward", .type = NP_KEY_REAL,
     .field = LAYER(desc.second_asymmetry), .is_grey_allowed = true, .range = WITHIN(-0.9999, 0.9999),
     .fallback = "-0.3", .meaning = "g of the second"},
    {.path = "atmosphere.layers[].phase.two_lobe.weight", .type = NP_KEY_REAL, .field = LAYER(desc.second_weight),
     .is_grey_allowed = true, .range = WITHIN(0, 1), .fallback = "0.1", .meaning = "of the second, between 0 and 1"},

    {.path = "environment", .type = NP_KEY_SECTION,
     .meaning = "uniform light from infinitely far away, for tests and studios"},
    {.path = "environment.radiance", .type = NP_KEY_REAL, .unit = NP_UNIT_RADIANCE,
     .field = SCENE(environment.radiance_w_m2_sr_nm), .is_grey_allowed = true, .range = WITHIN(0, 1e9),
     .fallback = "0", .meaning = "of that light"},
    {.path = "environment.hemisphere", .type = NP_KEY_CHOICE, .choices = hemispheres,
     .field = SCENE(environment.is_upper_only), .fallback = "both", .meaning = "where it comes from"},
    {.path = "environment.planet", .type = NP_KEY_CHOICE, .choices = planets, .field = SCENE(environment.has_planet),
     .fallback = "sphere", .meaning = "none leaves out the planet, and the air with it"},

    {.path = "clouds", .type = NP_KEY_LIST, .field = SCENE(clouds),
     .meaning = "each from a file, or baked, or baked to a file"},
    {.path = "clouds[].name", .type = NP_KEY_TEXT, .field = CLOUD(name),
     .meaning = "in messages and in names of baked files; without it, cloud0, cloud1, …"},
    {.path = "clouds[].vdb", .type = NP_KEY_FILE, .field = CLOUD(vdb), .meaning = "OpenVDB file, # for the frame"},
    {.path = "clouds[].grid", .type = NP_KEY_TEXT, .field = CLOUD(grid),
     .meaning = "name of a scalar grid in it; without it, density or the only one there is"},
    {.path = "clouds[].import", .type = NP_KEY_CHOICE, .choices = policies, .field = CLOUD(policy),
     .fallback = "refuse",
     .meaning = "what to do with values that no cloud has, such as NaN; repair takes them as 0"},
    {.path = "clouds[].precision", .type = NP_KEY_CHOICE, .choices = precisions, .field = CLOUD(precision),
     .fallback = "half", .meaning = "of the values in memory"},
    {.path = "clouds[].up", .type = NP_KEY_CHOICE, .choices = axes, .field = CLOUD(up), .fallback = "z",
     .meaning = "axis of the file that points up"},
    {.path = "clouds[].voxel", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(voxel_m), .range = SIZE,
     .meaning = "makes this the largest edge of a voxel; without it, as the file says"},
    {.path = "clouds[].scale", .type = NP_KEY_REAL, .field = CLOUD(scale), .range = WITHIN(1e-6, 1e6), .fallback = "1",
     .meaning = "enlarges the cloud after that"},
    {.path = "clouds[].rotation", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = CLOUD(rotation_rad),
     .range = WITHIN(-360, 360), .fallback = "0 deg",
     .meaning = "about the vertical, counter-clockwise seen from above"},
    {.path = "clouds[].position", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(position_m),
     .tag = CLOUD(has_position), .tag_value = true, .range = ANYWHERE,
     .meaning = "where the middle of the bottom of the cloud's box goes; without it, as the file says"},
    {.path = "clouds[].extinction", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE, .field = CLOUD(density_value),
     .tag = CLOUD(density_unit), .tag_value = NP_DENSITY_EXTINCTION, .range = WITHIN(0, 1e6), .fallback = "1 1/m",
     .group = GROUP_DENSITY, .alternative = 1, .meaning = "of a value of 1; baked clouds hold 1/m already"},
    {.path = "clouds[].mean_free_path", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(density_value),
     .tag = CLOUD(density_unit), .tag_value = NP_DENSITY_MEAN_FREE_PATH, .range = WITHIN(1e-6, 1e9),
     .group = GROUP_DENSITY, .alternative = 2, .meaning = "of light where the value is 1"},
    {.path = "clouds[].optical_depth", .type = NP_KEY_REAL, .field = CLOUD(density_value), .tag = CLOUD(density_unit),
     .tag_value = NP_DENSITY_OPTICAL_DEPTH, .range = WITHIN(0, 1e9), .group = GROUP_DENSITY, .alternative = 3,
     .meaning = "of the densest vertical column"},
    {.path = "clouds[].liquid_water", .type = NP_KEY_SECTION, .group = GROUP_DENSITY, .alternative = 4,
     .meaning = "says that values are grams of water in a cubic metre"},
    {.path = "clouds[].liquid_water.r_eff", .type = NP_KEY_REAL, .unit = NP_UNIT_MICROMETRE,
     .field = CLOUD(density_value), .tag = CLOUD(density_unit), .tag_value = NP_DENSITY_LIQUID_WATER,
     .range = WITHIN(0.01, 1e4), .meaning = "effective radius of the droplets"},
    {.path = "clouds[].albedo", .type = NP_KEY_REAL, .field = CLOUD(albedo), .is_grey_allowed = true,
     .range = WITHIN(0, 1), .fallback = "0.999995",
     .meaning = "share of the light that scattering leaves"},
    {.path = "clouds[].phase", .type = NP_KEY_SECTION, .choices = phases, .field = CLOUD(phase_source.kind),
     .meaning = "how light is scattered: one of the keys below, or rayleigh or isotropic in their place"},
    {.path = "clouds[].phase.droplets", .type = NP_KEY_SECTION, .tag = CLOUD(phase_source.kind),
     .tag_value = NP_PHASE_DROPLETS, .group = GROUP_PHASE, .alternative = 1,
     .meaning = "fit to Mie theory; the default"},
    {.path = "clouds[].phase.droplets.diameter", .type = NP_KEY_REAL, .unit = NP_UNIT_MICROMETRE,
     .field = CLOUD(phase_source.diameter_m), .range = WITHIN(5, 50), .fallback = "20 um",
     .meaning = "of the droplets"},
    {.path = "clouds[].phase.hg", .type = NP_KEY_REAL, .field = CLOUD(phase_source.asymmetry),
     .tag = CLOUD(phase_source.kind), .tag_value = NP_PHASE_HENYEY_GREENSTEIN, .range = ASYMMETRY,
     .group = GROUP_PHASE, .alternative = 2, .meaning = "g of the Henyey-Greenstein phase function"},
    {.path = "clouds[].phase.two_lobe", .type = NP_KEY_SECTION, .tag = CLOUD(phase_source.kind),
     .tag_value = NP_PHASE_TWO_LOBE, .group = GROUP_PHASE, .alternative = 3, .meaning = "two of them, added"},
    {.path = "clouds[].phase.two_lobe.forward", .type = NP_KEY_REAL, .field = CLOUD(phase_source.forward),
     .range = ASYMMETRY, .fallback = "0.85", .meaning = "g of the first"},
    {.path = "clouds[].phase.two_lobe.backward", .type = NP_KEY_REAL, .field = CLOUD(phase_source.backward),
     .range = ASYMMETRY, .fallback = "-0.25", .meaning = "g of the second"},
    {.path = "clouds[].phase.two_lobe.weight", .type = NP_KEY_REAL, .field = CLOUD(phase_source.backward_weight),
     .range = WITHIN(0, 1), .fallback = "0.1", .meaning = "share of the second"},
    {.path = "clouds[].phase.draine", .type = NP_KEY_SECTION, .tag = CLOUD(phase_source.kind),
     .tag_value = NP_PHASE_DRAINE, .group = GROUP_PHASE, .alternative = 4,
     .meaning = "Henyey-Greenstein times 1 + alpha times the squared cosine"},
    {.path = "clouds[].phase.draine.g", .type = NP_KEY_REAL, .field = CLOUD(phase_source.draine_asymmetry),
     .range = ASYMMETRY, .fallback = "0.8", .meaning = "of its Henyey-Greenstein part"},
    {.path = "clouds[].phase.draine.alpha", .type = NP_KEY_REAL, .field = CLOUD(phase_source.alpha),
     .range = WITHIN(0, 1e6), .fallback = "1", .meaning = "0 is Henyey-Greenstein, 1 Cornette-Shanks"},
    {.path = "clouds[].phase.table", .type = NP_KEY_FILE, .field = CLOUD(phase_source.table),
     .tag = CLOUD(phase_source.kind), .tag_value = NP_PHASE_TABLE, .group = GROUP_PHASE, .alternative = 5,
     .meaning = "CSV of angle_deg or cosine, and value in 1/sr"},
    {.path = "clouds[].emission", .type = NP_KEY_SECTION, .tag = CLOUD(emission.is_there), .tag_value = true,
     .meaning = "what glows in the file, as a black body"},
    {.path = "clouds[].emission.temperature", .type = NP_KEY_TEXT, .field = CLOUD(emission.temperature),
     .meaning = "name of the grid of temperatures; without it, temperature; none: it is offset everywhere"},
    {.path = "clouds[].emission.kelvin", .type = NP_KEY_REAL, .unit = NP_UNIT_KELVIN,
     .field = CLOUD(emission.kelvin_per_value), .range = WITHIN(0, 1e6), .fallback = "1 K",
     .meaning = "what a value of 1 in that grid adds to offset"},
    {.path = "clouds[].emission.offset", .type = NP_KEY_REAL, .unit = NP_UNIT_KELVIN, .field = CLOUD(emission.offset_k),
     .range = WITHIN(-1e5, 1e5), .fallback = "0 K", .meaning = "temperature where that grid holds 0"},
    {.path = "clouds[].emission.flame", .type = NP_KEY_TEXT, .field = CLOUD(emission.flame),
     .meaning = "name of the grid of flames; without it, flame if the file has one; none: the cloud glows by what it "
                "absorbs"},
    {.path = "clouds[].emission.absorption", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = CLOUD(emission.absorption_per_m), .range = WITHIN(0, 1e6), .fallback = "1 1/m",
     .meaning = "of a flame of 1, by which it glows; it hides nothing"},
    {.path = "clouds[].emission.strength", .type = NP_KEY_REAL, .field = CLOUD(emission.strength),
     .range = WITHIN(0, 1e12), .fallback = "1", .meaning = "factor on what glows"},

    {.path = "clouds[].bake", .type = NP_KEY_SECTION, .tag = CLOUD(is_baked), .tag_value = true,
     .meaning = "a cloud from noise; its values are extinction in 1/m"},
    {.path = "clouds[].bake.preset", .type = NP_KEY_PRESET, .field = CLOUD(preset),
     .meaning = "named values for all keys of bake, over which the others go wherever they stand"},
    {.path = "clouds[].bake.seed", .type = NP_KEY_SEED, .field = CLOUD(bake.seed), .fallback = "0",
     .meaning = "of the noise: another seed, another cloud of the same kind"},
    {.path = "clouds[].bake.extent", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(bake.extent_m),
     .is_grey_allowed = true, .range = SIZE, .fallback = "8 km", .meaning = "of the field along x and y"},
    {.path = "clouds[].bake.center", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(bake.center_m),
     .range = ANYWHERE, .fallback = "0 m, 0 m", .meaning = "x and y of the middle of the field"},
    {.path = "clouds[].bake.base", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(bake.base_altitude_m),
     .range = WITHIN(-1e6, 1e6), .fallback = "1.2 km", .meaning = "altitude of the flat cloud base above sea level"},
    {.path = "clouds[].bake.thickness", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(bake.thickness_m),
     .range = SIZE, .fallback = "1.2 km", .group = GROUP_TOP, .alternative = 1,
     .meaning = "from the base to the highest top"},
    {.path = "clouds[].bake.top", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(top_m),
     .tag = CLOUD(has_top), .tag_value = true, .range = WITHIN(-1e6, 1e6), .group = GROUP_TOP, .alternative = 2,
     .meaning = "altitude of the highest top, in place of the thickness"},
    {.path = "clouds[].bake.voxel", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(bake.voxel_m),
     .range = SIZE, .fallback = "20 m", .meaning = "edge of a voxel"},
    {.path = "clouds[].bake.coverage", .type = NP_KEY_REAL, .field = CLOUD(bake.coverage), .range = WITHIN(0, 1),
     .fallback = "0.35", .meaning = "fraction of the sky that is covered"},
    {.path = "clouds[].bake.cell", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(bake.cell_m),
     .range = SIZE, .fallback = "1.8 km", .meaning = "typical distance from cloud to cloud"},
    {.path = "clouds[].bake.type", .type = NP_KEY_REAL, .field = CLOUD(bake.type), .range = WITHIN(0, 1),
     .fallback = "0.5", .meaning = "from 0, flat humilis, to 1, tall congestus"},
    {.path = "clouds[].bake.billow", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(bake.billow_m),
     .range = SIZE, .fallback = "450 m", .meaning = "size of the largest billows"},
    {.path = "clouds[].bake.billowiness", .type = NP_KEY_REAL, .field = CLOUD(bake.billowiness),
     .range = WITHIN(0, 1), .fallback = "0.5", .meaning = "how far the largest billows stand out; not of a slab"},
    {.path = "clouds[].bake.erosion", .type = NP_KEY_REAL, .field = CLOUD(bake.erosion), .range = WITHIN(0, 1),
     .fallback = "0.4", .meaning = "how far detail eats into the shape"},
    {.path = "clouds[].bake.wispiness", .type = NP_KEY_REAL, .field = CLOUD(bake.wispiness), .range = WITHIN(0, 1),
     .fallback = "0.3", .meaning = "share of wispy rather than billowy detail at the base"},
    {.path = "clouds[].bake.turbulence", .type = NP_KEY_REAL, .field = CLOUD(bake.turbulence), .range = WITHIN(0, 1),
     .fallback = "0.3", .meaning = "how far detail is curled"},
    {.path = "clouds[].bake.skew", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(bake.skew_m),
     .range = ANYWHERE, .fallback = "0 m, 0 m", .meaning = "x and y by which wind moves the top against the base"},
    {.path = "clouds[].bake.extinction", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = CLOUD(bake.extinction_per_m), .range = WITHIN(1e-9, 1e6), .fallback = "0.06 1/m",
     .meaning = "in the core of the cloud"},
    {.path = "clouds[].bake.model", .type = NP_KEY_CHOICE, .choices = models, .field = CLOUD(bake.model),
     .fallback = "cells",
     .meaning = "cells tower over a flat base; a slab is a sheet with soft edges, and cheap; a hero is one cloud"},
    {.path = "clouds[].bake.sublayers", .type = NP_KEY_INTEGER, .field = CLOUD(bake.sublayers),
     .range = WITHIN(1, 16), .fallback = "1", .meaning = "sheets over each other that a slab is made of"},
    {.path = "clouds[].bake.softness", .type = NP_KEY_REAL, .field = CLOUD(bake.softness), .range = WITHIN(0, 1),
     .fallback = "0", .meaning = "from crisp edges, 0, to ones that fade over the whole cloud, 1"},
    {.path = "clouds[].bake.stretch", .type = NP_KEY_REAL, .field = CLOUD(bake.stretch), .range = WITHIN(1, 100),
     .fallback = "1", .meaning = "of a slab's pattern along the wind, or along x in calm"},
    {.path = "clouds[].bake.anvil", .type = NP_KEY_REAL, .field = CLOUD(bake.anvil), .range = WITHIN(0, 1),
     .fallback = "0", .meaning = "how far the tops of the largest cells spread"},
    {.path = "clouds[].bake.precipitation", .type = NP_KEY_REAL, .field = CLOUD(bake.precipitation),
     .range = WITHIN(0, 1), .fallback = "0", .meaning = "rain below the base: 1 reaches sea level, less evaporates"},
    {.path = "clouds[].bake.profile", .type = NP_KEY_REAL, .field = CLOUD(bake.profile),
     .tag = CLOUD(bake.has_profile), .tag_value = true, .range = WITHIN(0, 1),
     .meaning = "strength that a cell must have to reach 0, 1/4, 1/2, 3/4 and 1 of the thickness, never falling; "
                "without it, type decides"},
    {.path = "clouds[].bake.wind", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE_PER_SECOND,
     .field = CLOUD(bake.wind_m_s), .range = WITHIN(-200, 200), .fallback = "0 m/s, 0 m/s",
     .meaning = "x and y of the wind that moves the clouds through the extent"},
    {.path = "clouds[].bake.time", .type = NP_KEY_REAL, .unit = NP_UNIT_SECOND, .field = CLOUD(bake.time_s),
     .range = WITHIN(-1e6, 1e6), .fallback = "0 s",
     .meaning = "since the seed's own moment; clouds change steadily with it"},
    {.path = "clouds[].bake.frame_time", .type = NP_KEY_REAL, .unit = NP_UNIT_SECOND, .field = CLOUD(frame_time_s),
     .range = WITHIN(-1e4, 1e4), .fallback = "0 s",
     .meaning = "from one frame to the next; frame 1 is at time"},
    {.path = "clouds[].bake.lifetime", .type = NP_KEY_REAL, .unit = NP_UNIT_SECOND, .field = CLOUD(bake.lifetime_s),
     .range = WITHIN(1, 1e9), .fallback = "2400 s", .meaning = "over which a cell grows and decays"},
    {.path = "clouds[].bake.map", .type = NP_KEY_SECTION,
     .meaning = "a picture as weather map: 0 to 1 in a channel is a share of the key of that name"},
    {.path = "clouds[].bake.map.image", .type = NP_KEY_FILE, .field = CLOUD(bake.map_file),
     .meaning = "EXR or PNG, north up"},
    {.path = "clouds[].bake.map.coverage", .type = NP_KEY_TEXT, .field = MAP(COVERAGE),
     .meaning = "channel of the picture, such as R or Y: where it is 0 the sky is clear"},
    {.path = "clouds[].bake.map.type", .type = NP_KEY_TEXT, .field = MAP(TYPE), .meaning = "channel of the type"},
    {.path = "clouds[].bake.map.base", .type = NP_KEY_TEXT, .field = MAP(BASE),
     .meaning = "channel of the share of the thickness by which bases lie higher; tops stay below that of the field"},
    {.path = "clouds[].bake.map.thickness", .type = NP_KEY_TEXT, .field = MAP(THICKNESS),
     .meaning = "channel of the thickness"},
    {.path = "clouds[].bake.map.precipitation", .type = NP_KEY_TEXT, .field = MAP(PRECIPITATION),
     .meaning = "channel of the precipitation"},
    {.path = "clouds[].bake.map.size", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = CLOUD(bake.map_size_m),
     .tag = CLOUD(bake.has_map_size), .tag_value = true, .is_grey_allowed = true, .range = WITHIN(1e-6, 1e7),
     .meaning = "of the picture along x and y, in the middle of the field; without it, the extent"},
    {.path = "clouds[].bake.map.tiling", .type = NP_KEY_CHOICE, .choices = booleans, .field = CLOUD(bake.is_map_tiling),
     .fallback = "false", .meaning = "the picture repeats; else its border goes on beyond it"},

    {.path = "terrain", .type = NP_KEY_SECTION, .choices = terrains, .field = SCENE(terrain.kind),
     .meaning = "ground above the sphere, or none in place of the keys below"},
    {.path = "terrain.heightfield", .type = NP_KEY_FILE, .field = SCENE(terrain.heightfield),
     .tag = SCENE(terrain.kind), .tag_value = NP_TERRAIN_HEIGHTFIELD, .group = GROUP_TERRAIN, .alternative = 1,
     .meaning = "SRTM .hgt named by its corner, 16-bit PNG, or EXR in metres"},
    {.path = "terrain.ridges", .type = NP_KEY_SECTION, .tag = SCENE(terrain.kind), .tag_value = NP_TERRAIN_RIDGES,
     .group = GROUP_TERRAIN, .alternative = 2, .meaning = "mountains from noise"},
    {.path = "terrain.ridges.seed", .type = NP_KEY_SEED, .field = SCENE(terrain.ridges.seed), .fallback = "1",
     .meaning = "of the noise"},
    {.path = "terrain.ridges.samples", .type = NP_KEY_INTEGER, .field = SCENE(terrain.ridges.sample_count),
     .range = WITHIN(2, 16385), .fallback = "1025", .meaning = "heights along each side"},
    {.path = "terrain.ridges.relief", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(terrain.ridges.relief_m), .range = WITHIN(0, 1e5), .fallback = "1.4 km",
     .meaning = "from valleys to summits"},
    {.path = "terrain.ridges.ridge", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(terrain.ridges.ridge_m), .range = WITHIN(1, 1e7), .fallback = "9 km",
     .meaning = "distance from one large ridge to the next"},
    {.path = "terrain.albedo", .type = NP_KEY_REAL, .field = SCENE(terrain.desc.ground_albedo),
     .is_grey_allowed = true, .range = WITHIN(0, 1), .fallback = "0.2",
     .meaning = "share of the light that the ground reflects, at 680, 550 and 440 nm"},
    {.path = "terrain.width", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(terrain.desc.width_m),
     .range = WITHIN(1, 1e7), .fallback = "30 km", .meaning = "along x, of pictures and ridges"},
    {.path = "terrain.height_min", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(terrain.desc.height_min_m), .range = WITHIN(-1e5, 1e5), .fallback = "0 m",
     .meaning = "elevation of black in a PNG"},
    {.path = "terrain.height_max", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(terrain.desc.height_max_m), .range = WITHIN(-1e5, 1e5), .fallback = "2 km",
     .meaning = "elevation of white in a PNG"},

    {.path = "render", .type = NP_KEY_SECTION, .meaning = "how the picture is computed"},
    {.path = "render.integrator", .type = NP_KEY_CHOICE, .choices = integrators, .field = SCENE(render.integrator),
     .fallback = "march", .meaning = "march is fast and biased, path is unbiased and noisy"},
    {.path = "render.wavelengths", .type = NP_KEY_INTEGER, .field = SCENE(render.wavelength_count),
     .range = WITHIN(3, NP_WAVELENGTHS_MAX), .fallback = "3",
     .meaning = "a multiple of 3; three are the bands at 680, 550 and 440 nm, more are added up to colours as the eye "
                "does"},
    {.path = "render.samples", .type = NP_KEY_INTEGER, .field = SCENE(render.sample_count),
     .range = WITHIN(1, 16777216),
     .fallback = "4", .meaning = "for each pixel"},
    {.path = "render.target_error", .type = NP_KEY_REAL, .field = SCENE(render.target_error),
     .range = WITHIN(1e-6, 10), .fallback = "none", .word = "none", .word_value = INFINITY,
     .meaning = "standard error that each pixel's samples, render.samples or more, are to reach, over its radiance"},
    {.path = "render.max_samples", .type = NP_KEY_INTEGER, .field = SCENE(render.sample_count_max),
     .range = WITHIN(16, 16777216), .fallback = "65536", .meaning = "for each pixel, whatever the target error"},
    {.path = "render.time_limit", .type = NP_KEY_REAL, .unit = NP_UNIT_SECOND, .field = SCENE(render.time_limit_s),
     .range = WITHIN(0, 1e9), .fallback = "none", .word = "none", .word_value = INFINITY,
     .meaning = "for a frame; it ends with the samples it has, 16 of each pixel at least"},
    {.path = "render.seed", .type = NP_KEY_SEED, .field = SCENE(render.seed), .fallback = "0",
     .meaning = "of all random numbers"},
    {.path = "render.multiple_scattering", .type = NP_KEY_CHOICE, .choices = scatterings,
     .field = SCENE(render.multiple_scattering), .fallback = "ordinates",
     .meaning = "how the march answers for light scattered more than once"},
    {.path = "render.atmosphere", .type = NP_KEY_CHOICE, .choices = airs_of_paths, .field = SCENE(render.atmosphere),
     .fallback = "traced",
     .meaning = "of the integrator path: air and ground traced with the clouds, or, faster, from tables as in the "
                "march"},
    {.path = "render.light_memory", .type = NP_KEY_REAL, .unit = NP_UNIT_GIGABYTE,
     .field = SCENE(render.light_memory_bytes), .range = WITHIN(0.001, 1e6), .fallback = "auto", .word = "auto",
     .word_value = INFINITY,
     .meaning = "for ordinates while they are solved for; auto is a quarter of the machine's. Where it is too little, "
                "cells far from the camera are made larger first"},
    {.path = "render.look_gain", .type = NP_KEY_REAL, .field = SCENE(render.look_gain), .range = WITHIN(0, 1e6),
     .fallback = "1", .meaning = "on the light of octaves, softened_beer, powder and derivative"},
    {.path = "render.octaves", .type = NP_KEY_SECTION, .meaning = "of multiple scattering"},
    {.path = "render.octaves.count", .type = NP_KEY_INTEGER, .field = SCENE(render.octave_count),
     .range = WITHIN(1, 16),
     .fallback = "8", .meaning = "the first is single scattering"},
    {.path = "render.octaves.factors", .type = NP_KEY_REAL, .field = SCENE(render.octave_factors),
     .range = WITHIN(0, 1), .fallback = "0.5, 0.5, 0.5",
     .meaning = "from octave to octave, of light, optical depth and asymmetry"},
    {.path = "render.softened_beer", .type = NP_KEY_SECTION,
     .meaning = "sunlight through max(exp(-t), share * exp(-rate * t)) instead of exp(-t); powder takes it too"},
    {.path = "render.softened_beer.share", .type = NP_KEY_REAL, .field = SCENE(render.softened_share),
     .range = WITHIN(0, 1), .fallback = "0.7", .meaning = "of the light that fades slowly"},
    {.path = "render.softened_beer.rate", .type = NP_KEY_REAL, .field = SCENE(render.softened_rate),
     .range = WITHIN(0.01, 1), .fallback = "0.25", .meaning = "at which it fades, over that of Beer's law"},
    {.path = "render.powder", .type = NP_KEY_SECTION,
     .meaning = "how little light comes together in thin places and near the cloud's base"},
    {.path = "render.powder.strength", .type = NP_KEY_REAL, .field = SCENE(render.powder_strength),
     .range = WITHIN(0, 1), .fallback = "1", .meaning = "0 is softened_beer"},
    {.path = "render.derivative", .type = NP_KEY_SECTION, .meaning = "a slope of density that faces the sun is lit"},
    {.path = "render.derivative.distance", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(render.derivative_distance_m), .range = WITHIN(0.001, 1e6), .fallback = "30 m",
     .meaning = "to the look-up towards the sun"},
    {.path = "render.max_scatterings", .type = NP_KEY_INTEGER, .field = SCENE(render.scattering_max),
     .range = WITHIN(0, 1e9), .fallback = "all", .word = "all", .word_value = NEPH_SCATTERINGS_ALL,
     .meaning = "in cloud along one path; a limit loses light"},
    {.path = "render.tolerance", .type = NP_KEY_REAL, .field = SCENE(render.tolerance), .range = WITHIN(1e-5, 1),
     .fallback = "0.02",
     .meaning = "of the march: what its steps may err by, as a share of a ray's light; their number follows"},
    {.path = "render.step", .type = NP_KEY_REAL, .unit = NP_UNIT_VOXEL, .field = SCENE(render.step_voxels),
     .range = WITHIN(0.01, 100), .fallback = "4 voxels",
     .meaning = "longest step of the march, however little there is to see"},
    {.path = "render.transmittance_end", .type = NP_KEY_REAL, .field = SCENE(render.transmittance_end),
     .range = WITHIN(0, 0.5), .fallback = "0.001", .meaning = "the march ends a ray below it"},
    {.path = "render.sun_depth", .type = NP_KEY_CHOICE, .choices = sun_depths, .field = SCENE(render.sun_depth),
     .fallback = "auto",
     .meaning = "how the march finds how much cloud lies before the sun: looked up in a volume filled once, or marched "
                "for at every step; auto takes what is cheaper"},
    {.path = "render.air_shadows", .type = NP_KEY_CHOICE, .choices = booleans, .field = SCENE(render.has_air_shadows),
     .fallback = "false",
     .meaning = "whether clouds and hills cast shadows into the air before the camera; traced air always has them"},

    {.path = "output", .type = NP_KEY_SECTION, .meaning = "what is written, and where"},
    {.path = "output.image", .type = NP_KEY_FILE, .field = SCENE(output.image),
     .meaning = "OpenEXR file, # for the frame"},
    {.path = "output.preview", .type = NP_KEY_FILE, .field = SCENE(output.preview),
     .meaning = "PNG file, # for the frame"},
    {.path = "output.beauty", .type = NP_KEY_CHOICE, .choices = booleans, .field = SCENE(output.has_beauty),
     .fallback = "true", .meaning = "whether the picture itself is wanted, R, G and B, besides A, Z and the AOVs"},
    {.path = "output.aovs", .type = NP_KEY_FLAGS, .choices = aovs, .field = SCENE(output.aovs),
     .meaning = "further channels; depth is Z, which every picture has"},
    {.path = "output.pixel_type", .type = NP_KEY_CHOICE, .choices = pixel_types, .field = SCENE(output.pixel_type),
     .fallback = "half", .meaning = "of colour in the OpenEXR file"},
    {.path = "output.color_space", .type = NP_KEY_CHOICE, .choices = color_spaces, .field = SCENE(output.color),
     .fallback = "auto",
     .meaning = "what R, G and B are: radiances in three bands, or linear light in which (1, 1, 1) is D65; auto is "
                "bands for three wavelengths and rec709 for more"},
    {.path = "output.scale", .type = NP_KEY_REAL, .field = SCENE(output.scale), .range = WITHIN(0x1p-40, 0x1p40),
     .fallback = "1", .meaning = "factor on every radiance, a power of two, stated in the header"},
    {.path = "output.exposure", .type = NP_KEY_REAL, .unit = NP_UNIT_STOP, .field = SCENE(output.exposure_ev),
     .range = WITHIN(-40, 40), .fallback = "auto", .word = "auto", .word_value = 0,
     .tag = SCENE(output.is_exposure_auto),
     .tag_value = false, .word_tag_value = true, .meaning = "of the preview; auto goes by the picture"},
    {.path = "output.film", .type = NP_KEY_SECTION, .meaning = "what the film takes in"},
    {.path = "output.film.background", .type = NP_KEY_CHOICE, .choices = booleans,
     .field = SCENE(output.has_background),
     .fallback = "true", .meaning = "false leaves out the sky and the sun's disk behind everything"},
};
/* clang-format on */

static const size_t key_count = sizeof keys / sizeof *keys;

size_t np_key_count(void) { return key_count; }

const np_key *np_key_get(size_t index) { return &keys[index]; }

/* ---- Paths ---- */

const char *np_key_get_name(const np_key *key) {
  const char *dot = strrchr(key->path, '.');
  return dot ? dot + 1 : key->path;
}

/* The length of a path without its last part, and without the "[]" of a list's elements. */
static size_t find_parent_length(const np_key *key) {
  const char *dot = strrchr(key->path, '.');
  if (!dot) return 0;
  size_t length = (size_t)(dot - key->path);
  return length >= 2 && !strncmp(key->path + length - 2, "[]", 2) ? length - 2 : length;
}

static bool is_child(const np_key *key, const np_key *section) {
  size_t length = find_parent_length(key);
  if (!section) return length == 0;
  return strlen(section->path) == length && !strncmp(section->path, key->path, length);
}

const np_key *np_key_get_parent(const np_key *key) {
  for (size_t i = 0; i < key_count; i++)
    if (is_child(key, &keys[i])) return &keys[i];
  return NULL;
}

const np_key *np_key_find(const np_key *section, const char *name) {
  for (size_t i = 0; i < key_count; i++)
    if (!strcmp(np_key_get_name(&keys[i]), name) && is_child(&keys[i], section)) return &keys[i];
  return NULL;
}

const np_key *np_key_get_list(const np_key *key) {
  const char *brackets = strstr(key->path, "[].");
  for (size_t i = 0; brackets && i < key_count; i++) {
    const size_t length = strlen(keys[i].path);
    if (key->path + length == brackets && !strncmp(keys[i].path, key->path, length)) return &keys[i];
  }
  return NULL;
}

bool np_key_is_text(const np_key *key) {
  return key->type == NP_KEY_TEXT || key->type == NP_KEY_FILE || key->type == NP_KEY_TIME || key->type == NP_KEY_PRESET;
}

bool np_key_excludes(const np_key *a, const np_key *b) {
  return a->group && a->group == b->group && a->alternative != b->alternative;
}

unsigned np_key_count_values(const np_key *key) {
  switch (key->type) {
    case NP_KEY_REAL: return (unsigned)(key->field.size / sizeof(double));
    case NP_KEY_INTEGER: return (unsigned)(key->field.size / sizeof(unsigned));
    case NP_KEY_SECTION:
    case NP_KEY_LIST:
    case NP_KEY_SEED:
    case NP_KEY_CHOICE:
    case NP_KEY_FLAGS:
    case NP_KEY_TEXT:
    case NP_KEY_FILE:
    case NP_KEY_TIME:
    case NP_KEY_PRESET:
    case NP_KEY_ROWS: break;
  }
  return 1;
}
