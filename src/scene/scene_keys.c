/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_keys.h"

#include "image/film.h"
#include "image/wavelengths.h"
#include "scene/scene_key_rows.h"

#define LAYER(member)                                                                                                  \
  { offsetof(np_scene_layer, member), sizeof(((np_scene_layer *)0)->member) }
const np_choice np_booleans[] = {{"false", 0}, {"true", 1}, {NULL, 0}};

static const np_choice atmospheres[] = {{"earth", NP_AIR_EARTH}, {"earth-hazy", NP_AIR_EARTH_HAZY},
                                        {"mars", NP_AIR_MARS},   {"empty", NP_AIR_EMPTY},
                                        {"none", NP_AIR_NONE},   {NULL, 0}};
static const np_choice absorbers[] = {{"smooth", NEPH_LAYER_SMOOTH}, {"ozone", NEPH_LAYER_OZONE}, {NULL, 0}};
static const np_choice layer_phases[] = {{"rayleigh", NEPH_LAYER_RAYLEIGH}, {NULL, 0}};
static const np_choice absences[] = {{"none", 0}, {NULL, 0}};
static const np_choice hemispheres[] = {{"both", 0}, {"upper", 1}, {NULL, 0}};
static const np_choice planets[] = {{"sphere", 1}, {"none", 0}, {NULL, 0}};
static const np_choice terrains[] = {{"none", NP_TERRAIN_NONE}, {NULL, 0}};
static const np_choice terrain_edges[] = {{"infinite", NEPH_TERRAIN_EDGE_INFINITE},
                                          {"fade", NEPH_TERRAIN_EDGE_FADE},
                                          {"wall", NEPH_TERRAIN_EDGE_WALL},
                                          {NULL, 0}};
static const np_choice height_units[] = {{"file", NEPH_HEIGHT_UNIT_FILE},
                                         {"metre", NEPH_HEIGHT_UNIT_METRE},
                                         {"foot", NEPH_HEIGHT_UNIT_FOOT},
                                         {"us_survey_foot", NEPH_HEIGHT_UNIT_US_SURVEY_FOOT},
                                         {NULL, 0}};
static const np_choice height_encodings[] = {{"values", NEPH_HEIGHT_ENCODING_VALUES},
                                             {"terrain_rgb", NEPH_HEIGHT_ENCODING_TERRAIN_RGB},
                                             {"terrarium", NEPH_HEIGHT_ENCODING_TERRARIUM},
                                             {NULL, 0}};
static const np_choice raw_types[] = {
    {"uint16", NEPH_RAW_TYPE_UINT16}, {"int16", NEPH_RAW_TYPE_INT16}, {"float32", NEPH_RAW_TYPE_FLOAT32}, {NULL, 0}};
static const np_choice byte_orders[] = {{"little", 0}, {"big", 1}, {NULL, 0}};
const np_choice np_mesh_ups[] = {{"file", NEPH_MESH_UP_FILE}, {"y", NEPH_MESH_UP_Y}, {"z", NEPH_MESH_UP_Z}, {NULL, 0}};
static const np_choice mesh_pivots[] = {
    {"base", NEPH_MESH_PIVOT_BASE}, {"center", NEPH_MESH_PIVOT_CENTER}, {"origin", NEPH_MESH_PIVOT_ORIGIN}, {NULL, 0}};
static const np_choice mesh_normals[] = {
    {"smooth", NEPH_MESH_NORMALS_SMOOTH}, {"flat", NEPH_MESH_NORMALS_FLAT}, {NULL, 0}};
static const np_choice integrators[] = {{"march", NEPH_INTEGRATOR_MARCH}, {"path", NEPH_INTEGRATOR_PATH}, {NULL, 0}};
static const np_choice airs_of_paths[] = {
    {"traced", NEPH_RENDER_ATMOSPHERE_TRACED}, {"tables", NEPH_RENDER_ATMOSPHERE_TABLES}, {NULL, 0}};
static const np_choice path_guidings[] = {
    {"none", NEPH_PATH_GUIDING_NONE}, {"adjoint", NEPH_PATH_GUIDING_ADJOINT}, {NULL, 0}};
#define SCATTERING(id, name, needs) {name, NEPH_MULTIPLE_SCATTERING_##id},
static const np_choice scatterings[] = {NP_MULTIPLE_SCATTERING_ROWS(SCATTERING){NULL, 0}};
#undef SCATTERING
static const np_choice sun_optical_depths[] = {{"auto", NP_SUN_OPTICAL_DEPTH_AUTO},
                                               {"volume", NP_SUN_OPTICAL_DEPTH_VOLUME},
                                               {"march", NP_SUN_OPTICAL_DEPTH_MARCH},
                                               {NULL, 0}};
static const np_choice air_shadows[] = {
    {"auto", NP_AIR_SHADOWS_AUTO}, {"false", NP_AIR_SHADOWS_FALSE}, {"true", NP_AIR_SHADOWS_TRUE}, {NULL, 0}};

/* clang-format off */
static const np_key first_keys[] = {
    {.path = "version", .type = NP_KEY_INTEGER, .field = SCENE(version), .range = WITHIN(1, 1), .fallback = "1",
     .meaning = "version of the scene format"},

    {.path = "place", .type = NP_KEY_SECTION,
     .meaning = "place on Earth of the world's origin; without it, the centre of the height field"},
    {.path = "place.latitude", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(latitude_rad),
     .tag = SCENE(has_place), .tag_value = true, .range = WITHIN(-90, 90), .meaning = "north is positive"},
    {.path = "place.longitude", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(longitude_rad),
     .tag = SCENE(has_place), .tag_value = true, .range = WITHIN(-180, 180), .meaning = "east is positive"},
};

static const np_key sky_keys[] = {
    {.path = "sun", .type = NP_KEY_SECTION, .meaning = "the sun, by elevation and azimuth, or by time"},
    {.path = "sun.elevation", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(sun.elevation_rad),
     .range = WITHIN(-90, 90), .fallback = "35 deg", .group = GROUP_SUN, .alternative = 1,
     .meaning = "above the horizontal at the world's origin, without refraction"},
    {.path = "sun.azimuth", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(sun.azimuth_rad),
     .range = WITHIN(-360, 360), .fallback = "120 deg", .group = GROUP_SUN, .alternative = 1,
     .meaning = "clockwise from north"},
    {.path = "sun.time", .type = NP_KEY_TIME, .field = SCENE(sun.time), .group = GROUP_SUN, .alternative = 2,
     .meaning = "puts the sun where it stands at the scene's place; UTC unless an offset or a time zone is given"},
    {.path = "sun.frame_time", .type = NP_KEY_REAL, .unit = NP_UNIT_SECOND, .field = SCENE(sun.frame_time_s),
     .range = WITHIN(-1e6, 1e6),
     .meaning = "time of sun, moon and stars from one frame to the next, with sun.time, which is that of frame 1"},
    {.path = "sun.angular_radius", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE,
     .field = SCENE(sun.angular_radius_rad), .tag = SCENE(sun.has_angular_radius), .tag_value = true,
     .range = WITHIN(0, 45), .fallback = "0.2678 deg",
     .meaning = "angular radius of the disk; by default as seen from the planet"},
    {.path = "sun.irradiance", .type = NP_KEY_REAL, .unit = NP_UNIT_IRRADIANCE,
     .field = SCENE(sun.irradiance_w_m2_nm), .tag = SCENE(sun.has_irradiance), .tag_value = true,
     .is_grey_allowed = true, .range = WITHIN(0, 1e9),
     .fallback = "1.474, 1.8504, 1.91198",
     .meaning = "above the atmosphere, on a plane facing the sun, at 680, 550 and 440 nm"},

    {.path = "sun.limb_darkening", .type = NP_KEY_CHOICE, .choices = np_booleans,
     .field = SCENE(sun.has_limb_darkening),
     .fallback = "true", .meaning = "true: the disk darkens towards its edge, as the sun's does"},

    {.path = "moon", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(moon.is_enabled),
     .tag = SCENE(moon.is_enabled), .tag_value = true,
     .meaning = "the moon, at the sun's time, or by elevation and azimuth; its phase follows from the sun's "
                "position"},
    {.path = "moon.elevation", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(moon.elevation_rad),
     .tag = SCENE(moon.has_angles), .tag_value = true, .range = WITHIN(-90, 90),
     .meaning = "above the horizontal at the world's origin, without refraction; goes with azimuth"},
    {.path = "moon.azimuth", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(moon.azimuth_rad),
     .tag = SCENE(moon.has_azimuth), .tag_value = true, .range = WITHIN(-360, 360),
     .meaning = "clockwise from north; goes with elevation"},
    {.path = "moon.brightness", .type = NP_KEY_REAL, .field = SCENE(moon.brightness), .range = WITHIN(0, 1e6),
     .fallback = "1", .meaning = "factor on its light, 1 being the moon's own"},
    {.path = "moon.earthshine", .type = NP_KEY_CHOICE, .choices = np_booleans, .field = SCENE(moon.has_earthshine),
     .fallback = "true", .meaning = "true: the Earth lights its dark side"},
    {.path = "moon.map", .type = NP_KEY_FILE, .is_input = true, .field = SCENE(moon.map),
     .meaning = "OpenEXR picture of its albedo by longitude and latitude, longitude 0 in the middle, east to the "
                "right; changes the pattern, not the brightness"},

    {.path = "stars", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(stars.is_enabled),
     .tag = SCENE(stars.is_enabled), .tag_value = true,
     .meaning = "turned by the sun's time and place, or by sidereal_time"},
    {.path = "stars.catalogue", .type = NP_KEY_FILE, .is_input = true, .field = SCENE(stars.catalogue),
     .meaning = "CSV with columns ra_deg, dec_deg, v_mag and b_v; without it, the brightest stars"},
    {.path = "stars.faintest", .type = NP_KEY_REAL, .field = SCENE(stars.faintest), .range = WITHIN(-2, 40),
     .fallback = "40", .meaning = "V magnitude beyond which stars are left out"},
    {.path = "stars.map", .type = NP_KEY_FILE, .is_input = true, .field = SCENE(stars.map),
     .meaning = "OpenEXR picture of the whole sky in equatorial coordinates, right ascension 0 in the middle and "
                "growing to the left, beside the catalogue's stars"},
    {.path = "stars.map_radiance", .type = NP_KEY_REAL, .unit = NP_UNIT_RADIANCE, .field = SCENE(stars.map_radiance),
     .range = WITHIN(0, 1e9), .fallback = "1", .meaning = "radiance of a value of 1 in that picture"},
    {.path = "stars.sidereal_time", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE, .field = SCENE(stars.sidereal_rad),
     .tag = SCENE(stars.has_sidereal), .tag_value = true, .range = WITHIN(-360, 360),
     .meaning = "the right ascension on the meridian; needs the place's latitude"},
    {.path = "stars.twinkling", .type = NP_KEY_REAL, .field = SCENE(stars.twinkling), .range = WITHIN(0, 1),
     .fallback = "0", .meaning = "relative spread of a star's light at the zenith from frame to frame; more below"},

    {.path = "airglow", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(airglow.is_enabled),
     .tag = SCENE(airglow.is_enabled), .tag_value = true,
     .meaning = "the floor of the night sky: all that it holds beside single stars"},
    {.path = "airglow.magnitude", .type = NP_KEY_REAL, .field = SCENE(airglow.magnitude), .range = WITHIN(0, 40),
     .fallback = "22",
     .meaning = "magnitude in V of a square arc second at the zenith; the colour is that of La Palma's sky"},
    {.path = "airglow.altitude", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(airglow.altitude_m),
     .range = WITHIN(1000, 1e7), .fallback = "90 km", .meaning = "altitude of the layer that shines"},

    {.path = "atmosphere", .type = NP_KEY_SECTION, .choices = atmospheres, .field = SCENE(air.preset),
     .is_air_preset = true, .meaning = "the air"},
    {.path = "atmosphere.preset", .type = NP_KEY_CHOICE, .choices = atmospheres, .field = SCENE(air.preset),
     .is_air_preset = true, .fallback = "earth",
     .meaning = "planet and air to start from; empty has no air but what layers bring, none is a world without"},
    {.path = "atmosphere.planet_radius", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(atmosphere.planet_radius_m), .range = WITHIN(1000, 1e9), .fallback = "6360 km",
     .meaning = "radius of the sphere, on which clouds and terrain lie"},
    {.path = "atmosphere.top_altitude", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(atmosphere.top_altitude_m), .range = WITHIN(1, 1e7), .fallback = "100 km",
     .meaning = "altitude at which the air ends"},
    {.path = "atmosphere.rayleigh_scattering", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = SCENE(air.molecules.scattering_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1),
     .fallback = "5.802e-6 1/m, 13.558e-6 1/m, 33.1e-6 1/m", .meaning = "scattering of air at sea level"},
    {.path = "atmosphere.rayleigh_height", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(air.molecules.height_m), .range = WITHIN(1, 1e7), .fallback = "8 km",
     .meaning = "height over which air thins by a factor e"},
    {.path = "atmosphere.mie_scattering", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = SCENE(air.aerosol.scattering_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1),
     .fallback = "3.996e-6 1/m", .meaning = "scattering of haze at sea level"},
    {.path = "atmosphere.mie_extinction", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = SCENE(air.aerosol_extinction_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1),
     .fallback = "4.44e-6 1/m",
     .meaning = "scattering and absorption of haze at sea level; not below its scattering"},
    {.path = "atmosphere.mie_height", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(air.aerosol.height_m), .range = WITHIN(1, 1e7), .fallback = "1.2 km",
     .meaning = "height over which haze thins by a factor e"},
    {.path = "atmosphere.mie_asymmetry", .type = NP_KEY_REAL, .field = SCENE(air.aerosol.asymmetry),
     .is_grey_allowed = true, .range = WITHIN(-0.9999, 0.9999), .fallback = "0.8",
     .meaning = "g of haze, of the Cornette-Shanks phase function"},
    {.path = "atmosphere.ozone_absorption", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = SCENE(air.ozone.absorption_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1),
     .fallback = "0.65e-6 1/m, 1.881e-6 1/m, 0.085e-6 1/m", .meaning = "absorption at the centre of the ozone layer"},
    {.path = "atmosphere.ozone_center", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(air.ozone.center_m), .range = WITHIN(0, 1e7), .fallback = "25 km",
     .meaning = "altitude of the densest ozone"},
    {.path = "atmosphere.ozone_width", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(air.ozone.width_m), .range = WITHIN(1, 1e7), .fallback = "15 km",
     .meaning = "distance from there to the ends of the layer, above and below"},
    {.path = "atmosphere.ground_albedo", .type = NP_KEY_REAL, .field = SCENE(atmosphere.ground_albedo),
     .tag = SCENE(has_ground_albedo), .tag_value = true, .is_grey_allowed = true, .range = WITHIN(0, 1),
     .fallback = "0.3", .meaning = "albedo of the sphere; unless it is given, a terrain's takes its place"},
    {.path = "atmosphere.tolerance", .type = NP_KEY_REAL, .field = SCENE(atmosphere.tolerance),
     .range = WITHIN(0.003, 0.1), .fallback = "0.007",
     .meaning = "relative rms error that the sky's tables may make, by which they are sized and kept over a sequence"},
    {.path = "atmosphere.layers", .type = NP_KEY_LIST, .field = SCENE(air.layers),
     .meaning = "further layers of the air"},
    {.path = "atmosphere.layers[].exponential", .type = NP_KEY_SECTION, .tag = LAYER(desc.profile),
     .tag_value = NEPH_LAYER_EXPONENTIAL, .group = GROUP_PROFILE, .alternative = 1,
     .meaning = "a density that falls from 1 at the bottom; the default"},
    {.path = "atmosphere.layers[].exponential.height", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = LAYER(desc.height_m), .range = WITHIN(1, 1e7), .fallback = "1.2 km",
     .meaning = "height over which it thins by a factor e"},
    {.path = "atmosphere.layers[].tent", .type = NP_KEY_SECTION, .tag = LAYER(desc.profile),
     .tag_value = NEPH_LAYER_TENT, .group = GROUP_PROFILE, .alternative = 2,
     .meaning = "a density that is 1 in the middle and falls evenly to either side"},
    {.path = "atmosphere.layers[].tent.center", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = LAYER(desc.center_m), .range = WITHIN(-1e7, 1e7), .fallback = "25 km",
     .meaning = "altitude of the greatest density"},
    {.path = "atmosphere.layers[].tent.width", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = LAYER(desc.width_m), .range = WITHIN(1, 1e7), .fallback = "15 km",
     .meaning = "distance from there to the ends of the layer, above and below"},
    {.path = "atmosphere.layers[].table", .type = NP_KEY_ROWS, .unit = NP_UNIT_METRE, .field = LAYER(rows),
     .range = WITHIN(0, 1e9), .tag = LAYER(desc.profile), .tag_value = NEPH_LAYER_TABLE, .group = GROUP_PROFILE,
     .alternative = 3, .meaning = "altitudes and densities, linear between them and none beyond"},
    {.path = "atmosphere.layers[].bottom", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = LAYER(desc.bottom_m),
     .range = WITHIN(-1e7, 1e7), .fallback = "0 m", .meaning = "altitude below which there is none of it"},
    {.path = "atmosphere.layers[].top", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = LAYER(desc.top_m),
     .range = WITHIN(-1e7, 1e9), .fallback = "1000000 km", .meaning = "altitude above which there is none of it"},
    {.path = "atmosphere.layers[].scattering", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = LAYER(desc.scattering_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1), .fallback = "0 1/m",
     .meaning = "scattering at a density of 1"},
    {.path = "atmosphere.layers[].absorption", .type = NP_KEY_REAL, .unit = NP_UNIT_PER_METRE,
     .field = LAYER(desc.absorption_per_m), .is_grey_allowed = true, .range = WITHIN(0, 1), .fallback = "0 1/m",
     .meaning = "absorption at a density of 1"},
    {.path = "atmosphere.layers[].absorber", .type = NP_KEY_CHOICE, .choices = absorbers, .field = LAYER(desc.absorber),
     .fallback = "smooth", .meaning = "absorption at other wavelengths: as a power of them, or as ozone's"},
    {.path = "atmosphere.layers[].phase", .type = NP_KEY_SECTION, .choices = layer_phases, .field = LAYER(desc.phase),
     .meaning = "phase function: one of the keys below, or rayleigh in their place"},
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
     .is_grey_allowed = true, .range = WITHIN(0, 1), .fallback = "0.1", .meaning = "share of the second"},

    {.path = "environment", .type = NP_KEY_SECTION,
     .meaning = "uniform light from infinitely far away, for tests and studios"},
    {.path = "environment.radiance", .type = NP_KEY_REAL, .unit = NP_UNIT_RADIANCE,
     .field = SCENE(environment.radiance_w_m2_sr_nm), .is_grey_allowed = true, .range = WITHIN(0, 1e9),
     .fallback = "0", .meaning = "radiance of that light"},
    {.path = "environment.hemisphere", .type = NP_KEY_CHOICE, .choices = hemispheres,
     .field = SCENE(environment.is_upper_only), .fallback = "both", .meaning = "directions that it comes from"},
    {.path = "environment.planet", .type = NP_KEY_CHOICE, .choices = planets, .field = SCENE(environment.has_planet),
     .fallback = "sphere", .meaning = "none leaves out the planet, and the air with it"},
};

static const np_key last_keys[] = {
    {.path = "terrain", .type = NP_KEY_SECTION, .choices = terrains, .field = SCENE(terrain.kind),
     .meaning = "ground above the sphere, or none in place of the keys below"},
    {.path = "terrain.heightfield", .type = NP_KEY_FILE, .is_input = true, .field = SCENE(terrain.heightfield),
     .tag = SCENE(terrain.kind), .tag_value = NP_TERRAIN_HEIGHTFIELD, .group = GROUP_TERRAIN, .alternative = 1,
     .meaning = "heights: SRTM .hgt named by its corner, GeoTIFF and other rasters, 16-bit grey PNG, EXR of one "
                "channel in metres, .r16 or .raw; * and ? stand for all files that fit, {a,b} for "
                "each of a list, side by side"},
    {.path = "terrain.crs", .type = NP_KEY_TEXT, .field = SCENE(terrain.crs),
     .meaning = "coordinate system in place of the file's, as EPSG:32611"},
    {.path = "terrain.vertical_unit", .type = NP_KEY_CHOICE, .choices = height_units, .field = SCENE(terrain.desc.unit),
     .fallback = "file", .meaning = "unit of the heights in a raster: file is what it says, metres if nothing"},
    {.path = "terrain.encoding", .type = NP_KEY_CHOICE, .choices = height_encodings,
     .field = SCENE(terrain.desc.encoding), .fallback = "values",
     .meaning = "terrain_rgb, terrarium: heights are told by 8-bit colours"},
    {.path = "terrain.raw", .type = NP_KEY_SECTION, .meaning = "samples of .r16 and .raw, the northern row first"},
    {.path = "terrain.raw.size", .type = NP_KEY_INTEGER, .field = SCENE(terrain.desc.raw_size),
     .range = WITHIN(2, 16385), .meaning = "columns and rows"},
    {.path = "terrain.raw.type", .type = NP_KEY_CHOICE, .choices = raw_types, .field = SCENE(terrain.desc.raw_type),
     .fallback = "uint16", .meaning = "uint16 goes from height_min to height_max; int16 and float32 are metres"},
    {.path = "terrain.raw.byte_order", .type = NP_KEY_CHOICE, .choices = byte_orders,
     .field = SCENE(terrain.desc.raw_is_big_endian), .fallback = "little", .meaning = "which byte comes first"},
    {.path = "terrain.edge", .type = NP_KEY_CHOICE, .choices = terrain_edges, .field = SCENE(terrain.desc.edge),
     .fallback = "infinite",
     .meaning = "beyond the border land goes on at its height, to descend behind the horizon; fade: over the outer 5 % "
                "of the width to the sphere; wall: straight down. A border at sea level fades, but for a wall"},
    {.path = "terrain.ridges", .type = NP_KEY_SECTION, .tag = SCENE(terrain.kind), .tag_value = NP_TERRAIN_RIDGES,
     .group = GROUP_TERRAIN, .alternative = 2, .meaning = "mountains from noise"},
    {.path = "terrain.ridges.seed", .type = NP_KEY_SEED, .field = SCENE(terrain.ridges.seed), .fallback = "1",
     .meaning = "seed of the noise"},
    {.path = "terrain.ridges.samples", .type = NP_KEY_INTEGER, .field = SCENE(terrain.ridges.sample_count),
     .range = WITHIN(2, 16385), .fallback = "1025", .meaning = "heights along each side"},
    {.path = "terrain.ridges.relief", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(terrain.ridges.relief_m), .range = WITHIN(0, 1e5), .fallback = "1.4 km",
     .meaning = "height from valleys to summits"},
    {.path = "terrain.ridges.ridge", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(terrain.ridges.ridge_m), .range = WITHIN(1, 1e7), .fallback = "9 km",
     .meaning = "distance from one large ridge to the next"},
    {.path = "terrain.mesh", .type = NP_KEY_SECTION,
     .meaning = "triangles beside the height field or the ridges, or alone"},
    {.path = "terrain.mesh.file", .type = NP_KEY_FILE, .is_input = true, .field = SCENE(terrain.mesh_file),
     .meaning = "glTF, OBJ, PLY, STL, FBX or COLLADA, by Assimp"},
    {.path = "terrain.mesh.up", .type = NP_KEY_CHOICE, .choices = np_mesh_ups, .field = SCENE(terrain.mesh.up),
     .fallback = "file",
     .meaning = "axis of the file that points up; file: y in glTF, others do not say it and ask for this key. With y, "
                "the file's -z is north"},
    {.path = "terrain.mesh.unit", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(terrain.mesh.unit_m),
     .range = WITHIN(1e-9, 1e9), .fallback = "1 m", .meaning = "length of the file's unit"},
    {.path = "terrain.mesh.rotation", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE,
     .field = SCENE(terrain.mesh.rotation_rad), .range = WITHIN(-360, 360), .fallback = "0 deg",
     .meaning = "about the vertical, counter-clockwise seen from above"},
    {.path = "terrain.mesh.position", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(terrain.mesh.position_m), .tag = SCENE(terrain.mesh.has_position), .tag_value = true,
     .range = WITHIN(-1e9, 1e9), .meaning = "place of the pivot; without it, coordinates are the world's"},
    {.path = "terrain.mesh.pivot", .type = NP_KEY_CHOICE, .choices = mesh_pivots, .field = SCENE(terrain.mesh.pivot),
     .fallback = "base",
     .meaning = "point that stands at the position: base, the middle of the bottom of the box; center, that of the "
                "box; origin, where the file has 0, 0, 0"},
    {.path = "terrain.mesh.normals", .type = NP_KEY_CHOICE, .choices = mesh_normals,
     .field = SCENE(terrain.mesh.normals), .fallback = "smooth",
     .meaning = "smooth: the file's, or means of the triangles about a vertex; flat: each triangle's own"},
    {.path = "terrain.albedo", .type = NP_KEY_REAL, .field = SCENE(terrain.desc.ground_albedo),
     .is_grey_allowed = true, .range = WITHIN(0, 1), .fallback = "0.2", .group = GROUP_ALBEDO, .alternative = 1,
     .meaning = "share of the light that the ground reflects, at 680, 550 and 440 nm"},
    {.path = "terrain.albedo_image", .type = NP_KEY_FILE, .is_input = true, .field = SCENE(terrain.albedo_image),
     .group = GROUP_ALBEDO, .alternative = 2,
     .meaning = "picture of the albedo over the whole field, north up; PNG is taken as sRGB, EXR as linear"},
    {.path = "terrain.rock", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(terrain.desc.has_rock),
     .tag = SCENE(terrain.desc.has_rock), .tag_value = true, .meaning = "bare rock on steep slopes"},
    {.path = "terrain.rock.albedo", .type = NP_KEY_REAL, .field = SCENE(terrain.desc.rock_albedo),
     .is_grey_allowed = true, .range = WITHIN(0, 1), .fallback = "0.13, 0.12, 0.11", .meaning = "of the rock"},
    {.path = "terrain.rock.slope", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE,
     .field = SCENE(terrain.desc.rock_slope_rad), .range = WITHIN(0, 90), .fallback = "35 deg",
     .meaning = "slope above which it lies bare"},
    {.path = "terrain.snow", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(terrain.desc.has_snow),
     .tag = SCENE(terrain.desc.has_snow), .tag_value = true, .meaning = "snow on high ground"},
    {.path = "terrain.snow.albedo", .type = NP_KEY_REAL, .field = SCENE(terrain.desc.snow_albedo),
     .is_grey_allowed = true, .range = WITHIN(0, 1), .fallback = "0.86, 0.88, 0.9", .meaning = "of the snow"},
    {.path = "terrain.snow.level", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(terrain.desc.snow_level_m), .range = WITHIN(-1e5, 1e5), .fallback = "1.5 km",
     .meaning = "elevation above which it lies"},
    {.path = "terrain.snow.slope", .type = NP_KEY_REAL, .unit = NP_UNIT_DEGREE,
     .field = SCENE(terrain.desc.snow_slope_rad), .range = WITHIN(0, 90), .fallback = "50 deg",
     .meaning = "slope above which none stays"},
    {.path = "terrain.holdout", .type = NP_KEY_CHOICE, .choices = np_booleans, .field = SCENE(terrain.is_held_out),
     .fallback = "false", .meaning = "true: the ground hides what is behind it, and does not show itself"},
    {.path = "terrain.width", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(terrain.desc.width_m),
     .tag = SCENE(terrain.desc.has_width), .tag_value = true, .range = WITHIN(1, 1e7), .fallback = "30 km",
     .meaning = "width along x, of what does not say it itself: pictures, raw samples, ridges"},
    {.path = "terrain.height_min", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(terrain.desc.height_min_m), .range = WITHIN(-1e5, 1e5), .fallback = "0 m",
     .meaning = "elevation of black in a PNG or uint16"},
    {.path = "terrain.height_max", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(terrain.desc.height_max_m), .range = WITHIN(-1e5, 1e5), .fallback = "2 km",
     .meaning = "elevation of white in a PNG or uint16"},

    {.path = "water", .type = NP_KEY_SECTION, .choices = absences, .field = SCENE(water.is_enabled),
     .tag = SCENE(water.is_enabled), .tag_value = true,
     .meaning = "open water over all ground below its level; from sea level up it covers the planet beyond the "
                "terrain"},
    {.path = "water.level", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE, .field = SCENE(water.level_m),
     .range = WITHIN(-1e4, 1e4), .fallback = "0 m", .meaning = "its elevation"},
    {.path = "water.wind", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE_PER_SECOND, .field = SCENE(water.wind_m_s),
     .range = WITHIN(0, 40), .fallback = "5 m/s", .meaning = "wind that roughens it"},
    {.path = "water.albedo", .type = NP_KEY_REAL, .field = SCENE(water.albedo), .is_grey_allowed = true,
     .range = WITHIN(0, 1), .fallback = "0.002, 0.008, 0.02",
     .meaning = "of the light that enters it, the share that comes back out"},

    {.path = "render", .type = NP_KEY_SECTION, .meaning = "rendering of the picture"},
    {.path = "render.integrator", .type = NP_KEY_CHOICE, .choices = integrators, .field = SCENE(render.integrator),
     .fallback = "march", .meaning = "march is fast and biased, path is unbiased and noisy"},
    {.path = "render.wavelengths", .type = NP_KEY_INTEGER, .field = SCENE(render.wavelength_count),
     .range = WITHIN(3, NP_WAVELENGTHS_MAX), .fallback = "3",
     .meaning = "a multiple of 3; three are bands from which colours follow by a matrix that is fitted to the scene's "
                "light, more are added up as the eye does"},
    {.path = "render.samples", .type = NP_KEY_INTEGER, .field = SCENE(render.sample_count),
     .range = WITHIN(1, NP_FILM_SAMPLES_MAX),
     .fallback = "4", .meaning = "samples for each pixel"},
    {.path = "render.target_error", .type = NP_KEY_REAL, .field = SCENE(render.target_error),
     .range = WITHIN(1e-6, 10), .fallback = "none", .word = "none", .word_value = INFINITY,
     .meaning = "error a pixel that the picture is to have: noise takes what the march's expected bias leaves of "
                "it, by numbers of samples that differ from pixel to pixel, render.samples at least"},
    {.path = "render.max_samples", .type = NP_KEY_INTEGER, .field = SCENE(render.sample_count_max),
     .range = WITHIN(16, NP_FILM_SAMPLES_MAX), .fallback = "65536",
     .meaning = "most samples for a pixel, whatever the target error"},
    {.path = "render.time_limit", .type = NP_KEY_REAL, .unit = NP_UNIT_SECOND, .field = SCENE(render.time_limit_s),
     .range = WITHIN(0, 1e9), .fallback = "none", .word = "none", .word_value = INFINITY,
     .meaning = "time for a frame; it ends with the samples it has, and without a picture if a pixel has none"},
    {.path = "render.seed", .type = NP_KEY_SEED, .field = SCENE(render.seed), .fallback = "0",
     .meaning = "seed of all random numbers"},
    {.path = "render.multiple_scattering", .type = NP_KEY_CHOICE, .choices = scatterings,
     .field = SCENE(render.multiple_scattering), .fallback = "ordinates",
     .meaning = "method of the march for multiple scattering"},
    {.path = "render.atmosphere", .type = NP_KEY_CHOICE, .choices = airs_of_paths, .field = SCENE(render.atmosphere),
     .fallback = "traced",
     .meaning = "air of the integrator path: air and ground traced with the clouds, or, faster, from tables as in "
                "the march"},
    {.path = "render.path_guiding", .type = NP_KEY_CHOICE, .choices = path_guidings,
     .field = SCENE(render.path_guiding), .fallback = "none",
     .meaning = "guiding of the integrator path: adjoint guides, splits and ends paths in clouds by the march's "
                "solution of the multiple scattering; it pays at depths of tens and more, and in absorbing clouds"},
    {.path = "render.light_memory", .type = NP_KEY_REAL, .unit = NP_UNIT_GIGABYTE,
     .field = SCENE(render.light_memory_bytes), .range = WITHIN(0.001, 1e6), .fallback = "auto", .word = "auto",
     .word_value = INFINITY,
     .meaning = "memory for ordinates while they are solved for; auto is a quarter of the machine's. Too little "
                "makes cells larger, those far from the camera first"},
    {.path = "render.approximation_gain", .type = NP_KEY_REAL, .field = SCENE(render.approximation.gain),
     .range = WITHIN(0, 1e6), .fallback = "auto", .word = "auto", .word_value = INFINITY,
     .meaning = "factor on the light of octaves, softened_beer, powder and derivative; auto gives each cloud the mean "
                "brightness that was calibrated for its optical depth, albedo and asymmetry"},
    {.path = "render.octaves", .type = NP_KEY_SECTION, .meaning = "octaves of multiple scattering"},
    {.path = "render.octaves.count", .type = NP_KEY_INTEGER, .field = SCENE(render.approximation.octave_count),
     .range = WITHIN(1, 16),
     .fallback = "8", .meaning = "number of octaves; the first is single scattering"},
    {.path = "render.octaves.factors", .type = NP_KEY_REAL, .field = SCENE(render.approximation.octave_factors),
     .range = WITHIN(0, 1), .fallback = "0.5, 0.5, 0.5",
     .meaning = "factors from octave to octave, on light, optical depth and asymmetry"},
    {.path = "render.softened_beer", .type = NP_KEY_SECTION,
     .meaning = "sunlight through max(exp(-t), share * exp(-rate * t)) instead of exp(-t); powder takes it too"},
    {.path = "render.softened_beer.share", .type = NP_KEY_REAL, .field = SCENE(render.approximation.softened_share),
     .range = WITHIN(0, 1), .fallback = "0.7", .meaning = "share of the light that fades slowly"},
    {.path = "render.softened_beer.rate", .type = NP_KEY_REAL, .field = SCENE(render.approximation.softened_rate),
     .range = WITHIN(0.01, 1), .fallback = "0.25", .meaning = "rate at which it fades, over that of Beer's law"},
    {.path = "render.powder", .type = NP_KEY_SECTION,
     .meaning = "darkening of thin places and of the cloud's base, where little light comes together"},
    {.path = "render.powder.strength", .type = NP_KEY_REAL, .field = SCENE(render.approximation.powder_strength),
     .range = WITHIN(0, 1), .fallback = "1", .meaning = "strength of the darkening; 0 is softened_beer"},
    {.path = "render.derivative", .type = NP_KEY_SECTION, .meaning = "a slope of density that faces the sun is lit"},
    {.path = "render.derivative.distance", .type = NP_KEY_REAL, .unit = NP_UNIT_METRE,
     .field = SCENE(render.approximation.derivative_distance_m), .range = WITHIN(0.001, 1e6), .fallback = "30 m",
     .meaning = "distance to the look-up towards the sun"},
    {.path = "render.max_scatterings", .type = NP_KEY_INTEGER, .field = SCENE(render.scattering_max),
     .range = WITHIN(0, 1e9), .fallback = "all", .word = "all", .word_value = NEPH_SCATTERINGS_ALL,
     .meaning = "most scatterings in cloud along one path; a limit loses light"},
    {.path = "render.tolerance", .type = NP_KEY_REAL, .field = SCENE(render.tolerance), .range = WITHIN(1e-5, 1),
     .fallback = "0.02", .meaning = "error of the march's steps, as a share of a ray's light; their number follows"},
    {.path = "render.step", .type = NP_KEY_REAL, .unit = NP_UNIT_VOXEL, .field = SCENE(render.step_voxels),
     .range = WITHIN(0.01, 100), .fallback = "4 voxels",
     .meaning = "longest step of the march, however little there is to see"},
    {.path = "render.transmittance_end", .type = NP_KEY_REAL, .field = SCENE(render.transmittance_end),
     .range = WITHIN(0, 0.5), .fallback = "0.001", .meaning = "transmittance below which the march ends a ray"},
    {.path = "render.sun_optical_depth", .type = NP_KEY_CHOICE, .choices = sun_optical_depths,
     .field = SCENE(render.sun_optical_depth), .fallback = "auto",
     .meaning = "source of the march's optical depth from cloud to sun: volume, filled once and looked up, or march, "
                "at every step; auto takes the cheaper one"},
    {.path = "render.air_shadows", .type = NP_KEY_CHOICE, .choices = air_shadows, .field = SCENE(render.air_shadows),
     .fallback = "auto",
     .meaning = "shadows of clouds and hills in the air before the camera; auto: where they might be seen; traced "
                "air always has them"},
};
/* clang-format on */

static const np_key_rename renames[] = {
    {"render.splitting", "render.path_guiding"},
    {"render.look_gain", "render.approximation_gain"},
    {"render.sun_depth", "render.sun_optical_depth"},
};

size_t np_key_rename_count(void) { return sizeof renames / sizeof *renames; }

const np_key_rename *np_key_rename_at(size_t index) { return &renames[index]; }

static const np_key_table first = {first_keys, sizeof first_keys / sizeof *first_keys},
                          sky = {sky_keys, sizeof sky_keys / sizeof *sky_keys},
                          last = {last_keys, sizeof last_keys / sizeof *last_keys};

/* The order of the schema. */
static const np_key_table *const tables[] = {&first,           &np_keys_camera, &sky,
                                             &np_keys_clouds,  &np_keys_shape,  &last,
                                             &np_keys_quality, &np_keys_output, &np_keys_frames};

size_t np_key_count(void) {
  size_t count = 0;
  for (size_t t = 0; t < sizeof tables / sizeof *tables; t++) count += tables[t]->count;
  return count;
}

const np_key *np_key_get(size_t index) {
  const np_key_table *const *table = tables;
  for (; index >= (*table)->count; table++) index -= (*table)->count;
  return &(*table)->keys[index];
}
