/* SPDX-License-Identifier: Apache-2.0
 *
 * A volume source of one's own: a ball whose density falls from its middle to its surface. It needs the installed
 * header and a C compiler, nothing else of Scrim; PREFIX is where Scrim is installed:
 *
 *     cc -std=c99 -shared -fPIC -fvisibility=hidden -I PREFIX/include -o scrim_source_ball.so ball.c -lm
 *     SCRIM_PLUGIN_PATH=. PREFIX/bin/scrim make ball radius=2 -o ball.vdb
 *     PREFIX/bin/scrim info ball.vdb
 *
 * or, in a scene, with SCRIM_PLUGIN_PATH set:
 *
 *     [[volume]]
 *     source = "ball"
 *     parameters = { radius = 2, density = 5 }
 *
 * The file's name decides what the source is called. scrim_source.h says what a source may and must do.
 */
#include <scrim/volume/scrim_source.h>

#include <math.h>
#include <stddef.h>

/* Described to the user by `scrim make ball --help-source`. The host parses and checks what is given; `generate` gets
 * values in this order, and only such as fit their description. */
enum { RADIUS, DENSITY, RESOLUTION, PARAMETERS };
static const scrim_parameter parameters[PARAMETERS] = {
    {"radius", SCRIM_NUMBER, "1", 1e-6, 1e6, NULL, "radius, in world units"},
    {"density", SCRIM_NUMBER, "1", 0, 1e6, NULL, "value in the middle"},
    {"resolution", SCRIM_INTEGER, "64", 8, 1024, NULL, "voxels across"},
};

/* Fills the block whose first voxel is `origin`; says whether it holds anything. */
static int fill(const int32_t origin[3], double voxel, double radius, double density, float block[512]) {
    int x, y, z, any = 0;
    for (x = 0; x < 8; ++x)
        for (y = 0; y < 8; ++y)
            for (z = 0; z < 8; ++z) {
                /* Voxel i has its centre at (i + 0.5) voxel: see `world_from_index`. */
                const double px = (origin[0] + x + 0.5) * voxel, py = (origin[1] + y + 0.5) * voxel,
                             pz = (origin[2] + z + 0.5) * voxel;
                const double part = 1 - sqrt(px * px + py * py + pz * pz) / radius;
                block[(x * 8 + y) * 8 + z] = part > 0 ? (float)(density * part) : 0.0f;
                any = any || part > 0;
            }
    return any;
}

static int generate(const scrim_host* host, const scrim_value* values) {
    const double radius = values[RADIUS].number[0], density = values[DENSITY].number[0];
    const double voxel = 2 * radius / (double)values[RESOLUTION].integer, shift = 0.5 * voxel;
    const double world_from_index[16] = {voxel, 0, 0, shift, 0, voxel, 0, shift, 0, 0, voxel, shift, 0, 0, 0, 1};
    const int32_t half = (int32_t)((values[RESOLUTION].integer / 2 + 7) / 8 * 8);
    int32_t origin[3];
    float block[512];
    int error;

    const int grid = host->add_grid(host, "density", world_from_index);
    if (grid < 0) return grid; /* the host has noted why */
    for (origin[0] = -half; origin[0] < half; origin[0] += 8) {
        for (origin[1] = -half; origin[1] < half; origin[1] += 8)
            for (origin[2] = -half; origin[2] < half; origin[2] += 8) {
                if (!fill(origin, voxel, radius, density, block)) continue;
                if ((error = host->add_block(host, grid, origin, block)) != 0) return error;
            }
        /* The user may want to stop. */
        if ((error = host->progress(host, (double)(origin[0] + 8 + half) / (2 * half))) != 0) return error;
    }
    return 0;
}

static const scrim_source source = {SCRIM_SOURCE_ABI, sizeof(scrim_source),    "ball",  "a soft ball", parameters,
                                    PARAMETERS,       sizeof(scrim_parameter), generate};

SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) {
    return &source;
}
