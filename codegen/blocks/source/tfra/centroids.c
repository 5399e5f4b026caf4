// Direction of the tangential force from the centroids of compression and traction (Eqs. 11, 19-22).

typedef struct {
    scalar_t cos;
    scalar_t sin;
    bool sweep_y;   // mu_y is swept, else mu_x (Fig. 3)
    bool negative;  // towards smaller ones
    bool vanishing; // there is no direction
} direction_t;

static direction_t centroids(const code_t codes[TAXELS])
{
    direction_t direction;
    wide_t compression = 0, compression_u = 0, compression_v = 0;
    wide_t traction = 0, traction_u = 0, traction_v = 0;
    for (int i = 0; i < ROWS; i++) {
        moment_t pressed = 0, pulled = 0;
        for (int j = 0; j < COLUMNS; j++) {
            const int code = codes[i * COLUMNS + j];
            const int press = code < 0 ? -code : 0, pull = code > 0 ? code : 0;
            pressed += press;
            pulled += pull;
            compression_u += (wide_t)press * (COLUMNS - j);
            traction_u += (wide_t)pull * (COLUMNS - j);
        }
        compression += pressed;
        traction += pulled;
        compression_v += (wide_t)pressed * (ROWS - i);
        traction_v += (wide_t)pulled * (ROWS - i);
    }
    const wide_t u = traction_u * compression - compression_u * traction;
    const wide_t v = traction_v * compression - compression_v * traction;
    int needed = bit_length(significant(u) | significant(v));
    const wide_t x = block_normalize(u, needed, DIVISION) * PITCH_X;
    const wide_t y = block_normalize(v, needed, DIVISION) * PITCH_Y;
    needed = bit_length(significant(x) | significant(y));
    direction.vanishing = x == 0 && y == 0;
    direction.cos = (scalar_t)block_normalize(x, needed, DIRECTION);
    if (direction.vanishing)
        direction.cos = ((scalar_t)1 << (DIRECTION - 1)) - 1;
    direction.sin = (scalar_t)block_normalize(y, needed, DIRECTION);
    direction.sweep_y = magnitude(y) > magnitude(x);
    direction.negative = direction.sweep_y ? y < 0 : x < 0;
    return direction;
}
