// The routines of libMYOGROWTH, as CalculiX declares them: named arguments are used, the others are not.
#ifndef MYOGROWTH_TESTS_CCX_HOST_HPP
#define MYOGROWTH_TESTS_CCX_HOST_HPP

extern "C" {
void CCX(double* stress, double* statev, double* ddsdde, double*, double*, double*, double*, double*, double*,
         double*, const double*, const double*, const double*, const double* dtime, const double*,
         const double*, const double*, const double*, const char*, const int*, const int*, const int*,
         const int* nstatv, const double* props, const int* nprops, const double*, const double*,
         double* pnewdt, const double*, const double*, const double* dfgrd1, const int*, const int*,
         const int*, const int*, const int*, const int*, int);
void NATIVE(const char*, const int* iel, const int* iint, const int* kode, const double* elconloc,
            const double*, const double*, const double*, const double*, const double*, const double* xkl,
            const double*, const int*, const double*, const double* dtime, const double*, const double*,
            const int* icmd, const int*, const int* mi, const int* nstate, const double* xstateini,
            double* xstate, double* stre, double* stiff, const int*, const double*, const double*,
            double* pnewdt, const int*, int);
}

#endif
