/* SPDX-License-Identifier: Apache-2.0 */
/* All files of an imported sequence, by which its frames are placed and scaled alike: the union of their boxes, their
 * largest voxel, their densest column. Kept on disk, where the context has a folder for that, under the names, sizes
 * and times of the files. */
#ifndef NP_PLAN_SEQUENCE_SCAN_H
#define NP_PLAN_SEQUENCE_SCAN_H

#include "plan/placement.h"

/* Lengths in the coordinates of the files, turned, tilted and scaled by axis like the cloud. */
typedef struct np_sequence_scan {
  np_dvec3 low, high;  /* union of the boxes of active samples */
  double voxel;        /* largest edge */
  double column;       /* largest integral of the value over a vertical line; 0 where optical_depth does not need it */
  double densest;      /* number of its file */
  uint64_t file_count; /* number of files; `filled_count` of them are not empty */
  uint64_t filled_count;
} np_sequence_scan;

/* Fingerprint of all that a scan depends on. */
neph_result np_sequence_scan_compute_key(const np_scene_cloud *cloud, neph_context *context, char out_hex[33]);

/* The scan of that key, from disk or from the files. */
neph_result np_sequence_scan_get(neph_context *context, const np_scene_cloud *cloud, const neph_volume_load_desc *load,
                                 const char *key, np_monitor *monitor, np_sequence_scan *out_scan);

/* Placement by a scan that found something. */
void np_sequence_scan_anchor(const np_sequence_scan *scan, const np_scene_cloud *cloud, np_anchor *out_anchor);

#endif
