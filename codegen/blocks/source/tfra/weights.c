// The weights n = -w_z >= 0: the compressive part of C33^-1 b (Eq. 9); frames that are not swept keep it unclipped.

static void weights(const vector_t solution[4 * QUADS], bool regular, vector_t n[4 * QUADS])
{
    vector_t taxels[4 * QUADS];
    butterfly(QUADS, solution, taxels);
    for (int q = 0; q < 4 * QUADS; q++) {
        wide_t weight = -round_shift(taxels[q], 2);
        if (regular)
            weight = positive(weight);
        taxels[q] = (vector_t)weight;
    }
    butterfly(QUADS, taxels, n);
}
