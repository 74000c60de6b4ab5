# Eigen 3.4 and 5.x reject each other's version requests, so find any version and check it afterwards.
find_package(Eigen3 QUIET NO_MODULE)
if(NOT Eigen3_FOUND)
  message(FATAL_ERROR "Eigen 3.4 or newer is needed to build stiction and was not found. "
    "Debian and Ubuntu: apt install libeigen3-dev. Fedora: eigen3-devel. Homebrew and conda-forge: eigen.")
elseif(Eigen3_VERSION VERSION_LESS 3.4)
  message(FATAL_ERROR "Eigen 3.4 or newer is needed to build stiction, found ${Eigen3_VERSION} in ${Eigen3_DIR}")
endif()

# Only the tridiagonal solver of GSL is used, which all versions contain. Version 2.7 and newer ones are tested.
set(STICTION_GSL_OLDEST 2.5)
find_package(GSL QUIET)
if(NOT GSL_FOUND)
  message(FATAL_ERROR "The GNU Scientific Library ${STICTION_GSL_OLDEST} or newer is needed to build stiction and was not found. "
    "Debian and Ubuntu: apt install libgsl-dev. Fedora: gsl-devel. Homebrew and conda-forge: gsl.")
elseif(GSL_VERSION VERSION_LESS STICTION_GSL_OLDEST)
  message(FATAL_ERROR "GSL ${STICTION_GSL_OLDEST} or newer is needed to build stiction, found ${GSL_VERSION} in ${GSL_INCLUDE_DIRS}")
endif()

# The extension contains its own GSL with hidden symbols, so that switching off the error handler does not affect other
# users of GSL in the process. The static libraries are taken from the directory of the library that was found, because
# they match its headers. With a shared GSL all users in the process are affected.
get_filename_component(gsl_directory ${GSL_LIBRARY} DIRECTORY)
find_library(STICTION_GSL_ARCHIVE PATHS ${gsl_directory} NO_DEFAULT_PATH
  NAMES ${CMAKE_STATIC_LIBRARY_PREFIX}gsl${CMAKE_STATIC_LIBRARY_SUFFIX})
find_library(STICTION_GSLCBLAS_ARCHIVE PATHS ${gsl_directory} NO_DEFAULT_PATH
  NAMES ${CMAKE_STATIC_LIBRARY_PREFIX}gslcblas${CMAKE_STATIC_LIBRARY_SUFFIX})
mark_as_advanced(STICTION_GSL_ARCHIVE STICTION_GSLCBLAS_ARCHIVE)
if(STICTION_GSL_ARCHIVE AND STICTION_GSLCBLAS_ARCHIVE AND NOT STICTION_SHARED_GSL)
  set(STICTION_GSL ${STICTION_GSL_ARCHIVE} ${STICTION_GSLCBLAS_ARCHIVE})
else()
  set(STICTION_GSL GSL::gsl)
endif()

# FFTW in single and double precision, inside the extension like GSL. The planner is not thread-safe; a shared library
# would need a lock that all its users share.
set(STICTION_FFTW_OLDEST 3.3)
find_path(STICTION_FFTW_INCLUDE fftw3.h)
set(STICTION_FFTW_LIBRARIES)
set(STICTION_FFTW)
foreach(name IN ITEMS fftw3 fftw3f)
  string(TOUPPER ${name} variable)
  find_library(STICTION_${variable} NAMES ${name})
  mark_as_advanced(STICTION_${variable})
  if(NOT STICTION_${variable} OR NOT STICTION_FFTW_INCLUDE)
    message(FATAL_ERROR "FFTW ${STICTION_FFTW_OLDEST} or newer is needed to build stiction, in double and single precision, and was not found. "
      "Debian and Ubuntu: apt install libfftw3-dev. Fedora: fftw-devel. Homebrew and conda-forge: fftw.")
  endif()
  get_filename_component(fftw_directory ${STICTION_${variable}} DIRECTORY)
  find_library(STICTION_${variable}_ARCHIVE PATHS ${fftw_directory} NO_DEFAULT_PATH
    NAMES ${CMAKE_STATIC_LIBRARY_PREFIX}${name}${CMAKE_STATIC_LIBRARY_SUFFIX})
  mark_as_advanced(STICTION_${variable}_ARCHIVE)
  list(APPEND STICTION_FFTW_LIBRARIES ${STICTION_${variable}})
  if(STICTION_${variable}_ARCHIVE AND NOT STICTION_SHARED_GSL)
    list(APPEND STICTION_FFTW ${STICTION_${variable}_ARCHIVE})
  else()
    list(APPEND STICTION_FFTW ${STICTION_${variable}})
  endif()
endforeach()
mark_as_advanced(STICTION_FFTW_INCLUDE)
find_package(Threads REQUIRED)
