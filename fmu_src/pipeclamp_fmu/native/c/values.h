/* The file of values that travels in an FMU's resources. */
#ifndef VALUES_H
#define VALUES_H

#include "model.h"

/* Read `values.txt` in a folder (UTF-8); says why it can't and returns 0 then. */
static int values_read(Values *values, const char *folder, const char *token, char reason[TEXT]);

#endif
