// x of length bits, moved so that its top bit is bit bits - 1; bits below are cut off.
static wide_t normalize(wide_t x, int length, int bits)
{
    if (bits >= length)
        return scale_up(x, bits - length);
    return x >> (length - bits);
}
