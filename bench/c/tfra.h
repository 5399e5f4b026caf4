/* TFRA, one frame at a time.  REAL is double or float; sensor.h is written by bench/c_program.py. */
#include <tgmath.h>

typedef REAL real;

#include "sensor.h"

enum status { NO_CONTACT = 1, COMPRESSION_ONLY = 2, NO_DIRECTION = 4, VANISHING = 8, OUT_OF_RANGE = 16 };

/* As tfra.model.tfra.Result: N and degrees. */
struct result {
  real forces[3][TAXELS], resultant[3], phi_deg, mu, mu_x, mu_y;
  int sweep_index, status;
};

/* Forces of a frame of TAXELS stresses in Pa, row by row. */
void tfra(const real *frame, struct result *out);
