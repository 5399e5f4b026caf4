// Forces at the taxels: the resultant, shared as the normal forces of the field.

static void forces(const vector_t inverse[4 * QUADS], const resultant_t *total, const friction_t *chosen,
                   force_t out[3][TAXELS], wide_t *beyond)
{
    vector_t p0[4 * QUADS], shear_x[4 * QUADS], shear_y[4 * QUADS], p[TAXELS];
    share_t part;
    activation(QUADS, inverse, p0);
    product_field(p0, shear_x, shear_y);
    field(inverse, shear_x, shear_y, chosen, p);
    share(total, p, &part);
    for (int axis = 0; axis < 3; axis++)
        for (int t = 0; t < TAXELS; t++) {
            const wide_t spread = part.even ? (wide_t)EVEN_WORD : (wide_t)p[t];
            out[axis][t] = result_word(round_shift(spread * part.mantissa[axis], part.shift), beyond);
        }
}
