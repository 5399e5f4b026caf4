// Normal forces at the taxels: the second pass, none of them negative.

// A scalar limited to the friction that the field may have.
static scalar_t bounded(scalar_t scalar)
{
    if (scalar > MOST_FRICTION)
        return MOST_FRICTION;
    if (scalar < -MOST_FRICTION)
        return -MOST_FRICTION;
    return scalar;
}

static void field(const vector_t still[4 * QUADS], const vector_t shear_x[4 * QUADS], const vector_t shear_y[4 * QUADS],
                  const friction_t *chosen, vector_t p[TAXELS])
{
    vector_t along_x[4 * QUADS], along_y[4 * QUADS], mirrors[4 * QUADS];
    combine(still, bounded(chosen->mu_x), shear_x, along_x);
    combine(along_x, bounded(chosen->mu_y), shear_y, along_y);
    butterfly(QUADS, along_y, mirrors);
    for (int i = 0; i < 4 * QUADS; i++)
        mirrors[i] = (vector_t)positive(mirrors[i]);
    to_taxels(mirrors, p);
}
