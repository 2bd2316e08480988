/* SPDX-License-Identifier: Apache-2.0 */
/* Renderers: successive pictures, of one scene or of several, that share caches. */
#ifndef NEPHOS_RENDERER_H
#define NEPHOS_RENDERER_H

#include <nephos/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The caches that pictures share, of one scene or of several: volumes and terrain while their files and settings are
 * the same, tables of air and sky, multiple scattering, sun optical depth, the frame before where a frame needs it, and
 * the frame by which an imported sequence is placed and scaled. One owner; one picture at a time: a call while another
 * thread renders, or from a callback of a picture, returns NEPH_ERROR_INVALID_ARGUMENT. Several renderers may render
 * one scene at once. */
typedef struct neph_renderer neph_renderer;

NEPH_API neph_result neph_renderer_create(neph_context *context, neph_renderer **out_renderer) NEPH_NODISCARD;

/** Ends a renderer, and frees what it keeps. NULL is allowed. */
NEPH_API void neph_renderer_destroy(neph_renderer *renderer);

/** Renders one picture as neph_render_image does, and reuses caches of earlier pictures.
 *
 * A picture has the bits of the scene rendered alone where the caches were built for the same scene; where lights or
 * air have moved a little, tables are reused within the tolerances that they were sized for (atmosphere.tolerance, and
 * a thousandth for multiple scattering), as in a sequence. The log names what is reused, and what is rebuilt and why.
 *
 * @param scene      scene of the renderer's context.
 * @param desc       NULL: the scene's own settings.
 * @param out_image  owned by the caller; NULL on failure.
 */
NEPH_API neph_result neph_renderer_render(neph_renderer *renderer, const neph_scene *scene,
                                          const neph_render_desc *desc, neph_image **out_image) NEPH_NODISCARD;

/** Keeps the samples of each picture. The same picture with more samples a pixel, rendered next, then takes the further
 * ones alone, and has the bits of a picture rendered so from the start: none of its stages before the integrator runs
 * again, and its error is stated anew. A call that is cancelled keeps the pixels that it has finished. Pictures with a
 * target error, a time limit, deep pixels, parts, or pixels of the frame before are not kept.
 *
 * @param is_kept  true: at 8 bytes for each of some thirty numbers a pixel; false (default): those kept are freed.
 */
NEPH_API neph_result neph_renderer_keep_samples(neph_renderer *renderer, bool is_kept) NEPH_NODISCARD;

/** Chooses the place of the pictures whose tiles are rendered first, for a neph_tile_fn: the others follow outwards.
 * The bits of a picture do not depend on it.
 *
 * @param x  share of the width from the left, of the crop where there is one; not finite: tiles come from the top
 *           (default).
 * @param y  share of the height from the top.
 */
NEPH_API neph_result neph_renderer_set_focus(neph_renderer *renderer, double x, double y) NEPH_NODISCARD;

/** The plan of a picture as neph_render_explain has it. An imported sequence without a reference_frame goes by the
 * first frame that this renderer explained or rendered and that holds anything; a warning is logged once a renderer.
 *
 * @param out_text  free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_renderer_explain(neph_renderer *renderer, const neph_scene *scene,
                                           const neph_render_desc *desc, neph_text_format format,
                                           char **out_text) NEPH_NODISCARD;

/** Settings for a target or a limit as neph_scene_choose_effort chooses them. What is measured for that, such as the
 * share of a bake's cells that hold cloud, is kept for the picture, and takes none of its time limit. */
NEPH_API neph_result neph_renderer_choose_effort(neph_renderer *renderer, neph_scene *scene,
                                                 const neph_render_desc *desc, neph_effort *out_effort) NEPH_NODISCARD;

/** Ends the picture under way, from any thread: neph_renderer_render then returns NEPH_ERROR_CANCELLED within half a
 * second. Without one the next call of neph_renderer_render returns that at once, so that a cancel cannot come too
 * early; the call behind it renders. */
NEPH_API void neph_renderer_cancel(neph_renderer *renderer);

#ifdef __cplusplus
}
#endif

#endif
