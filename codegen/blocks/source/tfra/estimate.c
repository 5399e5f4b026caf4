// All blocks of TFRA in dataflow order, in stages that may work on a frame each.  What two stages read is written twice.

// A frame beside its vectors; every stage adds what it finds.
typedef struct {
    frame_t frame;
    direction_t direction;
} seen_t;

typedef struct {
    seen_t seen;
    dependent_t affine;
} coupled_t;

typedef struct {
    coupled_t coupled;
    friction_t friction;
    resultant_t total;
    gain_t factor;
} chosen_t;

// The stress, and the weights of it.
static void contact(const code_t codes[TAXELS], seen_t *seen, code_t stress[TAXELS], vector_t b[4 * QUADS],
                    vector_t sums[4], vector_t n[4 * QUADS], vector_t kept_n[4 * QUADS])
{
    vector_t folded[4 * QUADS], solution[4 * QUADS], found[4 * QUADS];
    code_t words[TAXELS];
    normaliser(codes, words, &seen->frame);
    seen->direction = centroids(codes);
    fold(words, folded);
    product_contact(folded, solution, sums);
    weights(solution, seen->frame.regular, found);
    for (int t = 0; t < TAXELS; t++)
        stress[t] = words[t];
    for (int i = 0; i < 4 * QUADS; i++) {
        b[i] = folded[i];
        n[i] = found[i];
        kept_n[i] = found[i];
    }
}

// The dependent friction, and with it e = e0 + mu_ind e1 (Eq. 8).
static void residual(const seen_t *seen, const vector_t b[4 * QUADS], const vector_t sums_b[4],
                     const vector_t n[4 * QUADS], coupled_t *coupled, vector_t c33[4 * QUADS], vector_t e0[4 * QUADS],
                     vector_t e1[4 * QUADS], vector_t kept_e0[4 * QUADS], vector_t kept_e1[4 * QUADS])
{
    vector_t sums[4 * 3], along_z[4 * QUADS], along_x[4 * QUADS], along_y[4 * QUADS], found[4 * QUADS];
    dependent_t affine;
    product_residual(n, sums, along_z, along_x, along_y);
    dependent(sums_b, sums, &seen->direction, seen->frame.regular, &affine);
    coupled->seen = *seen;
    coupled->affine = affine;
    for (int i = 0; i < 4 * QUADS; i++) {
        c33[i] = along_z[i];
        along_z[i] = b[i] + along_z[i];
    }
    if (seen->direction.sweep_y)
        combine(along_z, affine.alpha, along_x, found);
    else
        combine(along_z, affine.alpha, along_y, found);
    for (int i = 0; i < 4 * QUADS; i++) {
        e0[i] = found[i];
        kept_e0[i] = found[i];
    }
    if (seen->direction.sweep_y)
        combine(along_y, affine.beta, along_x, found);
    else
        combine(along_x, affine.beta, along_y, found);
    for (int i = 0; i < 4 * QUADS; i++) {
        e1[i] = found[i];
        kept_e1[i] = found[i];
    }
}

// The normal stress p + mu_ind q of the forces that cancel e.
static void normal(const vector_t e0[4 * QUADS], const vector_t e1[4 * QUADS], const vector_t c33[4 * QUADS],
                   vector_t p[TAXELS], vector_t q[TAXELS])
{
    vector_t found[4 * QUADS], mirrors[4 * QUADS];
    product_normal(e0, found);
    for (int i = 0; i < 4 * QUADS; i++)
        found[i] = found[i] - c33[i];
    butterfly(QUADS, found, mirrors);
    to_taxels(mirrors, p);
    product_normal(e1, found);
    butterfly(QUADS, found, mirrors);
    to_taxels(mirrors, q);
}

// The candidate, and what follows of it.
static void choice(const coupled_t *coupled, const code_t stress[TAXELS], const vector_t p[TAXELS],
                   const vector_t q[TAXELS], chosen_t *chosen)
{
    const frame_t frame = coupled->seen.frame;
    const direction_t direction = coupled->seen.direction;
    const int index = sweep(stress, frame.exponent, p, q, direction.negative);
    chosen->coupled = *coupled;
    chosen->friction = friction(index, &direction, &coupled->affine, frame.regular);
    chosen->total = resultant(&coupled->affine, &chosen->friction, frame.regular);
    chosen->factor = gain(&chosen->total, &frame);
}

// The forces along an axis; none of what is not kept.
static void along(int axis, const vector_t product[4 * QUADS], scalar_t scalar, const vector_t n[4 * QUADS], bool kept,
                  const chosen_t *chosen, result_t *result, wide_t *beyond)
{
    vector_t plane[TAXELS];
    const gain_t factor = chosen->factor;
    forces(product, scalar, n, plane);
    result->resultant[axis] = 0;
    if (kept)
        result->resultant[axis] = scaling(chosen->total.words[axis], &factor, factor.resultant_shift, beyond);
    for (int t = 0; t < TAXELS; t++) {
        result->forces[axis][t] = 0;
        if (kept)
            result->forces[axis][t] = scaling(plane[t], &factor, factor.force_shift, beyond);
    }
}

static void components(const chosen_t *chosen, const vector_t e0[4 * QUADS], const vector_t e1[4 * QUADS],
                       const vector_t n[4 * QUADS], result_t *result)
{
    vector_t d[4 * QUADS], pinv1[4 * QUADS], pinv2[4 * QUADS], pinv3[4 * QUADS];
    wide_t beyond = 0;
    const frame_t frame = chosen->coupled.seen.frame;
    const direction_t direction = chosen->coupled.seen.direction;
    const friction_t found = chosen->friction;
    combine(e0, found.mu_ind, e1, d);
    product_force(d, pinv1, pinv2, pinv3);
    along(0, pinv1, found.mu_x, n, frame.regular, chosen, result, &beyond);
    along(1, pinv2, found.mu_y, n, frame.regular, chosen, result, &beyond);
    along(2, pinv3, -((scalar_t)1 << SCALAR_FRACTION), n, frame.contact, chosen, result, &beyond);
    result->exponent = (exponent_t)frame.exponent;
    result->sweep_index = (sweep_index_t)found.index;
    result->phi = 0;
    if (frame.regular) {
        const int guard = DIVISION - DIRECTION;
        result->phi = (phi_t)cordic(scale_up(direction.cos, guard), scale_up(direction.sin, guard)).angle;
    }
    result->mu = (mu_t)chosen->factor.mu;
    result->mu_x = (mu_t)found.mu_x;
    result->mu_y = (mu_t)found.mu_y;
    result->status = (status_t)((frame.contact ? 0 : NO_CONTACT)
        | (frame.contact && !frame.regular ? COMPRESSION_ONLY : 0)
        | (frame.regular && direction.vanishing ? NO_DIRECTION : 0)
        | (frame.regular && chosen->coupled.affine.vanishing ? VANISHING_DENOMINATOR : 0)
        | (frame.regular && found.out_of_range ? DEPENDENT_OUT_OF_RANGE : 0)
        | (frame.saturated ? INPUT_SATURATED : 0)
        | (beyond != 0 || (chosen->factor.overflow && frame.contact) ? OUTPUT_SATURATED : 0));
}

static void estimate(state_t *state, const code_t codes[TAXELS], result_t *result)
{
    seen_t seen;
    coupled_t coupled;
    chosen_t chosen;
    contact(codes, &seen, state->stress, state->b, state->sums, state->n, state->kept_n);
    residual(&seen, state->b, state->sums, state->n, &coupled, state->c33, state->e0, state->e1, state->kept_e0,
             state->kept_e1);
    normal(state->e0, state->e1, state->c33, state->p, state->q);
    choice(&coupled, state->stress, state->p, state->q, &chosen);
    components(&chosen, state->kept_e0, state->kept_e1, state->kept_n, result);
}
