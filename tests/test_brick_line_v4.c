/* SPDX-License-Identifier: Apache-2.0 */
#include "test_brick_line.c"
