/* Expectations of the tests, which count faults and print them. */
#include <stdio.h>
#include <string.h>

#include "afterimage.h"

static int faults = 0;

static void expect(bool right, int line, const char *what) {
    if (!right) {
        fprintf(stderr, "line %d: %s; the last error is: %s\n", line, what, afterimage_error());
        faults++;
    }
}

#define HOLDS(what) expect(what, __LINE__, #what)
#define FAILS(call, text) expect(!(call) && strstr(afterimage_error(), text), __LINE__, #call)
