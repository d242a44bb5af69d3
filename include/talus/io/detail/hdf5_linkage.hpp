#pragma once
// As core/linkage.hpp, for definitions that need HDF5: each program compiles them, or the target
// talus::compiled_hdf5, which defines TALUS_COMPILED_HDF5, does once.
#ifdef TALUS_COMPILED_HDF5
#define TALUS_HDF5_INLINE
#else
#define TALUS_HDF5_INLINE inline
#endif
