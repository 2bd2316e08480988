/* SPDX-License-Identifier: Apache-2.0 */
/* C++'s operator new in place of its own, for all of a program that links operator_new.c before the C++ library. */
#ifndef TEST_OPERATOR_NEW_H
#define TEST_OPERATOR_NEW_H

#define TEST_ALLOCATIONS_ALL 1000000000

/* Limits operator new to `count` further allocations; then it throws. */
__attribute__((visibility("default"))) void test_operator_new_limit(int count);

#endif
