/* What tests in C claim: failures counts the claims that are not so. */
#ifndef ROADGEN_TESTS_COMMON_C_EXPECT_H
#define ROADGEN_TESTS_COMMON_C_EXPECT_H

#include <stdio.h>

#include "roadgen/capi/roadgen.h"

static int failures = 0;
#define EXPECT(claim)                                                                                \
  do {                                                                                               \
    if (!(claim)) {                                                                                  \
      fprintf(stderr, "%s:%d: not so: %s (%s)\n", __FILE__, __LINE__, #claim, roadgen_last_error()); \
      ++failures;                                                                                    \
    }                                                                                                \
  } while (0)

#endif
