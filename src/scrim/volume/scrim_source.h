/* SPDX-License-Identifier: Apache-2.0
 *
 * Volume sources for Scrim: shared objects that make volumes. A source needs nothing but this header, which is
 * plain C99, so that a source can be written in any language and with any compiler.
 *
 * A source is a shared object called `scrim_source_NAME.so` that exports one function, `scrim_source_v1`,
 * which returns a pointer to a constant description of the source (struct scrim_source). Scrim looks for it
 * in the folders of the environment variable SCRIM_PLUGIN_PATH (separated by colons), then beside itself in
 * lib/scrim/sources. The shortest complete source:
 *
 *     #include <scrim/volume/scrim_source.h>
 *
 *     static const scrim_parameter parameters[] = {
 *         {"density", SCRIM_NUMBER, "1", 0, 100, 0, "value of every voxel"},
 *     };
 *
 *     static int generate(const scrim_host* host, const scrim_value* values) {
 *         static const double world_from_index[16] = {1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1};
 *         const int32_t origin[3] = {0, 0, 0};
 *         int grid = host->add_grid(host, "density", world_from_index);
 *         if (grid < 0) return 1;
 *         return host->add_tile(host, grid, origin, 8, (float)values[0].number[0]);
 *     }
 *
 *     static const scrim_source source = {SCRIM_SOURCE_ABI, sizeof(scrim_source), "box", "a box of fog",
 *                                         parameters, 1, sizeof(scrim_parameter), generate};
 *
 *     SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) { return &source; }
 *
 *     cc -shared -fPIC -o scrim_source_box.so box.c
 *
 * A longer one, with progress and errors, is examples/source/ball.c.
 *
 * Rules. Nothing throws and nothing exits across this boundary, in either direction. An exception that leaves
 * `generate` is an error if the run-time can carry it to the host, and otherwise ends the program; therefore
 * sources in C++ should catch everything and call `fail`. The host's functions may be called only during
 * `generate` and only from the thread that called it; apart from that a source may use its own threads. The same
 * parameters must give the same grids, whatever the number of threads. All text is UTF-8 and ends with a zero
 * byte; the host copies all arguments before a function returns.
 *
 * Files. An untrusted file may crash its reader or take it over. If loading is guarded, as it always is in Scrim's
 * program, a source with a parameter called `file` therefore runs in a process that can do little else. There the
 * source can open that file and one other file of the same folder or below, for reading, with any library (if it fails
 * because it lacks the other file, it is run again with it), and can compute with any number of threads. All other
 * files seem not to exist, so tables and the like should be read when the source is loaded. Starting a process
 * fails; writing a file or making a socket ends the process. A crash becomes an error. A source that needs more must
 * give its parameter another name.
 *
 * If `file` names a folder, or one DICOM file (.dcm, .dicom) of a folder, then there the source finds under that name
 * one file that holds the folder's DICOM files: the line "scrim folder", and for each of them a line "SIZE NAME",
 * sorted by name, followed by its SIZE bytes. Elsewhere it finds the folder itself. A file that is not DICOM, although
 * its name says so, is found as it is. A folder without DICOM files is passed with its TIFF files in the same way. So
 * is a name with a '*', which stands for any characters, where no file has it: one file that holds the TIFF files of
 * such names, and perhaps others.
 */
#ifndef SCRIM_SOURCE_H
#define SCRIM_SOURCE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The version of everything below. Structures grow at their end only; a change that would break existing sources
 * raises the version and the number in the symbol's name. */
#define SCRIM_SOURCE_ABI 1u

#define SCRIM_SOURCE_EXPORT __attribute__((visibility("default")))

/* The types of parameters. They are stored in an int32_t, whose size, unlike that of an enum, is the same for every
 * compiler. */
#define SCRIM_NUMBER 0  /* a finite double */
#define SCRIM_INTEGER 1 /* an int64_t */
#define SCRIM_VEC3 2    /* three finite doubles, as text "x, y, z" */
#define SCRIM_STRING 3  /* text, or one of some choices; one called "file" is a path, relative to the scene */
#define SCRIM_BOOL 4    /* as text, "true" or "false" */

/* The description of one parameter. */
typedef struct scrim_parameter {
    const char* name;         /* lower case and underscores, unique within the source */
    int32_t type;             /* SCRIM_NUMBER, ... */
    const char* default_text; /* as a user would write it; must itself be valid */
    double minimum, maximum;  /* inclusive, for numbers, integers and each part of a vec3; both 0: no limits */
    const char* choices;      /* for strings: "plume|ball|slab"; NULL: any text */
    const char* help;         /* one line: meaning and unit */
} scrim_parameter;

/* The value of one parameter, which the host has checked against its description. Only the member for its type
 * is valid. */
typedef struct scrim_value {
    int32_t type;     /* as described */
    int32_t boolean;  /* SCRIM_BOOL: 0 or 1 */
    int64_t integer;  /* SCRIM_INTEGER */
    double number[3]; /* SCRIM_NUMBER: the first; SCRIM_VEC3: x, y, z */
    const char* text; /* SCRIM_STRING; valid until `generate` returns */
} scrim_value;

/* The functions of the host. Those that return int return 0 (or a grid's number) on success and a negative
 * number on an error, which the host has already recorded: the source should then clean up and return that
 * number. */
typedef struct scrim_host scrim_host;
struct scrim_host {
    uint32_t abi_version; /* SCRIM_SOURCE_ABI of the host */
    uint32_t struct_size; /* sizeof(scrim_host) of the host */
    void* context;        /* the host's own */

    /* Starts a grid and returns its number. `name` is unique among the source's grids; "density" is what
     * users expect. `world_from_index`: 4 x 4, row by row (the translation is [3], [7], [11]), affine and
     * invertible; maps index space, where voxel centres are at integers, to world space. */
    int (*add_grid)(const scrim_host* host, const char* name, const double world_from_index[16]);

    /* Adds the voxels origin .. origin + 7 of a grid. `origin`: multiples of 8, each block once. `values`:
     * the one of voxel origin + (x, y, z) is at (x * 8 + y) * 8 + z; 0 means empty, and values that are
     * negative, infinite or NaN count as 0, with a message to the user. Blocks that contain only 0 need not be
     * added. */
    int (*add_block)(const scrim_host* host, int grid, const int32_t origin[3], const float values[512]);

    /* Adds a cube of constant value: voxels origin .. origin + edge - 1. `edge`: 8 times a power of two;
     * `origin`: multiples of `edge`. Blocks and tiles must not overlap. */
    int (*add_tile)(const scrim_host* host, int grid, const int32_t origin[3], int32_t edge, float value);

    /* Shows the user a message of one line. */
    void (*warn)(const scrim_host* host, const char* text);

    /* Reports the finished fraction, in [0, 1]. If the result is not 0, the user wants to stop: clean up and
     * return that number. */
    int (*progress)(const scrim_host* host, double done);

    /* States, in one line, why `generate` is about to return something other than 0. The first text counts. */
    void (*fail)(const scrim_host* host, const char* text);

    /* 1: this process runs only this call, confined as described above. Older hosts lack this member: see
     * `struct_size`. */
    uint32_t alone;
};

/* The description of a source. */
typedef struct scrim_source {
    uint32_t abi_version;              /* SCRIM_SOURCE_ABI */
    uint32_t struct_size;              /* sizeof(scrim_source) */
    const char* name;                  /* NAME in the file's name: letters, digits, '_' and '-' */
    const char* description;           /* one line */
    const scrim_parameter* parameters; /* may be NULL where there are none */
    uint32_t parameter_count;
    uint32_t parameter_size; /* sizeof(scrim_parameter) */

    /* Makes the grids. `values`: one for each parameter, in the order described. Returns 0, or any other
     * number after `fail`. Must keep no state from call to call. */
    int (*generate)(const scrim_host* host, const scrim_value* values);
} scrim_source;

/* The function that the shared object exports, and the name that the host looks for. */
typedef const scrim_source* (*scrim_source_function)(void);
SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void);
#define SCRIM_SOURCE_SYMBOL "scrim_source_v1"

#ifdef __cplusplus
}
#endif

#endif /* SCRIM_SOURCE_H */
