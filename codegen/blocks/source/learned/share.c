// The resultant, shared among the taxels as their normal forces p: f = F p / sum of p.

typedef struct {
    scalar_t mantissa[3];
    int shift;  // a taxel's force is p * mantissa / 2^shift
    bool even;  // p is too small to tell anything: every taxel's is EVEN_WORD
} share_t;

// Right shift of p * mantissa, for a sum of p of length bits.
static int share_shift(const resultant_t *total, int length)
{
    const int significant_bits = DIVISION - 1 - total->exponent;
    return length - significant_bits + SCALAR - 2 + VECTOR_FRACTION - FORCE_FRACTION;
}

static void share(const resultant_t *total, const vector_t p[TAXELS], share_t *part)
{
    const wide_t top = ((wide_t)1 << (SCALAR - 1)) - 1;
    wide_t whole = 0;
    for (int t = 0; t < TAXELS; t++)
        whole += p[t];
    part->even = whole == 0 || share_shift(total, bit_length(whole)) < 0;
    if (part->even)
        whole = (wide_t)TAXELS * EVEN_WORD;
    const int length = bit_length(whole);
    const wide_t under = normalize(whole, length, DIVISION);
    for (int i = 0; i < 3; i++) {
        const wide_t ratio = divide(magnitude(total->words[i]), under, SCALAR - 1);
        part->mantissa[i] = (scalar_t)(ratio < top ? ratio : top);
        if (total->words[i] < 0)
            part->mantissa[i] = -part->mantissa[i];
    }
    part->shift = share_shift(total, length);
}
