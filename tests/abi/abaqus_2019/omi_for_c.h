/* Stands in for Abaqus's header of that name, for tests alone: FOR_NAME with two arguments, as from Abaqus
   2019 on. The suffix is made up, so that a name written without the macro is not found. */
#define FOR_NAME(lower, UPPER) lower##_in_abaqus
