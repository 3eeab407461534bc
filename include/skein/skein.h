/* Skein for programs in other languages: the interface of skein/run.hpp as plain C functions of the library
 * libskein.so. python/skein/simulation.py is that of Python.
 *
 * Functions that may fail return -1 or a null pointer; skein_error() then returns the message of the program. All
 * numbers are SI, lab frame. All ranks of MPI_COMM_WORLD call everything alike, and one thread at a time; MPI is
 * started where it has not been. */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define SKEIN_API __attribute__((visibility("default")))
#else
#define SKEIN_API
#endif

typedef struct skein_run skein_run;

/* Message of the last call that failed on this thread, valid until the next. */
SKEIN_API const char* skein_error(void);
SKEIN_API int skein_rank(void);
SKEIN_API int skein_ranks(void);

/* A run of the scene in a file, or in `toml` where that is not null (`file` then names it in messages), with overrides
 * "key=value". It writes nothing. threads, lanes: 0 for what this machine has. */
SKEIN_API skein_run* skein_open(const char* file, const char* toml, const char* const* overrides, int override_count,
                                int threads, int lanes);
SKEIN_API void skein_close(skein_run* run);

/* Plan as `skein plan` prints it, valid until the run is closed. */
SKEIN_API const char* skein_plan(skein_run* run);
SKEIN_API double skein_dt(skein_run* run);
SKEIN_API double skein_time(skein_run* run);
SKEIN_API int64_t skein_step(skein_run* run);
/* Number of steps of the whole scene. */
SKEIN_API int64_t skein_steps(skein_run* run);
/* Makes steps until `until` have been made in all, at most those of the scene. */
SKEIN_API int skein_advance(skein_run* run, int64_t until);
/* Digest of 16 hexadecimal digits, valid until the next call. */
SKEIN_API const char* skein_digest(skein_run* run);

/* Columns of observables.csv: their names, separated by commas, and their present values. */
SKEIN_API const char* skein_observable_names(skein_run* run);
SKEIN_API int skein_observables(skein_run* run, double* out, int count);
/* Table of all contacts, comma-separated, valid until the next call. */
SKEIN_API const char* skein_contacts(skein_run* run);
/* Makes a [[table]] of the scene go linearly from its last value now to `value` at `until`, and stay there. */
SKEIN_API int skein_drive(skein_run* run, const char* table, double until, double value);
/* Puts `count` points in the place of a table's own: x rising, and values. */
SKEIN_API int skein_set_table(skein_run* run, const char* table, const double* at, const double* value, int64_t count);
/* Returns rods of a group, by number, to their start while others go on. If rods may touch on several ranks, all ranks
   call it together, and each may name any rods. In other scenes a rank returns those of the named rods that it owns. */
SKEIN_API int skein_restart(skein_run* run, int group, const int64_t* rods, int64_t count);
/* Number of a table's points, of which the first `count` are copied. */
SKEIN_API int64_t skein_table(skein_run* run, const char* table, double* at, double* value, int64_t count);

/* 1 where no more steps are made: the scene has come to its end. */
SKEIN_API int skein_finished(skein_run* run);
/* Name of the [[stage]] under way, valid until the next call; empty in scenes without. The second ends it now. */
SKEIN_API const char* skein_stage(skein_run* run);
SKEIN_API int skein_next_stage(skein_run* run);

SKEIN_API int skein_group_count(skein_run* run);
SKEIN_API const char* skein_group_name(skein_run* run, int group);
/* Rods of the group on this rank, nodes and elements of each. */
SKEIN_API int64_t skein_group_rods(skein_run* run, int group);
SKEIN_API int skein_group_nodes(skein_run* run, int group);
SKEIN_API int skein_group_elements(skein_run* run, int group);
/* Numbers of these rods in the group, rising. */
SKEIN_API int skein_numbers(skein_run* run, int group, int64_t* out);
/* Values of these rods: quantity 0 position [rods, nodes, 3], 1 velocity [rods, nodes, 3], 2 directors [rods, elements,
 * 3, 3], 3 spin [rods, elements, 3] along the directors, at the time of the run; count: numbers that `out` has room
 * for. */
SKEIN_API int skein_read(skein_run* run, int group, int quantity, double* out, int64_t count);

#ifdef __cplusplus
}
#endif
