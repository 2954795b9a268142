/* Stands in for Abaqus's header of that name, for tests alone: FOR_NAME with one argument, as before Abaqus
 * 2019. */
#define FOR_NAME(lower) lower##_in_abaqus
