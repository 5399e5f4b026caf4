// A scaled force or resultant as a result word (Eq. 31).

static force_t scaling(wide_t unscaled, const gain_t *factor, int shift, wide_t *beyond)
{
    return result_word(round_shift(unscaled * factor->mantissa, shift), beyond);
}
