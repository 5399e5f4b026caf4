// All blocks of the learned estimator in dataflow order.

static void estimate(state_t *state, const code_t codes[TAXELS], result_t *result)
{
    frame_t frame;
    wide_t out[4];
    wide_t beyond = 0;

    normaliser(codes, &frame);
    fold(frame.stress, state->b);
#if TAXEL_FORCES
    product_first(state->b, state->sums1, state->direct, state->inverse);
#else
    product_first(state->b, state->sums1, state->direct);
#endif
    activation(UNITS1, state->sums1, state->h1);
    product_second(state->h1, state->sums2, state->read1);
    activation(UNITS2, state->sums2, state->h2);
    product_read(state->h2, state->read2);
    for (int i = 0; i < 4 * 2; i++) {
        state->total[i] = 0;
        if (frame.contact)
            state->total[i] = state->direct[i] + state->read1[i] + state->read2[i];
    }
    outputs(state->total, out);

    const resultant_t force = resultant(out);
    const bool still = force.words[0] == 0 && force.words[1] == 0;
    const polar_t turned = cordic(force.words[0], force.words[1]);
    const friction_t chosen = friction(&force, turned.modulus);
    for (int axis = 0; axis < 3; axis++)
        result->resultant[axis] = result_word(round_shift(out[axis], VECTOR_FRACTION - FORCE_FRACTION), &beyond);
    result->uncertainty = result_word(round_shift(positive(out[3]), VECTOR_FRACTION - FORCE_FRACTION), &beyond);
#if TAXEL_FORCES
    forces(state, &force, &chosen, result->forces, &beyond);
#endif
    result->exponent = (exponent_t)frame.exponent;
    result->phi = still ? (phi_t)0 : (phi_t)turned.angle;
    result->mu = (mu_t)chosen.mu;
    result->mu_x = (mu_t)chosen.mu_x;
    result->mu_y = (mu_t)chosen.mu_y;
    result->status = (status_t)((frame.contact ? 0 : NO_CONTACT)
        | (frame.contact && still ? NO_DIRECTION : 0)
        | (frame.contact && implausible(out) ? IMPLAUSIBLE : 0)
        | (frame.saturated ? INPUT_SATURATED : 0)
        | (beyond != 0 || chosen.overflow ? OUTPUT_SATURATED : 0));
}
