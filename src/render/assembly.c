/* SPDX-License-Identifier: Apache-2.0 */
/* Walks the stage table, forwards to build and backwards to clear. */
#include "render/assembly.h"

#include "core/alloc.h"
#include "render/stages.h"

/* ---- Packets ---- */

static void set_weights(const np_wavelengths *wavelengths, np_color_space space, unsigned index, np_packet *packet) {
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    double rgb[3];
    np_color_space_weigh(space, wavelengths->xyz_nm[np_band_set_get_index(wavelengths, index, b)], rgb);
    for (int c = 0; c < 3; c++) packet->color_weight[c][b] = (float)rgb[c];
  }
}

/* The bands of each, and their weights in the picture's colours. */
neph_result np_stage_build_packets(const np_stage_inputs *in, np_assembly *out) {
  const np_plan *plan = in->plan;
  out->packets = np_alloc(out->context, plan->packet_count, sizeof *out->packets);
  if (!out->packets) return NEPH_ERROR_OUT_OF_MEMORY;
  out->packet_count = plan->packet_count;
  if (plan->packet_count == 1) {
    out->packets->bands = np_band_set_reference();
    for (int c = 0; c < 3; c++) out->packets->color_weight[c][c] = 1.0f;
    return NEPH_OK;
  }
  np_wavelengths wavelengths;
  np_wavelengths_choose(plan->wavelength_count, &wavelengths);
  for (unsigned i = 0; i < plan->packet_count; i++) {
    out->packets[i].bands = np_band_set_choose(&wavelengths, i);
    set_weights(&wavelengths, plan->color_space, i, &out->packets[i]);
  }
  return NEPH_OK;
}

void np_stage_clear_packets(np_assembly *assembly) { np_alloc_free(assembly->context, assembly->packets); }

/* ---- Walks ---- */

static neph_result build_part(const np_stage_row *row, unsigned part, const np_stage_inputs *in, np_assembly *a) {
  if (row->build_once && part-- == 0) return row->build_once(in, a);
  if (row->build_light && part < a->light_count) return row->build_light(in, part, &a->lights[part]);
  part -= row->build_light ? a->light_count : 0;
  if (row->build_packet && part < a->packet_count) return row->build_packet(in, &a->packets[part]);
  part -= row->build_packet ? a->packet_count : 0;
  np_packet *packet = &a->packets[part / a->light_count];
  return row->build_packet_light(in, packet, &packet->lights[part % a->light_count]);
}

static void clear_part(const np_stage_row *row, unsigned part, np_assembly *a) {
  if (row->clear_once && part-- == 0) {
    row->clear_once(a);
    return;
  }
  if (row->clear_light && part < a->light_count) {
    row->clear_light(a, &a->lights[part]);
    return;
  }
  part -= row->clear_light ? a->light_count : 0;
  if (row->clear_packet && part < a->packet_count) {
    row->clear_packet(a, &a->packets[part]);
    return;
  }
  part -= row->clear_packet ? a->packet_count : 0;
  np_packet *packet = &a->packets[part / a->light_count];
  row->clear_packet_light(a, packet, &packet->lights[part % a->light_count]);
}

static neph_result build_stage(np_stage stage, const np_stage_inputs *in, np_assembly *a) {
  const np_stage_row *row = np_stage_get_row(stage);
  const unsigned count = np_stage_count_parts(row, a->packet_count, a->light_count);
  neph_result result = NEPH_OK;
  if (count > 0) a->built |= 1u << stage;
  for (unsigned part = 0; part < count && !result; part++) {
    np_schedule_begin(&a->schedule, in->monitor, stage, part, count);
    result = build_part(row, part, in, a);
  }
  return result;
}

neph_result np_assembly_build_some(const neph_scene *scene, np_plan *plan, uint32_t stages, np_monitor *monitor,
                                   np_assembly *out_assembly) {
  np_assembly *a = out_assembly;
  *a = (np_assembly){.context = scene->context, .stores = plan->stores};
  const np_stage_inputs in = {scene, plan, a, plan->stores, &a->schedule, monitor};
  np_schedule_make(plan, &a->schedule);
  neph_result result = np_camera_init(scene, plan->desc.width, plan->desc.height, &a->camera);
  for (int i = 0; i < NP_STAGE_COUNT && !result; i++) {
    if (!np_plan_needs(plan, (np_stage)i) || !(stages & 1u << i)) continue;
    result = build_stage((np_stage)i, &in, a);
    const np_stage_row *row = np_stage_get_row((np_stage)i);
    if (!result && row->revise) result = row->revise(a, scene, plan);
  }
  if (result) np_assembly_clear(a);
  return result;
}

neph_result np_assembly_build(const neph_scene *scene, np_plan *plan, np_monitor *monitor, np_assembly *out_assembly) {
  return np_assembly_build_some(scene, plan, UINT32_MAX, monitor, out_assembly);
}

void np_assembly_clear(np_assembly *assembly) {
  for (int i = NP_STAGE_COUNT; i-- > 0;) {
    if (!(assembly->built & 1u << i)) continue;
    const np_stage_row *row = np_stage_get_row((np_stage)i);
    unsigned part = np_stage_count_parts(row, assembly->packet_count, assembly->light_count);
    while (part-- > 0) clear_part(row, part, assembly);
  }
  *assembly = (np_assembly){0};
}
