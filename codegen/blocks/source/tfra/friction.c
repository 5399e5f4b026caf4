// mu_ind and mu_dep of the chosen candidate (Eqs. 17, 18, 26, 27).

typedef struct {
    int index;
    wide_t mu_ind;
    wide_t mu_x;
    wide_t mu_y;
    bool out_of_range;
} friction_t;

static friction_t friction(int index, const direction_t *direction, const dependent_t *affine, bool regular)
{
    friction_t chosen = {0, 0, 0, 0, false};
    if (regular) {
        chosen.index = index;
        chosen.mu_ind = MU_GRID[index];
        if (direction->negative)
            chosen.mu_ind = -(wide_t)MU_GRID[STEPS - index];
    }
    const wide_t dependent = affine->alpha + round_shift(affine->beta * chosen.mu_ind, SCALAR_FRACTION);
    const wide_t mu_dep = saturate(dependent, SCALAR);
    chosen.mu_x = direction->sweep_y ? mu_dep : chosen.mu_ind;
    chosen.mu_y = direction->sweep_y ? chosen.mu_ind : mu_dep;
    chosen.out_of_range = magnitude(mu_dep) > (wide_t)1 << SCALAR_FRACTION;
    return chosen;
}
