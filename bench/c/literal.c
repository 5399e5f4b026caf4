/* The paper's loop taken literally, as tfra.model.literal: the normal and the tangential stress by matrix products for
   each candidate, 3 m^2 multiplications.  Matrices are stored by columns, so that products make vectors.
   Frames without contact and frames of compression only are treated as in tfra.c; a vanishing denominator is not. */
#include <string.h>

#include "tfra.h"

#define EACH for (int t = 0; t < TAXELS; t++)

typedef real plane[TAXELS];

static const real zero = 0;

/* y += M x */
static void add_product(const real m[TAXELS][TAXELS], const real *x, real *y) {
  for (int j = 0; j < TAXELS; j++)
    for (int i = 0; i < TAXELS; i++) y[i] += m[j][i] * x[j];
}

static real positive(const real *x) {
  real sum = 0;
  EACH sum += x[t] > zero ? x[t] : zero;
  return sum;
}

static real total(const real *x) {
  real sum = 0;
  EACH sum += x[t];
  return sum;
}

/* phi from the centroid of traction to that of compression (Eqs. 11, 19-22). */
static real angle(const real *b) {
  real c[3] = {0}, t_[3] = {0};
  EACH {
    real *to = b[t] < zero ? c : t_;
    to[0] += b[t], to[1] += b[t] * FULL_X[t], to[2] += b[t] * FULL_Y[t];
  }
  return atan2(c[2] / c[0] - t_[2] / t_[0], c[1] / c[0] - t_[1] / t_[0]);
}

/* a_pq of Eq. 10, each of them a plane of forces. */
static void coefficients(const real *b, plane a[3][3]) {
  const real(*const pinv[3])[TAXELS] = {FULL_PINV1, FULL_PINV2, FULL_PINV3};
  plane w = {0}, n, r[3] = {{0}};
  add_product(FULL_C33_INV, b, w);  /* Eq. 9 */
  EACH w[t] = w[t] < zero ? w[t] : zero, n[t] = fabs(w[t]);
  add_product(FULL_C33, n, r[0]);
  EACH r[0][t] += b[t];
  add_product(FULL_C31, n, r[1]);
  add_product(FULL_C32, n, r[2]);
  EACH r[1][t] = -r[1][t], r[2][t] = -r[2][t];
  memset(a, 0, 9 * sizeof(plane));
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 3; j++) add_product(pinv[k], r[j], a[k][j]);
  EACH a[0][1][t] += n[t], a[1][2][t] += n[t], a[2][0][t] += w[t];
}

static void sweep(const real *b, plane a[3][3], real phi, struct result *out) {
  real sums[2][3], c = cos(phi), s = sin(phi), traction = positive(b), best_z = INFINITY, best_xy = INFINITY;
  for (int k = 0; k < 2; k++)
    for (int j = 0; j < 3; j++) sums[k][j] = total(a[k][j]);  /* Eq. 12 */
  real u_0 = sums[0][0] * s - sums[1][0] * c, u_x = sums[0][1] * s - sums[1][1] * c, u_y = sums[0][2] * s - sums[1][2] * c;
  int along_y = fabs(s) > fabs(c) * (1 + (real)TIE), start = (along_y ? s : c) < zero ? STEPS : 0;  /* Fig. 3 */
  for (int index = 0; index <= STEPS; index++) {
    real mu = (real)(index - start) / STEPS;
    real mu_x = along_y ? -(u_0 + mu * u_y) / u_x : mu, mu_y = along_y ? mu : -(u_0 + mu * u_x) / u_y;  /* Eqs. 17, 18 */
    plane f[3], normal = {0}, tangential = {0};
    for (int k = 0; k < 3; k++)
      EACH f[k][t] = a[k][0][t] + mu_x * a[k][1][t] + mu_y * a[k][2][t];  /* Eq. 10 */
    add_product(FULL_C33, f[2], normal);
    add_product(FULL_C31, f[0], tangential);  /* Eq. 24 */
    add_product(FULL_C32, f[1], tangential);
    real z = positive(normal), xy = fabs(positive(tangential) - traction);  /* Eqs. 23, 25 */
    if (z < best_z || (z == best_z && xy < best_xy)) {
      best_z = z, best_xy = xy;
      out->mu_x = mu_x, out->mu_y = mu_y, out->sweep_index = index;
      memcpy(out->forces, f, sizeof f);
    }
  }
}

void tfra(const real *frame, struct result *out) {
  plane a[3][3];
  real f_sens = 0, f_star, gain, phi, *r = out->resultant;
  int compressed = 0, pulled = 0, reached = 0;
  memset(out, 0, sizeof *out);
  EACH {
    compressed |= frame[t] < zero, pulled |= frame[t] > zero;
    reached |= (frame[t] < -THRESHOLD) | (frame[t] >= THRESHOLD);
  }
  if (!(compressed && reached)) {
    out->status = NO_CONTACT;
    return;
  }
  if (!pulled) {
    out->status = COMPRESSION_ONLY;
    add_product(FULL_C33_INV, frame, out->forces[2]);
    r[2] = total(out->forces[2]);
    return;
  }
  phi = angle(frame);
  coefficients(frame, a);
  sweep(frame, a, phi, out);
  EACH f_sens += fabs(frame[t]) * (real)AREA;  /* Eq. 29 */
  for (int k = 0; k < 3; k++) r[k] = total(out->forces[k]);
  f_star = sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);  /* Eq. 30 */
  gain = f_sens / f_star;
  for (int k = 0; k < 3; k++) {  /* Eq. 31 */
    r[k] *= gain;
    EACH out->forces[k][t] *= gain;
  }
  out->mu = r[2] != zero ? sqrt(r[0] * r[0] + r[1] * r[1]) / fabs(r[2]) : zero;
  if (fabs(out->mu_x) > 1 + (real)TIE || fabs(out->mu_y) > 1 + (real)TIE) out->status |= OUT_OF_RANGE;
  phi *= (real)DEGREES;
  out->phi_deg = phi < zero ? phi + 360 : phi;
  if (out->phi_deg >= 360) out->phi_deg = 0;
}
