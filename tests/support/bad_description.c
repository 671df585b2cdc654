/* SPDX-License-Identifier: Apache-2.0
 *
 * Volume sources whose description is wrong in one way each, chosen by a definition. Only `larger` is right: its
 * structures are longer than the host's, as those of a later version of the interface would be.
 */
#include <scrim/volume/scrim_source.h>

#include <stddef.h>

static int generate(const scrim_host* host, const scrim_value* values) {
    static const double unit[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const int32_t origin[3] = {0, 0, 0};
    const int grid = host->add_grid(host, "density", unit);
    if (grid < 0) return grid;
    return host->add_tile(host, grid, origin, 8, (float)values[1].number[0]);
}

/* A description of a parameter with something new at its end. */
typedef struct larger_parameter {
    scrim_parameter known;
    double news[3];
} larger_parameter;

#if defined(SCRIM_TEST_UNNAMED_PARAMETER)
#define FIRST_NAME NULL
#else
#define FIRST_NAME "first"
#endif
#if defined(SCRIM_TEST_UNKNOWN_TYPE)
#define FIRST_TYPE 17
#else
#define FIRST_TYPE SCRIM_NUMBER
#endif
#if defined(SCRIM_TEST_NO_DEFAULT)
#define FIRST_DEFAULT NULL
#else
#define FIRST_DEFAULT "1"
#endif
#if defined(SCRIM_TEST_EMPTY_RANGE)
#define FIRST_MINIMUM 3
#else
#define FIRST_MINIMUM 0
#endif
#if defined(SCRIM_TEST_PARAMETER_TWICE)
#define SECOND_NAME "first"
#else
#define SECOND_NAME "second"
#endif

static const larger_parameter kParameters[] = {
    {{FIRST_NAME, FIRST_TYPE, FIRST_DEFAULT, FIRST_MINIMUM, 2, NULL, NULL}, {7, 7, 7}},
    {{SECOND_NAME, SCRIM_NUMBER, "0.5", 0, 0, NULL, "value"}, {8, 8, 8}},
};

typedef struct larger_source {
    scrim_source known;
    const void* news[4];
} larger_source;

static const larger_source kSource = {{SCRIM_SOURCE_ABI, sizeof(larger_source), SCRIM_TEST_NAME, NULL,
#if defined(SCRIM_TEST_NO_PARAMETERS)
                                       NULL,
#else
                                       &kParameters[0].known,
#endif
#if defined(SCRIM_TEST_MANY_PARAMETERS)
                                       1000000,
#else
                                       2,
#endif
#if defined(SCRIM_TEST_SMALL_PARAMETERS)
                                       sizeof(scrim_parameter) - 8,
#elif defined(SCRIM_TEST_ODD_PARAMETERS)
                                       sizeof(larger_parameter) + 1,
#else
     sizeof(larger_parameter),
#endif
#if defined(SCRIM_TEST_NO_GENERATE)
                                       NULL
#else
                                       generate
#endif
                                      },
                                      {NULL, NULL, NULL, NULL}};

SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) {
#if defined(SCRIM_TEST_NOTHING)
    return (void)generate, (void)kSource, NULL;
#else
    (void)generate;
    return &kSource.known;
#endif
}
