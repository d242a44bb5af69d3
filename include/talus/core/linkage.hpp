#pragma once
// Non-template definitions are compiled in each program that includes the headers, or once in the
// compiled part of the package (the target talus::compiled, which defines TALUS_COMPILED).
#ifdef TALUS_COMPILED
#define TALUS_INLINE
#else
#define TALUS_INLINE inline
#endif
