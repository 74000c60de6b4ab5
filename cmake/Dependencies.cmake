# Eigen 3.4 and 5.x refuse each other's version requests: find it without one, then check.
find_package(Eigen3 REQUIRED NO_MODULE)
if(Eigen3_VERSION VERSION_LESS 3.4)
  message(FATAL_ERROR "Eigen 3.4 or newer is needed, found ${Eigen3_VERSION}")
endif()

find_package(GSL 2.7 REQUIRED)

# The extension carries its own GSL, with hidden symbols, so that nobody else's is touched.
find_library(STICTION_GSL_ARCHIVE NAMES ${CMAKE_STATIC_LIBRARY_PREFIX}gsl${CMAKE_STATIC_LIBRARY_SUFFIX})
find_library(STICTION_GSLCBLAS_ARCHIVE NAMES ${CMAKE_STATIC_LIBRARY_PREFIX}gslcblas${CMAKE_STATIC_LIBRARY_SUFFIX})
mark_as_advanced(STICTION_GSL_ARCHIVE STICTION_GSLCBLAS_ARCHIVE)
if(STICTION_GSL_ARCHIVE AND STICTION_GSLCBLAS_ARCHIVE)
  set(STICTION_GSL ${STICTION_GSL_ARCHIVE} ${STICTION_GSLCBLAS_ARCHIVE})
else()
  set(STICTION_GSL GSL::gsl)
endif()
