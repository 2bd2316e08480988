/* SPDX-License-Identifier: Apache-2.0 */
/* The door through which GDAL reaches files: names of a file system of its own, /vsinephos/, which opens regular files
 * for reading and nothing else. A name that a raster makes up from its own, of a header, a mask or a part, passes the
 * same door; one that stands in a file and does not begin so is refused before GDAL sees it (gdal_references.c). */
#ifndef NP_TERRAIN_GDAL_FILES_H
#define NP_TERRAIN_GDAL_FILES_H

/* Name by which GDAL opens a file, which CPLFree frees; NULL, after a failure of GDAL, where it must not be opened. If
 * it is confined, names beside it that lead out of its folder cannot be opened. */
char *np_gdal_files_name(const char *path, int is_confined);

/* Reason for which a name of this file system is not opened; NULL: it is opened. */
const char *np_gdal_files_get_refusal(const char *name);

/* Shortens names of this file system in a message of GDAL to their last parts. */
void np_gdal_files_clean_message(char *message);

#endif
