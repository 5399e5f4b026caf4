// Resultant of the unscaled forces (Eq. 12) from the sums A_pq: F* = A_p0 + mu_x A_p1 + mu_y A_p2.

static resultant_t resultant(const dependent_t *affine, const friction_t *chosen, bool regular)
{
    resultant_t total;
    wide_t exact[3];
    wide_t any = 0;
    for (int i = 0; i < 3; i++) {
        exact[i] = scale_up(affine->sums[i][0], SCALAR_FRACTION) + (wide_t)affine->sums[i][1] * chosen->mu_x
                 + (wide_t)affine->sums[i][2] * chosen->mu_y;
        if (i < 2 && !regular)
            exact[i] = 0;
        any |= significant(exact[i]);
    }
    const int needed = bit_length(any);
    for (int i = 0; i < 3; i++)
        total.words[i] = (scalar_t)block_normalize(exact[i], needed, DIVISION);
    total.exponent = (SUMS - 1 - affine->needed) + SCALAR_FRACTION + (DIVISION - 1 - needed);
    return total;
}
