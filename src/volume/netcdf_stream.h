/* SPDX-License-Identifier: Apache-2.0 */
/* The program nephos_netcdf_reader, which reads one NetCDF file of HDF5, and the stream between it and the library:
 * records of this machine. Its first argument is the file's path. To its input come requests, of which the first opens
 * the file, and to its output go replies, one for each. It ends with its input.
 */
#ifndef NP_VOLUME_NETCDF_STREAM_H
#define NP_VOLUME_NETCDF_STREAM_H

#include "volume/netcdf_table.h"

#define NP_NETCDF_PROGRAM_FILE "nephos_netcdf_reader"
#define NP_NETCDF_STREAM_VERSION 1u

/* Limits of the program: memory for every file, a factor on its bytes, and CPU time for each request. */
#define NP_NETCDF_ROOM_BYTES UINT64_C(500000000)
#define NP_NETCDF_ROOM_FACTOR 4u
#define NP_NETCDF_TIME_S 20u
#define NP_NETCDF_TIME_BYTES_PER_S 10000000u

/* Seconds that the library waits for the beginning of an answer. */
#define NP_NETCDF_WAIT_S 300

typedef enum np_netcdf_question {
  NP_NETCDF_OPEN, /* `byte_count` bytes of the file follow, 0: it is read from its path; answered by a count */
  NP_NETCDF_DESCRIBE,
  NP_NETCDF_NAME_DIMENSION,
  NP_NETCDF_READ_TEXT, /* answered by whether there is one */
  NP_NETCDF_READ_NUMBER,
  NP_NETCDF_READ
} np_netcdf_question;

enum { NP_NETCDF_TEXT_BYTES = 1024 }; /* text of an attribute, with its final zero */

typedef struct np_netcdf_request {
  uint32_t version; /* NP_NETCDF_STREAM_VERSION */
  np_netcdf_question question;
  int number;                      /* that of the variable or of the dimension */
  size_t byte_count;               /* bytes of the file, or of the answer */
  char name[NP_NETCDF_NAME_BYTES]; /* name of an attribute */
  size_t starts[NP_NETCDF_RANK_MAX], counts[NP_NETCDF_RANK_MAX];
} np_netcdf_request;

/* Answer to a request; its `byte_count` bytes follow where `error.result` is NEPH_OK. */
typedef struct np_netcdf_reply {
  np_netcdf_error error;
  int value; /* a count, or whether there is an attribute */
  size_t byte_count;
} np_netcdf_reply;

#endif
