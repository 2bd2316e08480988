/* SPDX-License-Identifier: Apache-2.0 */
/* Contexts with a cache on disk, or with messages for debugging. */
#ifndef NP_TEST_CONTEXTS_H
#define NP_TEST_CONTEXTS_H

#include "test_support.h"

/* A context as of test_context_create with messages for debugging: which stages are built and reused, and predictions,
 * for which every render tries its clouds. */
neph_context *test_context_create_verbose(unsigned thread_count, test_log *log);

/* A context as of test_context_create with a cache on disk, which all such contexts of the program share: each result
 * of a stage is computed once. Pictures that differ only in samples, layers or views are compared so; tests of stages
 * and of their bits are not. test_set_up_cached uses it. */
neph_context *test_context_create_cached(unsigned thread_count, test_log *log);

#endif
