// Exact integer primitives of all blocks.

// x * 2^places; places >= 0.
static wide_t scale_up(wide_t x, int places)
{
    return x * ((wide_t)1 << places); //+ return x << (unsigned)places;
}

// x / 2^places rounded half up; negative places multiply.
static wide_t round_shift(wide_t x, int places)
{
    if (places <= 0)
        return scale_up(x, -places);
    const unsigned down = places > 62 ? 62u : (unsigned)places;
    return (x + ((wide_t)1 << (down - 1))) >> down;
}

// x limited to a signed word of bits.
static wide_t saturate(wide_t x, int bits)
{
    const wide_t top = ((wide_t)1 << (bits - 1)) - 1;
    if (x > top)
        return top;
    if (x < -top - 1)
        return -top - 1;
    return x;
}

static wide_t magnitude(wide_t x)
{
    if (x < 0)
        return -x;
    return x;
}

// x where it is positive, else 0.
static wide_t positive(wide_t x)
{
    if (x < 0)
        return 0;
    return x;
}

// x ^ sign(x): the bits of x that its two's complement needs beside the sign.
static wide_t significant(wide_t x)
{
    return x ^ (x >> 63);
}

// Position of the highest set bit of x >= 0, plus one; 0 of 0.
static int bit_length(wide_t x)
{
    int length = 0;
    for (int step = 32; step; step >>= 1) {
        //+ #pragma HLS UNROLL
        if ((x >> step) != 0) {
            x = x >> step;
            length += step;
        }
    }
    if (x != 0)
        length += 1;
    return length;
}

// x as one of some words that need needed bits beside the sign, scaled to fill bits, rounded, saturated.
static wide_t block_normalize(wide_t x, int needed, int bits)
{
    return saturate(round_shift(x, needed - (bits - 1)), bits);
}

// numerator / denominator with fraction bits, its magnitude rounded half up; |numerator| < 2^(61 - fraction).
static wide_t divide(wide_t numerator, wide_t denominator, int fraction)
{
    const wide_t doubled = scale_up(magnitude(numerator), fraction + 1) / magnitude(denominator);
    const wide_t quotient = (doubled + 1) >> 1;
    if ((numerator < 0) != (denominator < 0))
        return -quotient;
    return quotient;
}
