// Unscaled forces of the chosen candidate, at the taxels, of one plane: f = A-dagger d + scalar * n (Eqs. 7, 10, 28).

static void forces(const vector_t product[4 * QUADS], scalar_t scalar, const vector_t n[4 * QUADS],
                   vector_t plane[TAXELS])
{
    vector_t folded[4 * QUADS], taxels[4 * QUADS];
    combine(product, scalar, n, folded);
    butterfly(QUADS, folded, taxels);
    for (int q = 0; q < 4 * QUADS; q++)
        taxels[q] = (vector_t)round_shift(taxels[q], FORCE_DROP);
    to_taxels(taxels, plane);
}
