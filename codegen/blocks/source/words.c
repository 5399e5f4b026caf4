// Result words.

// Saturates; bits of *beyond are set where wide does not fit.
static force_t result_word(wide_t wide, wide_t *beyond)
{
    const wide_t word = saturate(wide, OUTPUT);
    *beyond |= wide ^ word;
    return (force_t)word;
}
