/* TFRA as the core computes it: operators folded by the array's two mirrors, and a sweep that only adds.

   Line by line this follows tfra.model.tfra, with its tolerances.  Vectors have four rows: in the taxel domain the four
   mirror taxels of every quad, in the parity domain (names ending in _h) the four parities; rows are padded with zeros
   to PADDED words, so that every loop has a fixed length and no remainder and the compiler makes vectors of it. */
#include <string.h>

#include "tfra.h"

#define EACH for (int i = 0; i < 4 * PADDED; i++)

#define EACH_TAXEL for (int s = 0, i; s < 4; s++) for (i = s * PADDED; i < s * PADDED + QUADS; i++)

/* Candidates are tried in chunks that fill a few vector registers. */
#define CHUNK 32
#define CANDIDATES ((STEPS + CHUNK) / CHUNK * CHUNK)

/* Sums are taken in as many lanes, which a tree adds up; divides the length of a vector. */
#define LANES 32

enum parity { EE, OX, OY, OO };

typedef struct { _Alignas(64) real at[4 * PADDED]; } vector;

static const real zero = 0;

/* Butterfly of additions: unscaled it folds; a quarter of it unfolds. */
static void butterfly(const vector *x, vector *y, real scale) {
  for (int q = 0; q < PADDED; q++) {
    real a = x->at[q], b = x->at[PADDED + q], c = x->at[2 * PADDED + q], d = x->at[3 * PADDED + q];
    y->at[q] = scale * ((a + b) + (c + d));
    y->at[PADDED + q] = scale * ((a - b) + (c - d));
    y->at[2 * PADDED + q] = scale * ((a + b) - (c + d));
    y->at[3 * PADDED + q] = scale * ((a - b) - (c - d));
  }
}

static void fold(const vector *x, vector *y) { butterfly(x, y, 1); }
static void unfold(const vector *x, vector *y) { butterfly(x, y, (real)0.25); }

/* y = M x; an operator that is odd in x or y maps parity s to s ^ flip. */
static void multiply(const real m[4][QUADS][PADDED], int flip, const vector *x, vector *y) {
  for (int s = 0; s < 4; s++) {
    real sum[PADDED] = {0};
    for (int j = 0; j < QUADS; j++)
      for (int i = 0; i < PADDED; i++) sum[i] += m[s][j][i] * x->at[s * PADDED + j];
    memcpy(y->at + (s ^ flip) * PADDED, sum, sizeof sum);
  }
}

static real tree(real lane[LANES]) {
  for (int half = LANES / 2; half; half /= 2)
    for (int l = 0; l < half; l++) lane[l] += lane[l + half];
  return lane[0];
}

static real total(const vector *x) {
  real lane[LANES] = {0};
  for (int i = 0; i < 4 * PADDED; i += LANES)
    for (int l = 0; l < LANES; l++) lane[l] += x->at[i + l];
  return tree(lane);
}

static real dot(const real *a, const real *b) {
  real sum = 0;
  for (int q = 0; q < PADDED; q++) sum += a[q] * b[q];
  return sum;
}

/* B^z of a chunk of candidates: what is positive in p + mu q (Eq. 23). */
static void b_z(const vector *p, const vector *q, const real mu[CHUNK], real z[CHUNK]) {
  real sum[CHUNK] = {0};
  EACH_TAXEL {
    const real p_i = p->at[i], q_i = q->at[i];
    for (int k = 0; k < CHUNK; k++) {
      real x = p_i + mu[k] * q_i;
      sum[k] += x > zero ? x : zero;
    }
  }
  memcpy(z, sum, sizeof sum);
}

/* B^xy of a chunk of candidates: what is positive in b - (p + mu q), against the measured traction (Eqs. 24, 25). */
static void b_xy(const vector *b, const vector *p, const vector *q, real measured, const real mu[CHUNK],
                 real xy[CHUNK]) {
  real sum[CHUNK] = {0};
  EACH_TAXEL {
    const real b_i = b->at[i], p_i = p->at[i], q_i = q->at[i];
    for (int k = 0; k < CHUNK; k++) {
      real x = b_i - (p_i + mu[k] * q_i);
      sum[k] += x > zero ? x : zero;
    }
  }
  for (int k = 0; k < CHUNK; k++) xy[k] = fabs(sum[k] - measured);
}

/* Smallest B^z, ties by B^xy, then the first (Eqs. 26, 27): B^xy is wanted where there is a plateau alone. */
static int search(const vector *b, const vector *p, const vector *q, int start, real measured) {
  real mu[CANDIDATES], z[CANDIDATES], xy[CHUNK], least = INFINITY, best = INFINITY;
  int index = 0;
  for (int k = 0; k < CANDIDATES; k++) mu[k] = (real)(k - start) / STEPS;
  for (int k = 0; k < CANDIDATES; k += CHUNK) b_z(p, q, mu + k, z + k);
  for (int k = 0; k <= STEPS; k++) least = z[k] < least ? z[k] : least;
  for (int first = 0; first <= STEPS; first += CHUNK) {
    int done = 0;
    for (int k = first; k < first + CHUNK && k <= STEPS; k++) {
      if (z[k] > least) continue;
      if (!done) b_xy(b, p, q, measured, mu + first, xy);
      done = 1;
      if (xy[k - first] < best) best = xy[k - first], index = k;
    }
  }
  return index;
}

/* Forces in taxel order, their sum and mu (Eqs. 12, 15), scaled to f_sens (Eqs. 30, 31) unless that is negative. */
static void finish(const vector f[3], real f_sens, struct result *out) {
  for (int axis = 0; axis < 3; axis++) out->resultant[axis] = total(&f[axis]);
  real *r = out->resultant, gain = 1, tangential;
  if (f_sens >= zero) {
    real f_star = sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    gain = f_star > zero ? f_sens / f_star : zero;
  }
  for (int axis = 0; axis < 3; axis++) {
    r[axis] *= gain;
    for (int t = 0; t < TAXELS; t++) out->forces[axis][t] = gain * f[axis].at[PLACE[t]];
  }
  tangential = sqrt(r[0] * r[0] + r[1] * r[1]);
  out->mu = r[2] != zero ? tangential / fabs(r[2]) : zero;
}

void tfra(const real *frame, struct result *out) {
  vector b = {{0}}, b_h, w_h, n, n_h, g_h, d_h[3], e_h[2], p, q, v_h, f_h, f[3];
  real sum_c, sum_t, v_x, v_y, length, c = 1, s = 0;

  memset(out, 0, sizeof *out);
  for (int t = 0; t < TAXELS; t++) b.at[PLACE[t]] = frame[t];
  {  /* Eqs. 11, 19-22 */
    vector part[6];
    EACH {
      real x = b.at[i], down = x < zero ? x : zero, up = x > zero ? x : zero;
      part[0].at[i] = down, part[1].at[i] = down * X[i], part[2].at[i] = down * Y[i];
      part[3].at[i] = up, part[4].at[i] = up * X[i], part[5].at[i] = up * Y[i];
    }
    sum_c = total(&part[0]), sum_t = total(&part[3]);
    v_x = total(&part[4]) * sum_c - total(&part[1]) * sum_t;
    v_y = total(&part[5]) * sum_c - total(&part[2]) * sum_t;
  }
  int reached = 0;
  for (int t = 0; t < TAXELS; t++) reached |= (frame[t] < -THRESHOLD) | (frame[t] >= THRESHOLD);
  if (!(sum_c < zero && reached)) {
    out->status = NO_CONTACT;
    return;
  }
  fold(&b, &b_h);
  multiply(C33_INV, EE, &b_h, &w_h);
  if (!(sum_t > zero)) {
    memset(f, 0, sizeof f);
    unfold(&w_h, &f[2]);
    finish(f, -1, out);
    out->status = COMPRESSION_ONLY;
    return;
  }
  length = sqrt(v_x * v_x + v_y * v_y);
  if (length > (real)1e-13 * fabs(sum_c * sum_t) * REACH)
    c = v_x / length, s = v_y / length;
  else
    out->status |= NO_DIRECTION;
  int along_y = fabs(s) > fabs(c) * (1 + (real)TIE), start = (along_y ? s : c) < zero ? STEPS : 0;  /* Fig. 3 */

  unfold(&w_h, &n);  /* Eq. 9: w_z = -n */
  EACH n.at[i] = n.at[i] < zero ? -n.at[i] : zero;
  fold(&n, &n_h);
  multiply(C33, EE, &n_h, &g_h);
  multiply(MINUS_C31, OX, &n_h, &d_h[1]);
  multiply(MINUS_C32, OY, &n_h, &d_h[2]);
  EACH d_h[0].at[i] = b_h.at[i] + g_h.at[i];

  real a1[3], a2[3], all = total(&n);  /* Eq. 12 */
  for (int k = 0; k < 3; k++) {
    a1[k] = dot(SUM1, d_h[k].at + OX * PADDED) + (k == 1 ? all : zero);
    a2[k] = dot(SUM2, d_h[k].at + OY * PADDED) + (k == 2 ? all : zero);
  }
  real u_0 = a1[0] * s - a2[0] * c, u_x = a1[1] * s - a2[1] * c, u_y = a2[2] * c - a1[2] * s;  /* Eqs. 17, 18 */
  real den = along_y ? u_x : u_y, num0 = along_y ? -u_0 : u_0, num1 = along_y ? u_y : u_x, alpha = 0, beta = 0;
  if ((fabs(num0) > fabs(num1) ? fabs(num0) : fabs(num1)) < LIMIT * fabs(den))
    alpha = num0 / den, beta = num1 / den;
  else
    out->status |= VANISHING;

  const vector *ind = &d_h[along_y ? 2 : 1], *dep = &d_h[along_y ? 1 : 2];
  EACH {
    e_h[0].at[i] = d_h[0].at[i] + alpha * dep->at[i];
    e_h[1].at[i] = ind->at[i] + beta * dep->at[i];
  }
  multiply(NORMAL, EE, &e_h[0], &v_h);
  EACH v_h.at[i] -= g_h.at[i];
  unfold(&v_h, &p);
  multiply(NORMAL, EE, &e_h[1], &v_h);
  unfold(&v_h, &q);
  int index = search(&b, &p, &q, start, sum_t);
  real mu_ind = (real)(index - start) / STEPS, mu_dep = alpha + beta * mu_ind;
  out->sweep_index = index;
  out->mu_x = along_y ? mu_dep : mu_ind;
  out->mu_y = along_y ? mu_ind : mu_dep;
  if (fabs(mu_dep) > 1 + (real)TIE) out->status |= OUT_OF_RANGE;

  EACH v_h.at[i] = e_h[0].at[i] + mu_ind * e_h[1].at[i];
  multiply(PINV1, OX, &v_h, &f_h);  /* Eqs. 10, 28 */
  unfold(&f_h, &f[0]);
  multiply(PINV2, OY, &v_h, &f_h);
  unfold(&f_h, &f[1]);
  multiply(PINV3, EE, &v_h, &f_h);
  unfold(&f_h, &f[2]);
  EACH {
    f[0].at[i] += out->mu_x * n.at[i];
    f[1].at[i] += out->mu_y * n.at[i];
    f[2].at[i] -= n.at[i];
  }
  finish(f, (sum_t - sum_c) * AREA, out);  /* Eq. 29 */
  real phi = atan2(s, c) * (real)DEGREES;
  out->phi_deg = phi < zero ? phi + 360 : phi;
  if (out->phi_deg >= 360) out->phi_deg = 0;
}
