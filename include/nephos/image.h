/* SPDX-License-Identifier: Apache-2.0 */
/* Images: named float channels, read from and written to OpenEXR, previewed as PNG, compared. */
#ifndef NEPHOS_IMAGE_H
#define NEPHOS_IMAGE_H

#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A picture: width × height pixels, channels in planes, row 0 at the top. */
typedef struct neph_image neph_image;

/** A zeroed image with the given channels ("R", "A", "Z", "sun.R", …), names copied.
 *
 * 1 to 65536 pixels a side, 1 to 1024 channels with different names of 1 to 255 bytes, at most 16 GiB in all.
 */
NEPH_API neph_result neph_image_create(neph_context *context, unsigned width, unsigned height, unsigned channel_count,
                                       const char *const *channel_names, neph_image **out_image) NEPH_NODISCARD;

/** Ends an image. NULL is allowed. */
NEPH_API void neph_image_destroy(neph_image *image);

NEPH_API unsigned neph_image_get_width(const neph_image *image);
NEPH_API unsigned neph_image_get_height(const neph_image *image);
NEPH_API unsigned neph_image_get_channel_count(const neph_image *image);

/** NULL when `index` is not below the channel count. */
NEPH_API const char *neph_image_get_channel_name(const neph_image *image, unsigned index);

/** One channel's width·height values, row by row from the top; NULL when there is no such channel. */
NEPH_API float *neph_image_get_channel(neph_image *image, const char *name);

/** The read-only counterpart of neph_image_get_channel. */
NEPH_API const float *neph_image_get_values(const neph_image *image, const char *name);

/** A text attribute of the header; NULL when there is none. */
NEPH_API const char *neph_image_get_attribute(const neph_image *image, const char *name);

/** Sets or replaces a text attribute. */
NEPH_API neph_result neph_image_set_attribute(neph_image *image, const char *name, const char *value) NEPH_NODISCARD;

typedef enum neph_pixel_type { NEPH_PIXEL_HALF, NEPH_PIXEL_FLOAT } neph_pixel_type;

/** Writes OpenEXR (ZIP level 4, scan lines), atomically.
 *
 * The channels Z, depth, distance, position, position.* and P.* are always float.
 * Every channel is written as float, with a warning that names the scale to use, where halves would not do: a finite
 * value is above 65504, or the picture is one of radiances (with the attribute "nephos:scale") of whose lit pixels more
 * than half lie below 2⁻¹⁴. NaN and infinite colours are written as they are, with a warning that counts them.
 */
NEPH_API neph_result neph_image_save_exr(const neph_image *image, const char *path,
                                         neph_pixel_type pixel_type) NEPH_NODISCARD;

/** Whether an image has deep pixels: its scene named a file for them (output.deep). */
NEPH_API bool neph_image_has_deep(const neph_image *image);

/** Writes the deep pixels of an image as OpenEXR (deep scan lines, ZIPS), atomically: channels R, G, B, A, Z and ZBack,
 * at most 32 samples a pixel. Z, ZBack and A are always float.
 *
 * Fails with NEPH_ERROR_INVALID_ARGUMENT where the image has none.
 */
NEPH_API neph_result neph_image_save_deep_exr(const neph_image *image, const char *path,
                                              neph_pixel_type pixel_type) NEPH_NODISCARD;

/** Reads a scan-line or tiled OpenEXR, first part and full resolution, every channel to float.
 *
 * Text, int, float and double attributes are kept; numbers are given as text. Sub-sampled channels and deep pictures
 * are refused, and so are files that claim more than 65536 pixels a side, 1024 channels or 16 GiB in memory.
 */
NEPH_API neph_result neph_image_load_exr(neph_context *context, const char *path,
                                         neph_image **out_image) NEPH_NODISCARD;

/** Reads a PNG of 1 to 16 bits: grey as "Y", colour as "R", "G", "B", alpha as "A"; values 0 to 1, no gamma removed. */
NEPH_API neph_result neph_image_load_png(neph_context *context, const char *path,
                                         neph_image **out_image) NEPH_NODISCARD;

/** Transform from linear light to the values of a preview. */
typedef enum neph_view {
  NEPH_VIEW_FILMIC,   /**< linear up to 0.75, a shoulder above that keeps hue and fades to white, sRGB */
  NEPH_VIEW_STANDARD, /**< clipped at 1, sRGB */
  NEPH_VIEW_RAW,      /**< R, G and B times exposure_ev alone, clipped at 1; no sRGB, no conversion of primaries */
  NEPH_VIEW_CAMERA,   /**< white balance, glare and lifted midtones, sRGB; the default. Light of the chromaticity
                           nephos:meterX, nephos:meterY shows as neutral with the sun (nephos:sunElevation) above 15°,
                           and in its colour below 5°; by night so with the moon (nephos:moonElevation). The lens of
                           a perspective picture, whose camera the header has, scatters the share `glare`. Midtones
                           are lifted by 0.45 stops in the same hue, under the shoulder of NEPH_VIEW_FILMIC. A step
                           whose attributes are missing is left out */
  NEPH_VIEW_OCIO      /**< a view of an OpenColorIO configuration, `ocio_config`; needs NEPH_FEATURE_OCIO */
} neph_view;

/** Base exposure of a preview. */
typedef enum neph_exposure {
  NEPH_EXPOSURE_AUTO,  /**< exposure for the highlights: the 99.3rd percentile of luminance comes to 0.92, and the
                            log-average of the rest to at least 0.08; the default */
  NEPH_EXPOSURE_METER, /**< exposure by the light on the scene, from a render's attributes nephos:meter and
                            nephos:meterLuminance: a white diffuser comes to 0.8 by day and to less in the dark, the
                            same for all parts of a picture */
  NEPH_EXPOSURE_FIXED, /**< no base exposure: the picture times 2^exposure_ev */
  NEPH_EXPOSURE_CAMERA /**< exposure by f-stop, shutter and ISO, from the attributes nephos:EV100 and nephos:meter:
                            1.2·2^EV cd/m² comes to 1 */
} neph_exposure;

typedef struct neph_preview_desc {
  size_t struct_size;
  double exposure_ev;         /**< stops added to the base exposure, −64 to 64 (default 0) */
  neph_exposure exposure;     /**< default NEPH_EXPOSURE_AUTO */
  double white[3];            /**< radiance of R, G, B that shows as neutral (default 1, 1, 1); each > 0 */
  neph_view view;             /**< default NEPH_VIEW_CAMERA */
  unsigned bits;              /**< bits of a component: 8 (the default) or 16 */
  neph_pixel_type pixel_type; /**< type to which values are rounded first, as neph_image_save_exr rounds them: with
                                   half, a preview is that of the saved file, and of its merged tiles, to the bit
                                   (default float) */
  double glare;               /**< share of light that the lens scatters over the picture in NEPH_VIEW_CAMERA, 0 to 0.5
                                   (default 0.06); other views have none */
  /* Texts of NEPH_VIEW_OCIO; other views need none. */
  const char *ocio_config;  /**< path of the configuration, a file "config.ocio" (default NULL: an error) */
  const char *ocio_display; /**< display of the configuration (default NULL: its first) */
  const char *ocio_view;    /**< view of the display (default NULL: its first) */
  const char *ocio_input;   /**< colour space of the configuration that is linear light with the primaries of Rec.709
                                 (default NULL: by its roles aces_interchange or cie_xyz_d65_interchange, or by the
                                 names that such a space has in configurations of ACES and Blender) */
} neph_preview_desc;

#define NEPH_PREVIEW_DESC_DEFAULT                                                                                      \
  {                                                                                                                    \
    .struct_size = sizeof(neph_preview_desc), .exposure_ev = 0, .exposure = NEPH_EXPOSURE_AUTO, .white = {1, 1, 1},    \
    .view = NEPH_VIEW_CAMERA, .bits = 8, .pixel_type = NEPH_PIXEL_FLOAT, .glare = 0.06                                 \
  }

/** Checks a description before a picture is there: ranges, and for NEPH_VIEW_OCIO that the configuration can be used
 * and has the names.
 *
 * @param desc  NULL for the defaults.
 */
NEPH_API neph_result neph_preview_check(neph_context *context, const neph_preview_desc *desc) NEPH_NODISCARD;

/** Writes a PNG of channels R, G, B, or of Y alone: exposure, view, dither.
 *
 * The automatic exposure leaves out unlit pixels, so that black borders do not change it. Primaries that the header
 * names are converted to sRGB's, white to white. Negative values show as 0, infinite ones as white, NaN as magenta.
 *
 * @param desc  NULL for the defaults.
 */
NEPH_API neph_result neph_image_save_png(const neph_image *image, const char *path,
                                         const neph_preview_desc *desc) NEPH_NODISCARD;

/** Size, channels and header of an OpenEXR file as text; free it with neph_text_destroy. */
NEPH_API neph_result neph_image_describe_file(neph_context *context, const char *path, neph_text_format format,
                                              char **out_text) NEPH_NODISCARD;

/** A figure with its 95 % bounds; NaN where it is unknown. */
typedef struct neph_bounded {
  double value, min, max;
} neph_bounded;

/** Origin of a stated bias. */
typedef enum neph_bias_source {
  NEPH_BIAS_UNKNOWN,
  NEPH_BIAS_BY_MODEL, /**< bias predicted from the scene and the settings alone (docs/error.md) */
  NEPH_BIAS_MEASURED  /**< bias that the tracer has measured too, at some pixels */
} neph_bias_source;

/** Error of a picture as its render estimated it: relative rms of luminance over pixels above a hundredth of the mean
 * (docs/error.md). */
typedef struct neph_image_error {
  size_t struct_size;
  neph_bounded error; /**< error² = noise² + bias² */
  neph_bounded noise, bias;
  neph_bias_source bias_source;
} neph_image_error;

#define NEPH_IMAGE_ERROR_DEFAULT                                                                                       \
  { .struct_size = sizeof(neph_image_error) }

/** The error that the header of an image, rendered or loaded, states (nephos:error, nephos:noise, nephos:bias, and each
 * with Min and Max behind it).
 *
 * @param out_error  starts from NEPH_IMAGE_ERROR_DEFAULT; figures that the header lacks become NaN.
 */
NEPH_API neph_result neph_image_get_error(const neph_image *image, neph_image_error *out_error) NEPH_NODISCARD;

/** Origin of the noise of a reference. */
typedef enum neph_noise_source {
  NEPH_NOISE_UNKNOWN,   /**< unstated: noise is part of every measure */
  NEPH_NOISE_BY_HEADER, /**< nephos:noise of the reference's header: the same share of every pixel */
  NEPH_NOISE_BY_PIXEL   /**< the reference's channels standard_error.*, scaled to nephos:noise where that is less */
} neph_noise_source;

/** The difference of a picture from a reference, over the channels R, G, B (or all, where those are missing). L is the
 * reference, d the picture minus it. Values that are not finite in the reference are left out. */
typedef struct neph_image_difference {
  size_t struct_size;
  double relative_mse;      /**< mean of d²/(L² + ε²), ε = 0.01·mean |L| */
  double rmse;              /**< root of mean d² */
  double bias;              /**< Σ picture / Σ reference − 1 */
  double bias_interval;     /**< half width of the bias's 95 % confidence interval, from 8×8-pixel blocks taken as
                                 independent; NaN for less than two blocks */
  double block_rms;         /**< √(Σ d² / Σ L²) over 8×8-pixel means */
  double p999_relative;     /**< 99.9th percentile of |d|/(|L| + ε) */
  double max_absolute;      /**< largest |d| */
  double noise_rmse;        /**< noise of the reference within rmse, root of mean σ² (reference_noise_source); NaN, as
                                 noise_block_rms and noise_bias, where it is unknown */
  double noise_block_rms;   /**< noise of the reference within block_rms: the picture's is √(block_rms² −
                                 noise_block_rms²) */
  double noise_bias;        /**< standard error that the reference's noise adds to bias, all its channels taken from the
                                 same samples */
  uint64_t value_count;     /**< values compared */
  uint64_t differing_count; /**< values whose bits differ, in every channel; a channel that only one picture has differs
                                 everywhere */
  neph_bounded pixel_error; /**< relative rms difference of luminance from the reference's, over the pixels brighter
                                 than a hundredth of its mean (docs/error.md), less the reference's noise where it is
                                 known. Where noise leaves no positive square, the value is 0 and `max` bounds it; NaN
                                 where no value within the bounds is positive: the pictures share their noise, or it is
                                 overstated. Never less than pixel_noise */
  neph_bounded pixel_noise; /**< random part of pixel_error; NaN, as pixel_bias, without a second picture,
                                 standard_error.* of the picture or a figure in its header */
  neph_bounded pixel_bias;  /**< part of pixel_error that every seed shares: error² = noise² + bias² */
  uint64_t pixel_count;     /**< number of pixels in pixel_error, pixel_noise and pixel_bias */
  neph_noise_source reference_noise_source;
  neph_bounded reference_noise; /**< noise of the reference a pixel, defined as pixel_error; NaN where it is unknown */
} neph_image_difference;

#define NEPH_IMAGE_DIFFERENCE_DEFAULT                                                                                  \
  { .struct_size = sizeof(neph_image_difference) }

/** Compares two images of one size. NaN or infinity where the reference is finite is an error that names the pixel;
 * headers that name different colour spaces are an error as well.
 *
 * @param out_difference  starts from NEPH_IMAGE_DIFFERENCE_DEFAULT; unchanged on failure.
 */
NEPH_API neph_result neph_image_compare(neph_context *context, const neph_image *image, const neph_image *reference,
                                        neph_image_difference *out_difference) NEPH_NODISCARD;

/** Compares as neph_image_compare does, with noise from a second picture of the same size that differs from the first
 * only in its seed. */
NEPH_API neph_result neph_image_compare_seeds(neph_context *context, const neph_image *image, const neph_image *second,
                                              const neph_image *reference,
                                              neph_image_difference *out_difference) NEPH_NODISCARD;

/** A picture of the difference, for EXR, or for PNG without automatic exposure.
 *
 * "R" is 1 where the picture is twice as bright as the reference, "B" where it is black and the reference is not; "G"
 * is 0. "difference.R" and so on hold the signed relative difference d/(|L| + ε) of each compared channel; R and B show
 * their mean. Refuses what neph_image_compare refuses.
 */
NEPH_API neph_result neph_image_create_difference(neph_context *context, const neph_image *image,
                                                  const neph_image *reference, neph_image **out_image) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
