/* SPDX-License-Identifier: Apache-2.0 */
/* The module nephos_netcdf.so: variables and attributes of NetCDF files through libnetcdf.
 *
 * libnetcdf and HDF5 have state of the whole process, so that one lock guards every call. A path is opened by its
 * absolute name, which begins with a slash and is thus no address of a network.
 */
#include "volume/netcdf_table.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <hdf5.h>
#include <netcdf.h>
#include <netcdf_mem.h>

#include "core/text_copy.h"

struct np_netcdf_file {
  int id, variable_count;
};

static pthread_mutex_t netcdf_lock = PTHREAD_MUTEX_INITIALIZER;

/* HDF5 prints errors, of each thread by a setting of its own. */
static void lock_library(void) {
  pthread_mutex_lock(&netcdf_lock);
  (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

static void unlock_library(void) { pthread_mutex_unlock(&netcdf_lock); }

/* ---- Errors ---- */

static neph_result fail(np_netcdf_error *error, const char *action, int status) {
  const neph_result result = status == NC_ENOMEM ? NEPH_ERROR_OUT_OF_MEMORY : NEPH_ERROR_BAD_FILE;
  const int length = snprintf(error->message, sizeof error->message, "%s: %s", action, nc_strerror(status));
  if (length < 0) error->message[0] = 0;
  return error->result = result;
}

/* ---- Opening ---- */

static int open_path(const char *path, int *out_id) {
  char *absolute = realpath(path, NULL);
  if (!absolute) return NC_ENOMEM;
  const int status = nc_open(absolute, NC_NOWRITE, out_id);
  free(absolute);
  return status;
}

static int open_locked(const char *path, const void *memory, size_t byte_count, np_netcdf_file *file) {
  const int status = memory ? nc_open_mem(path, NC_NOWRITE, byte_count, (void *)(uintptr_t)memory, &file->id)
                            : open_path(path, &file->id);
  if (status) return status;
  const int counted = nc_inq_nvars(file->id, &file->variable_count);
  if (counted) nc_close(file->id);
  return counted;
}

static neph_result open_file(const char *path, const void *memory, size_t byte_count, np_netcdf_file **out_file,
                             np_netcdf_error *error) {
  np_netcdf_file *file = calloc(1, sizeof *file);
  *out_file = NULL;
  if (!file) return fail(error, "cannot be opened", NC_ENOMEM);
  lock_library();
  const int status = open_locked(path, memory, byte_count, file);
  unlock_library();
  if (status) {
    free(file);
    return fail(error, "is not a NetCDF file that can be read, or is damaged", status);
  }
  *out_file = file;
  return NEPH_OK;
}

static void close_file(np_netcdf_file *file) {
  if (!file) return;
  lock_library();
  nc_close(file->id);
  unlock_library();
  free(file);
}

/* ---- Variables ---- */

static int count_variables(const np_netcdf_file *file) { return file->variable_count; }

static int describe_locked(const np_netcdf_file *file, int variable, np_netcdf_variable *out) {
  int dimensions[NC_MAX_VAR_DIMS], rank;
  nc_type type;
  int status = nc_inq_var(file->id, variable, out->name, &type, &rank, dimensions, NULL);
  if (status) return status;
  np_text_clean(out->name);
  out->is_number = type != NC_CHAR && type >= NC_BYTE && type <= NC_UINT64;
  out->rank = rank <= NP_NETCDF_RANK_MAX ? rank : -1;
  for (int d = 0; d < out->rank && !status; d++) {
    out->dimensions[d] = dimensions[d];
    status = nc_inq_dimlen(file->id, dimensions[d], &out->sizes[d]);
  }
  return status;
}

static neph_result describe(const np_netcdf_file *file, int variable, np_netcdf_variable *out, np_netcdf_error *error) {
  memset(out, 0, sizeof *out);
  lock_library();
  const int status = describe_locked(file, variable, out);
  unlock_library();
  return status ? fail(error, "a variable cannot be read", status) : NEPH_OK;
}

static neph_result name_dimension(const np_netcdf_file *file, int dimension, char out_name[NP_NETCDF_NAME_BYTES],
                                  np_netcdf_error *error) {
  memset(out_name, 0, NP_NETCDF_NAME_BYTES);
  lock_library();
  const int status = nc_inq_dimname(file->id, dimension, out_name);
  np_text_clean(out_name);
  unlock_library();
  return status ? fail(error, "a dimension cannot be read", status) : NEPH_OK;
}

static neph_result read_values(const np_netcdf_file *file, int variable, const size_t *starts, const size_t *counts,
                               double *out_values, np_netcdf_error *error) {
  lock_library();
  const int status = nc_get_vara_double(file->id, variable, starts, counts, out_values);
  unlock_library();
  return status ? fail(error, "values cannot be read", status) : NEPH_OK;
}

/* ---- Attributes ---- */

enum { ATTRIBUTE_BYTES_MAX = 1 << 16 };

static int copy_string(int id, int variable, const char *name, size_t length, char *out, size_t capacity) {
  char *strings[1] = {NULL};
  if (length != 1 || nc_get_att_string(id, variable, name, strings)) return 0;
  np_text_copy_short(out, capacity, strings[0] ? strings[0] : "");
  nc_free_string(1, strings);
  return 1;
}

static int copy_characters(int id, int variable, const char *name, size_t length, char *out, size_t capacity) {
  char *text = length <= ATTRIBUTE_BYTES_MAX ? calloc(length + 1, 1) : NULL;
  const int is_read = text && !nc_get_att_text(id, variable, name, text);
  if (is_read) np_text_copy_short(out, capacity, text);
  free(text);
  return is_read;
}

static int read_text_locked(int id, int variable, const char *name, char *out, size_t capacity) {
  nc_type type;
  size_t length;
  if (nc_inq_att(id, variable, name, &type, &length)) return 0;
  if (type == NC_STRING) return copy_string(id, variable, name, length, out, capacity);
  return type == NC_CHAR && copy_characters(id, variable, name, length, out, capacity);
}

static int read_text(const np_netcdf_file *file, int variable, const char *name, char *out, size_t capacity) {
  out[0] = 0;
  lock_library();
  const int is_found = read_text_locked(file->id, variable < 0 ? NC_GLOBAL : variable, name, out, capacity);
  unlock_library();
  return is_found;
}

static int read_number_locked(int id, int variable, const char *name, double *out_number) {
  nc_type type;
  size_t length;
  if (nc_inq_att(id, variable, name, &type, &length) || length < 1 || length > ATTRIBUTE_BYTES_MAX) return 0;
  if (type == NC_CHAR || type < NC_BYTE || type > NC_UINT64) return 0;
  double *numbers = calloc(length, sizeof *numbers);
  const int is_read = numbers && !nc_get_att_double(id, variable, name, numbers);
  if (is_read) *out_number = numbers[0];
  free(numbers);
  return is_read;
}

static int read_number(const np_netcdf_file *file, int variable, const char *name, double *out_number) {
  *out_number = 0.0;
  lock_library();
  const int is_found = read_number_locked(file->id, variable < 0 ? NC_GLOBAL : variable, name, out_number);
  unlock_library();
  return is_found;
}

const np_netcdf_module *nephos_netcdf_module(void) {
  static const np_netcdf_module module = {.version = NP_NETCDF_MODULE_VERSION,
                                          .open = open_file,
                                          .close = close_file,
                                          .count = count_variables,
                                          .describe = describe,
                                          .name_dimension = name_dimension,
                                          .read_text = read_text,
                                          .read_number = read_number,
                                          .read = read_values};
  return &module;
}
