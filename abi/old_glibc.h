// The first versions of what glibc 2.29 and 2.35 have anew, for libraries that older systems load
// (MYOGROWTH_OLD_GLIBC). On x86-64 these are there since the beginning; they differ in errno and a little in
// speed.
#if defined(__x86_64__) && defined(__linux__)
__asm__(".symver exp,exp@GLIBC_2.2.5\n.symver log,log@GLIBC_2.2.5\n.symver pow,pow@GLIBC_2.2.5");
__asm__(".symver hypot,hypot@GLIBC_2.2.5");
#endif
