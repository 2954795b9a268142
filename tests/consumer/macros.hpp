// Names that system headers define as macros, as they do. The standard's headers come first: they cannot be
// read after some of these either.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <complex>
#include <csignal>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

// <windows.h> and what it includes
#define min(a, b) (((a) < (b)) ? (a) : (b))
#define max(a, b) (((a) > (b)) ? (a) : (b))
#define far
#define near
#define FAR
#define NEAR
#define small char
#define hyper __int64
#define pascal __stdcall
#define cdecl __cdecl
#define interface struct
#define IN
#define OUT
#define OPTIONAL
#define CONST const
#define VOID void
#define TRUE 1
#define FALSE 0
#define ERROR 0
#define NO_ERROR 0L
#define STRICT 1
#define DELETE (0x00010000L)
#define ABSOLUTE 1
#define RELATIVE 2
#define TRANSPARENT 1
#define OPAQUE 2
#define DOMAIN 1
#define SING 2
#define OVERFLOW 3
#define UNDERFLOW 4
#define TLOSS 5
#define PLOSS 6
#define HUGE 3.4e38f
#define Yield()
#define environ _environ
// <X11/X.h>, <X11/Xlib.h>
#define None 0L
#define Status int
#define Bool int
#define True 1
#define False 0
#define Success 0
#define Always 2
#define Above 0
#define Below 1
#define Opposite 4
#define Unsorted 0
#define Complex 0
#define Convex 2
#define Nonconvex 1
#define Expose 12
#define GrayScale 1
#define CursorShape 0
// <complex.h>, <sys/sysmacros.h>, <sys/param.h>, the compilers' own
#define I (__extension__ 1.0iF)
#define complex _Complex
#define major(dev) gnu_dev_major(dev)
#define minor(dev) gnu_dev_minor(dev)
#define makedev(a, b) gnu_dev_makedev(a, b)
#define MIN(a, b) (((a) < (b)) ? (a) : (b))
#define MAX(a, b) (((a) > (b)) ? (a) : (b))
#define roundup(x, y) ((((x) + ((y)-1)) / (y)) * (y))
#define isset(a, i) ((a)[(i) / 8] & (1 << (i) % 8))
#undef unix
#undef linux
#define unix 1
#define linux 1
// <termios.h>, Arduino.h, <ctype.h> of BSD and newlib, <sys/ucontext.h>, <curses.h>
#define B0 0000000
#define B1 1
#define B50 0000001
#define ECHO 0000010
#define PI 3.1415926535897932384626433832795
#define HALF_PI 1.5707963267948966
#define EULER 2.718281828459045
#define F(text) (text)
#define bit(b) (1UL << (b))
#define lowByte(w) ((w)&0xff)
#define _B 1
#define _C 2
#define _L 3
#define _N 4
#define _P 5
#define _S 6
#define _U 7
#define _X 8
#define SS 18
#define CS 17
#define DS 3
#define ERR (-1)
#define OK 0
#define stdscr 0
