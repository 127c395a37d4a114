/* An excitation remembers nothing. */
#ifndef EXCITATION_H
#define EXCITATION_H

typedef struct {
    char unused;
} Memory;

typedef struct {
    char unused;
} Scratch;

#endif
