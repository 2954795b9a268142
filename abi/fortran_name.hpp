/// @file
/// The names under which Fortran hosts know our routines, and we Abaqus's.
#ifndef MYOGROWTH_ABI_FORTRAN_NAME_HPP
#define MYOGROWTH_ABI_FORTRAN_NAME_HPP

// Names as the Fortran compiler writes them. Abaqus has a macro for that, FOR_NAME in omi_for_c.h, which took
// one argument before Abaqus 2019: there, define MYOGROWTH_ABAQUS_BEFORE_2019.
#if defined(__has_include)
#if __has_include(<omi_for_c.h>)
#include <omi_for_c.h>
#define MYOGROWTH_INSIDE_ABAQUS
#endif
#endif
#if !defined(MYOGROWTH_INSIDE_ABAQUS)
#define MYOGROWTH_FORTRAN(lower, UPPER) lower##_
#elif defined(MYOGROWTH_ABAQUS_BEFORE_2019)
#define MYOGROWTH_FORTRAN(lower, UPPER) FOR_NAME(lower)
#else
#define MYOGROWTH_FORTRAN(lower, UPPER) FOR_NAME(lower, UPPER)
#endif

// Before the declaration of a utility of Abaqus's. No other host has them, so elsewhere they are looked for,
// not linked.
#if defined(MYOGROWTH_INSIDE_ABAQUS)
#define MYOGROWTH_IF_THERE
#else
#define MYOGROWTH_IF_THERE __attribute__((weak))
#endif

#endif
