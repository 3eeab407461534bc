// Start of PETSc. The libraries that are linked to it include this: the program itself is not linked to it.
#pragma once

#include <petscsys.h>

namespace skein {

/// Starts PETSc for this process, unless it is started; `began`: this call did. It takes neither signals nor options
/// from files, and PETSC_COMM_WORLD is this rank alone, so that the start needs no other rank.
inline PetscErrorCode start_petsc(bool& began) {
    PetscBool started = PETSC_FALSE;
    PetscFunctionBegin;
    began = false;
    PetscCall(PetscInitialized(&started));
    if (started) PetscFunctionReturn(0);
    PETSC_COMM_WORLD = MPI_COMM_SELF;
    static char name[] = "skein", signals[] = "-no_signal_handler", file[] = "-skip_petscrc";
    static char* arguments[] = {name, signals, file, nullptr};
    int count = 3;
    char** all = arguments;
    PetscCall(PetscInitialize(&count, &all, nullptr, nullptr));
    began = true;
    PetscFunctionReturn(0);
}

} // namespace skein
