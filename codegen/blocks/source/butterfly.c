// Mirror folding: four mirror taxels to four parities and back, with additions alone.
// A vector of count quads is four planes of count words: mirror taxels, or the parities EE, OX, OY, OO.

static void butterfly(int count, const vector_t *in, vector_t *out)
{
    for (int q = 0; q < count; q++) {
        const vector_t a = in[q], b = in[count + q], c = in[2 * count + q], d = in[3 * count + q];
        out[q] = a + b + c + d;
        out[count + q] = a - b + c - d;
        out[2 * count + q] = a + b - c - d;
        out[3 * count + q] = a - b - c + d;
    }
}

// The folded stress on the vector grid, from row-major words.
static void fold(const code_t stress[TAXELS], vector_t b[4 * QUADS])
{
    vector_t planes[4 * QUADS];
    for (int q = 0; q < 4 * QUADS; q++)
        planes[q] = (vector_t)scale_up(stress[TAXEL_OF[q]], VECTOR_FRACTION);
    butterfly(QUADS, planes, b);
}
