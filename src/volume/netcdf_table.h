/* SPDX-License-Identifier: Apache-2.0 */
/* The door to libnetcdf: a module of C functions, loaded on first need. */
#ifndef NP_VOLUME_NETCDF_TABLE_H
#define NP_VOLUME_NETCDF_TABLE_H

#include <stddef.h>
#include <stdint.h>

#include <nephos/context.h>

#define NP_NETCDF_MODULE_VERSION 1u

/* Name of the module's file and of the function in it. */
#define NP_NETCDF_MODULE_FILE "nephos_netcdf.so"
#define NP_NETCDF_MODULE_FUNCTION "nephos_netcdf_module"

enum { NP_NETCDF_RANK_MAX = 6, NP_NETCDF_NAME_BYTES = 257 };

typedef struct np_netcdf_file np_netcdf_file;

/* One message for the caller to report; the module never logs by itself. */
typedef struct np_netcdf_error {
  neph_result result;
  char message[480];
} np_netcdf_error;

typedef struct np_netcdf_variable {
  char name[NP_NETCDF_NAME_BYTES];
  int is_number; /* integers and floats; false: characters, strings and types of the file's own */
  int rank;      /* -1: more than NP_NETCDF_RANK_MAX */
  int dimensions[NP_NETCDF_RANK_MAX];
  size_t sizes[NP_NETCDF_RANK_MAX];
} np_netcdf_variable;

/* Functions that can fail return a neph_result, the same as in `error`. Variables count from 0; -1 is the file itself,
 * where attributes are read. */
typedef struct np_netcdf_module {
  uint32_t version; /* NP_NETCDF_MODULE_VERSION, checked before anything else is used */

  /* Opens a file, or, where `memory` is not NULL, its bytes, which must stay until it is closed. */
  neph_result (*open)(const char *path, const void *memory, size_t byte_count, np_netcdf_file **out_file,
                      np_netcdf_error *error);
  void (*close)(np_netcdf_file *file); /* NULL is allowed */
  int (*count)(const np_netcdf_file *file);
  neph_result (*describe)(const np_netcdf_file *file, int variable, np_netcdf_variable *out_variable,
                          np_netcdf_error *error);
  neph_result (*name_dimension)(const np_netcdf_file *file, int dimension, char out_name[NP_NETCDF_NAME_BYTES],
                                np_netcdf_error *error);

  /* Reads an attribute of text, cut to `capacity` with its final zero; returns whether there is one. */
  int (*read_text)(const np_netcdf_file *file, int variable, const char *name, char *out_text, size_t capacity);

  /* Reads the first number of an attribute; returns whether there is one. */
  int (*read_number)(const np_netcdf_file *file, int variable, const char *name, double *out_number);

  /* Reads a box of a variable's stored numbers, the last dimension fastest. */
  neph_result (*read)(const np_netcdf_file *file, int variable, const size_t *starts, const size_t *counts,
                      double *out_values, np_netcdf_error *error);
} np_netcdf_module;

/* The only exported symbol of nephos_netcdf.so. */
NEPH_API const np_netcdf_module *nephos_netcdf_module(void);

#endif
