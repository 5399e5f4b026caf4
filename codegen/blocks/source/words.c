// Result words, and what estimators find them from.

// F*.
typedef struct {
    scalar_t words[3]; // on the vector grid, times 2^exponent
    int exponent;
} resultant_t;

// Saturates; bits of *beyond are set where wide does not fit.
static force_t result_word(wide_t wide, wide_t *beyond)
{
    const wide_t word = saturate(wide, OUTPUT);
    *beyond |= wide ^ word;
    return (force_t)word;
}
