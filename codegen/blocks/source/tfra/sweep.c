// The exact integer sweep: B^z and B^xy of every candidate, and the choice between them (Eqs. 23-27).

// Sum over the taxels of max(0, first + k * step) for every candidate k.
// A term changes its sign once at most: a falling one counts up to one k, a rising one from one on.
static void positive_sums(const candidate_t first[TAXELS], const vector_t step[TAXELS], wide_t sums[CANDIDATES])
{
    wide_t firsts[CANDIDATES + 1], steps[CANDIDATES + 1];
    wide_t first_sum = 0, step_sum = 0;
    // Candidates, of those from 0 on, with the sign of the first.  C vectorises over taxels, a pipeline takes one a cycle.
    wide_t change[TAXELS] = {0}; //+ step_t change[TAXELS];
    for (int bit = SWEEP_HALF; bit; bit >>= 1) //+ for (int t = 0; t < TAXELS; t++) {
        //+ #pragma HLS PIPELINE II=1
        //+ change[t] = 0;
        for (int t = 0; t < TAXELS; t++) { //+ for (int bit = SWEEP_HALF; bit; bit >>= 1) {
            const wide_t more = change[t] + bit; //+ const step_t more = change[t] + bit;
            const wide_t value = first[t] + (more - 1) * step[t];
            const bool same = (step[t] > 0) == (value <= 0) && more <= CANDIDATES;
            change[t] = same ? more : change[t];
        }
    //+ }
    for (int k = 0; k < CANDIDATES + 1; k++) {
        firsts[k] = 0;
        steps[k] = 0;
    }
    for (int t = 0; t < TAXELS; t++) {
        if (step[t] <= 0) {
            first_sum += first[t];
            step_sum += step[t];
            firsts[change[t]] -= first[t];
            steps[change[t]] -= step[t];
        } else {
            firsts[change[t]] += first[t];
            steps[change[t]] += step[t];
        }
    }
    for (int k = 0; k < CANDIDATES; k++) {
        first_sum += firsts[k];
        step_sum += steps[k];
        sums[k] = first_sum + k * step_sum;
    }
}

static int sweep(const code_t stress[TAXELS], int exponent, const vector_t p[TAXELS], const vector_t q[TAXELS],
                 bool negative)
{
    candidate_t x[TAXELS];
    vector_t opposite[TAXELS];
    wide_t b_z[CANDIDATES], b_xy[CANDIDATES];
    wide_t measured = 0;
    for (int t = 0; t < TAXELS; t++) {
        candidate_t start = p[t];
        if (negative)
            start = start - q[t];
        x[t] = STEPS * start;
    }
    positive_sums(x, q, b_z);
    for (int t = 0; t < TAXELS; t++) {
        const candidate_t found = (candidate_t)SWEEP_UNIT * stress[t];
        measured += positive(found);
        x[t] = found - x[t];
        opposite[t] = -q[t];
    }
    positive_sums(x, opposite, b_xy);

    wide_t least = b_z[0];
    for (int k = 1; k < CANDIDATES; k++)
        least = b_z[k] < least ? b_z[k] : least;
    const wide_t limit = least + TOLERANCE[exponent];
    wide_t best = -1;
    int index = 0;
    for (int k = 0; k < CANDIDATES; k++) {
        const wide_t error = magnitude(b_xy[k] - measured);
        if (b_z[k] <= limit && (best < 0 || error < best)) {
            best = error;
            index = k;
        }
    }
    return index;
}
