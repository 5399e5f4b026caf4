// CORDIC in vectoring mode: the modulus, times the CORDIC gain, and the angle of a vector, by additions alone.

typedef struct {
    wide_t modulus;
    int angle; // in 2^-CORDIC turns
} polar_t;

static polar_t cordic(wide_t x, wide_t y)
{
    polar_t polar;
    const bool left = x < 0;
    wide_t angle = 0;
    if (left) {
        x = -x;
        y = -y;
        angle = (wide_t)1 << (CORDIC + ANGLE_GUARD - 1);
    }
    for (int i = 0; i < CORDIC; i++) {
        const wide_t dx = x >> i, dy = y >> i;
        if (y < 0) {
            x = x - dy;
            y = y + dx;
            angle = angle - ANGLE_TABLE[i];
        } else {
            x = x + dy;
            y = y - dx;
            angle = angle + ANGLE_TABLE[i];
        }
    }
    polar.modulus = x;
    polar.angle = (int)(round_shift(angle, ANGLE_GUARD) & (((wide_t)1 << CORDIC) - 1));
    return polar;
}
