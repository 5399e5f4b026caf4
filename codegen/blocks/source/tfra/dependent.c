// The dependent friction mu_dep = alpha + beta * mu_ind (Eqs. 12, 17, 18), with cos and sin instead of tan.

typedef struct {
    scalar_t alpha;
    scalar_t beta;
    bool vanishing;       // the denominator
    scalar_t sums[3][3];  // A_pq of Eq. 12, normalised together
    int needed;           // bits that these sums needed
} dependent_t;

static void dependent(const vector_t b[4], const vector_t n[4 * 3], const direction_t *direction, bool regular,
                      dependent_t *affine)
{
    const wide_t exact[3][3] = {
        {(wide_t)b[OX] + n[3 * OX], n[3 * EE], n[3 * OO]},
        {(wide_t)b[OY] + n[3 * OY], n[3 * OO + 1], n[3 * EE + 1]},
        {(wide_t)b[EE] + n[3 * EE + 2], n[3 * OX + 1], n[3 * OY + 1]},
    };
    wide_t any = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            any |= significant(exact[i][j]);
    affine->needed = bit_length(any);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            affine->sums[i][j] = (scalar_t)block_normalize(exact[i][j], affine->needed, SUMS);

    wide_t u[3]; // u0, ux, -uy
    for (int j = 0; j < 3; j++)
        u[j] = (wide_t)affine->sums[0][j] * direction->sin - (wide_t)affine->sums[1][j] * direction->cos;
    wide_t num0 = u[0], num1 = u[1], den = -u[2];
    if (direction->sweep_y) {
        num0 = -u[0];
        num1 = -u[2];
        den = u[1];
    }
    const int needed = bit_length(significant(num0) | significant(num1) | significant(den));
    num0 = block_normalize(num0, needed, DIVISION);
    num1 = block_normalize(num1, needed, DIVISION);
    den = block_normalize(den, needed, DIVISION);
    const wide_t limit = COEFFICIENT_LIMIT * magnitude(den);
    affine->vanishing = magnitude(num0) >= limit || magnitude(num1) >= limit;
    affine->alpha = 0;
    affine->beta = 0;
    if (regular && !affine->vanishing) {
        affine->alpha = (scalar_t)divide(num0, den, SCALAR_FRACTION);
        affine->beta = (scalar_t)divide(num1, den, SCALAR_FRACTION);
    }
}
