/// @file
/// The only place where the version of myogrowth is written; CMake reads it from here.
#ifndef MYOGROWTH_VERSION_HPP
#define MYOGROWTH_VERSION_HPP

/// The version, major.minor.patch.
/// @{
#define MYOGROWTH_VERSION_MAJOR 0
#define MYOGROWTH_VERSION_MINOR 2
#define MYOGROWTH_VERSION_PATCH 0
/// @}

#endif
