/* SPDX-License-Identifier: Apache-2.0
 *
 * Volume sources for tests of the loader, written in C99 with the public header alone. Built as several
 * shared objects: plainly it is a source `test` whose parameter `act` chooses what it does wrong; the
 * definitions below make descriptions that the host must refuse before it calls anything.
 */
#include <scrim/volume/scrim_source.h>

#include <math.h>
#include <string.h>

static const double kUnit[16] = {2, 0, 0, 10, 0, 2, 0, 20, 0, 0, 2, 30, 0, 0, 0, 1};

static int act(const scrim_host* host, int grid, const char* what, float value) {
    float block[512] = {0};
    int32_t origin[3] = {-8, 0, 8};
    int i;
    for (i = 0; i < 8; ++i) block[i] = value;
    if (strcmp(what, "nan") == 0) {
        block[0] = (float)NAN;
        block[1] = -1;
    }
    if (strcmp(what, "misplaced block") == 0) origin[1] = 4;
    if (host->add_block(host, grid, origin, block) != 0) return 2;
    origin[0] = 0;
    origin[1] = 0;
    if (host->add_tile(host, grid, origin, strcmp(what, "odd tile") == 0 ? 24 : 8, value) != 0) return 3;
    if (strcmp(what, "block twice") == 0) {
        origin[0] = -8;
        return host->add_block(host, grid, origin, block);
    }
    if (strcmp(what, "overlap") == 0) return host->add_block(host, grid, origin, block);
    if (strcmp(what, "wrong grid") == 0) return host->add_block(host, 7, origin, block);
    if (strcmp(what, "grid twice") == 0) return host->add_grid(host, "density", kUnit) < 0 ? 4 : 0;
    return 0;
}

static int generate(const scrim_host* host, const scrim_value* values) {
    static const double flat[16] = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const char* what = values[0].text;
    int grid;
    if (strcmp(what, "fail") == 0) {
        host->fail(host, "the weather is bad");
        return 5;
    }
    if (strcmp(what, "silent") == 0) return 6;
    if (strcmp(what, "nothing") == 0) return 0;
    if (strcmp(what, "warn") == 0) host->warn(host, "it may rain");
    grid = host->add_grid(host, "density", strcmp(what, "flat") == 0 ? flat : kUnit);
    if (grid < 0) return 1;
    if (host->progress(host, 0.5) != 0) return 7;
    return act(host, grid, what, values[4].boolean ? (float)values[1].integer : (float)values[2].number[1]);
}

static const scrim_parameter kParameters[] = {
    {"act", SCRIM_STRING, "well", 0, 0,
     "well|fail|silent|nothing|warn|flat|nan|misplaced block|odd tile|block twice|overlap|wrong grid|grid "
     "twice",
     "what to do"},
    {"count", SCRIM_INTEGER, "3", 1, 9, 0, "value if whole"},
    {"place", SCRIM_VEC3, "0, 0.5, 0", -1, 1, 0, "value if not whole: its y"},
#ifdef SCRIM_TEST_BAD_DEFAULT
    {"width", SCRIM_NUMBER, "wide", 0, 0, 0, ""},
#else
    {"width", SCRIM_NUMBER, "1e3", 0, 0, 0, "any number"},
#endif
    {"whole", SCRIM_BOOL, "true", 0, 0, 0, "which value to use"},
};

#ifdef SCRIM_TEST_NAME
static const char kName[] = SCRIM_TEST_NAME;
#else
static const char kName[] = "test";
#endif

static const scrim_source kSource = {
#ifdef SCRIM_TEST_WRONG_ABI
    SCRIM_SOURCE_ABI + 1,
#else
    SCRIM_SOURCE_ABI,
#endif
#ifdef SCRIM_TEST_SHORT
    8,
#else
    sizeof(scrim_source),
#endif
    kName,
    "does as it is told",
    kParameters,
    sizeof kParameters / sizeof kParameters[0],
    sizeof(scrim_parameter),
    generate};

#ifdef SCRIM_TEST_NO_SYMBOL
SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v0(void);
SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v0(void) {
    return &kSource;
}
#else
SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) {
    return &kSource;
}
#endif
