// Matrix-vector products: block-normalised operands times folded coefficients, exact sums, one rounding.

// An exact sum as a word of the vector grid.
static wide_t round_product(wide_t sum, int places)
{
#if HALF_EVEN
    if (places > 0) {
        const bool even = ((sum >> places) & 1) == 0;
        return (sum + scale_up(1, places - 1) - (even ? 1 : 0)) >> places;
    }
#elif TRUNCATE
    if (places > 0)
        return sum >> places;
#endif
    return round_shift(sum, places);
}

// Operand words of a plane of a vector, as block_normalize; returns the bits that it needed beside the sign.
static int operand(int count, const vector_t *plane, int bits, operand_t *words)
{
    vector_t any = 0;
    for (int q = 0; q < count; q++)
        any |= plane[q] < 0 ? ~plane[q] : plane[q];
    const int needed = bit_length(any);
    const int shift = needed - (bits - 1);
    if (shift <= 0) {
        //+ const unsigned up = (unsigned)-shift;
        for (int q = 0; q < count; q++)
            words[q] = (operand_t)(plane[q] * ((vector_t)1 << -shift)); //+ words[q] = (operand_t)(plane[q] << up);
    } else {
        const unsigned down = (unsigned)shift;
        const vector_t top = ((vector_t)1 << (bits - 1)) - 1;
        for (int q = 0; q < count; q++) {
            const vector_t word = (plane[q] + ((vector_t)1 << (down - 1))) >> down;
            words[q] = (operand_t)(word > top ? top : word);
        }
    }
    return needed;
}

// Operand words of all planes, and the bits that each needed.
static void operands(int count, const vector_t *x, int bits, operand_t *words, int needed[4])
{
    for (int p = 0; p < 4; p++)
        needed[p] = operand(count, x + p * count, bits, words + p * count);
}

// One operator: quads results of count operand words in each parity, from the operand's parity ^ flip.
//+ template <int quads, int count, int reuse>
static void matvec(int quads, int count, const coefficient_t *rows, const operand_t *words, int flip, int point,
                   const int needed[4], vector_t *out)
{
    for (int p = 0; p < 4; p++) {
        const operand_t *plane = words + (p ^ flip) * count;
        const int shift = point - needed[p ^ flip];
        for (int i = 0; i < quads; i++) {
            //+ #pragma HLS PIPELINE II=reuse
            const coefficient_t *row = rows + (p * quads + i) * count;
            accumulator_t sum = 0;
            for (int k = 0; k < count; k++)
                sum += (accumulator_t)row[k] * plane[k];
            out[p * quads + i] = (vector_t)round_product(sum, shift);
        }
    }
}
