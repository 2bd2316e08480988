/* SPDX-License-Identifier: Apache-2.0 */
/* Keys of the output. */
#include "scene/scene_key_rows.h"

static const np_choice pixel_types[] = {{"half", NEPH_PIXEL_HALF}, {"float", NEPH_PIXEL_FLOAT}, {NULL, 0}};
static const np_choice alphas[] = {{"clouds", NP_ALPHA_CLOUDS},
                                   {"clouds_and_ground", NP_ALPHA_CLOUDS_AND_GROUND},
                                   {"scene", NP_ALPHA_SCENE},
                                   {NULL, 0}};
static const np_choice cloud_airs[] = {{"kept", NP_CLOUD_AIR_KEPT}, {"apart", NP_CLOUD_AIR_APART}, {NULL, 0}};
static const np_choice exposures[] = {
    {"auto", NEPH_EXPOSURE_AUTO}, {"meter", NEPH_EXPOSURE_METER}, {"camera", NEPH_EXPOSURE_CAMERA}, {NULL, 0}};
static const np_choice views[] = {{"camera", NEPH_VIEW_CAMERA},
                                  {"filmic", NEPH_VIEW_FILMIC},
                                  {"standard", NEPH_VIEW_STANDARD},
                                  {"raw", NEPH_VIEW_RAW},
                                  {NULL, 0}};
static const np_choice preview_bits[] = {{"8", 8}, {"16", 16}, {NULL, 0}};
static const np_choice color_spaces[] = {{"rec709", NP_COLOR_REC709},   {"acescg", NP_COLOR_ACESCG},
                                         {"rec2020", NP_COLOR_REC2020}, {"xyz", NP_COLOR_XYZ},
                                         {"bands", NP_COLOR_BANDS},     {NULL, 0}};
#define AOV(id, name, ...) {name, NP_AOV_##id},
static const np_choice aovs[] = {NP_AOV_ROWS(AOV){NULL, 0}};
#undef AOV

/* clang-format off */
static const np_key keys[] = {
    {.path = "output", .type = NP_KEY_SECTION, .meaning = "output files and their contents"},
    {.path = "output.image", .type = NP_KEY_FILE, .field = SCENE(output.image),
     .meaning = "OpenEXR file; # stands for the frame number"},
    {.path = "output.preview", .type = NP_KEY_FILE, .field = SCENE(output.preview),
     .meaning = "PNG file; # stands for the frame number"},
    {.path = "output.deep", .type = NP_KEY_FILE, .field = SCENE(output.deep),
     .meaning = "deep OpenEXR file of the clouds; # stands for the frame number; at most 32 samples per pixel, which "
                "flatten to the layer clouds"},
    {.path = "output.beauty", .type = NP_KEY_CHOICE, .choices = np_booleans, .field = SCENE(output.has_beauty),
     .fallback = "true", .meaning = "true: the picture is written to R, G and B, besides A, Z and the AOVs"},
    {.path = "output.aovs", .type = NP_KEY_FLAGS, .choices = aovs, .field = SCENE(output.aovs),
     .meaning = "additional channels; depth is Z, which every picture has"},
    {.path = "output.alpha", .type = NP_KEY_CHOICE, .choices = alphas, .field = SCENE(output.alpha),
     .fallback = "clouds_and_ground",
     .meaning = "coverage in A: clouds alone, clouds and ground, or everything in the picture, including the sky; the "
                "first two ignore air"},
    {.path = "output.cloud_air", .type = NP_KEY_CHOICE, .choices = cloud_airs, .field = SCENE(output.cloud_air),
     .fallback = "kept",
     .meaning = "in-scatter of the air in front of clouds, in the layer clouds and in deep pictures: kept in them, or "
                "apart, in the layer cloud_air alone"},
    {.path = "output.pixel_type", .type = NP_KEY_CHOICE, .choices = pixel_types, .field = SCENE(output.pixel_type),
     .fallback = "half",
     .meaning = "type of colour channels in the OpenEXR file; half becomes float, with a warning, if a value "
                "overflows or the median lit pixel is below 2^-14"},
    {.path = "output.color_space", .type = NP_KEY_CHOICE, .choices = color_spaces, .field = SCENE(output.color_space),
     .fallback = "rec709",
     .meaning = "meaning of R, G and B: scene-linear light with these primaries, CIE 1931 X, Y and Z, or the "
                "radiances at 680, 550 and 440 nm"},
    {.path = "output.scale", .type = NP_KEY_REAL, .field = SCENE(output.scale), .range = WITHIN(0x1p-40, 0x1p40),
     .fallback = "auto", .word = "auto", .word_value = 0,
     .meaning = "factor on every radiance, a power of two, stated in the header; auto is 1 for bands and 2 for "
                "colours, for which a perfect diffuser under sun and sky at noon is near 1"},
    {.path = "output.exposure", .type = NP_KEY_REAL, .unit = NP_UNIT_STOP, .field = SCENE(output.exposure_ev),
     .range = WITHIN(-40, 40), .fallback = "auto", .choices = exposures, .tag = SCENE(output.exposure),
     .tag_value = NEPH_EXPOSURE_FIXED,
     .meaning = "exposure of the preview in stops; auto: by its highlights; meter: by the light on the scene, so that "
                "frames and tiles match and night stays dark; camera: by its f_stop, shutter and iso"},
    {.path = "output.view", .type = NP_KEY_SECTION, .choices = views, .field = SCENE(output.view), .fallback = "camera",
     .tag = SCENE(output.view), .tag_value = NEPH_VIEW_OCIO,
     .meaning = "display of the preview: camera has white balance, glare and lifted midtones; filmic has a soft "
                "shoulder, standard clips, raw is linear like the EXR; or a view of an OpenColorIO configuration"},
    {.path = "output.view.ocio", .type = NP_KEY_FILE, .is_input = true, .field = SCENE(output.ocio_config),
     .meaning = "configuration of OpenColorIO, a file config.ocio"},
    {.path = "output.view.display", .type = NP_KEY_TEXT, .field = SCENE(output.ocio_display),
     .meaning = "display of the configuration; default: its first"},
    {.path = "output.view.view", .type = NP_KEY_TEXT, .field = SCENE(output.ocio_view),
     .meaning = "view of the display; default: its first"},
    {.path = "output.view.input", .type = NP_KEY_TEXT, .field = SCENE(output.ocio_input),
     .meaning = "colour space of the configuration that is linear light with Rec.709's primaries; default: by the role "
                "aces_interchange or cie_xyz_d65_interchange, or a space of such a name"},
    {.path = "output.glare", .type = NP_KEY_REAL, .field = SCENE(output.glare), .range = WITHIN(0, 0.5),
     .fallback = "0.06", .meaning = "share of light that the lens scatters over a preview of view camera"},
    {.path = "output.preview_bits", .type = NP_KEY_CHOICE, .choices = preview_bits,
     .field = SCENE(output.preview_bits), .fallback = "8", .meaning = "bits per component of the preview"},
    {.path = "output.film", .type = NP_KEY_SECTION, .meaning = "components of light in the picture"},
    {.path = "output.film.background", .type = NP_KEY_CHOICE, .choices = np_booleans,
     .field = SCENE(output.has_background),
     .fallback = "true", .meaning = "false leaves out the sky and the sun's disk in the background"},
    {.path = "output.film.disks", .type = NP_KEY_CHOICE, .choices = np_booleans, .field = SCENE(output.has_disks),
     .fallback = "true",
     .meaning = "false leaves out the disks of sun and moon, for example for a dome light with a separate sun; they "
                "still light the scene"},
};
/* clang-format on */

const np_key_table np_keys_output = {keys, sizeof keys / sizeof *keys};
