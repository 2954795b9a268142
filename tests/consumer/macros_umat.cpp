// The UMAT in one file after the same macros.
#include "macros.hpp"

#include MYOGROWTH_SINGLE_UMAT
