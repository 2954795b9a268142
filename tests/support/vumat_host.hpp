// The VUMAT as a host declares it: its 33 arguments, in the precision of the build.
#ifndef MYOGROWTH_TESTS_VUMAT_HOST_HPP
#define MYOGROWTH_TESTS_VUMAT_HOST_HPP

#ifdef MYOGROWTH_VUMAT_SINGLE
using Number = float;
#else
using Number = double;
#endif

extern "C" {
using Vumat = void(const int* nblock, const int* ndir, const int* nshr, const int* nstatev,
                   const int* nfieldv, const int* nprops, const int* lanneal, const Number* stepTime,
                   const Number* totalTime, const Number* dt, const char* cmname, const Number* coordMp,
                   const Number* charLength, const Number* props, const Number* density,
                   const Number* strainInc, const Number* relSpinInc, const Number* tempOld,
                   const Number* stretchOld, const Number* defgradOld, const Number* fieldOld,
                   const Number* stressOld, const Number* stateOld, const Number* enerInternOld,
                   const Number* enerInelasOld, const Number* tempNew, const Number* stretchNew,
                   const Number* defgradNew, const Number* fieldNew, Number* stressNew, Number* stateNew,
                   Number* enerInternNew, Number* enerInelasNew);
Vumat vumat_, myogrowth_vumat_;
}

#endif
