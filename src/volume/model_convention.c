/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/model_convention.h"

#include <string.h>

/* clang-format off */
const np_model_role_row np_model_role_rows[NP_MODEL_ROLES] = {
    [NP_MODEL_LIQUID] = {
        "liquid water", {{"kg kg-1", "mixing ratio (kg kg-1, g/kg)"}, {"kg m-3", "content (kg m-3, g m-3)"}},
        "mass_fraction_of_cloud_liquid_water_in_air cloud_liquid_water_mixing_ratio "
        "mass_concentration_of_cloud_liquid_water_in_air liquid_water_content mass_fraction_of_liquid_water_in_air"},
    [NP_MODEL_ICE] = {
        "ice", {{"kg kg-1", "mixing ratio (kg kg-1, g/kg)"}, {"kg m-3", "content (kg m-3, g m-3)"}},
        "mass_fraction_of_cloud_ice_in_air cloud_ice_mixing_ratio mass_concentration_of_cloud_ice_in_air"},
    [NP_MODEL_VAPOUR] = {
        "water vapour", {{"kg kg-1", "mixing ratio (kg kg-1, g/kg)"}}, "specific_humidity humidity_mixing_ratio"},
    [NP_MODEL_DENSITY] = {"density of air", {{"kg m-3", "density (kg m-3)"}}, "air_density"},
    [NP_MODEL_PRESSURE] = {"pressure", {{"Pa", "pressure (Pa, hPa, mb)"}}, "air_pressure"},
    [NP_MODEL_TEMPERATURE] = {"temperature", {{"K", "temperature (K)"}}, "air_temperature"},
    [NP_MODEL_POTENTIAL_TEMPERATURE] = {
        "potential temperature", {{"K", "temperature (K)"}}, "air_potential_temperature"},
    [NP_MODEL_NUMBER] = {
        "number of droplets", {{"m-3", "number (m-3, cm-3)"}, {"kg-1", "number in a mass of air (kg-1)"}},
        "number_concentration_of_cloud_liquid_water_particles_in_air"},
    [NP_MODEL_LIQUID_RADIUS] = {
        "effective radius of droplets", {{"m", "length (m, um)"}},
        "effective_radius_of_cloud_liquid_water_particles effective_radius_of_cloud_liquid_water_particle"},
    [NP_MODEL_ICE_RADIUS] = {
        "effective radius of ice", {{"m", "length (m, um)"}},
        "effective_radius_of_cloud_ice_particles effective_radius_of_cloud_ice_particle"},
    [NP_MODEL_HEIGHT] = {
        "height", {{"m", "length (m, km)"}, {"m2 s-2", "geopotential (m2 s-2)"}},
        "altitude height geopotential_height geopotential"},
    [NP_MODEL_FACE] = {
        "height of faces", {{"m", "length (m, km)"}, {"m2 s-2", "geopotential (m2 s-2)"}}, ""},
};

const np_model_convention np_model_conventions[] = {
    {.model = "WRF",
     .names = {[NP_MODEL_LIQUID] = "QCLOUD", [NP_MODEL_ICE] = "QICE", [NP_MODEL_VAPOUR] = "QVAPOR",
               [NP_MODEL_PRESSURE] = "P+PB", [NP_MODEL_POTENTIAL_TEMPERATURE] = "T", [NP_MODEL_NUMBER] = "QNCLOUD",
               [NP_MODEL_LIQUID_RADIUS] = "RE_CLOUD", [NP_MODEL_ICE_RADIUS] = "RE_ICE", [NP_MODEL_FACE] = "PH+PHB"},
     .units = {[NP_MODEL_LIQUID] = "kg kg-1", [NP_MODEL_ICE] = "kg kg-1", [NP_MODEL_VAPOUR] = "kg kg-1",
               [NP_MODEL_PRESSURE] = "Pa", [NP_MODEL_POTENTIAL_TEMPERATURE] = "K", [NP_MODEL_NUMBER] = "kg-1",
               [NP_MODEL_LIQUID_RADIUS] = "m", [NP_MODEL_ICE_RADIUS] = "m", [NP_MODEL_FACE] = "m2 s-2"},
     .axes = {"bottom_top", "south_north", "west_east", "Time"}, .spacings = {"DY", "DX"}, .length_unit = "m",
     .potential_temperature_offset_k = 300.0, .gravity_m_s2 = 9.81, .is_dry = true},
    {.model = "Meso-NH",
     .names = {[NP_MODEL_LIQUID] = "RCT", [NP_MODEL_ICE] = "RIT", [NP_MODEL_VAPOUR] = "RVT",
               [NP_MODEL_PRESSURE] = "PABST", [NP_MODEL_POTENTIAL_TEMPERATURE] = "THT", [NP_MODEL_HEIGHT] = "VLEV"},
     .units = {[NP_MODEL_LIQUID] = "kg kg-1", [NP_MODEL_ICE] = "kg kg-1", [NP_MODEL_VAPOUR] = "kg kg-1",
               [NP_MODEL_PRESSURE] = "Pa", [NP_MODEL_POTENTIAL_TEMPERATURE] = "K", [NP_MODEL_HEIGHT] = "m"},
     .axes = {"vertical_levels VLEV level", "S_N_direction nj", "W_E_direction ni", "time"}, .length_unit = "m",
     .is_dry = true},
    {.model = "PALM",
     .names = {[NP_MODEL_LIQUID] = "ql qc", [NP_MODEL_ICE] = "qi", [NP_MODEL_DENSITY] = "rho_air",
               [NP_MODEL_PRESSURE] = "hyp", [NP_MODEL_TEMPERATURE] = "ta",
               [NP_MODEL_POTENTIAL_TEMPERATURE] = "theta pt", [NP_MODEL_NUMBER] = "nc"},
     .units = {[NP_MODEL_LIQUID] = "kg kg-1", [NP_MODEL_ICE] = "kg kg-1", [NP_MODEL_DENSITY] = "kg m-3",
               [NP_MODEL_PRESSURE] = "Pa"},
     .axes = {"zu_3d", "y", "x", "time"}, .length_unit = "m"},
    {.model = "DALES",
     .names = {[NP_MODEL_LIQUID] = "ql", [NP_MODEL_ICE] = "qi", [NP_MODEL_DENSITY] = "rhobf rhof",
               [NP_MODEL_PRESSURE] = "presf", [NP_MODEL_FACE] = "zm"},
     .units = {[NP_MODEL_LIQUID] = "kg kg-1", [NP_MODEL_ICE] = "kg kg-1", [NP_MODEL_DENSITY] = "kg m-3",
               [NP_MODEL_PRESSURE] = "Pa", [NP_MODEL_FACE] = "m"},
     .axes = {"zt", "yt", "xt", "time"}, .length_unit = "m"},
    {.model = "CM1",
     .names = {[NP_MODEL_LIQUID] = "qc", [NP_MODEL_ICE] = "qi", [NP_MODEL_VAPOUR] = "qv",
               [NP_MODEL_PRESSURE] = "prs", [NP_MODEL_POTENTIAL_TEMPERATURE] = "th", [NP_MODEL_HEIGHT] = "zhval zh"},
     .units = {[NP_MODEL_LIQUID] = "kg kg-1", [NP_MODEL_ICE] = "kg kg-1", [NP_MODEL_VAPOUR] = "kg kg-1",
               [NP_MODEL_PRESSURE] = "Pa", [NP_MODEL_POTENTIAL_TEMPERATURE] = "K", [NP_MODEL_HEIGHT] = "m"},
     .axes = {"zh z zhval nk", "yh", "xh", "time"}, .length_unit = "km", .is_dry = true},
    {.model = "SAM",
     .names = {[NP_MODEL_LIQUID] = "QC QCL QN", [NP_MODEL_ICE] = "QI QCI", [NP_MODEL_VAPOUR] = "QV",
               [NP_MODEL_PRESSURE] = "p", [NP_MODEL_TEMPERATURE] = "TABS"},
     .units = {[NP_MODEL_LIQUID] = "g kg-1", [NP_MODEL_ICE] = "g kg-1", [NP_MODEL_VAPOUR] = "g kg-1",
               [NP_MODEL_PRESSURE] = "mb", [NP_MODEL_TEMPERATURE] = "K"},
     .axes = {"z", "y", "x", "time"}, .length_unit = "m"},
    {.model = "MicroHH",
     .names = {[NP_MODEL_LIQUID] = "ql", [NP_MODEL_ICE] = "qi", [NP_MODEL_DENSITY] = "rhoref rho",
               [NP_MODEL_PRESSURE] = "phydro", [NP_MODEL_TEMPERATURE] = "T", [NP_MODEL_FACE] = "zh"},
     .units = {[NP_MODEL_LIQUID] = "kg kg-1", [NP_MODEL_ICE] = "kg kg-1", [NP_MODEL_DENSITY] = "kg m-3",
               [NP_MODEL_PRESSURE] = "Pa", [NP_MODEL_TEMPERATURE] = "K", [NP_MODEL_FACE] = "m"},
     .axes = {"z", "y", "x", "time"}, .length_unit = "m"},
    {.model = "CF",
     .axes = {"z height altitude lev level plev", "y yc lat latitude rlat", "x xc lon longitude rlon", "time t"}},
};
/* clang-format on */

const size_t np_model_convention_count = sizeof np_model_conventions / sizeof *np_model_conventions;

bool np_model_names_next(const char **at, char *out, size_t capacity) {
  if (!*at) return false;
  *at += strspn(*at, " ");
  const size_t length = strcspn(*at, " ");
  if (length == 0 || length >= capacity) return false;
  memcpy(out, *at, length);
  out[length] = 0;
  *at += length;
  return true;
}
