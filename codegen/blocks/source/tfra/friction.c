// mu_ind and mu_dep of the chosen candidate (Eqs. 17, 18, 26, 27).

typedef struct {
    int index;
    scalar_t mu_ind;
    scalar_t mu_x;
    scalar_t mu_y;
    bool out_of_range;
} friction_t;

static friction_t friction(int index, const direction_t *direction, const dependent_t *affine, bool regular)
{
    friction_t chosen = {0, 0, 0, 0, false};
    if (regular) {
        chosen.index = index;
        chosen.mu_ind = MU_GRID[index];
        if (direction->negative)
            chosen.mu_ind = -(scalar_t)MU_GRID[STEPS - index];
    }
    const wide_t dependent = affine->alpha + round_shift((wide_t)affine->beta * chosen.mu_ind, SCALAR_FRACTION);
    const scalar_t mu_dep = (scalar_t)saturate(dependent, SCALAR);
    chosen.mu_x = direction->sweep_y ? mu_dep : chosen.mu_ind;
    chosen.mu_y = direction->sweep_y ? chosen.mu_ind : mu_dep;
    chosen.out_of_range = magnitude(mu_dep) > (wide_t)1 << SCALAR_FRACTION;
    return chosen;
}
