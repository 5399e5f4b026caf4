// All blocks of the learned estimator in dataflow order, in stages that may work on a frame each.

// What the last stage makes words of.
typedef struct {
    frame_t frame;
    wide_t out[4];
    resultant_t force;
    polar_t turned;
    friction_t friction;
} found_t;

#if TAXEL_FORCES
static void first(const code_t codes[TAXELS], frame_t *frame, vector_t sums[4 * UNITS1], vector_t direct[4 * 2],
                  vector_t inverse[4 * QUADS])
#else
static void first(const code_t codes[TAXELS], frame_t *frame, vector_t sums[4 * UNITS1], vector_t direct[4 * 2])
#endif
{
    code_t stress[TAXELS];
    vector_t b[4 * QUADS];
    normaliser(codes, stress, frame);
    fold(stress, b);
#if TAXEL_FORCES
    product_first(b, sums, direct, inverse);
#else
    product_first(b, sums, direct);
#endif
}

static void second(const vector_t sums1[4 * UNITS1], vector_t sums2[4 * UNITS2], vector_t read[4 * 2])
{
    vector_t units[4 * UNITS1];
    activation(UNITS1, sums1, units);
    product_second(units, sums2, read);
}

// The outputs of the network, and what follows of them.
static void third(const vector_t sums[4 * UNITS2], const vector_t direct[4 * 2], const vector_t read1[4 * 2],
                  const frame_t *frame, found_t *found)
{
    vector_t units[4 * UNITS2], read2[4 * 2], total[4 * 2];
    activation(UNITS2, sums, units);
    product_read(units, read2);
    for (int i = 0; i < 4 * 2; i++) {
        total[i] = 0;
        if (frame->contact)
            total[i] = direct[i] + read1[i] + read2[i];
    }
    outputs(total, found->out);
    found->frame = *frame;
    found->force = resultant(found->out);
    found->turned = cordic(found->force.words[0], found->force.words[1]);
    found->friction = friction(&found->force, found->turned.modulus);
}

#if TAXEL_FORCES
static void components(const found_t *found, const vector_t inverse[4 * QUADS], result_t *result)
#else
static void components(const found_t *found, result_t *result)
#endif
{
    wide_t beyond = 0;
    const frame_t frame = found->frame;
    const friction_t chosen = found->friction;
    const bool still = found->force.words[0] == 0 && found->force.words[1] == 0;
    for (int axis = 0; axis < 3; axis++)
        result->resultant[axis] = result_word(round_shift(found->out[axis], VECTOR_FRACTION - FORCE_FRACTION), &beyond);
    result->uncertainty = result_word(round_shift(positive(found->out[3]), VECTOR_FRACTION - FORCE_FRACTION), &beyond);
#if TAXEL_FORCES
    forces(inverse, &found->force, &chosen, result->forces, &beyond);
#endif
    result->exponent = (exponent_t)frame.exponent;
    result->phi = 0;
    if (!still)
        result->phi = (phi_t)found->turned.angle;
    result->mu = (mu_t)chosen.mu;
    result->mu_x = (mu_t)chosen.mu_x;
    result->mu_y = (mu_t)chosen.mu_y;
    result->status = (status_t)((frame.contact ? 0 : NO_CONTACT)
        | (frame.contact && still ? NO_DIRECTION : 0)
        | (frame.contact && implausible(found->out) ? IMPLAUSIBLE : 0)
        | (frame.saturated ? INPUT_SATURATED : 0)
        | (beyond != 0 || chosen.overflow ? OUTPUT_SATURATED : 0));
}

static void estimate(state_t *state, const code_t codes[TAXELS], result_t *result)
{
    frame_t frame;
    found_t found;
#if TAXEL_FORCES
    first(codes, &frame, state->sums1, state->direct, state->inverse);
#else
    first(codes, &frame, state->sums1, state->direct);
#endif
    second(state->sums1, state->sums2, state->read);
    third(state->sums2, state->direct, state->read, &frame, &found);
#if TAXEL_FORCES
    components(&found, state->inverse, result);
#else
    components(&found, result);
#endif
}
