// The resultant and its plausibility from the outputs of the network.

// The outputs, F_x, F_y, F_z and the uncertainty, in two quads.
static void outputs(const vector_t total[4 * 2], wide_t out[4])
{
    out[0] = total[2 * OX];
    out[1] = total[2 * OY];
    out[2] = total[2 * EE];
    out[3] = total[2 * EE + 1];
}

// F_x, F_y and F_z normalised together.
static resultant_t resultant(const wide_t force[3])
{
    resultant_t total;
    const int needed = bit_length(significant(force[0]) | significant(force[1]) | significant(force[2]));
    for (int i = 0; i < 3; i++)
        total.words[i] = (scalar_t)block_normalize(force[i], needed, DIVISION);
    total.exponent = DIVISION - 1 - needed;
    return total;
}

// F pulls, or its uncertainty is over the threshold.
static bool implausible(const wide_t out[4])
{
    return out[2] >= 0 || scale_up(positive(out[3]), THRESHOLD_FRACTION) > THRESHOLD * magnitude(out[2]);
}
