// |F*|, mu and the gain F_sens / F* (Eqs. 15, 29-31).

typedef struct {
    scalar_t mantissa;
    int force_shift;     // right shifts that bring a force, or a resultant, times the mantissa to result words
    int resultant_shift;
    wide_t mu;
    bool overflow;       // mu or the gain is limited
} gain_t;

static gain_t gain(const resultant_t *total, const frame_t *frame)
{
    gain_t factor;
    const wide_t tangential = cordic(magnitude(total->words[0]), magnitude(total->words[1])).modulus;
    const wide_t normal = (magnitude(total->words[2]) * CORDIC_GAIN) >> (CORDIC - 2);
    const wide_t modulus = cordic(tangential, normal).modulus;
    const wide_t numerator = frame->magnitude * CORDIC_GAIN_SQUARED;
    const wide_t top_mu = ((wide_t)1 << (SCALAR - 1)) - 1;
    const bool unbounded = frame->regular && tangential >= MU_LIMIT * normal;
    int exponent = NORMAL_EXPONENT;
    factor.mu = 0;
    factor.mantissa = NORMAL_MANTISSA;
    if (frame->regular) {
        const int n_bits = bit_length(numerator), m_bits = bit_length(modulus);
        const wide_t over = normalize(numerator, n_bits, DIVISION);
        const wide_t under = normalize(modulus, m_bits, DIVISION);
        const wide_t quotient = divide(over, under > 0 ? under : (wide_t)1, SCALAR - 1);
        const wide_t top = ((wide_t)1 << SCALAR) - 1;
        factor.mantissa = (scalar_t)(quotient < top ? quotient : top);
        exponent = (SCALAR - 1) + (CORDIC - 3) + m_bits - n_bits - total->exponent;
        factor.mu = top_mu;
        if (!unbounded) {
            const wide_t ratio = divide(tangential, normal > 0 ? normal : (wide_t)1, SCALAR_FRACTION);
            factor.mu = ratio < top_mu ? ratio : top_mu;
        }
    }
    factor.force_shift = exponent + 2 - FORCE_DROP - FORCE_FRACTION;
    factor.resultant_shift = exponent + total->exponent - FORCE_FRACTION;
    factor.overflow = unbounded || (frame->regular && modulus == 0) || factor.force_shift < 0
                   || factor.resultant_shift < 0;
    if (factor.force_shift < 0)
        factor.force_shift = 0;
    if (factor.resultant_shift < 0)
        factor.resultant_shift = 0;
    return factor;
}
