// Friction of the resultant (Eqs. 15, 16).

typedef struct {
    scalar_t mu;
    scalar_t mu_x;
    scalar_t mu_y;
    bool overflow; // one of them is limited
} friction_t;

// force / normal as a scalar, limited to the longest one; 0 of no force.
static scalar_t quotient(wide_t force, wide_t normal, bool *overflow)
{
    const scalar_t top = ((scalar_t)1 << (SCALAR - 1)) - 1;
    if (force != 0 && magnitude(force) >= MU_LIMIT * normal) {
        *overflow = true;
        if (force < 0)
            return -top;
        return top;
    }
    const wide_t ratio = divide(force, normal > 0 ? normal : (wide_t)1, SCALAR_FRACTION);
    if (ratio > top)
        return top;
    if (ratio < -top)
        return -top;
    return (scalar_t)ratio;
}

// The tangential modulus is times the CORDIC gain.
static friction_t friction(const resultant_t *total, wide_t modulus)
{
    friction_t chosen = {0, 0, 0, false};
    const wide_t normal = magnitude(total->words[2]);
    chosen.mu = quotient(modulus, (normal * CORDIC_GAIN) >> (CORDIC - 2), &chosen.overflow);
    chosen.mu_x = quotient(total->words[0], normal, &chosen.overflow);
    chosen.mu_y = quotient(total->words[1], normal, &chosen.overflow);
    return chosen;
}
