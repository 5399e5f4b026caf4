/* Times every frame by itself.  Input and output lie in the first-level cache: a frame is copied in before its clock
   starts, its result out after it has stopped. */
#define _POSIX_C_SOURCE 199309L
#include <string.h>
#include <time.h>

#include "tfra.h"

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

const int result_size = sizeof(struct result);

/* Results of `count` frames, and the nanoseconds that each took. */
void measure(long count, const real *frames, struct result *results, double *nanoseconds) {
  static real frame[TAXELS];
  static struct result result;
  for (long i = 0; i < count; i++) {
    memcpy(frame, frames + i * TAXELS, sizeof frame);
    double start = now();
    tfra(frame, &result);
    nanoseconds[i] = now() - start;
    results[i] = result;
  }
}

/* What the clock itself takes, `count` times. */
void overhead(long count, double *nanoseconds) {
  for (long i = 0; i < count; i++) {
    double start = now();
    nanoseconds[i] = now() - start;
  }
}
