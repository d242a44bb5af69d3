#pragma once
// Non-template definitions are compiled in each program that includes the headers, or once in the
// compiled part of the package (the target talus::compiled, which defines TALUS_COMPILED).
#ifdef TALUS_COMPILED
#define TALUS_INLINE
#else
#define TALUS_INLINE inline
#endif
// Definitions that need MPI are compiled in each program, or once in the target
// talus::compiled_mpi, which defines TALUS_COMPILED_MPI.
#ifdef TALUS_COMPILED_MPI
#define TALUS_MPI_INLINE
#else
#define TALUS_MPI_INLINE inline
#endif
