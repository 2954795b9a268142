/// @file
/// Abaqus's side of the UMAT and the VUMAT: their names, their arguments in order, and the utilities that
/// Abaqus offers them. Every argument is an address, and arrays are stored column by column, as in Fortran.
#ifndef MYOGROWTH_ABI_ABAQUS_H
#define MYOGROWTH_ABI_ABAQUS_H

#include <cstddef>
#include <cstdio>

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

// The address of a utility, null where there is none. A DLL of Windows finds nothing in the program that
// loads it: there only what is linked with the utilities has them, and says so by this macro.
#if defined(_WIN32) && !defined(MYOGROWTH_INSIDE_ABAQUS) && !defined(MYOGROWTH_LINKED_WITH_UTILITIES)
#define MYOGROWTH_UTILITY(lower, UPPER) nullptr
#else
#define MYOGROWTH_UTILITY(lower, UPPER) MYOGROWTH_FORTRAN(lower, UPPER)
#endif

// MYOGROWTH_SECOND_NAME(type, name, routine): the routine under another name as well.
#define MYOGROWTH_TEXT_OF(x) #x
#define MYOGROWTH_TEXT(x) MYOGROWTH_TEXT_OF(x)
#if defined(_MSC_VER) && !defined(__clang__)
#define MYOGROWTH_SECOND_NAME(type, name, routine) \
  __pragma(comment(linker, "/alternatename:" MYOGROWTH_TEXT(name) "=" MYOGROWTH_TEXT(routine))) type name
#elif defined(__APPLE__)  // whose compilers have no alias (not tried by us)
#define MYOGROWTH_SECOND_NAME(type, name, routine) \
  type name;                                       \
  __asm__(".globl _" MYOGROWTH_TEXT(name) "\n.set _" MYOGROWTH_TEXT(name) ", _" MYOGROWTH_TEXT(routine))
#else
#define MYOGROWTH_SECOND_NAME(type, name, routine) type name __attribute__((alias(MYOGROWTH_TEXT(routine))))
#endif

extern "C" {

/// Abaqus/Standard's user subroutine UMAT (Abaqus User Subroutines Guide). "Not used": neither read nor
/// written by ours.
using Umat = void(
    double* stress,        // in/out (NTENS): Cauchy stress, 11 22 33 12 13 23; mixed elements: three more
    double* statev,        // in/out (NSTATV): state at the beginning of the increment; at its end
    double* ddsdde,        // out (NTENS, NTENS): tangent (1/J) d(J stress), columns of engineering shear
    double* sse,           // out: elastic energy; ours per unit reference volume
    double* spd,           // in/out: plastic dissipation; not used
    double* scd,           // in/out: creep dissipation; not used
    double* rpl,           // out: heat generation; ours 0, and its derivatives
    double* ddsddt,        // out (NTENS): derivative of stress with respect to temperature
    double* drplde,        // out (NTENS): of rpl with respect to strain
    double* drpldt,        // out: of rpl with respect to temperature
    const double* stran,   // in (NTENS): strain at the beginning; not used
    const double* dstran,  // in (NTENS): strain increment; not used
    const double* time,    // in (2): step time and total time at the beginning; not used
    const double* dtime,   // in: length of the increment
    const double* temp,    // in: temperature; not used
    const double* dtemp,   // in: its increment; not used
    const double* predef,  // in: predefined field variables; the first: activation, if PROPS(20) = -1
    const double* dpred,   // in: their increments; not used
    const char* cmname,    // in (80 characters): material name; not used
    const int* ndi,        // in: number of direct stress components
    const int* nshr,       // in: number of shear stress components
    const int* ntens,      // in: NDI + NSHR
    const int* nstatv,     // in: number of state variables, *DEPVAR
    const double* props,   // in (NPROPS): material constants, *USER MATERIAL
    const int* nprops,     // in: their number
    const double* coords,  // in (3): position of the point; not used
    const double* drot,    // in (3, 3): rotation of the increment; not used
    double* pnewdt,        // in/out: factor on the time increment; below 1: this increment again, shorter
    const double* celent,  // in: characteristic element length; not used
    const double* dfgrd0,  // in (3, 3): deformation gradient at the beginning; not used
    const double* dfgrd1,  // in (3, 3): deformation gradient at the end
    const int* noel,       // in: element number; not used
    const int* npt,        // in: integration point; not used
    const int* layer,      // in: layer of a shell; not used
    const int* kspt,       // in: section point; not used
    const int* kstep,      // in: step number; not used
    const int* kinc        // in: increment number; not used
);

/// The reals of Abaqus/Explicit: double in double precision.
#ifdef MYOGROWTH_VUMAT_SINGLE
using VumatReal = float;
#else
using VumatReal = double;
#endif

/// Abaqus/Explicit's user subroutine VUMAT, for NBLOCK points at once (Abaqus User Subroutines Guide).
/// Components of symmetric tensors: 11 22 33 12 23 31.
using Vumat = void(
    const int* nblock,            // in: number of points
    const int* ndir,              // in: number of direct stress components
    const int* nshr,              // in: number of shear stress components
    const int* nstatev,           // in: number of state variables, *DEPVAR
    const int* nfieldv,           // in: number of field variables
    const int* nprops,            // in: number of material constants
    const int* lanneal,           // in: whether this is an annealing step; not used
    const VumatReal* stepTime,    // in: time since the step began
    const VumatReal* totalTime,   // in: total time
    const VumatReal* dt,          // in: length of the increment
    const char* cmname,           // in: material name; not used
    const VumatReal* coordMp,     // in (NBLOCK, *): positions; not used
    const VumatReal* charLength,  // in (NBLOCK): characteristic element lengths; not used
    const VumatReal* props,       // in (NPROPS): material constants
    const VumatReal* density,     // in (NBLOCK): density in the middle of the increment
    const VumatReal* strainInc,   // in (NBLOCK, NDIR+NSHR): strain increments; for the data check only
    const VumatReal* relSpinInc,  // in (NBLOCK, NSHR): relative spin increments; not used
    const VumatReal* tempOld,     // in (NBLOCK): temperatures at the beginning; not used
    const VumatReal* stretchOld,  // in (NBLOCK, NDIR+NSHR): U at the beginning, where F = R U
    const VumatReal* defgradOld,  // in (NBLOCK, NDIR+2 NSHR): F at the beginning; not used
    const VumatReal* fieldOld,    // in (NBLOCK, NFIELDV): field variables; not used
    const VumatReal* stressOld,   // in (NBLOCK, NDIR+NSHR): stress at the beginning; for the data check only
    const VumatReal* stateOld,    // in (NBLOCK, NSTATEV): state at the beginning
    const VumatReal* enerInternOld,  // in (NBLOCK): internal energy per unit mass at the beginning
    const VumatReal* enerInelasOld,  // in (NBLOCK): dissipated energy per unit mass at the beginning
    const VumatReal* tempNew,        // in (NBLOCK): temperatures at the end; not used
    const VumatReal* stretchNew,     // in (NBLOCK, NDIR+NSHR): U at the end
    const VumatReal* defgradNew,     // in (NBLOCK, NDIR+2 NSHR): F at the end; not used
    const VumatReal* fieldNew,       // in (NBLOCK, NFIELDV): fields; 1: activation, if PROPS(20) = -1
    VumatReal* stressNew,            // out (NBLOCK, NDIR+NSHR): R^T stress R at the end
    VumatReal* stateNew,             // out (NBLOCK, NSTATEV): state at the end
    VumatReal* enerInternNew,        // out (NBLOCK): internal energy per unit mass at the end
    VumatReal* enerInelasNew         // out (NBLOCK): dissipated energy per unit mass at the end
);

/// The routines of ours; myogrowth_...: for a user's routine that dispatches between materials.
Umat MYOGROWTH_FORTRAN(umat, UMAT), MYOGROWTH_FORTRAN(myogrowth_umat, MYOGROWTH_UMAT);
Vumat MYOGROWTH_FORTRAN(vumat, VUMAT), MYOGROWTH_FORTRAN(myogrowth_vumat, MYOGROWTH_VUMAT);

/// Abaqus's STDB_ABQERR and XPLB_ABQERR. Our texts refer to none of the numbers, whose type varies.
using HostMessage = void(const int* lop, const char* text, const int* ints, const void* reals,
                         const char* chars, std::size_t text_length, std::size_t chars_length);
/// Abaqus's XIT and XPLB_EXIT.
using HostExit = void();
}

namespace myogrowth {
namespace abi {

/// Says that `routine` (UMAT, ...) has found a fault: as an error through the host's utilities and its exit,
/// as far as the host has them (null where not), else on standard error.
inline void report(const char* routine, const char* text, HostMessage* message, HostExit* exit) {
  const int error = -2, no_int = 0;
  const double no_real = 0;
  char line[512];
  const int written = std::snprintf(line, sizeof line, "myogrowth %s: %s", routine, text);
  const int length = written < static_cast<int>(sizeof line) ? written : static_cast<int>(sizeof line) - 1;
  if (message) {
    message(&error, line, &no_int, &no_real, "        ", static_cast<std::size_t>(length), 8);
  } else {
    std::fprintf(stderr, "%s\n", line);
  }
  if (exit) exit();
}

}  // namespace abi
}  // namespace myogrowth

#endif
