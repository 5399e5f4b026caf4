// Forces at the taxels: the resultant, shared as the normal forces of the field.

static void forces(state_t *state, const resultant_t *total, const friction_t *chosen,
                   force_t out[3][TAXELS], wide_t *beyond)
{
    share_t part;
    activation(QUADS, state->inverse, state->p0);
    product_field(state->p0, state->shear_x, state->shear_y);
    field(state->inverse, state->shear_x, state->shear_y, chosen, state->p);
    share(total, state->p, &part);
    for (int axis = 0; axis < 3; axis++)
        for (int t = 0; t < TAXELS; t++) {
            const wide_t spread = part.even ? (wide_t)EVEN_WORD : (wide_t)state->p[t];
            out[axis][t] = result_word(round_shift(spread * part.mantissa[axis], part.shift), beyond);
        }
}
