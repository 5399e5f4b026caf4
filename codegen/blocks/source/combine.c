// Vector updates z + scalar * x: x enters as a multiplier operand (Eqs. 7, 8, 10).

static void combine(const vector_t z[4 * QUADS], scalar_t scalar, const vector_t x[4 * QUADS], vector_t out[4 * QUADS])
{
    for (int p = 0; p < 4; p++) {
        operand_t words[QUADS];
        const int needed = operand(QUADS, x + p * QUADS, OPERAND_COMBINE, words);
        const int shift = SCALAR_FRACTION + OPERAND_COMBINE - 1 - needed;
        for (int q = 0; q < QUADS; q++)
            out[p * QUADS + q] = z[p * QUADS + q] + (vector_t)round_shift((wide_t)scalar * words[q], shift);
    }
}
