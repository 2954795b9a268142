# Where `cmake --install` puts the files, in three components, and the packages that `cpack` makes from them:
#
#   headers   include/myogrowth, myogrowth::myogrowth; needs Eigen on the user's machine
#   umat      the libraries that hosts load, myogrowth::umat, ::vumat, ::c, ::mgis ...; myogrowth.h; the UMAT as one file
#   driver    bin/myogrowth_driver and its cases, myogrowth::driver; needs umat
#
# find_package(myogrowth COMPONENTS ...) asks for them by the same names.
include(CMakePackageConfigHelpers)
set(cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/myogrowth)
set(data_dir ${CMAKE_INSTALL_DATADIR}/myogrowth)

install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/myogrowth DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT headers)
install(TARGETS myogrowth EXPORT myogrowth-headers)
install(EXPORT myogrowth-headers NAMESPACE myogrowth:: DESTINATION ${cmake_dir} COMPONENT headers)

if(MYOGROWTH_BUILD_UMAT)
  set(ccx)
  if(TARGET myogrowth_ccx)
    set(ccx myogrowth_ccx)
  endif()
  install(TARGETS myogrowth_umat myogrowth_vumat myogrowth_vumat_float myogrowth_c ${ccx} myogrowth_comsol
                  myogrowth_mgis myogrowth_probe
          EXPORT myogrowth-umat LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT umat NAMELINK_COMPONENT umat
          RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT umat
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT umat)
  if(WIN32) # under the names that Abaqus on Windows looks for in usub_lib_dir
    foreach(names umat=standardU vumat=explicitU-D vumat_float=explicitU)
      string(REGEX MATCH "(.*)=(.*)" _ ${names})
      install(FILES $<TARGET_FILE:myogrowth_${CMAKE_MATCH_1}> DESTINATION abaqus RENAME ${CMAKE_MATCH_2}.dll COMPONENT umat)
    endforeach()
  endif()
  install(EXPORT myogrowth-umat NAMESPACE myogrowth:: DESTINATION ${cmake_dir} COMPONENT umat)
  install(FILES ${PROJECT_SOURCE_DIR}/abi/myogrowth.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT umat)
  if(MYOGROWTH_UMAT_SINGLE)
    install(FILES ${MYOGROWTH_UMAT_SINGLE} DESTINATION ${data_dir} COMPONENT umat)
  endif()
endif()

if(MYOGROWTH_BUILD_DRIVER)
  install(TARGETS myogrowth_driver EXPORT myogrowth-driver RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT driver)
  install(TARGETS myogrowth_abaqus LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT driver)
  install(PROGRAMS ${PROJECT_SOURCE_DIR}/fortran_driver/umat/compile.sh DESTINATION ${data_dir}/umat COMPONENT driver)
  install(FILES ${PROJECT_SOURCE_DIR}/fortran_driver/umat/ABA_PARAM.INC DESTINATION ${data_dir}/umat COMPONENT driver)
  install(EXPORT myogrowth-driver NAMESPACE myogrowth:: DESTINATION ${cmake_dir} COMPONENT driver)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/fortran_driver/cases DESTINATION ${data_dir} COMPONENT driver)
endif()

# For CMake: one file that all components share. Before 1.0 minor versions may be incompatible.
configure_package_config_file(cmake/myogrowth-config.cmake.in ${PROJECT_BINARY_DIR}/myogrowth-config.cmake
                              INSTALL_DESTINATION ${cmake_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/myogrowth-config-version.cmake COMPATIBILITY SameMinorVersion
                                 ARCH_INDEPENDENT)
foreach(component headers umat driver)
  install(FILES ${PROJECT_BINARY_DIR}/myogrowth-config.cmake ${PROJECT_BINARY_DIR}/myogrowth-config-version.cmake
          DESTINATION ${cmake_dir} COMPONENT ${component})
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright
          COMPONENT ${component})
endforeach()

# For pkg-config: paths are relative to the .pc file, so that the tree may be moved.
set(pkgconfig_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pkgconfig_prefix ${CMAKE_INSTALL_PREFIX}/${pkgconfig_dir} ${CMAKE_INSTALL_PREFIX})
function(myogrowth_pkgconfig name component description requires cflags libs)
  configure_file(cmake/pkgconfig.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${pkgconfig_dir} COMPONENT ${component})
endfunction()
myogrowth_pkgconfig(myogrowth headers "${PROJECT_DESCRIPTION}: C++17 headers" "eigen3 >= 3.4" "-I\${includedir}" "")
if(MYOGROWTH_BUILD_UMAT)
  myogrowth_pkgconfig(myogrowth-c umat "${PROJECT_DESCRIPTION}: C API" "" "-I\${includedir}" "-L\${libdir} -lmyogrowth")
  myogrowth_pkgconfig(myogrowth-umat umat "${PROJECT_DESCRIPTION}: Abaqus-compatible UMAT" "" ""
                      "-L\${libdir} -lmyogrowth_umat")
endif()

set(CPACK_GENERATOR DEB TGZ)
if(WIN32)
  set(CPACK_GENERATOR ZIP)
endif()
set(CPACK_PACKAGE_NAME myogrowth)
set(CPACK_PACKAGE_VENDOR "the myogrowth authors")
set(CPACK_PACKAGE_CONTACT "the myogrowth authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "stretch-driven skeletal-muscle growth: headers, UMAT, driver")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
    "A muscle that is held stretched grows: it adds sarcomeres in series. This is the constitutive law of that growth with
its exact tangent, as a header-only C++ library; as user material routines for Abaqus, CalculiX and hosts alike (UMAT,
VUMAT, a generic behaviour of MGIS) and behind a C interface; and a one-element driver to try it with.")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_FILE_NAME myogrowth-${PROJECT_VERSION}-${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS libeigen3-dev)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
if(PROJECT_IS_TOP_LEVEL) # else it is for the project around this one to say what it packs
  include(CPack)
endif()
