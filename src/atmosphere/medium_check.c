/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/medium.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/context_private.h"
#include "core/text.h"

/* One parameter of a description and its allowed interval. */
typedef struct bounded {
  const char *name;
  double value, low, high;
  bool is_open; /* excludes `low` itself */
} bounded;

static neph_result check_bounded(neph_context *context, const char *where, const bounded *b) {
  if (isfinite(b->value) && (b->is_open ? b->value > b->low : b->value >= b->low) && b->value <= b->high)
    return NEPH_OK;
  const char *least = b->is_open ? "above" : "at least";
  if (!isfinite(b->low))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "atmosphere: %s%s is %g, must be finite", where, b->name,
                   b->value);
  if (isfinite(b->high))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "atmosphere: %s%s is %g, must be %s %g and at most %g", where,
                   b->name, b->value, least, b->low, b->high);
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "atmosphere: %s%s is %g, must be finite and %s %g", where,
                 b->name, b->value, least, b->low);
}

static neph_result check_all(neph_context *context, const char *where, const bounded *all, size_t count) {
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < count; i++) result = check_bounded(context, where, &all[i]);
  return result;
}

static neph_result check_table(neph_context *context, const char *where, const neph_atmosphere_layer *layer) {
  if (layer->table_rows < 2)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "atmosphere: %stable_rows is %u, must be at least 2", where,
                   layer->table_rows);
  if (!layer->table_altitude_m || !layer->table_density)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "atmosphere: %s%s is NULL, must be %u numbers", where,
                   layer->table_altitude_m ? "table_density" : "table_altitude_m", layer->table_rows);
  for (unsigned i = 0; i < layer->table_rows; i++) {
    const double altitude = layer->table_altitude_m[i], density = layer->table_density[i];
    if (!isfinite(altitude) || (i && altitude <= layer->table_altitude_m[i - 1]))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "atmosphere: %stable_altitude_m[%u] is %g, must be finite and above the one before", where, i,
                     altitude);
    if (!(isfinite(density) && density >= 0.0))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "atmosphere: %stable_density[%u] is %g, must be finite and at least 0", where, i, density);
  }
  return NEPH_OK;
}

static neph_result check_profile(neph_context *context, const char *where, const neph_atmosphere_layer *layer) {
  const bounded height = {"height_m", layer->height_m, 0.0, INFINITY, true};
  const bounded tent[] = {{"center_m", layer->center_m, -INFINITY, INFINITY, false},
                          {"width_m", layer->width_m, 0.0, INFINITY, true}};
  switch (layer->profile) {
  case NEPH_LAYER_EXPONENTIAL:
    return check_bounded(context, where, &height);
  case NEPH_LAYER_TENT:
    return check_all(context, where, tent, 2);
  case NEPH_LAYER_TABLE:
    return check_table(context, where, layer);
  }
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "atmosphere: %sprofile is %d, must be a neph_layer_profile",
                 where, (int)layer->profile);
}

/* Checks that a layer begins below its end and below the top of the atmosphere. */
static neph_result check_range(neph_context *context, const char *where, const neph_atmosphere_layer *layer,
                               double top_m) {
  const bounded bottom = {"bottom_m", layer->bottom_m, -INFINITY, INFINITY, false};
  neph_result result = check_bounded(context, where, &bottom);
  if (result) return result;
  if (!(layer->top_m > layer->bottom_m))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "atmosphere: %stop_m is %g, must be above bottom_m, %g", where,
                   layer->top_m, layer->bottom_m);
  const bool is_table = layer->profile == NEPH_LAYER_TABLE, is_tent = layer->profile == NEPH_LAYER_TENT;
  const double low = is_table  ? layer->table_altitude_m[0]
                     : is_tent ? layer->center_m - layer->width_m
                               : layer->bottom_m;
  const double begin = fmax(low, layer->bottom_m);
  if (begin < top_m) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                 "atmosphere: top_altitude_m is %g, must be above %.*s, which begins at %g", top_m,
                 (int)strlen(where) - 1, where, begin);
}

static neph_result check_phase(neph_context *context, const char *where, const neph_atmosphere_layer *layer) {
  static const size_t parameter_counts[] = {
      [NEPH_PHASE_RAYLEIGH] = 0, [NEPH_PHASE_ISOTROPIC] = 0,       [NEPH_PHASE_HENYEY_GREENSTEIN] = 1,
      [NEPH_PHASE_TWO_LOBE] = 3, [NEPH_PHASE_CORNETTE_SHANKS] = 1, [NEPH_PHASE_HAZE] = 1};
  if ((unsigned)layer->phase >= sizeof parameter_counts / sizeof *parameter_counts)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "atmosphere: %sphase is %d, must be the neph_phase Rayleigh (0), isotropic (1), Henyey-Greenstein "
                   "(2), two lobes (3), Cornette-Shanks (4) or haze (5)",
                   where, (int)layer->phase);
  const bool is_haze = layer->phase == NEPH_PHASE_HAZE;
  const double low = is_haze ? NP_PHASE_HAZE_MIN : -0.9999, high = is_haze ? NP_PHASE_HAZE_MAX : 0.9999;
  neph_result result = NEPH_OK;
  for (int b = 0; !result && b < 3; b++) {
    const bounded all[] = {{"asymmetry", layer->asymmetry[b], low, high, false},
                           {"second_asymmetry", layer->second_asymmetry[b], -0.9999, 0.9999, false},
                           {"second_weight", layer->second_weight[b], 0.0, 1.0, false}};
    result = check_all(context, where, all, parameter_counts[layer->phase]);
  }
  return result;
}

static neph_result check_layer(neph_context *context, const neph_atmosphere_desc *d, unsigned index) {
  const neph_atmosphere_layer *layer = &d->layers[index];
  char where[32];
  np_print(where, sizeof where, "layers[%u].", index);
  neph_result result = check_profile(context, where, layer);
  if (!result) result = check_range(context, where, layer, d->top_altitude_m);
  for (int b = 0; !result && b < 3; b++) {
    const bounded all[] = {{"scattering_per_m", layer->scattering_per_m[b], 0.0, INFINITY, false},
                           {"absorption_per_m", layer->absorption_per_m[b], 0.0, INFINITY, false}};
    result = check_all(context, where, all, 2);
  }
  return result ? result : check_phase(context, where, layer);
}

neph_result np_medium_check(neph_context *context, const neph_atmosphere_desc *d) {
  const bounded all[] = {{"planet_radius_m", d->planet_radius_m, 0.0, INFINITY, true},
                         {"top_altitude_m", d->top_altitude_m, 0.0, INFINITY, true},
                         {"tolerance", d->tolerance, NP_SKY_TOLERANCE_MIN, NP_SKY_TOLERANCE_MAX, false},
                         {"ground_albedo", d->ground_albedo[0], 0.0, 1.0, false},
                         {"ground_albedo", d->ground_albedo[1], 0.0, 1.0, false},
                         {"ground_albedo", d->ground_albedo[2], 0.0, 1.0, false}};
  neph_result result = check_all(context, "", all, sizeof all / sizeof *all);
  if (!result && d->layer_count && !d->layers)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "atmosphere: layers is NULL, must be %u of them",
                   d->layer_count);
  for (unsigned i = 0; !result && i < d->layer_count; i++) result = check_layer(context, d, i);
  return result;
}
