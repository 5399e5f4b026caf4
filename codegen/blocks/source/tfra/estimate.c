// All blocks of TFRA in dataflow order.

static void estimate(state_t *state, const code_t codes[TAXELS], result_t *result)
{
    frame_t frame;
    dependent_t affine;

    normaliser(codes, &frame);
    const direction_t direction = centroids(codes);
    fold(frame.stress, state->b);
    product_contact(state->b, state->c33_inv, state->sums_b);
    weights(state->c33_inv, frame.regular, state->n);
    product_residual(state->n, state->sums_n, state->c33, state->c31, state->c32);
    dependent(state->sums_b, state->sums_n, &direction, frame.regular, &affine);

    for (int i = 0; i < 4 * QUADS; i++)
        state->b[i] = state->b[i] + state->c33[i];
    if (direction.sweep_y) {
        combine(state->b, affine.alpha, state->c31, state->e0);
        combine(state->c32, affine.beta, state->c31, state->e1);
    } else {
        combine(state->b, affine.alpha, state->c32, state->e0);
        combine(state->c31, affine.beta, state->c32, state->e1);
    }
    product_normal(state->e0, state->normal0);
    product_normal(state->e1, state->normal1);
    for (int i = 0; i < 4 * QUADS; i++)
        state->normal0[i] = state->normal0[i] - state->c33[i];
    butterfly(QUADS, state->normal0, state->d);
    to_taxels(state->d, state->p);
    butterfly(QUADS, state->normal1, state->d);
    to_taxels(state->d, state->q);

    const int index = sweep(&frame, state->p, state->q, direction.negative);
    const friction_t chosen = friction(index, &direction, &affine, frame.regular);
    const resultant_t total = resultant(&affine, &chosen, frame.regular);
    const gain_t factor = gain(&total, &frame);
    combine(state->e0, chosen.mu_ind, state->e1, state->d);
    product_force(state->d, state->pinv1, state->pinv2, state->pinv3);
    const vector_t *products[3] = {state->pinv1, state->pinv2, state->pinv3};
    const wide_t scalars[3] = {chosen.mu_x, chosen.mu_y, -((wide_t)1 << SCALAR_FRACTION)};
    wide_t beyond = 0;
    for (int axis = 0; axis < 3; axis++) {
        const bool kept = axis < 2 ? frame.regular : frame.contact;
        forces(products[axis], scalars[axis], state->n, state->plane);
        result->resultant[axis] = 0;
        if (kept)
            result->resultant[axis] = scaling(total.words[axis], &factor, factor.resultant_shift, &beyond);
        for (int t = 0; t < TAXELS; t++) {
            result->forces[axis][t] = 0;
            if (kept)
                result->forces[axis][t] = scaling(state->plane[t], &factor, factor.force_shift, &beyond);
        }
    }
    result->exponent = (exponent_t)frame.exponent;
    result->sweep_index = (sweep_index_t)chosen.index;
    result->phi = 0;
    if (frame.regular) {
        const int guard = DIVISION - DIRECTION;
        result->phi = (phi_t)cordic(scale_up(direction.cos, guard), scale_up(direction.sin, guard)).angle;
    }
    result->mu = (mu_t)factor.mu;
    result->mu_x = (mu_t)chosen.mu_x;
    result->mu_y = (mu_t)chosen.mu_y;
    result->status = (status_t)((frame.contact ? 0 : NO_CONTACT)
        | (frame.contact && !frame.regular ? COMPRESSION_ONLY : 0)
        | (frame.regular && direction.vanishing ? NO_DIRECTION : 0)
        | (frame.regular && affine.vanishing ? VANISHING_DENOMINATOR : 0)
        | (frame.regular && chosen.out_of_range ? DEPENDENT_OUT_OF_RANGE : 0)
        | (frame.saturated ? INPUT_SATURATED : 0)
        | (beyond != 0 || (factor.overflow && frame.contact) ? OUTPUT_SATURATED : 0));
}
