/* The one file to compile; `layout.h` says which of the others it consists of. */
#include "layout.h"

#include MODEL_SOURCE
#include "values.c"
#include "instance.c"
#include "variables.c"
#if FMI_VERSION == 2
#include "fmi2.c"
#else
#include "fmi3.c"
#endif
