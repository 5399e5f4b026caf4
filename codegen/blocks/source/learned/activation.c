// ReLU at every mirror, between two butterflies: the results of a product become the operand of the next one.

static void activation(int count, const vector_t *sums, vector_t *units)
{
    vector_t mirrors[4 * MOST_UNITS];
    butterfly(count, sums, mirrors);
    for (int i = 0; i < 4 * count; i++)
        mirrors[i] = (vector_t)positive(mirrors[i]);
    butterfly(count, mirrors, units);
}
