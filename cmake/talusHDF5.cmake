# talus_find_hdf5(<out> <parallel>): libraries and include folders of HDF5's C interface, as an imported
# target whose name goes to <out>; empty if there is none. With <parallel> true that for MPI is taken
# where it is installed, else the serial one. (CMake's own FindHDF5 goes by compiler wrappers, of which
# Debian has one for each, and takes the wrong one where both are installed.)
function(talus_find_hdf5 out parallel)
  set(${out} "" PARENT_SCOPE)
  set(kinds serial)
  if(parallel)
    set(kinds openmpi mpich serial)
  endif()
  foreach(kind IN LISTS kinds)
    find_path(TALUS_HDF5_${kind}_INCLUDE hdf5.h PATH_SUFFIXES hdf5/${kind} NO_CACHE)
    find_library(TALUS_HDF5_${kind}_LIBRARY NAMES hdf5_${kind} hdf5 PATH_SUFFIXES hdf5/${kind}
                                                                              NO_CACHE)
    if(NOT TALUS_HDF5_${kind}_INCLUDE OR NOT TALUS_HDF5_${kind}_LIBRARY)
      continue()
    endif()
    # A folder that belongs to no kind, as of an installation by hand, may hold either.
    file(STRINGS ${TALUS_HDF5_${kind}_INCLUDE}/H5pubconf.h for_mpi
         REGEX "define +H5_HAVE_PARALLEL +1")
    if(for_mpi AND NOT parallel)
      continue()
    endif()
    set(mpi)
    if(for_mpi)
      set(mpi talus::mpi)  # its header is included by HDF5's
    endif()
    set(target talus::hdf5_${kind})
    if(NOT TARGET ${target})
      add_library(${target} INTERFACE IMPORTED)
      set_target_properties(
        ${target} PROPERTIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${TALUS_HDF5_${kind}_INCLUDE}
                             INTERFACE_INCLUDE_DIRECTORIES ${TALUS_HDF5_${kind}_INCLUDE}
                             INTERFACE_LINK_LIBRARIES "${TALUS_HDF5_${kind}_LIBRARY};${mpi}")
    endif()
    set(${out} ${target} PARENT_SCOPE)
    return()
  endforeach()
endfunction()
